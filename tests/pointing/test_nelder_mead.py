import numpy as np
from numpy.testing import assert_allclose
from scipy.optimize import minimize

from armspan.frames import sheet_from_user
from armspan.pointing.least_squares import Problem
from armspan.pointing.nelder_mead import nelder_mead, nelder_mead_report

POINTS = np.array([[0.2, 0.1, 0.0], [0.6, 0.1, 0.0], [0.6, 0.5, 0.0], [0.2, 0.5, 0.0]])
EYE = np.array([0.0, 0.0, 1.65])


def problem_at(xyz, yaw):
    rays = sheet_from_user(xyz, yaw).inverse().points(POINTS) - EYE
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    centre = POINTS.mean(axis=0)
    return Problem(np.tile(EYE, (4, 1)), rays, (POINTS - centre) * [1, -1, -1], np.ones(4)), centre


def test_in_metres_it_finds_the_place():
    xyz, yaw = np.array([-0.7, 0.3, 0.75]), 0.3
    problem, centre = problem_at(xyz, yaw)
    place = nelder_mead(problem, centre)
    assert_allclose(place[3], yaw, atol=1e-4)
    assert_allclose(sheet_from_user(xyz, yaw).points(place[:3]), centre, atol=1e-3)


def test_in_millimetres_it_finds_a_place_next_to_where_it_starts():
    """The seed's own direction of search: z lies near 800 mm, and x, y and yaw are small."""
    problem, centre = problem_at(np.array([-0.02, 0.01, 0.79]), 0.01)
    place = nelder_mead_report(problem, centre)
    found = centre - sheet_from_user((0.0, 0.0, 0.0), float(place[3])).points(place[:3])
    assert_allclose(found, [-0.02, 0.01, 0.79], atol=0.02)


def test_in_millimetres_it_is_scipys_default_simplex_on_the_mean_angle():
    """Against the report's call written out: x0 = [0, 0, 800, 0], Nelder-Mead, tol 1e-8, 10000 iterations."""
    problem, centre = problem_at(np.array([-0.7, 0.3, 0.75]), 0.3)

    def mean_angle(x):
        back = sheet_from_user(x[:3], x[3]).inverse()
        seen = back.points(1000.0 * POINTS) - 1000.0 * EYE
        cosines = (seen * problem.directions).sum(axis=1) / np.linalg.norm(seen, axis=1)
        return np.arccos(np.clip(cosines, -1.0, 1.0)).mean()

    start, options = [0.0, 0.0, 800.0, 0.0], {"maxiter": 10000}
    literal = minimize(mean_angle, start, method="Nelder-Mead", tol=1e-8, options=options)
    place = nelder_mead_report(problem, centre)
    xyz = centre - sheet_from_user((0.0, 0.0, 0.0), float(place[3])).points(place[:3])
    assert_allclose([*(1000.0 * xyz), place[3]], literal.x, atol=1.0)
    assert np.linalg.norm(xyz - [-0.7, 0.3, 0.75]) > 0.05  # without any noise it stopped centimetres off
