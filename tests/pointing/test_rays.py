import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from armspan.errors import CalibrationError
from armspan.pointing.rays import arm_rays, default_model, unit
from armspan.records import Body
from straight_arms import BODY, with_x

REPORT = Body(eye_height_m=1.65, shoulder_to_eye_m=(0.0, 0.2, 0.25), shoulder_to_fingertip_m=0.7)
AHEAD = np.eye(3)
DOWN = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # x axis straight down


def test_the_head_finger_ray_of_an_arm_straight_ahead():
    origin, direction = arm_rays(REPORT, AHEAD, None, "head-finger")
    assert_allclose(origin, [0, 0, 1.65])
    assert_allclose(direction, np.array([0.7, -0.2, -0.25]) / np.sqrt(0.49 + 0.04 + 0.0625))


def test_the_shoulder_finger_ray_starts_in_the_shoulder_along_the_arm():
    origin, direction = arm_rays(REPORT, DOWN, None, "shoulder-finger")
    assert_allclose(origin, [0, -0.2, 1.4])
    assert_allclose(direction, [0, 0, -1])


def test_the_two_band_ray_sees_the_elbow():
    origin, direction = arm_rays(BODY, AHEAD, DOWN, "two-band")
    assert_allclose(origin, [0, 0, 1.65])
    finger_from_eye = np.array([-0.02 + 0.36, -0.18, -0.24 - 0.36])
    assert_allclose(direction, finger_from_eye / np.linalg.norm(finger_from_eye))


def test_the_forearm_ray_starts_in_the_elbow_where_it_is_known():
    assert_allclose(arm_rays(BODY, AHEAD, DOWN, "forearm")[0], [-0.02, -0.18, 1.65 - 0.24 - 0.36])
    origin, direction = arm_rays(BODY, AHEAD, None, "forearm")
    assert_allclose(origin, [-0.02, -0.18, 1.65 - 0.24])
    assert_allclose(direction, [1, 0, 0])


def test_many_attitudes_give_as_many_rays():
    attitudes = np.stack([AHEAD, DOWN, AHEAD])
    for model in ("head-finger", "shoulder-finger", "forearm", "two-band"):
        origins, directions = arm_rays(BODY, attitudes, attitudes, model)
        assert origins.shape == directions.shape == (3, 3)
        assert_allclose(np.linalg.norm(directions, axis=1), 1.0)


@settings(derandomize=True, max_examples=50)
@given(st.floats(0.7, 1.4), st.floats(-1.2, 1.2), st.floats(-1.2, 0.5))
def test_a_common_scale_of_shoulder_and_arm_leaves_the_direction(scale, azimuth, elevation):
    x = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    forearm = with_x(np.array([x]))
    scaled = msgspec.structs.replace(
        REPORT,
        shoulder_to_eye_m=tuple(scale * v for v in REPORT.shoulder_to_eye_m),
        shoulder_to_fingertip_m=scale * REPORT.shoulder_to_fingertip_m,
    )
    found = arm_rays(scaled, forearm, None, "head-finger")[1]
    assert_allclose(found, arm_rays(REPORT, forearm, None, "head-finger")[1], atol=1e-12)


def test_the_default_model_needs_both_lengths_and_both_bands():
    assert default_model(BODY, has_upper_arm=True) == "two-band"
    assert default_model(BODY, has_upper_arm=False) == "head-finger"
    assert default_model(REPORT, has_upper_arm=True) == "head-finger"


def test_what_the_two_band_model_lacks_is_named():
    with pytest.raises(CalibrationError, match="upper arm's attitude"):
        arm_rays(BODY, AHEAD, None, "two-band")
    with pytest.raises(CalibrationError, match="upper_arm_m and elbow_to_fingertip_m"):
        arm_rays(REPORT, AHEAD, AHEAD, "two-band")
    with pytest.raises(CalibrationError, match=r"'head-fingr' does not exist.*Did you mean 'head-finger'"):
        arm_rays(BODY, AHEAD, None, "head-fingr")


def test_unit():
    assert_allclose(unit(np.array([[3.0, 0, 4.0], [0, -2.0, 0]])), [[0.6, 0, 0.8], [0, -1, 0]])
