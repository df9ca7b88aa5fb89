"""Skeletons: their names, which points are trusted, and the small geometry of a picture."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from armspan.body.skeleton import NAMES, Skeleton, bend_between, facing, middle, skeleton_document
from armspan.errors import DataError


def test_an_unknown_point_is_answered_with_those_there_are() -> None:
    with pytest.raises(DataError, match=r"'lwrist' does not exist; there are: .*Did you mean 'lwr'"):
        Skeleton({"lwrist": (1.0, 2.0, 1.0)}, None, "test")


def test_every_point_has_a_name_of_its_own_and_both_sides() -> None:
    assert len(set(NAMES)) == len(NAMES)
    sided = [name for name in NAMES if name not in ("nose", "neck", "crown")]
    assert {name[0] for name in sided} == {"l", "r"}
    assert {name[1:] for name in sided if name[0] == "l"} == {name[1:] for name in sided if name[0] == "r"}


def test_points_that_are_unsure_or_outside_the_picture_are_not_trusted() -> None:
    points = {
        "nose": (5.0, 5.0, 0.3),
        "lsh": (5.0, 5.0, 0.29),
        "lwr": (-0.1, 5.0, 0.9),
        "rwr": (10.0, 20.0, 0.9),
        "rel": (10.1, 5.0, 1.0),
        "lel": (5.0, 20.1, 1.0),
    }
    skeleton = Skeleton(points, (10, 20), "test")
    assert set(skeleton.trusted()) == {"nose", "rwr"}
    assert [name for name in points if skeleton.outside(name)] == ["lwr", "rel", "lel"]
    assert set(Skeleton(points, None, "test").trusted()) == set(points) - {"lsh"}


def test_the_document_holds_plain_lists() -> None:
    skeleton = Skeleton({"nose": (1.0, 2.0, 0.5)}, (10, 20), "OpenPose BODY_25", 0.7)
    assert skeleton_document(skeleton) == {
        "armspan_skeleton": 1,
        "source": "OpenPose BODY_25",
        "size": [10, 20],
        "score": 0.7,
        "points": {"nose": [1.0, 2.0, 0.5]},
    }


@pytest.mark.parametrize(
    ("first", "second", "degrees"),
    [((1, 0), (2, 0), 0), ((1, 0), (0, 3), 90), ((1, 0), (0, -3), 90), ((1, 1), (-1, -1), 180), ((1, 0), (1, 1), 45)],
)
def test_the_bend_between_two_ways(first: tuple[float, float], second: tuple[float, float], degrees: float) -> None:
    assert_allclose(bend_between(np.array(first, float), np.array(second, float)), degrees, atol=1e-9)


@given(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4))
def test_the_middle_of_one_point_is_that_point(x: float, y: float) -> None:
    found = middle({"leye": (x, y, 1.0)}, "leye", "reye")
    assert found is not None
    assert tuple(found) == (x, y)
    assert middle({}, "leye", "reye") is None


def test_a_person_faces_where_the_nose_lies_from_the_ears_or_the_toes_from_the_heels() -> None:
    head = facing({"lear": (10.0, 5.0, 1.0), "nose": (4.0, 6.0, 1.0)})
    feet = facing({"lheel": (10.0, 50.0, 1.0), "ltoe": (20.0, 51.0, 1.0)})
    assert head is not None
    assert feet is not None
    assert_allclose(head, [-6.0, 1.0])
    assert_allclose(feet, [10.0, 1.0])
    assert facing({"nose": (4.0, 6.0, 1.0), "lheel": (1.0, 1.0, 1.0)}) is None
