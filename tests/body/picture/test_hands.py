import numpy as np
import pytest

from armspan.body.picture.hands import TIPS, about, agreement, follow, hand_points
from armspan.body.picture.landmarks import Points

ELBOW, WRIST, KNUCKLES = np.array([50.0, 100]), np.array([100.0, 100]), np.array([120.0, 100])


def hand_of(image_point: np.ndarray, score: float):
    """A network that finds a hand of 21 points all at one place of its picture, but the wrist and middle knuckle."""

    def network(picture):
        places = np.zeros((21, 3))
        places[:, :2] = image_point
        places[0, :2], places[9, :2] = (112, 180), (112, 110)
        return [places.ravel(), np.array([score]), np.array([0.5]), np.zeros(63)]

    return network


def test_the_first_square_has_the_fingers_up_and_room_for_them():
    region = about(WRIST, KNUCKLES, 50)
    up = region.to_picture(np.array([0.5, 0.0])) - region.centre
    assert up / np.linalg.norm(up) == pytest.approx([1, 0])
    assert region.to_picture(np.array([0.5, 0.0]))[0] > 100 + 0.75 * 50  # beyond the longest finger
    assert region.to_picture(np.array([0.5, 1.0]))[0] < 100


def test_a_hand_that_points_at_the_camera_keeps_its_room():
    places = np.tile(WRIST, (21, 1))
    places[9] = WRIST + np.array([2, 0])
    assert follow(places, 50).size >= 50


def test_the_fingers_are_those_of_the_published_network():
    assert dict(TIPS) == {"idxtip": 8, "midtip": 12}


def test_a_hand_is_found_where_the_network_points():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    found = hand_points(np.zeros((200, 300, 3), np.uint8), ELBOW, WRIST, KNUCKLES, hand_of(np.array([112, 20]), 0.95))
    assert found is not None
    assert found.score == pytest.approx(0.95)
    assert found.places[8][0] > found.places[9][0] > found.places[0][0]  # along the arm
    assert found.places[8][1] == pytest.approx(100, abs=3)


def test_a_finger_on_which_the_looks_differ_is_less_sure():
    places = np.zeros((4, 21, 2))
    places[2:, 8] = 6, 8  # half of the looks see it stretched
    places[3, 12] = 0, 4
    looks = [Points(each, np.ones(21), 0.9) for each in places]
    assert agreement(looks, 10.0)[[0, 8, 12]] == pytest.approx([1, 0.5, 0.9])
    assert agreement(looks, 4.0)[8] == 0


def test_a_doubtful_hand_is_none():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    image = np.zeros((200, 300, 3), np.uint8)
    assert hand_points(image, ELBOW, WRIST, KNUCKLES, hand_of(np.array([112, 20]), 0.55)) is None


def test_a_hand_on_another_wrist_is_none():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")

    def elsewhere(picture):
        places = np.zeros((21, 3))
        places[:, :2] = 20, 20
        places[9, :2] = 20, -40
        return [places.ravel(), np.array([0.99]), np.array([0.5]), np.zeros(63)]

    image = np.zeros((200, 300, 3), np.uint8)
    assert hand_points(image, ELBOW, WRIST, KNUCKLES, elsewhere) is None


def test_an_arm_of_no_length_is_no_crash():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    image = np.zeros((20, 30, 3), np.uint8)
    found = hand_points(image, WRIST, WRIST, WRIST, hand_of(np.array([112, 20]), 0.95))
    assert found is not None
    assert found.places == pytest.approx(np.tile(WRIST, (21, 1)))
