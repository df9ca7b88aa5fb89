import numpy as np
from numpy.testing import assert_allclose

from armspan.pointing.least_squares import Problem, solve
from armspan.pointing.misfits import leave_out_misfits
from straight_arms import SQUARE, place_before, seen_from

XYZ = place_before(SQUARE, [1.2, 0.1, 0.7], 0.4)
SIGMA = np.radians(2.0)


def problem(shift_deg, points=SQUARE):
    """Rays to the points, the last of which is turned aside about the vertical."""
    rays = seen_from(points, XYZ, 0.4) - [0.0, 0.0, 1.6]
    turn = np.radians(shift_deg)
    x, y, z = rays[-1]
    rays[-1] = [np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, z]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    origins = np.tile([0.0, 0.0, 1.6], (len(points), 1))
    return Problem(origins, rays, (points - points.mean(axis=0)) * [1, -1, -1], np.ones(len(points)))


def test_a_stop_tens_of_degrees_off_is_left_out_and_a_few_degrees_are_kept():
    far, near = problem(50.0), problem(5.0)
    kept, place = leave_out_misfits(far, *solve(far), SIGMA)
    assert_allclose(kept.weights, [1, 1, 1, 0])
    assert_allclose(place[3], 0.4, atol=1e-6)
    assert_allclose(far.weights, 1.0)
    assert_allclose(leave_out_misfits(near, *solve(near), SIGMA)[0].weights, 1.0)


def test_three_stops_are_never_made_two():
    three = problem(50.0, SQUARE[:3])
    assert_allclose(leave_out_misfits(three, *solve(three), SIGMA)[0].weights, 1.0)


def test_a_stop_without_which_the_rest_lies_on_one_line_is_kept():
    points = np.array([[0.0, 0, 0], [0.4, 0, 0], [0.8, 0, 0], [0.4, 0.6, 0]])
    line = problem(40.0, points)
    assert leave_out_misfits(line, *solve(line), SIGMA)[0].weights[3] == 1.0


def test_of_many_stops_two_may_be_left_out():
    points = np.vstack([SQUARE, SQUARE * 0.5 + [0.2, 0.1, 0.0]])
    eight = problem(45.0, points)
    rays = eight.directions.copy()
    rays[0] = rays[0] + [0.0, 0.8, 0.0]
    rays[0] /= np.linalg.norm(rays[0])
    two = Problem(eight.origins, rays, eight.points, eight.weights)
    assert_allclose(leave_out_misfits(two, *solve(two), SIGMA)[0].weights, [0, 1, 1, 1, 1, 1, 1, 0])
