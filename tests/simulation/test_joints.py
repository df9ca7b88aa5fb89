"""Joint angles against arms drawn on paper."""

import numpy as np
import pytest

from armspan.simulation.figure import BACK, FOREARM, SHIFT, UPPER
from armspan.simulation.joints import posture_from_joints, wrist_step


def arm(side=-1.0, offset=0.0, **degrees):
    names = ("plane", "elevation", "axial", "flexion", "pronation", "turn", "lift")
    joints = np.array([np.radians(degrees.get(name, 0.0)) for name in names])
    return posture_from_joints(joints[:, None], side, offset)[:, 0]


@pytest.mark.parametrize(
    ("angles", "upper", "forearm"),
    [
        ({}, (0, 0, -1), (0, 0, -1)),
        ({"elevation": 90}, (1, 0, 0), (1, 0, 0)),
        ({"elevation": 90, "plane": 90}, (0, -1, 0), (0, -1, 0)),
        ({"elevation": 180, "plane": 30}, (0, 0, 1), (0, 0, 1)),
        ({"flexion": 90}, (0, 0, -1), (1, 0, 0)),
        ({"flexion": 90, "axial": -90}, (0, 0, -1), (0, 1, 0)),
        ({"elevation": 90, "flexion": 90}, (1, 0, 0), (0, 0, 1)),
        ({"elevation": 90, "flexion": 90, "axial": -90}, (1, 0, 0), (0, 1, 0)),
        ({"elevation": 90, "plane": 90, "flexion": 90, "axial": -90}, (0, -1, 0), (1, 0, 0)),
        ({"elevation": 90, "turn": 90}, (0, 1, 0), (0, 1, 0)),
    ],
)
def test_a_right_arm(angles, upper, forearm):
    posture = arm(**angles)
    assert posture[UPPER] == pytest.approx(upper, abs=1e-12)
    assert posture[FOREARM] == pytest.approx(forearm, abs=1e-12)


def test_a_left_arm_is_the_mirror_image_until_the_trunk_turns():
    angles = {"plane": 20, "elevation": 70, "axial": -35, "flexion": 50, "pronation": 25}
    mirror = np.tile([1.0, -1.0, 1.0], 5)
    assert arm(1.0, **angles)[:15] == pytest.approx(mirror * arm(-1.0, **angles)[:15])
    left, right = arm(1.0, turn=90, elevation=90), arm(-1.0, turn=90, elevation=90)
    assert left[UPPER] == pytest.approx(right[UPPER])


@pytest.mark.parametrize(
    ("pronation", "back"),
    [(0, (0, -1, 0)), (90, (0, 0, 1)), (-90, (0, 0, -1))],
)
def test_the_palm_of_a_right_hand_before_the_body(pronation, back):
    # Thumb up the back faces outward; pronated the palm is down, supinated up.
    assert arm(flexion=90, pronation=pronation)[BACK] == pytest.approx(back, abs=1e-12)


def test_shoulders_turn_about_the_middle_and_rise_with_the_arm():
    assert arm(-1.0, offset=-0.2, turn=90)[SHIFT] == pytest.approx((0.2, 0.2, 0.0))
    assert arm(elevation=180)[SHIFT] == pytest.approx((0.0, 0.0, 0.05))


def test_what_a_joint_does_to_the_wrist():
    hanging_bent = np.radians([0.0, 0.0, 0.0, 90.0, 0.0, 0.0, 0.0])  # the wrist is 0.25 m before the elbow
    step = wrist_step(hanging_bent, 0.3, 0.25)
    plane, elevation, axial, flexion = step.T
    assert axial == pytest.approx((0.0, 0.25, 0.0), abs=1e-6)
    assert plane == pytest.approx(axial, abs=1e-6)
    assert elevation == pytest.approx((0.3, 0.0, 0.25), abs=1e-6)
    assert flexion == pytest.approx((0.0, 0.0, 0.25), abs=1e-6)
