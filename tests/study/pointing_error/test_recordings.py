from pathlib import Path

import numpy as np
import pytest

from armspan.config.error_recordings import read_error_recordings, read_people, read_sessions
from armspan.errors import DataError
from armspan.study.pointing_error.recordings import limb, numbered_places

SHARED = Path(__file__).parents[3] / ".." / "shared" / "data"

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


def session_folder(folder, head_rows=3):
    pointing = folder / "pointing"
    pointing.mkdir()
    (pointing / "body.toml").write_text(BODY)
    for name in ("circle_0", "triangle_2", "triangle_3"):
        rows = [f"{t / 30:.5f},1,0,0,0,{t},2,0.5" for t in range(3)]
        (pointing / f"{name}.csv").write_text(
            "t_s,forearm_qw,forearm_qx,forearm_qy,forearm_qz,x_m,y_m,z_m\n" + "\n".join(rows) + "\n"
        )
        heads = [f"{t / 30:.5f},0.1,0.2,1.8" for t in range(head_rows)]
        (pointing / f"{name}_head.csv").write_text("t_s,x_m,y_m,z_m\n" + "\n".join(heads) + "\n")
    return pointing


def test_a_limb_points_from_joint_to_joint_with_its_side_level():
    (axes,) = limb(np.array([[0.0, 0.0, 1.0]]), np.array([[3.0, 0.0, 5.0]]))
    assert axes[:, 0] == pytest.approx([0.6, 0.0, 0.8])
    assert axes[:, 1] == pytest.approx([0.0, 1.0, 0.0])
    assert axes[:, 2] == pytest.approx([-0.8, 0.0, 0.6])


def test_places_are_numbered_row_by_row():
    targets = np.array([[x, y, 0.5] for x in (3, 1, 2) for y in (1, -1, 0)], dtype=float)
    assert numbered_places(targets).tolist() == [8, 6, 7, 2, 0, 1, 5, 3, 4]


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
    assert sessions[0].points[2] == pytest.approx([2.0, 2.0, 0.5])
    assert sessions[0].head[2] == pytest.approx([0.1, 0.2, 1.8])
    assert sessions[0].forearm.shape == (3, 3, 3)


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
    with pytest.raises(DataError, match=r"circle_0_head\.csv has 2 rows, but circle_0\.csv has 3"):
        read_sessions(session_folder(tmp_path, head_rows=2))


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
