import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from armspan.errors import CalibrationError
from armspan.frames import yaw_rotation
from armspan.pointing.calibration import NATURAL, STRAIGHT, calibrate
from armspan.pointing.pairs import moving_pairs, still_pairs
from straight_arms import BODY, SQUARE, place_before, pointing_at, seen_from, with_x

NAMES = ("0", "1", "2", "3")
TABLE_AHEAD = np.array([1.0, 0.2, 0.75])
YAWS = st.floats(-3.1, 3.1)
PLACES = st.tuples(st.floats(0.6, 2.0), st.floats(-0.8, 0.8), st.floats(0.0, 0.9))


def pairs_from(xyz, yaw, points=SQUARE, z_up=False, body=BODY):
    """Pairs of a stiff arm that points exactly, at a place told by its numbers."""
    forearm = pointing_at(seen_from(points, xyz, yaw, z_up), body)
    return still_pairs(forearm, None, points, tuple(str(k) for k in range(len(points))))


@settings(derandomize=True, max_examples=40, deadline=None)
@given(PLACES, YAWS, st.booleans())
def test_without_noise_the_place_is_exact(ahead, yaw, z_up):
    xyz = place_before(SQUARE, ahead, yaw, z_up)
    fit = calibrate(BODY, pairs_from(xyz, yaw, z_up=z_up), "head-finger", z_up=z_up)
    assert_allclose(fit.xyz, xyz, atol=1e-6)
    assert abs((fit.yaw - yaw + np.pi) % (2 * np.pi) - np.pi) < 1e-6
    assert fit.rms < 1e-7
    eye = fit.transform().points([0.0, 0.0, BODY.eye_height_m])
    assert_allclose(seen_from(eye[None], xyz, yaw, z_up)[0], [0, 0, BODY.eye_height_m], atol=1e-6)


@settings(derandomize=True, max_examples=25, deadline=None)
@given(PLACES, YAWS, YAWS)
def test_a_turn_of_whole_rays_is_absorbed_by_the_yaw_alone(ahead, yaw, turn):
    """Gauge (i): the eye stands on the axis of the turn, so x, y and z stay."""
    xyz = place_before(SQUARE, ahead, yaw)
    symmetric = msgspec.structs.replace(BODY, shoulder_to_eye_m=(0.0, 0.0, 0.24))
    pairs = pairs_from(xyz, yaw, body=symmetric)
    turned = still_pairs(yaw_rotation(turn) @ pairs.user_from_forearm, None, SQUARE, NAMES)
    fit = calibrate(symmetric, turned, "head-finger")
    assert_allclose(fit.xyz, xyz, atol=1e-6)
    assert abs((fit.yaw - yaw + turn + np.pi) % (2 * np.pi) - np.pi) < 1e-6
    assert fit.rms < 1e-7


@settings(derandomize=True, max_examples=25, deadline=None)
@given(st.floats(-0.3, 0.3), st.floats(0.8, 1.25))
def test_eye_height_and_the_scale_of_the_body_are_absorbed_by_z(higher, scale):
    """Gauges (ii) and (iv): the sheet seems lower by as much as the eye is taken to be higher."""
    xyz, yaw = place_before(SQUARE, TABLE_AHEAD, 0.7), 0.7
    wrong = msgspec.structs.replace(
        BODY,
        eye_height_m=BODY.eye_height_m + higher,
        shoulder_to_eye_m=tuple(scale * v for v in BODY.shoulder_to_eye_m),
        shoulder_to_fingertip_m=scale * BODY.shoulder_to_fingertip_m,
    )
    fit = calibrate(wrong, pairs_from(xyz, yaw), "head-finger")
    assert_allclose(fit.xyz - xyz, [0, 0, higher], atol=1e-6)
    assert fit.rms < 1e-7


def test_a_longer_stop_weighs_no_more():
    rng = np.random.default_rng(1)
    forearm = pointing_at(seen_from(SQUARE, place_before(SQUARE, TABLE_AHEAD, 0.7), 0.7))
    x = forearm[:, :, 0] + 0.03 * rng.normal(size=(4, 3))
    forearm = with_x(x / np.linalg.norm(x, axis=1, keepdims=True))
    once = calibrate(BODY, still_pairs(forearm, None, SQUARE, NAMES), "head-finger")
    rows = [0] * 50 + [1, 2, 3]
    often = still_pairs(forearm[rows], None, SQUARE[rows], tuple(NAMES[row] for row in rows))
    again = calibrate(BODY, often, "head-finger")
    assert_allclose(again.xyz, once.xyz, atol=1e-9)
    assert_allclose(again.covariance, once.covariance, atol=1e-9)
    assert [stop.pairs for stop in again.stops] == [50, 1, 1, 1]


def test_the_covariance_is_the_spread_of_many_fits():
    rng = np.random.default_rng(2)
    xyz, yaw, sigma = place_before(SQUARE, TABLE_AHEAD, 0.7), 0.7, np.radians(1.0)
    exact = pointing_at(seen_from(SQUARE, xyz, yaw))[:, :, 0]
    eye_ray_gain = 0.72 / 0.7  # the finger is about this far from the shoulder and the eye
    found, claimed = [], []
    for _ in range(250):
        x = exact + sigma / eye_ray_gain * rng.normal(size=(4, 3))
        pairs = still_pairs(with_x(x / np.linalg.norm(x, axis=1, keepdims=True)), None, SQUARE, NAMES)
        fit = calibrate(BODY, pairs, "head-finger")
        found.append([*fit.xyz, fit.yaw])
        claimed.append(fit.covariance * (sigma / fit.sigma) ** 2)
    assert_allclose(np.std(found, axis=0), np.sqrt(np.diagonal(np.mean(claimed, axis=0))), rtol=0.2)
    assert_allclose(np.mean(found, axis=0), [*xyz, yaw], atol=0.02)


def test_the_noise_of_few_stops_is_drawn_towards_what_is_assumed():
    pairs = pairs_from(place_before(SQUARE, TABLE_AHEAD, 0.7), 0.7)
    fit = calibrate(BODY, pairs, "head-finger", noise=STRAIGHT)  # 4 stops leave 8 - 4 degrees of freedom, all 0
    assert_allclose(fit.sigma, STRAIGHT.sigma * np.sqrt(4 / (4 + 4)), rtol=1e-6)
    default = calibrate(BODY, pairs, "head-finger")
    assert_allclose(default.sigma, NATURAL.sigma * np.sqrt(2 / (2 + 4)), rtol=1e-6)


def test_two_bands_see_a_bent_elbow():
    xyz, yaw = place_before(SQUARE, TABLE_AHEAD, -2.0), -2.0
    targets = seen_from(SQUARE, xyz, yaw)
    stiff = pointing_at(targets)[:, :, 0] * BODY.shoulder_to_fingertip_m
    bent = msgspec.structs.replace(BODY, upper_arm_m=0.36, elbow_to_fingertip_m=0.45)
    # the elbow 0.36 m from the shoulder and 0.45 m from the fingertip, below the line between them
    length = BODY.shoulder_to_fingertip_m
    along = (0.36**2 - 0.45**2 + length**2) / (2 * length)
    axis = stiff / length
    below = np.array([0.0, 0.0, -1.0]) + axis * axis[:, 2:]
    below /= np.linalg.norm(below, axis=1, keepdims=True)
    elbow = along * axis + np.sqrt(0.36**2 - along**2) * below
    upperarm, forearm = with_x(elbow / 0.36), with_x((stiff - elbow) / 0.45)
    fit = calibrate(bent, still_pairs(forearm, upperarm, SQUARE, NAMES), "two-band")
    assert_allclose(fit.xyz, xyz, atol=1e-6)
    one_band = calibrate(bent, still_pairs(forearm, upperarm, SQUARE, NAMES), "head-finger")
    assert np.linalg.norm(one_band.xyz - xyz) > 0.05


def test_a_stop_at_which_the_person_pointed_elsewhere_is_left_out():
    xyz, yaw = place_before(SQUARE, TABLE_AHEAD, 0.7), 0.7
    targets = seen_from(SQUARE, xyz, yaw)
    targets[2] += [0.0, 1.2, 0.0]
    fit = calibrate(BODY, still_pairs(pointing_at(targets), None, SQUARE, NAMES), "head-finger", noise=STRAIGHT)
    assert [stop.used for stop in fit.stops] == [True, True, False, True]
    assert_allclose(fit.xyz, xyz, atol=1e-6)
    assert np.degrees(fit.stops[2].residual) > 20
    assert fit.rms < 1e-6


def test_a_moving_point_places_the_user_too():
    turn = np.linspace(0, 2 * np.pi, 200)
    points = np.column_stack([0.8 * np.cos(turn), 0.5 * np.sin(turn), 0.2 * np.sin(3 * turn)])
    xyz, yaw = place_before(points, [2.0, 0.3, 1.0], 1.0, z_up=True), 1.0
    forearm = pointing_at(seen_from(points, xyz, yaw, z_up=True))
    fit = calibrate(BODY, moving_pairs(forearm, None, points, turn * 5), "head-finger", z_up=True)
    assert_allclose(fit.xyz, xyz, atol=1e-6)
    assert fit.stops == ()
    assert fit.area is None


def test_rays_that_all_coincide_are_refused():
    same = np.tile(np.eye(3), (4, 1, 1))
    with pytest.raises(CalibrationError, match="The rays hardly differ"):
        calibrate(BODY, still_pairs(same, None, SQUARE, NAMES), "head-finger")
    nearly = with_x(np.array([[1.0, 1e-3 * k, -0.3] for k in (0, 1, -1, 2)]) / np.sqrt(1.09))
    with pytest.raises(CalibrationError, match="The rays hardly differ"):
        calibrate(BODY, still_pairs(nearly, None, SQUARE, NAMES), "head-finger")


def test_arms_that_have_nothing_to_do_with_the_points_are_refused():
    aims = np.array([[1.0, 0, 0], [-1.0, 0.3, 0.5], [0.1, 1.0, -0.6], [0, -1.0, 0.9], [0.4, 0.4, 1.0], [-0.7, -0.7, 0]])
    points = np.vstack([SQUARE, SQUARE[:2] + np.array([0.1, 0.3, 0.0])])
    forearm = with_x(aims / np.linalg.norm(aims, axis=1, keepdims=True))
    with pytest.raises(CalibrationError, match="degrees from their points"):
        calibrate(BODY, still_pairs(forearm, None, points, tuple("012345")), "head-finger")


def test_names_that_do_not_exist_are_answered_with_those_that_do():
    pairs = pairs_from(place_before(SQUARE, TABLE_AHEAD, 0.7), 0.7)
    with pytest.raises(CalibrationError, match=r"'least-square' does not exist.*nelder-mead"):
        calibrate(BODY, pairs, "head-finger", method="least-square")


def test_the_reports_nelder_mead_is_kept_with_its_fault():
    """From (0, 0, 800, 0) mm it finds places beside it, and stays where it began for others."""
    xyz, yaw = place_before(SQUARE, [1.0, 0.1, 0.75], 2.0), 2.0
    pairs = pairs_from(xyz, yaw)
    in_metres = calibrate(BODY, pairs, "head-finger", method="nelder-mead")
    assert_allclose(in_metres.xyz, xyz, atol=1e-3)
    in_millimetres = calibrate(BODY, pairs, "head-finger", method="nelder-mead-report")
    assert np.linalg.norm(in_millimetres.xyz - xyz) > 0.3
    assert in_millimetres.method == "nelder-mead-report"
