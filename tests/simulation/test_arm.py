"""The arm's triangle, against triangles that can be worked out on paper."""

import numpy as np
import pytest

from armspan.simulation import arm
from armspan.simulation.arm import Arm

column = np.array([[1.0], [0.0], [0.0]])


def test_a_straight_arm_is_as_long_as_its_parts():
    limb = Arm(0.3, 0.25, 0.2)
    lower = arm.elbow_to_fingertip(limb, np.zeros((2, 1)))
    assert lower == pytest.approx(0.45)
    assert arm.chord(limb, np.zeros((2, 1)), lower) == pytest.approx(0.75)


def test_a_right_angled_elbow_makes_the_triangle_3_4_5():
    limb = Arm(0.3, 0.25, 0.15)
    bend = np.array([[np.arctan2(3.0, 4.0)], [0.0]])
    assert arm.chord(limb, bend, np.array([0.4])) == pytest.approx(0.5)


def test_a_hand_bent_by_60_degrees_shortens_the_forearm_and_hand():
    # 0.3² + 0.5² - 2 0.3 0.5 cos 120 = 0.49
    lower = arm.elbow_to_fingertip(Arm(0.3, 0.3, 0.5), np.radians([[0.0], [60.0]]))
    assert lower == pytest.approx(0.7)


def test_the_bent_hand_still_ends_at_the_fingertip():
    limb = Arm(0.3, 0.25, 0.18)
    bend, wrist = np.radians([[14.0], [-5.0]]), np.radians([[-9.0], [12.0]])
    lower = arm.elbow_to_fingertip(limb, wrist)
    reach = arm.chord(limb, bend, lower)
    there = arm.unit(np.array([[0.8], [-0.3], [0.4]]))
    parts = arm.bent_arm(limb, there, bend, wrist, reach, lower)
    fingertip = 0.3 * parts.upper + 0.25 * parts.forearm + 0.18 * parts.hand
    assert fingertip == pytest.approx(reach * there)
    for part in (parts.upper, parts.forearm, parts.hand):
        assert np.linalg.norm(part) == pytest.approx(1.0)
    angle = np.degrees(np.arccos((parts.forearm * parts.hand).sum()))
    assert angle == pytest.approx(np.hypot(9.0, 12.0))


def test_turning_goes_left_and_up():
    left, up = arm.tangents(column)
    assert left[:, 0] == pytest.approx([0.0, 1.0, 0.0])
    assert up[:, 0] == pytest.approx([0.0, 0.0, 1.0])
    turned = arm.turned(column, (left, up), np.radians([[90.0], [0.0]]))
    assert turned[:, 0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    turned = arm.turned(column, (left, up), np.radians([[0.0], [30.0]]))
    assert turned[:, 0] == pytest.approx([np.sqrt(0.75), 0.0, 0.5])


def test_the_fingertip_is_on_the_sight_and_in_reach():
    eye, shoulder = np.array([[0.0], [0.0], [1.6]]), np.array([[0.0], [-0.2], [1.35]])
    sight = np.array([[0.5], [0.3], [0.0]]) / np.hypot(0.5, 0.3)
    fingertip = arm.fingertip_on_sight(eye, sight, shoulder, np.array([0.75]))
    assert fingertip[:, 0] == pytest.approx([0.5, 0.3, 1.6])  # (0.5, 0.5, 0.25) from the shoulder: 0.75 m


def test_the_widest_bend_leaves_a_triangle():
    limb = Arm(0.28, 0.27, 0.2)
    bend = np.array([[limb.widest_bend], [0.0]])
    assert 0.4 < arm.chord(limb, bend, np.array([0.47]))[0] < 0.75
