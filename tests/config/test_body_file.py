import pytest

from armspan.config.body_file import body_from_table, read_body
from armspan.errors import ConfigError

GOOD = """
[body]
eye_height_m = 1.65
shoulder_to_eye_m = [0.02, 0.18, 0.24]  # forward, left, up
shoulder_to_fingertip_m = 0.72
"""


def write(tmp_path, text):
    path = tmp_path / "BODY.toml"
    path.write_text(text, encoding="utf-8")
    return path


def refusal(tmp_path, text):
    path = write(tmp_path, text)
    with pytest.raises(ConfigError) as caught:
        read_body(path)
    assert str(path) in str(caught.value)
    assert path.read_text(encoding="utf-8") == text
    return str(caught.value)


def test_the_five_measures(tmp_path):
    body = read_body(write(tmp_path, GOOD))
    assert body.eye_height_m == 1.65
    assert body.shoulder_to_eye_m == (0.02, 0.18, 0.24)
    assert body.shoulder_to_fingertip_m == 0.72
    assert body.arm == "right"
    assert body.upper_arm_m is None


def test_two_bands_and_the_left_arm(tmp_path):
    more = 'arm = "left"\nupper_arm_m = 0.36\nelbow_to_fingertip_m = 0.37\n'
    body = read_body(write(tmp_path, GOOD + more))
    assert (body.arm, body.upper_arm_m, body.elbow_to_fingertip_m) == ("left", 0.36, 0.37)


def test_a_covariance_has_25_numbers(tmp_path):
    rows = ", ".join(["0.0001"] * 25)
    assert read_body(write(tmp_path, GOOD + f"covariance_m2 = [{rows}]")).covariance == (0.0001,) * 25
    assert "25 numbers" in refusal(tmp_path, GOOD + "covariance_m2 = [0.1, 0.2]")


def test_centimetres_are_told_from_metres(tmp_path):
    message = refusal(tmp_path, GOOD.replace("1.65", "165"))
    assert "eye_height_m = 165" in message
    assert "centimetres, did you mean 1.65?" in message


def test_millimetres_too(tmp_path):
    assert "millimetres, did you mean 0.72?" in refusal(tmp_path, GOOD.replace("0.72", "720"))


def test_each_part_of_the_shoulder_is_checked(tmp_path):
    message = refusal(tmp_path, GOOD.replace("0.18", "18"))
    assert "shoulder_to_eye_m (left) = 18" in message
    assert "did you mean 0.18?" in message
    assert "(up) = -0.24" in refusal(tmp_path, GOOD.replace("0.24", "-0.24"))
    assert "three numbers [forward, left, up]" in refusal(tmp_path, GOOD.replace("[0.02, 0.18, 0.24]", "[0.18, 0.24]"))


@pytest.mark.parametrize("value", ["nan", "inf", '"1.65"', "true"])
def test_what_is_not_a_finite_number_is_refused(tmp_path, value):
    assert "eye_height_m" in refusal(tmp_path, GOOD.replace("1.65", value))


def test_missing_and_unknown_keys_are_named(tmp_path):
    assert "lacks eye_height_m" in refusal(tmp_path, GOOD.replace("eye_height_m = 1.65", ""))
    message = refusal(tmp_path, GOOD.replace("eye_height_m", "eye_hight_m"))
    assert "'eye_hight_m' does not exist" in message
    assert "Did you mean 'eye_height_m'?" in message


def test_a_wrong_arm_is_refused(tmp_path):
    assert "'left' or 'right'" in refusal(tmp_path, GOOD + 'arm = "both"')


def test_a_file_that_is_not_a_body_file(tmp_path):
    assert "no table [body]" in refusal(tmp_path, "eye_height_m = 1.65")
    assert "cannot be read as TOML" in refusal(tmp_path, "[body\n")
    with pytest.raises(ConfigError, match="does not exist"):
        read_body(tmp_path / "nobody.toml")


def test_the_table_of_another_file_is_named_in_complaints():
    with pytest.raises(ConfigError, match=r"^room\.toml: \[body\] lacks eye_height_m"):
        body_from_table({"shoulder_to_eye_m": [0.0, 0.2, 0.2]}, "room.toml")
