import numpy as np
import pytest

from armspan.simulation.person import VirtualPerson, draw_person
from armspan.study.pointing_error.recordings import numbered_places
from armspan.study.pointing_error.virtual import nine_places, settled, virtual_gestures

PLACES = nine_places((2.0, 0.3), 0.5, 0.49)


def test_nine_places_are_numbered_as_those_of_recordings():
    assert numbered_places(PLACES).tolist() == list(range(9))
    assert PLACES[[0, 4, 8]] == pytest.approx(np.array([[1.5, -0.2, 0.49], [2.0, 0.3, 0.49], [2.5, 0.8, 0.49]]))


def test_a_held_attitude_is_a_rotation_near_each_of_its_moments():
    rng = np.random.default_rng(1)
    someone = VirtualPerson(draw_person(rng, posture="natural"), (0.0, 0.0), 0.0, rng)
    someone.point(0.0, PLACES[4])
    pose = someone.pose(2.5 + np.linspace(0.0, 0.5, 5))
    for attitude, moments in zip(settled(someone, 2.5), (pose.room_from_forearm, pose.room_from_upperarm), strict=True):
        assert attitude @ attitude.T == pytest.approx(np.eye(3))
        assert np.linalg.det(attitude) == pytest.approx(1.0)
        cosines = (np.einsum("ij,kij->k", attitude, moments) - 1.0) / 2.0
        assert np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))).max() < 3.0


@pytest.mark.parametrize("repeats", [1, 3])
def test_each_place_is_pointed_at_as_often_as_asked(repeats):
    found = virtual_gestures(np.random.default_rng(4), "straight", PLACES, repeats)
    assert np.bincount(found.places).tolist() == [repeats] * 9
    assert np.array_equal(found.targets, PLACES[found.places])
    assert found.forearm.shape == found.upperarm.shape == (9 * repeats, 3, 3)
    again = virtual_gestures(np.random.default_rng(4), "straight", PLACES, repeats)
    assert np.array_equal(found.upperarm, again.upperarm)


def test_a_straight_arm_points_roughly_at_its_places():
    """But for a heading that is off, and for one gesture in a hundred that goes elsewhere altogether."""
    found = virtual_gestures(np.random.default_rng(4), "straight", PLACES)
    azimuths = np.degrees(np.arctan2(found.forearm[:, 1, 0], found.forearm[:, 0, 0]))
    off = azimuths - np.degrees(np.arctan2(found.targets[:, 1], found.targets[:, 0]))
    assert np.median(np.abs(off - np.median(off))) < 2.0
    assert abs(np.median(off)) < 12.0  # three times the heading's deviation
    assert np.median(found.forearm[:, 2, 0]) < 0.0  # down to the low targets
