import numpy as np
import pytest
from msgspec.structs import replace

from armspan.config.body_file import body_from_table, body_text, check_new, read_body, write_body
from armspan.errors import ConfigError
from armspan.records import Body

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


def covariance(matrix):
    return f"covariance_m2 = {np.reshape(matrix, 25).tolist()}\n"


SPREAD = np.diag([0.010, 0.020, 0.008, 0.012, 0.016]) ** 2
SPREAD[3, 4] = SPREAD[4, 3] = -0.5 * 0.012 * 0.016


def test_a_covariance_is_read_row_by_row(tmp_path):
    assert read_body(write(tmp_path, GOOD + covariance(SPREAD))).covariance == tuple(SPREAD.ravel().tolist())
    assert read_body(write(tmp_path, GOOD)).covariance is None
    whole = tuple(np.full(25, 0.0001).tolist())  # of rank one: all five know of one doubt only
    assert read_body(write(tmp_path, GOOD + covariance(whole))).covariance == whole


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("covariance_m2 = [0.1, 0.2]", "25 numbers"),
        ("covariance_m2 = 0.0001", "25 numbers"),
        (f"covariance_m2 = {SPREAD.tolist()}", "25 numbers"),
        (covariance(SPREAD).replace("0.0001,", "nan,", 1), "covariance_m2 = nan is not a finite number"),
        (covariance(SPREAD).replace("0.0001,", '"a",', 1), "covariance_m2 = 'a' is not a finite number"),
        (covariance(-SPREAD), "is no covariance"),
        (covariance(np.triu(SPREAD)), "is no covariance"),
        (covariance(np.where(SPREAD < 0.0, 2.5 * SPREAD, SPREAD)), "is no covariance"),  # correlation -1.25
        (covariance(1e6 * SPREAD), "in square metres, 0.000064 for 8 mm"),
        (covariance(np.diag([0.0, 0.0, 0.0, 0.0, 0.1])), "a doubt of 0.3 m"),
        (covariance(np.diag([1e200, 0.0, 0.0, 0.0, 0.0])), "in square metres"),
    ],
)
def test_what_is_no_covariance_in_square_metres_is_refused(tmp_path, line, words):
    message = refusal(tmp_path, GOOD + line)
    assert words in message
    assert "leave it out" in message or "write metres" in message


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


FULL = Body(1.6364, (0.1171, -0.1523, 0.2345), 0.7432, "left", 0.3312, 0.4120, tuple(SPREAD.ravel().tolist()))


@pytest.mark.parametrize(
    "body", [FULL, replace(FULL, covariance=None), Body(1.5, (0.0, 0.18, 0.25), 0.7), replace(FULL, upper_arm_m=None)]
)
def test_what_is_written_is_read_again(body, tmp_path):
    path = tmp_path / "me.toml"
    write_body(path, body, "from a tape\nof 8 mm")
    limbs = body.upper_arm_m is not None and body.elbow_to_fingertip_m is not None
    assert read_body(path) == (body if limbs else replace(body, upper_arm_m=None, elbow_to_fingertip_m=None))
    assert path.read_text(encoding="utf-8").startswith("# from a tape\n# of 8 mm\n[body]\n")


def test_metres_are_written_to_the_tenth_of_a_millimetre():
    text = body_text(Body(1.636449, (0.1, 0.2, 0.30006), 0.7), "")
    assert "eye_height_m = 1.6364\n" in text
    assert "shoulder_to_eye_m = [0.1000, 0.2000, 0.3001]" in text


def test_an_existing_file_is_kept(tmp_path):
    path = write(tmp_path, "mine")
    with pytest.raises(ConfigError, match=r"BODY\.toml exists and is kept: name another file with --out"):
        write_body(path, FULL, "")
    with pytest.raises(ConfigError, match=r"BODY\.toml exists and is kept: name another file with --out"):
        check_new(path)
    assert path.read_text() == "mine"


def test_where_no_file_can_be_written(tmp_path):
    with pytest.raises(ConfigError, match=r"nowhere\S*me\.toml cannot be written \(.+\): name another file with --out"):
        write_body(tmp_path / "nowhere" / "me.toml", FULL, "")
    with pytest.raises(ConfigError, match=r"cannot be written, as \S+nowhere is no folder: name another file"):
        check_new(tmp_path / "nowhere" / "me.toml")
    check_new(tmp_path / "me.toml")
    assert list(tmp_path.iterdir()) == []
