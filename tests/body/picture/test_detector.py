import math
import sys

import numpy as np
import pytest

from armspan.body.picture.detector import SIDE, Detections, anchors, apart, decode, detect, shared, squares
from armspan.body.picture.regions import Region, crop, picture_from_crop, upright
from armspan.errors import MissingExtra


def test_the_anchors_are_those_of_the_published_network():
    places = anchors()
    assert len(places) == 2254  # 28 x 28 x 2 + 14 x 14 x 2 + 7 x 7 x 6
    assert places[0] * 224 == pytest.approx([4, 4])
    assert places[1] * 224 == pytest.approx([4, 4])
    assert places[2] * 224 == pytest.approx([12, 4])  # along a row first
    assert places[56] * 224 == pytest.approx([4, 12])
    assert places[1568] * 224 == pytest.approx([8, 8])
    assert places[1960] * 224 == pytest.approx([16, 16])
    assert places[-1] * 224 == pytest.approx([208, 208])
    assert places.mean(axis=0) == pytest.approx([0.5, 0.5])


def a_guess(number: int, *told: float) -> tuple[np.ndarray, np.ndarray]:
    raw, logits = np.zeros((2254, 12)), np.full(2254, -9.0)
    raw[number], logits[number] = told, math.log(3)
    return raw, logits


def test_a_guess_is_told_from_its_anchor():
    found = decode(*a_guess(56, 20, -4, 100, 60, 8, 12, 8, -88, 0, 0, 0, 0))
    assert found.scores == pytest.approx([0.75])
    assert found.boxes[0] * 224 == pytest.approx([24 - 50, 8 - 30, 24 + 50, 8 + 30])
    assert found.points[0] * 224 == pytest.approx(np.array([[12, 24], [12, -76], [4, 12], [4, 12]]))


def test_guesses_that_are_no_likelier_than_not_are_dropped():
    raw, logits = a_guess(3, *([10.0] * 12))
    assert len(decode(raw, np.where(logits > 0, -0.01, logits)).scores) == 0


def test_common_area():
    box = np.array([0, 0, 2, 2.0])
    assert shared(box, box) == pytest.approx(1)
    assert shared(box, np.array([1, 1, 3, 3.0])) == pytest.approx(1 / 7)
    assert shared(box, np.array([2, 0, 4, 2.0])) == 0
    assert shared(np.zeros(4), np.zeros(4)) == 0


def test_of_boxes_on_one_another_the_surest_stays():
    boxes = np.array([[0, 0, 1, 1], [0.1, 0, 1.1, 1], [5, 5, 6, 6.0]])
    found = Detections(np.array([0.6, 0.9, 0.7]), boxes, np.zeros((3, 4, 2)))
    assert apart(found) == [1, 2]


def test_a_person_is_found_where_the_network_points_in_a_wide_picture():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    # 448 px wide, 224 high: a picture's pixel is half one of the network's, and 112 px are padding above
    raw, logits = a_guess(1960, 0, 0, 40, 40, 96, 96, 96, 36, 0, 0, 0, 0)
    seen = []

    def network(picture):
        seen.append(picture)
        return [raw, logits[:, None]]

    image = np.full((224, 448, 3), 255, np.uint8)
    (region,) = detect(image, network)
    assert region.centre == pytest.approx([224, 112])  # (16 + 96) x 2, less the padding
    assert region.size == pytest.approx(2.5 * 120)
    assert region.angle == pytest.approx(0)
    assert seen[0].shape == (SIDE, SIDE, 3)
    assert seen[0][100, 100] == pytest.approx([1, 1, 1])
    assert seen[0][10, 10] == pytest.approx([-1, -1, -1])


def test_the_whole_picture_is_one_square_and_its_parts_overlap_by_half():
    image = np.zeros((90, 160, 3), np.uint8)
    (whole,) = squares(image, 1.0)
    assert whole.centre == pytest.approx([80, 45])
    assert whole.size == 160
    parts = squares(image, 0.5)
    assert [tuple(each.centre) for each in parts] == [(40, 40), (80, 40), (120, 40), (40, 50), (80, 50), (120, 50)]
    assert {each.size for each in parts} == {80}


def test_somebody_small_is_found_in_a_part_of_the_picture():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    raw, logits = a_guess(1960, 96, 96, 40, 40, 96, 96, 96, 51, 0, 0, 0, 0)  # in the middle of what is shown
    image = np.zeros((100, 100, 3), np.uint8)
    image[70:, 70:] = 255
    shown = []

    def network(picture):
        shown.append(picture)
        seen = picture[130, 130, 0] > 0 and picture[20, 20, 0] < 0
        return [raw, logits[:, None] if seen and len(shown) > 1 else np.full((2254, 1), -9.0)]

    (region,) = detect(image, network, (1.0, 0.6))
    assert region.centre == pytest.approx([70, 70])
    assert region.size == pytest.approx(2.5 * 45 / 224 * 60)


@pytest.mark.parametrize(
    ("head", "turned"), [((10, 5), 0), ((15, 10), math.pi / 2), ((10, 15), math.pi), ((5, 10), -math.pi / 2)]
)
def test_the_square_stands_along_the_body(head, turned):
    region = upright(np.array([10.0, 10]), np.array(head, float), 2.5)
    assert region.size == pytest.approx(12.5)
    assert math.cos(region.angle - turned) == pytest.approx(1)
    assert region.to_picture(np.array([0.5, 0.5 - 1 / 2.5])) == pytest.approx(head)


def test_a_square_may_lie_beyond_its_foot():
    region = upright(np.array([0.0, 0]), np.array([0.0, -10]), 3, shift=0.9)
    assert region.centre == pytest.approx([0, -9])


def test_corners_of_a_turned_and_of_a_mirrored_square():
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    turned = Region(np.array([100.0, 50]), 20, math.pi / 2)
    assert turned.to_picture(corners) == pytest.approx(np.array([[110, 40], [110, 60], [90, 60], [90, 40]]))
    mirrored = Region(np.array([100.0, 50]), 20, mirrored=True)
    assert mirrored.to_picture(corners) == pytest.approx(np.array([[110, 40], [90, 40], [90, 60], [110, 60]]))


def test_a_moved_square():
    moved = Region(np.array([100.0, 50]), 20, math.pi / 2).moved(right=0.1, down=0.2, grown=2, turned=0.5)
    assert moved.centre == pytest.approx([96, 52])  # its right is the picture's down, its down the picture's left
    assert moved.size == 40
    assert moved.angle == pytest.approx(math.pi / 2 + 0.5)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("size", [32, 90, 300])
def test_what_a_crop_shows_lies_where_the_square_says(size, mirrored):
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    rows, columns = np.mgrid[0:400, 0:400]
    spot = 255 * np.exp(-((columns + 0.5 - 220) ** 2 + (rows + 0.5 - 180) ** 2) / (2 * (size / 12) ** 2))
    image = np.repeat(spot[..., None], 3, axis=2).astype(np.uint8)
    region = Region(np.array([215.0, 190]), size, 0.4, mirrored)
    seen = crop(image, region, 64)[..., 0].astype(float)
    assert 0.9 < seen.max() <= 1
    seen = np.where(seen > 0.2, seen, 0)
    along = (np.arange(64) + 0.5) / 64
    place = np.array([seen.sum(0) @ along, seen.sum(1) @ along]) / seen.sum()
    assert region.to_picture(place) == pytest.approx([220, 180], abs=0.012 * size)


def test_a_crop_of_a_fine_pattern_is_its_mean():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    stripes = np.zeros((512, 512, 3), np.uint8)
    stripes[:, ::2] = 255
    seen = crop(stripes, Region(np.array([256.0, 256]), 512), 64)
    assert seen == pytest.approx(np.full((64, 64, 3), 0.5), abs=0.01)


def test_the_map_of_a_crop_takes_pixel_centres_to_pixel_centres():
    same = picture_from_crop(Region(np.array([32.0, 32]), 64), 64)
    assert same == pytest.approx(np.array([[1, 0, 0], [0, 1, 0]]))
    half = picture_from_crop(Region(np.array([32.0, 32]), 64), 32)
    assert half @ np.array([0, 0, 1]) == pytest.approx([0.5, 0.5])  # between the first two pixels


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(
        MissingExtra, match=r"opencv-python-headless is not installed: pip install 'armspan\[picture\]'"
    ):
        crop(np.zeros((9, 9, 3), np.uint8), Region(np.zeros(2), 9), 4)
