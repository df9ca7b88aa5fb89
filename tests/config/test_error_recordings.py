from pathlib import Path

import numpy as np
import pytest

from armspan.config.error_recordings import read_error_recordings, read_people, read_sessions
from armspan.errors import ConfigError, DataError

SHARED = Path(__file__).parents[2] / ".." / "shared" / "data"

BODY = """[body]
eye_height_m = 1.6
shoulder_to_eye_m = [0.0, 0.18, 0.24]
shoulder_to_fingertip_m = 0.72
"""
MARKERS = ("eyes", "shoulder", "elbow", "wrist", "fingertip", "target")
HEADER = "person,gesture," + ",".join(f"{marker}_{axis}_m" for marker in MARKERS for axis in "xyz")


def people_folder(folder, places=9, spoil=lambda line: line):
    people = folder / "people"
    (people / "p01").mkdir(parents=True)
    (people / "p01" / "body.toml").write_text(BODY)
    rows = [HEADER]
    for place in range(places):
        x, y = 1.5 + place // 3, place % 3 - 1.0
        points = ([-0.4, 0.1, 1.6], [-0.3, -0.1, 1.3], [0.0, -0.1, 1.3], [0.0, 0.2, 1.3], [0.1, 0.3, 1.3], [x, y, 0.49])
        rows.append(f"anna,{place}," + ",".join(f"{value:.4f}" for point in points for value in point))
    (people / "gestures.csv").write_text("\n".join(spoil(row) for row in rows) + "\n")
    return people


def session_folder(folder, seconds=24.0, head_rows=None):
    pointing = folder / "pointing"
    pointing.mkdir()
    (pointing / "body.toml").write_text(BODY)
    times = [k / 2 for k in range(round(2 * seconds) + 1)]
    for name in ("circle_0", "triangle_2", "triangle_3"):
        rows = [f"{t:.5f},1,0,0,0,{t},2,0.5" for t in times]
        (pointing / f"{name}.csv").write_text(
            "t_s,forearm_qw,forearm_qx,forearm_qy,forearm_qz,x_m,y_m,z_m\n" + "\n".join(rows) + "\n"
        )
        heads = [f"{t:.5f},0.1,{t / 10},1.8" for t in times[:head_rows]]
        (pointing / f"{name}_head.csv").write_text("t_s,x_m,y_m,z_m\n" + "\n".join(heads) + "\n")
    return pointing


def test_people_are_read_with_the_floor_below_their_eyes(tmp_path):
    (person,) = read_people(people_folder(tmp_path))
    assert person.places.tolist() == list(range(9))
    assert person.targets[0] == pytest.approx([1.5 + 0.4, -1.0 - 0.1, 0.49])
    assert person.upperarm[0, :, 0] == pytest.approx([1.0, 0.0, 0.0])
    assert person.forearm[0, :, 0] == pytest.approx([0.0, 1.0, 0.0])
    assert person.body.shoulder_to_fingertip_m == 0.72


def test_sessions_are_read_with_the_head(tmp_path):
    sessions = read_sessions(session_folder(tmp_path))
    assert len(sessions) == 3
    for session in sessions:
        assert session.times[[0, 1, -1]] == pytest.approx([0.0, 0.5, 24.0])
        assert session.points[4] == pytest.approx([2.0, 2.0, 0.5])
        assert session.head[4] == pytest.approx([0.1, 0.2, 1.8])
        assert session.forearm[4] == pytest.approx(np.eye(3))
        assert session.body.eye_height_m == 1.6


def test_both_together(tmp_path):
    people_folder(tmp_path)
    session_folder(tmp_path)
    found = read_error_recordings(tmp_path)
    assert (len(found.pointed), len(found.followed)) == (1, 3)


def test_a_folder_that_is_none_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"nowhere is not a folder: name one that holds people/gestures.csv"):
        read_error_recordings(tmp_path / "nowhere")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DataError, match=r"gestures\.csv does not exist: --recordings names a folder"):
        read_error_recordings(tmp_path)


def test_a_head_of_another_length_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"circle_0_head\.csv has 2 rows, but circle_0\.csv has 49"):
        read_sessions(session_folder(tmp_path, head_rows=2))


@pytest.mark.parametrize("seconds", [2.0, 20.0])
def test_a_session_too_short_for_the_longest_segment_is_refused(tmp_path, seconds):
    with pytest.raises(DataError, match=rf"circle_0\.csv lasts {seconds:g} s, but more than 20 s are expected"):
        read_sessions(session_folder(tmp_path, seconds))


def test_a_missing_session_is_named(tmp_path):
    pointing = session_folder(tmp_path)
    (pointing / "triangle_3_head.csv").unlink()
    with pytest.raises(DataError, match=r"triangle_3_head\.csv does not exist"):
        read_sessions(pointing)


def test_everybody_has_sizes_of_their_own(tmp_path):
    people = people_folder(tmp_path)
    own = (people / "gestures.csv").read_text().splitlines()
    (people / "gestures.csv").write_text("\n".join([*own, *(row.replace("anna", "ben") for row in own[1:])]) + "\n")
    with pytest.raises(ConfigError, match=r"p02\S+body\.toml does not exist"):
        read_people(people)
    (people / "p02").mkdir()
    (people / "p02" / "body.toml").write_text(BODY.replace("0.72", "0.68"))
    assert [person.body.shoulder_to_fingertip_m for person in read_people(people)] == [0.72, 0.68]


def test_targets_at_other_heights_are_left_out(tmp_path):
    people = people_folder(tmp_path)
    high = (people / "gestures.csv").read_text().splitlines()[1].replace("0.4900", "1.4900")
    with (people / "gestures.csv").open("a") as file:
        file.write(high + "\n")
    (person,) = read_people(people)
    assert len(person.targets) == 9
    only_high = people_folder(tmp_path / "other", spoil=lambda row: row.replace("0.4900", "1.4900"))
    with pytest.raises(DataError, match=r"0 targets at 0\.49 m, but nine places are expected"):
        read_people(only_high)


def test_too_few_places_are_refused(tmp_path):
    with pytest.raises(DataError, match=r"4 targets at 0\.49 m, but nine places are expected"):
        read_people(people_folder(tmp_path, places=4))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda row: row.replace("person", "who"), "column 'person' is missing"),
        (lambda row: row.replace("elbow_y_m", "elbow_y"), "column 'elbow_y_m' is missing"),
        (lambda row: row.replace("1.6000", "high"), "a field is no number"),
        (
            lambda row: row.replace("-0.4000", "nan") if row.startswith("anna,3") else row,
            "line 5: a number is not finite",
        ),
        (lambda row: row.rpartition(",")[0] if row.startswith("anna,3") else row, "a field is no number"),
    ],
)
def test_another_file_is_refused(tmp_path, spoil, words):
    with pytest.raises(DataError, match=words):
        read_people(people_folder(tmp_path, spoil=spoil))


def test_an_empty_file_is_refused(tmp_path):
    people = people_folder(tmp_path)
    (people / "gestures.csv").write_text("")
    with pytest.raises(DataError, match="holds no rows"):
        read_people(people)


@pytest.mark.skipif(not SHARED.is_dir(), reason="the published recordings are not beside the checkout")
def test_the_published_recordings_are_read_whole():
    found = read_error_recordings(SHARED)
    assert [len(person.places) for person in found.pointed] == [45] * 6
    assert all((np.bincount(person.places) == 5).all() for person in found.pointed)
    assert [len(session.times) for session in found.followed] == [2335, 1132, 1439]
