import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import least_squares

from armspan.pointing import batch
from armspan.pointing.batch import calibrate_many
from armspan.pointing.calibration import calibrate
from armspan.pointing.pairs import moving_pairs, still_pairs
from armspan.pointing.rays import arm_rays
from straight_arms import BODY, place_before, pointing_at, seen_from, with_x

EYE = np.array([0.0, 0.0, 1.65])
CORNERS = np.array([[0.0, 0.0, 0.0], [0.8, 0.0, 0.0], [0.8, 0.6, -0.05], [0.0, 0.6, 0.0], [0.4, 0.3, 0.0]])


def rays_to(points, xyz, yaw, z_up=False):
    """Unit rays from the eye, the place written out."""
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    rays = (points - xyz) @ ((np.eye(3) if z_up else np.diag([1, -1, -1])) @ turn) - EYE
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def noisy(rays, rng, degrees):
    rays = rays + np.radians(degrees) * rng.normal(size=rays.shape)
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def places(rng, count, z_up=False):
    yaws = rng.uniform(-np.pi, np.pi, count)
    centres = np.stack(
        [rng.uniform(0.6, 2.0, count), rng.uniform(-0.3, 0.3, count), rng.uniform(0.0, 0.9, count)], axis=1
    )
    xyz = [place_before(CORNERS, centre, yaw, z_up=z_up) for centre, yaw in zip(centres, yaws, strict=True)]
    return np.array(xyz), yaws


@pytest.mark.parametrize("z_up", [False, True])
def test_without_noise_every_place_is_exact(z_up):
    xyz, yaws = places(np.random.default_rng(1), 50, z_up)
    rays = np.stack([rays_to(CORNERS, x, yaw, z_up) for x, yaw in zip(xyz, yaws, strict=True)])
    many = calibrate_many(EYE, rays, CORNERS, z_up=z_up)
    assert_allclose(many.xyz, xyz, atol=1e-8)
    assert_allclose(many.yaw, yaws, atol=1e-8)
    assert_allclose(many.rms, 0.0, atol=1e-8)


def test_the_answers_are_those_of_single_calibrations():
    rng = np.random.default_rng(2)
    xyz, yaws = places(rng, 40)
    points = CORNERS * rng.uniform(0.5, 1.5, (40, 1, 1))
    rays, fits = [], []
    for own, place, yaw in zip(points, xyz, yaws, strict=True):
        x = noisy(pointing_at(seen_from(own, place, yaw))[:, :, 0], rng, 2.0)
        pairs = moving_pairs(with_x(x), None, own, np.linspace(0.0, 6.0, 5))
        fits.append(calibrate(BODY, pairs, "head-finger"))
        rays.append(arm_rays(BODY, with_x(x), None, "head-finger"))
    origins, directions = (np.stack(arrays) for arrays in zip(*rays, strict=True))
    many = calibrate_many(origins, directions, points, pairs.weights)
    assert_allclose(many.xyz, [fit.xyz for fit in fits], atol=1e-9)
    assert_allclose(many.yaw, [fit.yaw for fit in fits], atol=1e-9)
    assert_allclose(many.rms, [fit.rms for fit in fits], atol=1e-10)
    assert_allclose(many.cost, [fit.cost for fit in fits], atol=1e-12)
    for fit, covariance in zip(fits, many.covariance(1.0), strict=True):
        assert_allclose(fit.sigma**2 * covariance, fit.covariance, rtol=1e-6)


def test_scipy_finds_no_better_place():
    rng = np.random.default_rng(3)
    xyz, yaws = places(rng, 10)
    rays = np.stack([noisy(rays_to(CORNERS, x, yaw), rng, 2.0) for x, yaw in zip(xyz, yaws, strict=True)])
    many = calibrate_many(EYE, rays, CORNERS, loss_scale=1e6)
    for own, x, yaw, cost in zip(rays, xyz, yaws, many.cost, strict=True):

        def misses(pose, own=own):
            wanted = rays_to(CORNERS, pose[:3], pose[3])
            across = np.cross(own, wanted)
            sine = np.linalg.norm(across, axis=1)
            return (across * (np.arcsin(sine) / sine)[:, None]).ravel()

        found = least_squares(misses, [*x, yaw], x_scale="jac", xtol=1e-12, ftol=1e-12)
        assert_allclose(cost, found.cost, rtol=1e-5)


def test_the_covariance_is_the_scatter_of_many_draws():
    rng = np.random.default_rng(4)
    true = rays_to(CORNERS, np.array([-1.0, 0.3, 0.75]), 0.4)
    rays = noisy(np.broadcast_to(true, (3000, 5, 3)), rng, 0.5)
    many = calibrate_many(EYE, rays, CORNERS)
    scatter = np.cov(np.column_stack([many.xyz, many.yaw]).T)
    told = calibrate_many(EYE, true[None], CORNERS).covariance(np.radians(0.5))[0]
    assert_allclose(np.sqrt(np.diagonal(scatter)), np.sqrt(np.diagonal(told)), rtol=0.06)
    assert_allclose(
        np.corrcoef(many.xyz[:, 0], many.yaw)[0, 1], told[0, 3] / np.sqrt(told[0, 0] * told[3, 3]), atol=0.1
    )


def test_a_weight_of_0_leaves_a_ray_out():
    rng = np.random.default_rng(5)
    rays = noisy(np.broadcast_to(rays_to(CORNERS, np.array([-1.0, 0.3, 0.75]), 0.4), (8, 5, 3)), rng, 2.0)
    weights = np.ones((8, 5))
    weights[:, 4] = 0.0
    told, fewer = calibrate_many(EYE, rays, CORNERS, weights), calibrate_many(EYE, rays[:, :4], CORNERS[:4])
    assert_allclose(told.xyz, fewer.xyz, atol=1e-5)  # centred elsewhere, so that it takes other steps
    assert_allclose(told.rms, fewer.rms, atol=1e-8)


def test_rays_that_run_parallel_or_are_no_numbers_leave_the_others_alone():
    rng = np.random.default_rng(6)
    rays = noisy(np.broadcast_to(rays_to(CORNERS, np.array([-1.0, 0.3, 0.75]), 0.4), (5, 5, 3)), rng, 2.0)
    alone = calibrate_many(EYE, rays[[0, 2, 4]], CORNERS)
    rays[1], rays[3, 2] = [0.0, 0.0, -1.0], np.nan
    many = calibrate_many(EYE, rays, CORNERS)
    assert np.isnan(many.xyz[[1, 3]]).all()
    assert np.isnan(many.cost[[1, 3]]).all()
    assert_allclose(many.xyz[[0, 2, 4]], alone.xyz, atol=1e-9)
    assert np.isnan(calibrate_many(EYE, rays[[1, 3]], CORNERS).yaw).all()


def test_progress_is_told_chunk_by_chunk_and_chunks_do_not_show(monkeypatch):
    rng = np.random.default_rng(7)
    rays = noisy(np.broadcast_to(rays_to(CORNERS, np.array([-1.0, 0.3, 0.75]), 0.4), (11, 5, 3)), rng, 2.0)
    whole, told = calibrate_many(EYE, rays, CORNERS), []
    monkeypatch.setattr(batch, "_ROWS", 4 * 5 * 4)
    parts = calibrate_many(EYE, rays, CORNERS, progress=lambda done, of: told.append((done, of)))
    assert told == [(4, 11), (8, 11), (11, 11)]
    assert_allclose(parts.xyz, whole.xyz, atol=1e-12)


def test_misfits_are_left_to_the_caller():
    """What `calibrate` leaves out, the batch keeps: it weighs what it is told."""
    points = np.array([[x, y, 0.0] for x in (0.0, 0.5, 1.0) for y in (0.0, 0.5, 1.0)])
    forearm = pointing_at(seen_from(points, place_before(points, [1.0, 0.2, 0.75], 0.7), 0.7))
    forearm[8] = forearm[0]  # the last stop points where the first did
    fit = calibrate(BODY, still_pairs(forearm, None, points, tuple("123456789")), "head-finger")
    used = np.array([stop.used for stop in fit.stops])
    assert_allclose(used, [1, 1, 1, 1, 1, 1, 1, 1, 0])
    origins, directions = arm_rays(BODY, forearm, None, "head-finger")
    many = calibrate_many(origins[None], directions[None], points, used.astype(float))
    assert_allclose(many.xyz[0], fit.xyz, atol=1e-9)
    assert calibrate_many(origins[None], directions[None], points).rms[0] > 0.03
