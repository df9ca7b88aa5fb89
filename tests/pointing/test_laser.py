import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.errors import ConfigError
from armspan.frames import yaw_rotation
from armspan.pointing.calibration import STRAIGHT, calibrate
from armspan.pointing.laser import HAND_SHARE, LaserSettings, laser_rays
from armspan.pointing.pairs import still_pairs
from armspan.pointing.rays import arm_rays
from laser_arms import aimed
from straight_arms import BODY, SQUARE, seen_from

STRETCHED = np.eye(3)
DOWN = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""user_from_wrist of arms that are stretched forward and that hang."""

SHOULDER = np.array([-0.02, -0.18, 1.65 - 0.24])


def test_the_beam_of_a_stretched_arm():
    laser = LaserSettings(position_m=(0.01, 0.02, -0.03), direction_deg=(0.0, 0.0))
    origin, direction = laser_rays(laser, BODY, STRETCHED, None)
    along = 0.72 * (1 - HAND_SHARE)
    assert_allclose(origin, SHOULDER + np.array([along + 0.01, 0.02, -0.03]))
    assert_allclose(direction, [1.0, 0.0, 0.0])


def test_the_beam_goes_where_it_is_mounted_to_go():
    _, direction = laser_rays(LaserSettings(direction_deg=(90.0 / 3, 0.0)), BODY, STRETCHED, None)
    assert_allclose(direction, [np.sqrt(0.75), 0.5, 0.0])
    _, direction = laser_rays(LaserSettings(direction_deg=(0.0, -30.0)), BODY, STRETCHED, None)
    assert_allclose(direction, [np.sqrt(0.75), 0.0, -0.5])


def test_the_mounting_turns_with_the_arm():
    laser = LaserSettings(position_m=(0.0, 0.0, 0.03), direction_deg=(0.0, 30.0))
    origin, direction = laser_rays(laser, BODY, DOWN, None)
    # The back of a hand that hangs, palm backward, faces forward: out of it is +x, and so is "up" for the beam.
    assert_allclose(direction, [0.5, 0.0, -np.sqrt(0.75)], atol=1e-12)
    assert_allclose(origin, SHOULDER + np.array([0.03, 0.0, -0.72 * (1 - HAND_SHARE)]), atol=1e-12)


def test_a_bend_that_is_seen_moves_the_wrist():
    laser = LaserSettings(position_m=(0.0, 0.0, 0.0))
    origin, _ = laser_rays(laser, BODY, STRETCHED, DOWN)
    assert_allclose(origin, SHOULDER + np.array([0.36 - HAND_SHARE * 0.72, 0.0, -0.36]), atol=1e-12)


def test_many_arms_at_once_and_only_the_forearms_model():
    laser, many = LaserSettings(), np.stack([STRETCHED, DOWN, yaw_rotation(0.4)])
    origins, directions = arm_rays(BODY, many, None, "forearm", laser)
    for k, one in enumerate(many):
        origin, direction = laser_rays(laser, BODY, one, None)
        assert_allclose(origins[k], origin)
        assert_allclose(directions[k], direction)
    for model in ("head-finger", "shoulder-finger"):
        assert_allclose(arm_rays(BODY, many, None, model, laser), arm_rays(BODY, many, None, model))
    assert_allclose(arm_rays(BODY, many, None, "forearm")[1], many[:, :, 0])


def test_the_place_is_found_from_beams_on_known_points():
    laser = LaserSettings(position_m=(0.0, 0.01, -0.03), direction_deg=(3.0, -12.0))
    place, yaw = np.array([0.45, 0.85, 0.75]), 1.5
    targets = seen_from(SQUARE, place, yaw)
    pairs = still_pairs(aimed(laser, targets), None, SQUARE, ("1", "2", "3", "4"))
    fit = calibrate(BODY, pairs, "forearm", noise=STRAIGHT, laser=laser)
    assert_allclose(fit.xyz, place, atol=1e-6)
    assert fit.yaw == pytest.approx(yaw, abs=1e-6)
    assert_allclose(fit.rays(pairs.user_from_forearm)[1], laser_rays(laser, BODY, pairs.user_from_forearm, None)[1])
    bare = calibrate(BODY, pairs, "forearm", noise=STRAIGHT)
    assert bare.rms > np.radians(0.5)  # the forearm itself does not point there


def test_odds_are_those_of_a_test_that_errs():
    laser = LaserSettings(false_hit=0.01, missed=0.2)
    assert laser.odds(True) == pytest.approx(0.8 / 0.01)
    assert laser.odds(False) == pytest.approx(0.2 / 0.99)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"false_hit": 0.0}, "laser.false_hit is 0.0; it is a probability"),
        ({"missed": 0.9}, "laser.missed is 0.9"),
        ({"dwell_s": 0.0}, "0.1 to 2 s"),
        ({"release_s": 9.0}, "0 to 5 s"),
        ({"position_m": (0.0, 35.0, 0.0)}, "expected metres from the wrist"),
        ({"direction_deg": (0.0, 90.0)}, "expected degrees to the left"),
        ({"direction_deg": (float("nan"), 0.0)}, "expected degrees to the left"),
    ],
)
def test_settings_out_of_range_are_refused_in_words(wrong, words):
    with pytest.raises(ConfigError, match=words):
        LaserSettings(**wrong)
