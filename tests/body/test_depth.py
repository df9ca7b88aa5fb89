import numpy as np
import pytest

from armspan.body.anthropometry import prior
from armspan.body.depth import depths_of, place
from armspan.body.told import Told
from filmed_person import Person


class Doubling:
    """Ten pixels a metre, half as many for each metre nearer; nothing can be placed at negative x."""

    sd_share, height_sd, notes = 0.0, 0.0, ()

    def __init__(self, shift=0.0):
        self.shift = shift

    def place(self, points):
        return np.where(points[:, :1] < 0.0, np.nan, points / 10.0 * 0.5**self.shift)

    def nearer(self, distance):
        return Doubling(self.shift + distance)


def test_points_are_placed_each_in_its_own_plane():
    points = {"lsh": (20.0, 30.0, 0.9), "rsh": (20.0, 30.0, 0.9), "nose": (-1.0, 30.0, 0.9)}
    placed = place(points, Doubling(), {"rsh": 1.0})
    assert {name: point.tolist() for name, point in placed.items()} == {"lsh": [2.0, 3.0, 0.0], "rsh": [1.0, 1.5, 1.0]}


def test_from_the_front_the_face_is_nearer_than_the_shoulders_and_those_than_the_ankles():
    depths = depths_of({}, "front", prior(Told(height_m=1.75)))
    assert 0.0 < depths["lsh"] == depths["ridxtip"] == depths["neck"] < depths["nose"] == depths["leye"]
    assert not {"lan", "rheel", "lhip"} & set(depths)


@pytest.mark.parametrize("arm", ["left", "right"])
@pytest.mark.parametrize("seen_from", ["left", "right"])
def test_from_the_side_depths_are_those_of_a_person_who_points(arm, seen_from):
    """Against the person of `filmed_person`, whose shoulders and finger lie where anatomy puts them."""
    points = Person().pointing(arm, slope=0.0)
    nearer = 1.0 if seen_from == "left" else -1.0  # y runs to the person's left
    picture = {name: np.array([-nearer * x, z, 0.0]) for name, (x, _, z) in points.items()}
    depths = depths_of(picture, "side", prior(Told(height_m=1.75, sex="man", arm=arm)))
    assert set(depths) == {"lsh", "rsh", *(arm[0] + end for end in ("el", "wr", "idxknuckle", "idxtip", "midtip"))}
    for name, depth in depths.items():
        # joints are 0.18 m from the middle, a shoulder's point 0.10 of the stature
        assert depth == pytest.approx(nearer * points[name][1], abs=0.03), name


def test_who_looks_nowhere_has_no_depths():
    assert depths_of({"rsh": np.zeros(3)}, "side", prior(Told(height_m=1.75))) == {}
