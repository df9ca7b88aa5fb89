"""The firmware's rules against what EPFL's own firmware did, recorded in cellulo_firmware.json."""

import json
from pathlib import Path

import numpy as np
import pytest

from armspan.simulation.cellulo import Localisation, Motion, motors_from_velocity

VECTORS = json.loads((Path(__file__).parent / "cellulo_firmware.json").read_text())
YES, NO = np.array([True]), np.array([False])
FRAME_MS = 11


def counts(x_mm, y_mm, theta_deg):
    """A pose as the firmware's camera gives it, whole counts and hundredths of a degree."""
    return np.floor(np.array([[x_mm / 0.00508], [y_mm / 0.00508], [theta_deg * 100.0]]) + 1e-6)


class Robot:
    """One robot on an ideal plant: its pose moves by what the goal asks for, 11 ms a frame."""

    def __init__(self, x=100.0, y=100.0, theta=0.0):
        self.motion, self.pose, self.now = Motion(1), np.array([x, y, theta]), 0
        self.events, self.rows = [], []
        self.see()

    def see(self, fresh=YES, kidnapped=NO):
        reached = self.motion.frame(float(self.now), counts(*self.pose), fresh, kidnapped)
        if reached[0]:
            self.events.append(self.now)
        return self.motors()

    def motors(self):
        return self.motion.motors()[:, 0].tolist()

    def tracked(self):
        return self.motion.tracked[:, 0].tolist()

    def run(self, frames, *, hold=False):
        for _ in range(frames):
            self.now += FRAME_MS
            self.see()
            self.rows.append([self.now, *self.pose, *self.tracked(), *self.motors()])
            if not hold:
                self.pose = self.pose + np.array(self.tracked()) * [0.011, 0.011, np.degrees(0.011)]
        return self


def close_motors(got, expected):
    return np.abs(np.array(got) - np.array(expected)).max() <= 1


# --- wheels ----------------------------------------------------------------------------------------------


def test_every_recorded_velocity_gives_the_recorded_pwm():
    rows = np.array(VECTORS["velocity_to_pwm"]["rows"])
    motors = motors_from_velocity(rows[:, 1:4].T, rows[:, 0] * 100)
    assert np.abs(motors.T - rows[:, 4:]).max() <= 1


@pytest.mark.parametrize(
    ("velocity", "motors"),
    [
        ((50, 0, 0), (2056, -1556, -1556)),
        ((0, 50, 0), (0, 1922, -1922)),
        ((0, 0, 1), (1429, 1429, 1429)),
        ((185, 0, 0), (4095, -2502, -2502)),
    ],
)
def test_the_told_examples_of_the_wheels(velocity, motors):
    assert motors_from_velocity(np.array([velocity]).T, np.zeros(1))[:, 0].tolist() == list(motors)


# --- trackers --------------------------------------------------------------------------------------------


def test_the_ramp_of_a_pose_goal():
    case = VECTORS["pose_goal_static_ramp"]
    x, y, theta, vmax, wmax = case["goal_x_y_theta_vmax_wmax"]
    robot = Robot(*case["pose"])
    robot.motion.track_pose(0, *counts(x, y, theta)[:, 0], vmax=vmax, wmax=wmax)
    rows = np.array(robot.run(len(case["rows"]), hold=True).rows)
    expected = np.array(case["rows"])
    np.testing.assert_allclose(rows[:, 4:7], expected[:, :3], atol=2e-4)
    assert close_motors(rows[:, 7:], expected[:, 3:])
    assert robot.events == []


@pytest.mark.parametrize("case", VECTORS["closed_loop_ideal_plant"]["cases"], ids=lambda case: case["name"])
def test_the_closed_loops(case):
    robot = Robot(*case["start"])
    robot.motion.track_pose(0, **case["goal"])
    rows = {row[0]: row for row in robot.run(case["last"][0] // FRAME_MS).rows}
    expected = np.array([*case["trace"], case["last"]])
    got = np.array([rows[int(row[0])] for row in expected])
    assert robot.events == [case["goal_event_ms"]]
    np.testing.assert_allclose(got[:, 1:4], expected[:, 1:4], atol=0.01)
    np.testing.assert_allclose(got[:, 4:7], expected[:, 4:7], atol=0.0201)  # one count is 0.02 mm/s
    assert close_motors(got[:, 7:], expected[:, 7:])


def test_a_position_goal_comes_to_rest_where_the_firmware_does():
    robot = Robot(100.0, 100.0, 0.0)
    robot.motion.track_pose(0, *counts(200, 100, 0)[:2, 0], vmax=100.0)
    robot.run(200)
    assert robot.events == [1353]
    assert robot.pose[0] == pytest.approx(197.48, abs=0.01)


def test_an_orientation_goal_takes_the_short_way_through_zero():
    robot = Robot(100.0, 100.0, 10.0)
    robot.motion.track_pose(0, theta=35000.0, wmax=3.0)
    robot.run(60)
    assert robot.events == [418]
    assert -10.0 < robot.pose[2] < -7.9


def test_coordinates_that_are_not_told_are_not_driven():
    robot = Robot()
    robot.motion.track_velocity(0, (30.0, 40.0, 2.0))
    robot.run(1)
    robot.motion.track_pose(0, x=counts(150, 0, 0)[0, 0], vmax=80.0)
    robot.run(1)
    assert robot.tracked() == [50.0, 0.0, 0.0]  # 20 mm/s more than 30; y and theta at once nothing


def test_x_theta_and_y_theta_drive_two_coordinates():
    for axis, told in ((0, {"x": counts(150, 0, 0)[0, 0]}), (1, {"y": counts(0, 150, 0)[1, 0]})):
        robot = Robot()
        robot.motion.track_pose(0, **told, theta=9000.0, vmax=80.0, wmax=3.0)
        robot.run(400)
        assert robot.pose[axis] == pytest.approx(147.5, abs=0.1)
        assert robot.pose[1 - axis] == 100.0
        assert 87.9 < robot.pose[2] < 90.0
        assert len(robot.events) == 1


def test_an_axis_nearer_than_five_grid_units_is_never_driven():
    robot = Robot()
    robot.motion.track_pose(0, *counts(140.0, 100 + 40 * np.tan(np.radians(3.0)), 0)[:2, 0], vmax=150.0)
    robot.run(200)
    assert robot.pose[1] == 100.0
    assert robot.pose[0] > 137.0


def test_a_velocity_goal_has_no_slew_and_no_event_and_no_end():
    robot = Robot()
    robot.motion.track_velocity(0, (185.0, -20.0, 1.0))
    robot.run(1)
    assert robot.tracked() == [185.0, -20.0, 1.0]
    robot.run(2000)
    assert robot.tracked() == [185.0, -20.0, 1.0]
    assert robot.events == []


def test_a_limit_of_zero_still_tells_what_is_reached():
    robot = Robot()
    robot.motion.track_pose(0, *counts(150, 100, 0)[:2, 0], vmax=0.0)
    robot.run(20)
    assert robot.tracked() == [0.0, 0.0, 0.0]
    assert robot.events == []
    robot.motion.track_pose(0, *counts(101, 100, 0)[:2, 0], vmax=0.0)
    robot.run(20)
    assert robot.events == [21 * FRAME_MS]


def test_the_event_comes_again_after_a_push_and_after_a_new_goal():
    robot = Robot()
    goal = counts(101, 100, 0)[:2, 0]
    robot.motion.track_pose(0, *goal, vmax=100.0)
    robot.run(30)
    assert len(robot.events) == 1
    robot.pose[0] += 20.0
    robot.run(200)
    assert len(robot.events) == 2
    assert robot.pose[0] == pytest.approx(103.5, abs=0.1)
    robot.motion.track_pose(0, *goal, vmax=100.0)
    robot.run(30)
    assert len(robot.events) == 3


def test_robots_do_not_mix():
    motion, both = Motion(2), np.array([True, True])
    poses = np.hstack([counts(100, 100, 0), counts(300, 100, 90)])
    motion.frame(0.0, poses, both, ~both)
    motion.track_pose(0, *counts(200, 100, 0)[:2, 0], vmax=100.0)
    motion.track_velocity(1, (50.0, 0.0, 0.0))
    motion.frame(11.0, poses, np.array([True, False]), ~both)
    assert motion.driven[:, 0].tolist() == [20.0, 0.0, 0.0]
    assert motion.driven[:, 1].tolist() == [0.0, 0.0, 0.0]


# --- what keeps the motors off ---------------------------------------------------------------------------


def matches(robot, case):
    return robot.tracked() == case["tracker"] and close_motors(robot.motors(), case["motors"])


def test_kidnapped_motors_are_off_and_the_goal_is_kept():
    robot = Robot()
    robot.motion.track_velocity(0, (50.0, 0.0, 0.0))
    robot.run(1, hold=True)
    assert matches(robot, VECTORS["kidnap"]["before"])
    robot.now += FRAME_MS
    robot.see(fresh=NO, kidnapped=YES)
    assert matches(robot, VECTORS["kidnap"]["while_kidnapped"])
    robot.run(1, hold=True)
    assert matches(robot, VECTORS["kidnap"]["after"])


def test_a_robot_that_has_to_be_held():
    robot = Robot()
    robot.motion.track_velocity(0, (50.0, 0.0, 0.0))
    robot.motion.block(0, unheld=True)
    robot.run(1, hold=True)
    assert matches(robot, VECTORS["requires_hold"]["not_held"])
    robot.motion.block(0, unheld=False)
    robot.run(1, hold=True)
    assert matches(robot, VECTORS["requires_hold"]["held"])


def test_without_a_new_frame_the_motors_keep_what_they_have():
    robot = Robot()
    robot.motion.track_velocity(0, (0.0, 50.0, 0.0))
    robot.run(1, hold=True)
    robot.motion.track_velocity(0, (50.0, 0.0, 0.0))
    robot.now += FRAME_MS
    assert robot.see(fresh=NO) == [0, 1922, -1922]
    assert VECTORS["no_new_frame"] == {"motors": [None] * 3, "tracker": robot.tracked()}


def test_a_gap_of_a_second_only_resynchronises():
    robot = Robot()
    robot.motion.track_velocity(0, (0.0, 50.0, 0.0))
    robot.run(1, hold=True)
    robot.motion.track_velocity(0, (50.0, 0.0, 0.0))
    robot.now += 1500
    assert robot.see() == [0, 1922, -1922]
    assert VECTORS["gap_1500ms"] == {"motors": [None] * 3, "tracker": robot.tracked()}
    robot.now += 999
    assert robot.see() == [2056, -1556, -1556]


def test_clearing_stops_at_once():
    robot = Robot()
    robot.motion.track_velocity(0, (50.0, 0.0, 0.0))
    robot.run(1, hold=True)
    robot.motion.clear(0)
    robot.run(1, hold=True)
    assert matches(robot, VECTORS["clear_tracking"])


# --- vibration -------------------------------------------------------------------------------------------


def shaken(robot, case):
    motors = []
    for _ in case["motors"]:
        robot.now += case["frame_ms"]
        motors.append(robot.see())
    return motors


def test_the_simple_vibration():
    case, robot = VECTORS["simple_vibrate"], Robot()
    robot.motion.shake.start(0.0, 0, case["push"], case["period_ms"], case["duration_ms"])
    assert shaken(robot, case) == case["motors"]


def test_a_vibration_starts_against_the_motion_and_can_be_ended():
    robot = Robot()
    robot.motion.track_velocity(0, (50.0, -50.0, 0.0))
    robot.run(1, hold=True)
    robot.motion.shake.start(robot.now, 0, (20.0, 20.0, 0.0), 50.0, 0.0)
    robot.run(1, hold=True)
    assert robot.motion.driven[:, 0].tolist() == [30.0, -30.0, 0.0]
    robot.motion.shake.stop(0)
    robot.run(1, hold=True)
    assert robot.motion.driven[:, 0].tolist() == [50.0, -50.0, 0.0]


# --- localisation ----------------------------------------------------------------------------------------


def broadcast(case, x=lambda t: 10000.0 + t, valid=lambda frame: True):
    """When poses and kidnap events are sent, frames from 1000 ms on."""
    localisation, poses, kidnap = Localisation(1), [], []
    localisation.period[:], localisation.stamped[:] = case["period_ms"], case["stamped"]
    for frame in range(case["frames"]):
        t = 1000 + FRAME_MS * frame
        pose = np.array([[x(t)], [20000.0], [9000.0]])
        sighting = localisation.frame(float(t), pose, np.array([valid(frame)]))
        poses += [t] * int(sighting.pose[0])
        kidnap += [[t, 0]] * int(sighting.returned[0]) + [[t, 1]] * int(sighting.lifted[0])
    return poses, kidnap


@pytest.mark.parametrize("case", VECTORS["pose_broadcast"], ids=lambda case: case["name"])
def test_when_poses_are_sent(case):
    told = {}
    if case["name"].startswith("still"):
        told["x"] = lambda t: 11000.0
    if case["name"].startswith("kidnap"):
        told["valid"] = lambda frame: not 3 <= frame < 18
    assert broadcast(case, **told) == (case["poses_ms"], case["kidnap"])


def test_an_idle_robot_that_moves_is_told_at_once():
    case = {"period_ms": 100, "stamped": False, "frames": 150}
    poses, _ = broadcast(case, x=lambda t: 11000.0 if t < 1880 else 11100.0)  # 1880 is a frame; one grid unit
    after = [t for t in poses if t > 1600]
    assert after[:4] == [1891, 2001, 2111, 2221]


@pytest.mark.parametrize(("turn", "interval"), [(199.0, 506), (200.0, 110)])
def test_a_turn_of_less_than_two_degrees_is_no_motion(turn, interval):
    localisation, poses = Localisation(1), []
    for frame in range(200):
        pose = np.array([[5000.0], [5000.0], [turn * (frame % 2)]])
        poses += [FRAME_MS * frame] * int(localisation.frame(FRAME_MS * frame, pose, YES).pose[0])
    assert poses[-1] - poses[-2] == interval


def test_nine_bad_frames_are_no_kidnap():
    case = {"period_ms": 100, "stamped": True, "frames": 60}
    _, kidnap = broadcast(case, valid=lambda frame: frame % 10 == 0)
    assert kidnap == [[1000, 0]]
