from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.records import Sheet
from armspan.swarm.paths import SLACK, nearest_pass, next_point

SHEET, MARGIN, CLEAR = Sheet(0.9, 0.6), 0.045, 0.11


def test_the_nearest_pass_by_hand():
    others = np.array([[0.5, 0.2], [0.0, 0.0], [1.2, 0.1]])
    assert nearest_pass(np.array([0.1, 0.1]), np.array([0.9, 0.1]), others) == pytest.approx([0.1, 0.1 * 2**0.5, 0.3])


def walk(start, goal, others, clear=CLEAR):
    """Straight from point to point until the goal; the corners (n, 2) of the way, or None where there is none."""
    here, corners = np.array(start), [np.array(start)]
    for _ in range(60):
        point = next_point(here, np.array(goal), np.array(others).reshape(-1, 2), SHEET, MARGIN, clear)
        if point is None:
            return None
        here = point
        corners.append(here)
        if np.allclose(here, goal):
            return np.array(corners)
    raise AssertionError("walked in circles")


def test_alone_the_way_is_straight():
    assert len(walk((0.1, 0.1), (0.8, 0.5), [])) == 2


def test_out_of_a_dead_end():
    """A robot at exactly the least gap from one neighbour, with its goal behind two that leave no way between."""
    way = walk((0.411, 0.277), (0.08, 0.08), [(0.389, 0.179), (0.668, 0.293), (0.317, 0.387)])
    assert way[-1] == pytest.approx([0.08, 0.08])
    assert len(way) > 2


def test_a_goal_nearer_to_another_than_usual_is_reached_all_the_same():
    assert walk((0.1, 0.1), (0.8, 0.5), [(0.8, 0.4)])[-1] == pytest.approx([0.8, 0.5])


def test_a_wall_has_no_way():
    assert walk((0.1, 0.3), (0.8, 0.3), [(0.45, y) for y in np.arange(0.05, 0.6, 0.1)]) is None


places = st.tuples(st.floats(0.06, 0.84), st.floats(0.06, 0.54))


@settings(max_examples=150, derandomize=True, deadline=None)
@given(places, places, st.lists(places, min_size=1, max_size=5))
def test_a_way_keeps_clear_and_stays_on_the_sheet(start, goal, others):
    others = [o for o in others if min(np.hypot(o[0] - x, o[1] - y) for x, y in (start, goal)) > 0.1]
    way = walk(start, goal, others)
    if way is None or not others:
        return
    ends = np.min([np.hypot(*(np.array(others) - end).T) for end in (start, goal)], axis=0)
    for a, b in pairwise(way):
        assert (nearest_pass(a, b, np.array(others)) >= np.minimum(CLEAR, ends) - 2 * SLACK).all()
    assert way.min() >= MARGIN - 1e-9
    assert way[:, 0].max() <= 0.9 - MARGIN + 1e-9
