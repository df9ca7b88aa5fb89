import msgspec
import numpy as np
import pytest
from numpy.testing import assert_allclose

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


def test_no_priors_are_false():
    assert not Priors()
    assert Priors(pitch_sd=0.1)
