import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.pointing.closed_form import stationary_poses, stationary_yaws


def rays_and_points(rng, count=5, noise=0.0, flat=True, one_eye=True):
    points = rng.uniform(-0.5, 0.5, (count, 3)) * [1, 1, 0 if flat else 1]
    points -= points.mean(axis=0)
    yaw, centroid = rng.uniform(-np.pi, np.pi), np.array([1.2, 0.1, 0.5])
    origins = np.tile([0.0, 0.0, 1.6], (count, 1)) + (0 if one_eye else rng.normal(0, 0.2, (count, 3)))
    c, s = np.cos(yaw), np.sin(yaw)
    seen = points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) + centroid
    rays = seen - origins + rng.normal(0, noise, (count, 3))
    return origins, rays / np.linalg.norm(rays, axis=1, keepdims=True), points, centroid, yaw


def squared_distance(origins, directions, points, weights, centroid, yaw):
    """The objective, written out ray by ray."""
    c, s = np.cos(yaw), np.sin(yaw)
    total = 0.0
    for o, d, (x, y, z), w in zip(origins, directions, points, weights, strict=True):
        off = np.array([c * x + s * y, -s * x + c * y, z]) + centroid - o
        total += w * float(np.sum((off - d * (d @ off)) ** 2))
    return total


@pytest.mark.parametrize("flat", [True, False])
@pytest.mark.parametrize("one_eye", [True, False])  # one eye over a flat sheet is the "hard case"
def test_without_noise_one_of_the_poses_is_exact(flat, one_eye):
    rng = np.random.default_rng(3)
    for _ in range(20):
        o, d, p, centroid, yaw = rays_and_points(rng, flat=flat, one_eye=one_eye)
        centroids, yaws = stationary_poses(o, d, p, np.ones(len(p)))
        off = np.abs((yaws - yaw + np.pi) % (2 * np.pi) - np.pi)
        best = off.argmin()
        assert off[best] < 1e-7
        assert_allclose(centroids[best], centroid, atol=1e-6)


def test_the_least_pose_has_no_slope_and_no_other_yaw_is_lower():
    rng = np.random.default_rng(4)
    for _ in range(10):
        o, d, p, _, _ = rays_and_points(rng, noise=0.05, flat=False, one_eye=False)
        w = rng.uniform(0.5, 2.0, len(p))
        centroids, yaws = stationary_poses(o, d, p, w)
        costs = [squared_distance(o, d, p, w, c, y) for c, y in zip(centroids, yaws, strict=True)]
        best = int(np.argmin(costs))
        for step in 1e-4 * np.eye(4):
            for sign in (1, -1):
                moved = squared_distance(o, d, p, w, centroids[best] + sign * step[:3], yaws[best] + sign * step[3])
                assert moved > costs[best] - 1e-12
        grid = [squared_distance(o, d, p, w, centroids[best], y) for y in np.linspace(-np.pi, np.pi, 200)]
        assert costs[best] <= min(grid) + 1e-12


def test_the_origins_are_left_as_they_are():
    o, d, p, _, _ = rays_and_points(np.random.default_rng(5))
    kept = o.copy()
    stationary_poses(o, d, p, np.ones(len(p)))
    assert (o == kept).all()


def test_many_problems_at_once_are_each_alone():
    rng = np.random.default_rng(6)
    o, d, p, _, _ = (
        np.stack(arrays) for arrays in zip(*(rays_and_points(rng, noise=0.03) for _ in range(7)), strict=True)
    )
    weights = rng.uniform(0.5, 2.0, (7, 5))
    centroids, yaws = stationary_poses(o, d, p, weights)
    assert centroids.shape == (7, 4, 3)
    for k in range(7):
        alone, turns = stationary_poses(o[k], d[k], p[k], weights[k])
        assert_allclose(np.sort(yaws[k]), np.sort(turns), atol=1e-9)
        assert_allclose(centroids[k][np.argsort(yaws[k])], alone[np.argsort(turns)], atol=1e-9)


def test_a_quartic_without_its_ends_has_the_two_roots_on_the_circle():
    """1 + 2 (c cos + d sin) is least and greatest where (cos, sin) lies along (c, d)."""
    form = np.array([[1.0, 0.0, 0.3], [0.0, 1.0, -0.4], [0.3, -0.4, 0.0]])
    yaws = stationary_yaws(np.stack([form, np.zeros((3, 3))]))
    assert np.isfinite(yaws).all()
    for wanted in (np.arctan2(-0.4, 0.3), np.arctan2(0.4, -0.3)):
        assert np.abs((yaws[0] - wanted + np.pi) % (2 * np.pi) - np.pi).min() < 1e-9
