import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.errors import CalibrationError
from armspan.pointing.pairs import CORRELATION_S, area, check_layout, moving_pairs, still_pairs
from straight_arms import SQUARE, with_x


def attitudes(azimuths_deg):
    a = np.radians(azimuths_deg)
    return with_x(np.column_stack([np.cos(a), np.sin(a), np.zeros_like(a)]))


def test_a_stop_is_one_pair_however_many_samples_it_has():
    forearm = attitudes([10.0, 10.0, 10.0, 40.0])
    points = SQUARE[[0, 0, 0, 1]]
    pairs = still_pairs(forearm, None, points, ("a", "a", "a", "b"))
    assert pairs.stops == ("a", "b")
    assert_allclose(pairs.counts, [3, 1])
    assert_allclose(pairs.weights, [1, 1])
    assert_allclose(pairs.points, SQUARE[:2])
    assert_allclose(pairs.user_from_forearm, attitudes([10.0, 40.0]), atol=1e-12)
    assert pairs.user_from_upperarm is None


def test_the_median_leaves_out_the_moment_in_which_the_arm_settles():
    settling = attitudes([-60.0, -20.0, 10.0, 10.0, 10.0, 10.0, 10.0])
    pairs = still_pairs(settling, settling, np.zeros((7, 3)), ("a",) * 7)
    assert_allclose(pairs.user_from_forearm, attitudes([10.0]), atol=1e-12)
    assert_allclose(pairs.user_from_upperarm, attitudes([10.0]), atol=1e-12)


def test_rows_of_one_stop_may_lie_apart_in_the_file_but_not_on_the_sheet():
    forearm = attitudes([0.0, 20.0, 2.0])
    pairs = still_pairs(forearm, None, SQUARE[[0, 1, 0]], ("a", "b", "a"))
    assert pairs.stops == ("a", "b")
    with pytest.raises(CalibrationError, match=r"Stop 'a' has points 0.40 m from its middle"):
        still_pairs(forearm, None, SQUARE[[0, 1, 1]], ("a", "a", "b"))


def test_moving_samples_count_by_the_time_they_span():
    times = np.linspace(0.0, 10 * CORRELATION_S, 600)
    pairs = moving_pairs(attitudes(np.zeros(600)), None, np.zeros((600, 3)), times)
    assert_allclose(pairs.weights.sum(), 11.0)
    assert pairs.stops is None
    few = moving_pairs(attitudes(np.zeros(3)), None, np.zeros((3, 3)), np.array([0.0, 50.0, 100.0]))
    assert_allclose(few.weights, 1.0)


def test_too_few_places_are_refused_with_their_number():
    check_layout(SQUARE[:3])
    with pytest.raises(CalibrationError, match="2 distinct points, but at least 3"):
        check_layout(SQUARE[[0, 1, 1, 0]])
    with pytest.raises(CalibrationError, match="1 distinct point, but"):
        check_layout(SQUARE[[0, 0, 0]] + [[0, 0, 0], [0.002, 0, 0], [0, 0.002, 0]])


def test_places_on_one_line_are_refused():
    line = np.array([[0.0, 0, 0], [0.4, 0.2, 0], [0.8, 0.4, 0.0], [0.2, 0.1, 0]])
    with pytest.raises(CalibrationError, match="4 points lie on one line"):
        check_layout(line)
    line[1, 1] += 0.1
    check_layout(line)


def test_the_area_is_the_middle_and_the_scatter_of_the_points():
    pairs = still_pairs(attitudes([0.0, 10, 20, 30]), None, SQUARE, ("0", "1", "2", "3"))
    found = area(pairs)
    assert_allclose(found.centre, [0.4, 0.3, 0.0])
    assert_allclose(found.scatter, [[0.16, 0.0], [0.0, 0.09]], atol=1e-12)


def test_points_on_a_wall_or_in_motion_span_no_area_of_a_sheet():
    wall = SQUARE[:, [0, 2, 1]]
    assert area(still_pairs(attitudes([0.0, 10, 20, 30]), None, wall, ("0", "1", "2", "3"))) is None
    assert area(moving_pairs(attitudes([0.0, 10, 20, 30]), None, SQUARE, np.arange(4.0))) is None
