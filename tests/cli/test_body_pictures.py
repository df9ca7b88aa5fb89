"""`armspan body` with pictures of a drawn person; the networks must have been fetched."""

import json

import numpy as np
import pytest

from armspan.config.weights import missing_weights, weights_folder
from body.picture.drawn_people import drawn_person, wall_and_floor
from command_line import code_of, refused

cv2 = pytest.importorskip("cv2", reason="pictures are read by OpenCV (extra 'picture')")
pytest.importorskip("ai_edge_litert", reason="networks are run by LiteRT (extra 'picture')")
if missing_weights(weights_folder()):
    pytest.skip("the networks are not there: `armspan body --set-up` fetches them", allow_module_level=True)

TOLD = ("body", "--height-m", "1.75", "--sex", "man")


def saved(path, pixels):
    cv2.imwrite(str(path), np.ascontiguousarray(pixels[..., ::-1]))
    return path


@pytest.fixture
def alone(tmp_path):
    pixels = wall_and_floor()
    joints = drawn_person(pixels, 320)
    return saved(tmp_path / "one.png", pixels), joints


@pytest.fixture
def together(tmp_path):
    pixels = wall_and_floor(1000)
    drawn_person(pixels, 270)
    drawn_person(pixels, 740, top=140, tall=400)
    return saved(tmp_path / "two.png", pixels)


def test_a_picture_narrows_the_measures_and_its_points_are_kept(alone, tmp_path, capfd):
    picture, joints = alone
    kept, out = tmp_path / "kept", tmp_path / "me.toml"
    assert code_of(*TOLD, "--front", picture, "--keep", kept, "--out", out, "--json") == 0
    told, talk = capfd.readouterr()
    found = json.loads(told)
    assert "INFO" not in talk
    assert {row["measure"] for row in found["taken"]} == {"left", "up", "arm length"}
    assert found["sd_m"]["arm length"] < 0.75 * found["prior"]["sd_m"]["arm length"]
    points = json.loads((kept / "front.json").read_text())["points"]
    assert np.hypot(*np.subtract(points["rwr"][:2], joints["rwr"])) < 14  # a thirtieth of the body: it is a drawing
    drawn = cv2.imread(str(kept / "front.png"))
    assert drawn.shape[1] == 640
    assert drawn.shape[0] > 640  # a legend below
    assert out.exists()
    assert picture.exists()


def test_of_two_people_one_must_be_chosen(together, tmp_path, capfd):
    assert "shows 2 people: choose one with --person" in refused(capfd, tmp_path, *TOLD, "--front", together)


def test_one_of_two_people(together, tmp_path):
    assert code_of(*TOLD, "--front", together, "--person", "2", "--keep", tmp_path / "kept") == 0
    points = json.loads((tmp_path / "kept" / "front.json").read_text())["points"]
    assert points["nose"][0] == pytest.approx(740, abs=10)


def test_nobody_in_the_picture(tmp_path, capfd):
    picture = saved(tmp_path / "wall.jpg", wall_and_floor())
    assert "shows nobody" in refused(capfd, tmp_path, *TOLD, "--front", picture)


def test_an_arm_that_ends_outside_the_picture(tmp_path, capfd):
    pixels = wall_and_floor()
    drawn_person(pixels, 320)
    picture = saved(tmp_path / "cut.png", pixels[:, 180:])
    assert "right wrist lies outside the picture" in refused(capfd, tmp_path, *TOLD, "--front", picture)


def test_a_promised_marker_that_is_not_there(alone, tmp_path, capfd):
    assert "no printed marker is seen" in refused(capfd, tmp_path, *TOLD, "--front", alone[0], "--marker")


def test_a_front_picture_given_as_the_side(alone, tmp_path, capfd):
    assert "faces the camera: turn the side to it" in refused(capfd, tmp_path, *TOLD, "--side", alone[0])


@pytest.mark.parametrize("kind", ["jpg", "png"])
def test_a_damaged_picture_is_not_measured(kind, alone, tmp_path, capfd):
    picture = saved(tmp_path / f"damaged.{kind}", cv2.imread(str(alone[0]))[..., ::-1])
    data = bytearray(picture.read_bytes())
    third = len(data) // 3
    data[third : third + 300] = bytes(300)
    picture.write_bytes(data)
    assert "damaged" in refused(capfd, tmp_path, *TOLD, "--front", picture)  # and no line of a codec's own
