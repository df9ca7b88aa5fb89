import numpy as np
import pytest

from armspan.body.picture.marker import Marker
from armspan.body.picture.overlay import DRAWN_SIDE, LEFT, MEASURED, RIGHT, SHEET, overlay
from armspan.body.skeleton import Skeleton

cv2 = pytest.importorskip("cv2", reason="pictures are drawn by OpenCV (extra 'picture')")

POINTS = {
    "leye": (260.0, 80.0, 1.0),
    "reye": (240.0, 80.0, 1.0),
    "lsh": (300.0, 150.0, 1.0),
    "rsh": (200.0, 150.0, 1.0),
    "lel": (380.0, 150.0, 1.0),
    "rwr": (60.0, 152.0, 0.9),
    "ridxtip": (30.0, 152.0, 0.9),
    "lan": (280.0, 440.0, 1.0),
}


def drawn(size=(500, 500), points=POINTS, **options):
    pixels = np.full((size[1], size[0], 3), 100, np.uint8)
    png = overlay(pixels, Skeleton(points=points, size=size, source="test"), **options)
    assert png.startswith(b"\x89PNG")
    assert (pixels == 100).all()  # the picture itself is left alone
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def colour_at(picture, x, y):
    """The colour there, as the palette has it where it is near to one of its (lines have soft edges)."""
    found = tuple(int(value) for value in picture[y, x])
    near = (colour for colour in (LEFT, RIGHT, MEASURED, SHEET) if np.abs(np.subtract(colour, found)).max() < 30)
    return next(near, found)


def test_points_have_the_colour_of_their_side():
    picture = drawn()
    assert colour_at(picture, 380, 150) == LEFT
    assert colour_at(picture, 280, 440) == LEFT
    assert colour_at(picture, 60, 152) == RIGHT


def test_the_measured_lines_are_those_of_the_arm():
    right, left = drawn(arm="right"), drawn(arm="left")
    assert colour_at(right, 220, 115) == MEASURED  # half way from the right shoulder to the right eye
    assert colour_at(right, 100, 151) == MEASURED  # on the way to the fingertip
    assert colour_at(left, 220, 115) == (100, 100, 100)
    assert colour_at(left, 280, 115) == MEASURED
    assert colour_at(right, 280, 115) == (100, 100, 100)
    both = drawn()
    assert colour_at(both, 220, 115) == colour_at(both, 280, 115) == MEASURED


def test_a_sure_point_is_drawn_upon_an_unsure_one():
    picture = drawn(points={"leye": (260.0, 80.0, 1.0), "rear": (260.0, 80.0, 0.1)})
    assert colour_at(picture, 260, 80) == LEFT


def test_without_a_fingertip_the_arm_ends_at_the_wrist():
    picture = drawn(points={name: point for name, point in POINTS.items() if name != "ridxtip"}, arm="right")
    assert colour_at(picture, 130, 151) == MEASURED
    assert colour_at(picture, 45, 152) == (100, 100, 100)


def test_the_marker_is_outlined():
    corners = np.array([[200.0, 400], [260, 400], [270, 430], [190, 430]])
    assert colour_at(drawn(marker=Marker(corners, 7)), 230, 400) == SHEET
    assert colour_at(drawn(), 230, 400) == (100, 100, 100)


def test_notes_stand_below_the_picture():
    bare, noted = drawn(), drawn(notes=("eye height 1.64 m ± 0.02", "a second line"))
    assert bare.shape[0] > 500
    step = (noted.shape[0] - bare.shape[0]) / 2
    assert 10 < step < 60
    assert (noted[bare.shape[0] :] > 128).any()


def test_long_notes_are_wrapped():
    words = "the focal length is not in the picture and was found from the perspective of the sheet on the floor"
    once, twice = drawn(notes=(words,)), drawn(notes=(words, words))
    assert twice.shape[0] - once.shape[0] >= 2 * (drawn(notes=("a",)).shape[0] - drawn().shape[0])
    assert not (once[500:, -4:] > 60).any()  # nothing runs over the rim


def test_a_large_picture_is_drawn_small_at_the_right_place():
    picture = drawn(size=(4000, 3000), points={"lsh": (2000.0, 1500.0, 1.0)})
    assert picture.shape[1] == DRAWN_SIDE
    assert colour_at(picture, 800, 600) == LEFT


def test_points_outside_and_an_empty_skeleton_do_no_harm():
    assert drawn(points={"lsh": (-9e9, 1e12, 0.5), "lel": (100.0, 100.0, 1.0)}).shape[1] == 500
    assert drawn(points={}).shape[1] == 500


def test_a_point_that_is_not_sure_is_hollow_and_without_lines():
    unsure = POINTS | {"lel": (380.0, 150.0, 0.1)}
    picture = drawn(points=unsure, arm="right")
    assert colour_at(picture, 380, 150) == (0, 0, 0)
    assert colour_at(picture, 340, 150) == (100, 100, 100)
    assert colour_at(drawn(arm="right"), 340, 150) == LEFT


def test_names_never_cover_a_point():
    crowded = {"nose": (250.0, 80.0, 1.0), "leye": (258.0, 74.0, 1.0), "reye": (242.0, 74.0, 1.0)}
    picture = drawn(points=crowded)
    assert colour_at(picture, 258, 74) == LEFT
    assert colour_at(picture, 242, 74) == RIGHT


def test_colours_differ_to_the_colour_blind():
    # brightness alone (CIE Y of sRGB) keeps left, right and measured apart
    light = [np.dot((np.array(colour) / 255) ** 2.2, [0.2126, 0.7152, 0.0722]) for colour in (SHEET, LEFT, MEASURED)]
    assert light[0] + 0.1 < light[1] < light[2] - 0.2
    assert LEFT[2] > 2 * LEFT[0] > 0 == RIGHT[2]  # blue against yellow is what red-green blindness leaves


def test_the_same_picture_gives_the_same_bytes():
    skeleton = Skeleton(points=POINTS, size=(500, 500), source="test")
    pixels = np.full((500, 500, 3), 100, np.uint8)
    assert overlay(pixels, skeleton, notes=("a",)) == overlay(pixels, skeleton, notes=("a",))
