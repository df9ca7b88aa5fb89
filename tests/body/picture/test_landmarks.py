import numpy as np
import pytest

from armspan.body.picture.landmarks import Points, body_points, exchanged, look, middle, refined
from armspan.body.picture.regions import Region

COLD = np.full((64, 64, 39), -9.0)


def told(places: np.ndarray, *, visible: float = 2, present: float = 3, score: float = 0.9, heat: np.ndarray = COLD):
    """What the network says of 39 places in its picture of 256 pixels; the two confidences are log odds."""
    table = np.zeros((39, 5))
    table[:, :2], table[:, 3], table[:, 4] = places, visible, present
    return [table.ravel(), np.array([score]), np.zeros((256, 256, 1)), heat, np.zeros(117)]


def test_a_look_places_the_points_and_takes_the_lesser_confidence():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    places = np.tile([128.0, 128.0], (39, 1))
    places[3] = 0, 256
    seen = look(np.zeros((40, 40, 3), np.uint8), Region(np.array([20.0, 10]), 8), lambda _: told(places))
    assert seen.places[0] == pytest.approx([20, 10])
    assert seen.places[3] == pytest.approx([16, 14])
    assert seen.confidences[0] == pytest.approx(0.880797)  # 1 / (1 + exp(-2))
    assert seen.score == 0.9


def test_a_mirrored_look_exchanges_left_and_right():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    places = np.tile([128.0, 128.0], (39, 1))
    places[11] = 64, 128  # the left shoulder of the mirror picture
    seen = look(np.zeros((9, 9, 3), np.uint8), Region(np.array([20.0, 10]), 8, mirrored=True), lambda _: told(places))
    assert seen.places[12] == pytest.approx([22, 10])
    assert seen.places[11] == pytest.approx([20, 10])


def test_left_and_right_are_exchanged_in_pairs():
    order = exchanged()
    assert [order[each] for each in (0, 1, 2, 3, 7, 9, 11, 16, 19, 31)] == [0, 4, 5, 6, 8, 10, 12, 15, 20, 32]
    assert [order[each] for each in order] == list(range(39))


def test_a_place_moves_to_the_heat_near_it():
    heat = np.zeros((64, 64, 2))
    heat[20, 31, 0], heat[20, 32, 0] = 0.6, 0.6
    heat[50, 50, 0] = 0.9  # too far to count
    heat[20, 31, 1] = 0.4  # too cold to count
    there = np.array([30.2, 21.7]) / 64
    moved = refined(np.array([there, there]), heat)
    assert moved[0] * 64 == pytest.approx([31.5, 20])
    assert moved[1] == pytest.approx(there)


@pytest.mark.parametrize("place", [(-0.3, 0.5), (0.5, 1.4), (5.0, 5.0), (0.999, 0.001)])
def test_a_place_at_the_border_or_outside_stays_sound(place):
    moved = refined(np.array([place]), np.full((64, 64, 1), 0.1))
    assert moved[0] == pytest.approx(place)


def test_the_median_outlives_a_look_that_went_astray():
    looks = [Points(np.full((39, 2), value), np.full(39, 0.5), 0.9) for value in (10.0, 11.0, 12.0, 11.5, 400.0)]
    found = middle(looks, 33)
    assert found.places == pytest.approx(np.full((33, 2), 11.5))
    assert len(found.confidences) == 33


def test_the_second_square_follows_from_the_first_look():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    image = np.zeros((300, 300, 3), np.uint8)
    image[100:200, 100:200] = 255
    bright = []

    def network(picture):
        bright.append(float(picture.mean()))
        places = np.tile([128.0, 128.0], (39, 1))
        places[34] = 128, 128 - 256 / 2.5  # the circle just fills this square: the next is the same
        return told(places)

    found = body_points(image, Region(np.array([150.0, 150]), 100), network)
    assert found is not None
    assert found.places.shape == (33, 2)
    assert found.places == pytest.approx(np.full((33, 2), 150.0))
    assert len(bright) == 7
    assert bright[:3] == pytest.approx([1, 1, 1], abs=0.01)  # the square itself, and its mirror picture
    assert bright[3:5] == pytest.approx([1 / 1.1**2] * 2, abs=0.01)  # a larger one
    assert bright[5] > bright[0]  # a smaller one


def test_nobody_in_the_square():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    nothing = told(np.zeros((39, 2)), score=0.2)
    assert body_points(np.zeros((9, 9, 3), np.uint8), Region(np.zeros(2), 9), lambda _: nothing) is None


def test_a_likeness_on_which_the_looks_disagree_is_nobody():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    image, square = np.zeros((300, 300, 3), np.uint8), Region(np.array([150.0, 150]), 100)

    def looks(off):
        dice = np.random.default_rng(1)

        def network(picture):
            places = 128 + off * dice.choice([-1.0, 1.0], (39, 2))
            places[33], places[34] = (128, 128), (128, 128 - 256 / 2.5)
            return told(places)

        return network

    assert body_points(image, square, looks(1.5)) is not None  # 0.6 % of the square to the side and down
    assert body_points(image, square, looks(8.0)) is None
