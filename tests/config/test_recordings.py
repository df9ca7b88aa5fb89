import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from armspan.config.recordings import read_pairs, read_rays
from armspan.errors import DataError

HEADER = "t_s,stop,forearm_qw,forearm_qx,forearm_qy,forearm_qz,x_m,y_m,z_m"
ROWS = ["0.0,a,1,0,0,0,0.1,0.2,0.0", "0.1,a,0.6,0,0,0.8,0.1,0.2,0.0", "0.2,b,0,1,0,0,0.5,0.2,-0.05"]
RAYS = "t_s,forearm_qw,forearm_qx,forearm_qy,forearm_qz,z_m\n0.0,1,0,0,0,0.0\n"
UPPER = "upperarm_qw,upperarm_qx,upperarm_qy,upperarm_qz"


def write(tmp_path, *lines):
    path = tmp_path / "PAIRS.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def refusal(tmp_path, *lines, read=read_pairs):
    path = write(tmp_path, *lines)
    with pytest.raises(DataError) as caught:
        read(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    return message.removeprefix(str(path))


def test_pairs_of_one_band(tmp_path):
    recording = read_pairs(write(tmp_path, HEADER, *ROWS))
    assert_allclose(recording.times, [0, 0.1, 0.2])
    assert_allclose(recording.forearm, [[1, 0, 0, 0], [0.6, 0, 0, 0.8], [0, 1, 0, 0]])
    assert_allclose(recording.points[2], [0.5, 0.2, -0.05])
    assert recording.stops == ("a", "a", "b")
    assert recording.upperarm is None


def test_columns_may_come_in_any_order_and_with_a_second_band(tmp_path):
    lines = [f"{UPPER},x_m,y_m,z_m,t_s,{HEADER[9:52]}", "0,0,1,0,0.1,0.2,0.3,7.0,0,0,0,1"]
    recording = read_pairs(write(tmp_path, *lines))
    assert_allclose(recording.upperarm, [[0, 0, 1, 0]])
    assert_allclose(recording.forearm, [[0, 0, 0, 1]])
    assert_allclose(recording.points, [[0.1, 0.2, 0.3]])
    assert recording.stops is None


def test_rays(tmp_path):
    recording = read_rays(write(tmp_path, *RAYS.split()))
    assert_allclose(recording.points[:, 2], [0.0])
    assert np.isnan(recording.points[:, :2]).all()


def test_a_quaternion_is_scaled_to_length_one(tmp_path):
    recording = read_pairs(write(tmp_path, HEADER, "0.0,a,0.61,0,0,0.79,0,0,0"))
    assert_allclose(np.linalg.norm(recording.forearm, axis=1), 1.0, atol=1e-15)


def test_spaces_blank_lines_and_a_byte_order_mark_do_no_harm(tmp_path):
    path = tmp_path / "p.csv"
    path.write_bytes(
        b"\xef\xbb\xbf" + HEADER.replace(",", " , ").encode() + b"\r\n\r\n" + ROWS[0].encode() + b"\r\n\r\n"
    )
    assert read_pairs(path).stops == ("a",)


@settings(derandomize=True, max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    arrays(float, (4, 4), elements=st.floats(-1, 1)).filter(lambda q: (np.linalg.norm(q, axis=1) > 0.1).all()),
    arrays(float, (4, 3), elements=st.floats(-5, 5)),
)
def test_what_is_written_is_read(tmp_path, quaternions, points):
    quaternions = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    numbers = np.column_stack([quaternions, points]).tolist()
    rows = [f"{k},{k % 2}," + ",".join(map(repr, row)) for k, row in enumerate(numbers)]
    recording = read_pairs(write(tmp_path, HEADER, *rows))
    assert_allclose(recording.forearm, quaternions, atol=1e-15)
    assert (recording.points == points).all()
    assert recording.stops == ("0", "1", "0", "1")


def test_a_missing_column_is_named(tmp_path):
    message = refusal(tmp_path, HEADER.replace(",x_m", ""), "0.0,a,1,0,0,0,0.2,0.0")
    assert message.startswith(", line 1: column 'x_m' is missing")
    assert "expected: t_s,[stop],forearm_qw" in message
    message = refusal(tmp_path, HEADER + ",upperarm_qw", ROWS[0] + ",1")
    assert "columns 'upperarm_qx', 'upperarm_qy', 'upperarm_qz' are missing" in message


def test_an_unknown_or_a_doubled_column_is_named(tmp_path):
    assert "column 'note' is unknown" in refusal(tmp_path, HEADER + ",note", ROWS[0] + ",hello")
    assert "column 'z_m' is there twice" in refusal(tmp_path, HEADER + ",z_m", ROWS[0] + ",0")
    assert "column 'z_m' is missing" in refusal(tmp_path, RAYS.split()[0].replace("z_m", "x_m"), read=read_rays)


@pytest.mark.parametrize("value", ["abc", "nan", "inf", "", "1,5"])
def test_what_is_not_a_finite_number_is_named_with_its_line(tmp_path, value):
    message = refusal(tmp_path, HEADER, ROWS[0], f'0.1,a,1,0,0,0,"{value}",0.2,0.0')
    assert message.startswith(f", line 3: x_m is {value!r}, but a finite number is expected")


def test_a_quaternion_that_is_not_unit_is_named_with_its_length(tmp_path):
    message = refusal(tmp_path, HEADER, "0.0,a,1,1,0,0,0.1,0.2,0.0")
    assert ", line 2: forearm_qw..qz is (1, 1, 0, 0) of length 1.414" in message
    assert "length 0.000" in refusal(tmp_path, HEADER, "0.0,a,0,0,0,0,0.1,0.2,0.0")


def test_time_that_runs_backwards_is_named(tmp_path):
    message = refusal(tmp_path, HEADER, ROWS[1], ROWS[0])
    assert message.startswith(", line 3: t_s is 0 after 0.1")


def test_another_separator_is_noticed(tmp_path):
    assert "not separated by commas" in refusal(tmp_path, HEADER.replace(",", ";"), ROWS[0].replace(",", ";"))


def test_rows_of_another_length_and_empty_stops(tmp_path):
    assert ", line 3: 8 fields, but the first line names 9 columns" in refusal(tmp_path, HEADER, ROWS[0], ROWS[1][:-4])
    assert ", line 2: stop is empty" in refusal(tmp_path, HEADER, ROWS[0].replace("a", ""))


def test_empty_files(tmp_path):
    path = tmp_path / "empty.csv"
    path.write_text("")
    with pytest.raises(DataError, match="is empty: its first line names the columns t_s"):
        read_pairs(path)
    assert "no rows" in refusal(tmp_path, HEADER)
    with pytest.raises(DataError, match="does not exist"):
        read_pairs(tmp_path / "none.csv")
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(DataError, match="cannot be read as CSV text"):
        read_pairs(path)
