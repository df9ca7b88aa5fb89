from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import least_squares as scipy_least_squares

from armspan.pointing.least_squares import Problem, angles, linearise, minimise, miss, robust_cost, solve


def random_problem(rng, count=4, sigma=0.035):
    """Noisy rays from one eye to a square sheet at a random place, and that place."""
    side = rng.uniform(0.4, 1.0)
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0]])[:count] * side
    points = points - points.mean(axis=0)
    yaw, centroid = rng.uniform(-np.pi, np.pi), np.array([rng.uniform(0.6, 2.0), 0.1, rng.uniform(0.0, 0.9)])
    eye = np.array([0.0, 0.0, 1.65])
    c, s = np.cos(yaw), np.sin(yaw)
    rays = points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) + centroid - eye
    rays = rays / np.linalg.norm(rays, axis=1, keepdims=True) + sigma * rng.normal(size=(count, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return Problem(np.tile(eye, (count, 1)), rays, points, np.ones(count)), np.array([*centroid, yaw])


def written_out(problem, parameters):
    """Angles by the arc cosine, pair by pair."""
    x0, y0, z0, yaw = parameters
    found = []
    for o, d, (x, y, z) in zip(problem.origins, problem.directions, problem.points, strict=True):
        q = [np.cos(yaw) * x + np.sin(yaw) * y + x0, np.cos(yaw) * y - np.sin(yaw) * x + y0, z + z0]
        v = np.array(q) - o
        found.append(np.arccos(d @ v / np.linalg.norm(v)))
    return np.array(found)


def test_angles_and_rotation_vectors():
    problem, place = random_problem(np.random.default_rng(0), 5)
    expected = written_out(problem, place)
    assert_allclose(angles(problem, place[None])[0], expected, rtol=1e-9)
    assert_allclose(np.linalg.norm(miss(problem, place), axis=1), expected, rtol=1e-9)


def test_the_cost_is_that_of_soft_l1():
    problem, place = random_problem(np.random.default_rng(1), 5)
    problem = replace(problem, weights=np.array([1.0, 2.0, 0.5, 1.0, 3.0]))
    z = (written_out(problem, place) / problem.loss_scale) ** 2
    expected = 0.5 * problem.loss_scale**2 * np.sum(problem.weights * 2 * (np.sqrt(1 + z) - 1))
    assert_allclose(linearise(problem, place[None]).cost, [expected], rtol=1e-12)
    assert_allclose(robust_cost(problem, angles(problem, place[None])), [expected], rtol=1e-12)


def test_the_gradient_agrees_with_finite_differences():
    rng = np.random.default_rng(2)
    problem, place = random_problem(rng, 5)
    starts = place + rng.normal(0, 0.2, (6, 4))
    here, step = linearise(problem, starts), 1e-6
    for k in range(4):
        move = step * np.eye(4)[k]
        slope = (linearise(problem, starts + move).cost - linearise(problem, starts - move).cost) / (2 * step)
        assert_allclose(here.gradient[:, k], slope, atol=1e-9)


def test_the_curvature_is_gauss_newtons_of_the_angles_with_the_bend_of_the_loss():
    problem, place = random_problem(np.random.default_rng(3), 5, sigma=np.radians(4.0))
    step, here = 1e-6, linearise(problem, place[None])
    slopes = np.stack([(miss(problem, place + m) - miss(problem, place - m)) / (2 * step) for m in step * np.eye(4)])
    residuals = miss(problem, place)
    expected = np.zeros((4, 4))
    for i, r in enumerate(residuals):
        jacobian = slopes[:, i].T
        z = r @ r / problem.loss_scale**2
        bend = (1 + z) ** -0.5 * np.eye(3) - (1 + z) ** -1.5 * np.outer(r, r) / problem.loss_scale**2
        expected += jacobian.T @ bend @ jacobian
    assert_allclose(here.curvature[0], expected, rtol=1e-5, atol=1e-6)


def test_scipy_finds_the_same_minimum_of_the_same_cost():
    rng = np.random.default_rng(4)
    for _ in range(15):
        problem, place = random_problem(rng, 5, sigma=np.radians(3.0))
        found, cost = solve(problem)
        scipys = scipy_least_squares(
            lambda x, p=problem: written_out(p, x),
            place,
            loss="soft_l1",
            f_scale=problem.loss_scale,
            xtol=1e-14,
            ftol=1e-14,
            gtol=1e-14,
            max_nfev=2000,
        )
        assert cost <= scipys.cost * (1 + 1e-6)
        assert_allclose(cost, scipys.cost, rtol=1e-4)
        assert_allclose(found[:3], scipys.x[:3], atol=2e-3)


def test_no_wrong_minimum_on_random_set_ups():
    rng = np.random.default_rng(5)
    for _ in range(60):
        problem, place = random_problem(rng)
        starts = place + np.column_stack([rng.normal(0, 0.4, (24, 3)), np.linspace(-np.pi, np.pi, 24)])
        best = minimise(problem, np.vstack([starts, place]), iterations=200)[1].min()
        assert solve(problem)[1] <= best * (1 + 1e-6)


def test_without_noise_the_place_is_exact():
    rng = np.random.default_rng(6)
    for _ in range(20):
        problem, place = random_problem(rng, sigma=0.0)
        found, _ = solve(problem)
        assert_allclose(found[:3], place[:3], atol=1e-9)


def test_a_wrong_ray_pulls_less_than_with_plain_squares():
    problem, place = random_problem(np.random.default_rng(7), 5, sigma=0.0)
    directions = problem.directions.copy()
    directions[4] += [0.0, 0.5, 0.0]
    directions[4] /= np.linalg.norm(directions[4])
    wrong = replace(problem, directions=directions)
    robust = np.linalg.norm(solve(wrong)[0][:3] - place[:3])
    plain = np.linalg.norm(solve(replace(wrong, loss_scale=1e3))[0][:3] - place[:3])
    assert robust < 0.7 * plain


def test_rays_that_coincide_are_singular():
    problem, _ = random_problem(np.random.default_rng(8), sigma=0.0)
    with pytest.raises(np.linalg.LinAlgError):
        solve(replace(problem, directions=np.tile([0.0, 0.0, -1.0], (4, 1))))
