import msgspec
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import least_squares

from armspan.errors import CalibrationError
from armspan.pointing.calibration import calibrate
from armspan.pointing.pairs import still_pairs
from armspan.pointing.priors import PITCH_SD, Priors, pitched
from straight_arms import BODY, place_before, pointing_at, seen_from, with_x

NINE = np.array([[x, y, 0.0] for x in (0.0, 0.5, 1.0) for y in (0.0, 0.5, 1.0)])
XYZ = place_before(NINE, [0.9, 0.2, 0.75], 0.5)


def pairs_of(forearm):
    return still_pairs(forearm, None, NINE, tuple(str(k) for k in range(len(NINE))))


def noisy_arms(seed, degrees=1.5):
    rng = np.random.default_rng(seed)
    x = pointing_at(seen_from(NINE, XYZ, 0.5))[:, :, 0] + np.radians(degrees) * rng.normal(size=(9, 3))
    return with_x(x / np.linalg.norm(x, axis=1, keepdims=True))


def test_a_known_table_height_is_kept_and_narrows_the_rest():
    pairs = pairs_of(noisy_arms(0))
    free = calibrate(BODY, pairs, "head-finger")
    held = calibrate(BODY, pairs, "head-finger", priors=Priors(plane_height=(0.75, 0.005)))
    assert abs(free.xyz[2] - 0.75) > 0.01  # the sheet's z points down: xyz[2] is the height of its z = 0
    assert_allclose(held.xyz[2], 0.75, atol=0.005)
    assert (np.diagonal(held.covariance) < np.diagonal(free.covariance)).all()
    assert_allclose(np.sqrt(held.covariance[2, 2]), 0.005, rtol=0.1)


def test_the_height_means_the_same_in_a_frame_with_z_up():
    xyz = place_before(NINE, [0.9, 0.2, 0.75], 0.5, z_up=True)
    pairs = pairs_of(pointing_at(seen_from(NINE, xyz, 0.5, z_up=True)))
    fit = calibrate(BODY, pairs, "head-finger", z_up=True, priors=Priors(plane_height=(0.85, 1e-4)))
    assert_allclose(fit.xyz[2], -0.85, atol=1e-3)


def test_the_height_is_that_of_z_0_not_of_the_points():
    lights = NINE - np.array([0.0, 0.0, 0.05])  # 5 cm above the sheet
    xyz = place_before(NINE, [0.9, 0.2, 0.75], 0.5)
    pairs = still_pairs(pointing_at(seen_from(lights, xyz, 0.5)), None, lights, tuple("012345678"))
    fit = calibrate(BODY, pairs, "head-finger", priors=Priors(plane_height=(0.75, 1e-4)))
    assert_allclose(fit.xyz, xyz, atol=1e-4)
    assert fit.rms < 1e-4


def test_doubt_about_the_eyes_height_widens_a_known_table_height():
    sure = msgspec.structs.replace(BODY, covariance=tuple((1e-8 * np.eye(5)).ravel()))
    unsure = msgspec.structs.replace(BODY, covariance=tuple(np.diag([0.05**2, 1e-8, 1e-8, 1e-8, 1e-8]).ravel()))
    pairs, priors = pairs_of(noisy_arms(0)), Priors(plane_height=(0.75, 0.005))
    assert (
        calibrate(unsure, pairs, "head-finger", priors=priors).covariance[2, 2]
        > 4 * calibrate(sure, pairs, "head-finger", priors=priors).covariance[2, 2]
    )


def test_a_band_that_sits_turned_on_the_wrist_is_found_in_part():
    exact = pointing_at(seen_from(NINE, XYZ, 0.5))
    turned = pitched(exact, np.radians(-4.0))  # the fit must turn it back by +4 deg
    plain = calibrate(BODY, pairs_of(turned), "head-finger")
    freed = calibrate(BODY, pairs_of(turned), "head-finger", priors=Priors(pitch_sd=PITCH_SD))
    assert 0.0 < np.degrees(freed.pitch) <= 4.1
    assert freed.rms < plain.rms
    origins, directions = freed.rays(turned)
    assert_allclose(directions, plain.rays(pitched(turned, freed.pitch))[1])
    assert origins.shape == (9, 3)


def test_pitch_turns_the_forearm_about_its_own_y():
    assert_allclose(pitched(np.eye(3), np.radians(90.0))[:, 0], [0, 0, -1], atol=1e-12)


def test_wrong_measures_are_drawn_towards_those_that_fit():
    covariance = tuple((0.04**2 * np.eye(5)).ravel())
    wrong = msgspec.structs.replace(BODY, shoulder_to_eye_m=(0.02, 0.18, 0.16), covariance=covariance)
    points = np.vstack([NINE, NINE * 2 - [0.5, 0.5, 0]])
    forearm = pointing_at(seen_from(points, XYZ, 0.5))
    pairs = still_pairs(forearm, None, points, tuple(str(k) for k in range(18)))
    plain = calibrate(wrong, pairs, "head-finger")
    freed = calibrate(wrong, pairs, "head-finger", priors=Priors(measures=True))
    assert freed.rms < 0.7 * plain.rms
    ratio = freed.body.shoulder_to_eye_m[2] / freed.body.shoulder_to_fingertip_m
    assert abs(ratio - 0.24 / 0.72) < abs(0.16 / 0.72 - 0.24 / 0.72)
    assert freed.body.eye_height_m == wrong.eye_height_m


def test_measures_without_covariance_are_refused():
    with pytest.raises(CalibrationError, match="without their covariance"):
        calibrate(BODY, pairs_of(noisy_arms(0)), "head-finger", priors=Priors(measures=True))


def doubting(sd, pairs_of_rows=()):
    """The body with standard deviations (5,) [m] and correlations {(row, column): value}."""
    correlation = np.eye(5)
    for (i, j), value in pairs_of_rows:
        correlation[i, j] = correlation[j, i] = value
    return msgspec.structs.replace(BODY, covariance=tuple((correlation * np.outer(sd, sd)).ravel()))


def test_a_measure_without_doubt_stays_and_the_others_move():
    body = doubting([0.0, 0.0, 0.03, 0.03, 0.03])
    freed = calibrate(body, pairs_of(noisy_arms(3)), "head-finger", priors=Priors(measures=True)).body
    assert freed.shoulder_to_eye_m[0] == pytest.approx(BODY.shoulder_to_eye_m[0], abs=1e-12)
    assert abs(freed.shoulder_to_eye_m[2] - BODY.shoulder_to_eye_m[2]) > 1e-4


def test_measures_without_any_doubt_give_the_plain_fit():
    pairs = pairs_of(noisy_arms(3))
    plain = calibrate(BODY, pairs, "head-finger")
    sure = calibrate(doubting(np.zeros(5)), pairs, "head-finger", priors=Priors(measures=True))
    assert_allclose(sure.xyz, plain.xyz, atol=1e-4)
    assert sure.body.shoulder_to_eye_m == BODY.shoulder_to_eye_m


def test_measures_that_are_one_move_as_one():
    body = doubting([0.0, 0.0, 0.0, 0.03, 0.06], [((3, 4), -1.0)])  # a shoulder lower by as much as the arm is short
    freed = calibrate(body, pairs_of(noisy_arms(3)), "head-finger", priors=Priors(measures=True)).body
    up, arm = freed.shoulder_to_eye_m[2] - BODY.shoulder_to_eye_m[2], freed.shoulder_to_fingertip_m - 0.72
    assert abs(up) > 1e-4
    assert_allclose(arm, -2.0 * up, rtol=1e-6)


def test_an_eye_that_goes_with_other_measures_is_left_out_as_if_it_had_been_freed():
    """Against a fit by scipy that frees the eye's height beside the other four, all five under their covariance."""
    sd = np.array([0.03, 0.02, 0.01, 0.03, 0.03])
    body, height, tape = doubting(sd, [((0, 3), 0.7), ((3, 4), -0.5)]), 0.55, 0.004
    forearm = noisy_arms(5)
    priors = Priors(plane_height=(height, tape), measures=True)
    fit = calibrate(body, pairs_of(forearm), "head-finger", priors=priors)
    root = np.linalg.cholesky(np.reshape(body.covariance, (5, 5)))
    mean = np.array([1.65, *BODY.shoulder_to_eye_m, 0.72])

    def whitened(x):
        eye, forward, left, up, arm = mean + x[4:]
        rays = np.array([forward, left, up]) * -1 + arm * forearm[:, :, 0]
        seen = seen_from(NINE, x[:3], x[3]) - [0.0, 0.0, eye]
        rays, seen = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (rays, seen))
        across = np.cross(rays, seen)
        sine = np.linalg.norm(across, axis=1, keepdims=True)
        angle = np.arcsin(sine)
        bent = across / sine * np.sqrt(2.0 * (np.sqrt(1.0 + (angle / np.radians(5.0)) ** 2) - 1.0)) * np.radians(5.0)
        return np.array([*(bent / fit.sigma).ravel(), *np.linalg.solve(root, x[4:]), (x[2] - height) / tape])

    start = np.array([*fit.xyz, fit.yaw, *np.zeros(5)])
    found = least_squares(whitened, start, x_scale="jac", xtol=1e-13, ftol=1e-13, gtol=1e-13)
    assert abs(found.x[4]) > 1e-3
    assert_allclose(fit.xyz[:2], found.x[:2], atol=1e-4)
    assert_allclose(fit.xyz[2], found.x[2] - found.x[4], atol=1e-4)  # lower with the eye
    measures = [*fit.body.shoulder_to_eye_m, fit.body.shoulder_to_fingertip_m]
    assert_allclose(measures, (mean + found.x[4:])[1:], atol=1e-4)


def test_no_priors_are_false():
    assert not Priors()
    assert Priors(pitch_sd=0.1)
