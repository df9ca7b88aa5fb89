import math

import numpy as np
import pytest

from armspan.devices.cellulo.robot import CLEAR, PING, SETTINGS, Outbox, Placement, Robot, Track
from armspan.devices.cellulo.wire import COMMANDS, EVENTS
from armspan.errors import DeviceError
from armspan.records import Drive, GoTo, Haptic, Light, Link, RobotState, Stop, Touch

GREETING = [CLEAR, *SETTINGS, COMMANDS.encode("queryBatteryState")]


def pose(x_mm=100.0, y_mm=200.0, theta_deg=90.0, ticks=1000):
    args = {"x_raw": round(x_mm / 0.00508), "y_raw": round(y_mm / 0.00508), "theta_raw": round(100 * theta_deg)}
    if ticks is None:
        return EVENTS.decode(EVENTS.encode("poseChanged", **args))
    return EVENTS.decode(EVENTS.encode("poseChangedTimestamped", **args, timestamp_ms=ticks))


def event(name, **args):
    return EVENTS.decode(EVENTS.encode(name, **args))


def linked(**placement):
    robot = Robot("ash", Placement(**placement))
    robot.linked(0.0, True)
    for t in (0.0, 0.1):
        robot.outbox.due(t)
    return robot


def goal(xy=(0.1, 0.2), speed=0.1, until=9.0, heading=None):
    return GoTo(0.0, "ash", xy, speed, until, heading)


# --- outbox ----------------------------------------------------------------------------------------------


def test_the_latest_motion_wins_and_is_sent_once():
    box = Outbox()
    box.move(b"one", 9.0, 0.0)
    box.move(b"two", 9.0, 0.0)
    assert box.due(0.0) == [b"two"]
    assert box.due(0.1) == []


def test_a_stop_goes_first_three_times_and_voids_the_motion_that_waits():
    box = Outbox()
    box.put("light", b"red")
    box.move(b"go", 9.0, 0.0)
    box.stop(1.0)
    assert box.due(1.0) == [CLEAR, b"red"]
    assert box.wake() == pytest.approx(1.03)
    assert [box.due(t) for t in (1.01, 1.031, 1.04, 1.061, 1.1)] == [[], [CLEAR], [], [CLEAR], []]
    assert box.wake() == math.inf


def test_a_new_motion_ends_the_repeats_but_not_the_stop_itself():
    box = Outbox()
    box.stop(1.0)
    box.move(b"go", 9.0, 1.0)
    assert box.due(1.0) == [CLEAR, b"go"]
    assert box.due(1.1) == []


def test_a_motion_that_is_late_is_not_sent():
    box = Outbox()
    box.move(b"go", 1.3, 1.0)
    assert box.due(1.3) == []


def test_the_end_of_a_lease_is_a_stop():
    box = Outbox()
    box.move(b"go", 1.3, 1.0)
    assert box.due(1.0) == [b"go"]
    assert box.wake() == 1.3
    assert [box.due(t) for t in (1.29, 1.3, 1.331, 1.361, 1.5)] == [[], [CLEAR], [CLEAR], [CLEAR], []]


def test_a_refreshed_lease_does_not_end():
    box = Outbox()
    for k in range(20):
        box.move(b"go", 0.1 * k + 0.3, 0.1 * k)
        assert box.due(0.1 * k) == [b"go"]


def test_of_each_light_the_latest_is_sent():
    box = Outbox()
    for slot, packet in [("all", b"1"), (2, b"2"), ("all", b"3"), (4, b"4")]:
        box.put(slot, packet)
    assert box.due(0.0) == [b"2", b"3", b"4"]


# --- poses that cannot be --------------------------------------------------------------------------------


def test_a_pose_that_jumps_is_refused():
    track = Track()
    takes = [track.takes(0.02 * k, (0.7 if k == 5 else 0.1, 0.1), 20 * k) for k in range(10)]
    assert takes == [k != 5 for k in range(10)]
    assert track.refused == 1


def test_a_robot_that_is_really_elsewhere_is_believed_at_the_second_pose():
    track = Track()
    takes = [track.takes(0.02 * k, (0.7 if k >= 5 else 0.1, 0.1), 20 * k) for k in range(10)]
    assert takes == [k != 5 for k in range(10)]


def test_noise_poses_do_not_agree_with_each_other():
    rng, track = np.random.default_rng(0), Track()
    assert track.takes(0.0, (0.1, 0.1), 0)
    assert not any(track.takes(0.02 * k, tuple(rng.uniform(0, 4e4, 2)), int(rng.integers(1 << 32))) for k in range(99))


def test_a_time_stamp_that_jumps_is_refused():
    track = Track()
    ticks = [1000, 1020, 1 << 31, 1060, 1080]
    assert [track.takes(0.02 * k, (0.1, 0.1), tick) for k, tick in enumerate(ticks)] == [True, True, False, True, True]


def test_a_fast_hand_and_a_wrapping_counter_are_no_jumps():
    track = Track()
    for k in range(100):
        assert track.takes(0.022 * k, (0.022 * k, 0.1), ((1 << 32) - 500 + 22 * k) % (1 << 32))


def test_a_burst_of_poses_that_were_held_up_is_believed():
    track = Track()
    assert track.takes(0.0, (0.1, 0.1), 0)
    assert track.takes(1.0, (0.12, 0.1), 100)
    assert track.takes(1.001, (0.25, 0.1), 1000)


# --- from the robot --------------------------------------------------------------------------------------


def test_who_comes_is_stopped_before_it_is_set_up():
    robot = Robot("ash", Placement())
    assert robot.linked(1.0, True) == [Link(1.0, "ash", True)]
    assert robot.outbox.due(1.0) == GREETING
    assert robot.linked(1.1, True) == []
    assert robot.outbox.due(1.2) == [CLEAR]  # only the stop is said again


def test_a_pose_is_a_state_on_the_sheet():
    robot = linked(origin=(0.02, 0.05), scale=2.0)
    (state,) = robot.hear(pose(100, 200, 90, 5000), 3.0)
    assert (state.t, state.robot, state.held, state.battery) == (3.0, "ash", False, None)
    assert state.xy == pytest.approx((0.18, 0.35), abs=1e-5)
    assert state.heading == pytest.approx(math.pi / 2)


def test_goals_go_the_way_back():
    robot = linked(origin=(0.02, 0.05), scale=2.0)
    robot.take(goal((0.18, 0.35), 0.1), 0.1)
    (packet,) = robot.outbox.due(0.1)
    assert COMMANDS.decode(packet).args == pytest.approx({"x_mm": 100, "y_mm": 200, "v_max_mm_s": 50}, abs=0.01)


def test_the_time_of_a_state_is_the_cameras_not_the_packets():
    rng, robot, errors, last = np.random.default_rng(4), linked(), [], 0.0
    for k in range(500):
        measured = 0.022 * k
        (state,) = robot.hear(pose(ticks=round(1000 * measured) + 777), measured + rng.uniform(0.005, 0.03))
        errors.append(state.t - measured)
        assert state.t >= last
        last = state.t
    assert max(errors[100:]) - min(errors[100:]) < 0.002
    assert max(errors[100:]) == pytest.approx(0.006, abs=0.002)  # the shortest delay cannot be seen


def test_poses_without_time_stamps_are_asked_for_again():
    robot = linked()
    (state,) = robot.hear(pose(ticks=None), 0.2)
    assert state.t == 0.2
    assert robot.outbox.due(0.2) == []
    robot.hear(pose(ticks=None), 0.6)
    assert robot.outbox.due(0.6) == GREETING[1:]


def test_a_robot_that_boots_again_is_set_up_again_and_its_clock_is_a_new_one():
    robot = linked()
    for k in range(10):
        robot.hear(pose(ticks=100000 + 20 * k), 1.0 + 0.02 * k)
    assert robot.hear(event("bootComplete"), 3.0) == []
    assert robot.outbox.due(3.0) == GREETING[1:]
    (state,) = robot.hear(pose(500, 500, ticks=40), 3.1)
    assert state.t == 3.1


def test_a_boot_that_was_not_heard_costs_one_pose():
    robot = linked()
    for k in range(10):
        robot.hear(pose(ticks=100000 + 20 * k), 1.0 + 0.02 * k)
    assert robot.hear(pose(ticks=40), 3.1) == []
    (state,) = robot.hear(pose(ticks=60), 3.12)
    assert state.t == 3.12


def test_a_lifted_robot_is_told_to_forget_its_goal_and_again_when_it_is_back():
    robot = linked()
    robot.hear(pose(), 1.0)
    robot.take(goal(), 1.0)
    (state,) = robot.hear(event("kidnapChanged", kidnapped=True), 1.5)
    assert (state.held, state.t) == (True, 1.5)
    assert state.xy == pytest.approx((0.1, 0.2), abs=1e-5)
    assert robot.outbox.due(1.5) == [CLEAR]
    assert robot.hear(event("kidnapChanged", kidnapped=False), 2.0) == []
    assert robot.outbox.due(2.0) == [CLEAR]
    (state,) = robot.hear(pose(600, 600, ticks=2000), 2.0)  # it was carried: no jump
    assert not state.held


@pytest.mark.parametrize(("told", "share"), [(0, 0.5), (1, 0.02), (2, 0.5), (3, 1.0), (4, None), (5, None)])
def test_battery_states_are_shares_roughly(told, share):
    robot = linked()
    robot.hear(event("batteryStateChanged", state=told), 0.5)
    (state,) = robot.hear(pose(), 1.0)
    assert state.battery == share


def test_an_empty_battery_is_zero():
    robot = linked()
    robot.hear(event("lowBattery"), 0.5)
    assert robot.hear(pose(), 1.0)[0].battery == 0.0


def test_keys():
    robot = linked()
    heard = [robot.hear(event(name, key=3), 1.0)[0] for name in ("touchBegan", "longTouch", "touchReleased")]
    assert heard == [Touch(1.0, "ash", 3, kind) for kind in ("began", "long", "released")]


def test_a_silent_robot_is_asked_then_lost_then_met_again():
    robot = linked()
    robot.hear(event("batteryStateChanged", state=0), 1.0)
    assert robot.watch(1.9) == []
    assert robot.outbox.due(1.9) == []
    robot.watch(2.1)
    assert robot.outbox.due(2.1) == [PING]
    robot.hear(event("acknowledged"), 2.2)
    assert robot.watch(5.1) == []
    assert robot.watch(5.3) == [Link(5.3, "ash", False)]
    robot.take(goal(), 5.4)
    assert robot.outbox.due(5.4) == []
    link, state = robot.hear(pose(), 6.0)
    assert (link, type(state)) == (Link(6.0, "ash", True), RobotState)
    assert robot.outbox.due(6.0) == GREETING


# --- to the robot ----------------------------------------------------------------------------------------


def sent(command):
    robot = linked()
    robot.take(command, 1.0)
    return [packet.hex() for packet in robot.outbox.due(1.0)]


def test_commands_as_bytes():
    assert sent(goal()) == ["014e" + "00004ce5" + "000099ca" + "2710"]
    assert sent(goal(heading=-math.pi / 2)) == ["0147" + "00004ce5" + "000099ca" + "6978" + "2710" + "02ee"]
    assert sent(Stop(1.0, "ash")) == ["0158"]
    assert sent(Light(1.0, "ash", (255, 0, 7))) == ["014500ff000700"]
    assert sent(Light(1.0, "ash", (0, 200, 0), 3)) == ["01450100c80003"]
    assert sent(Haptic(1.0, "ash", 0.5, 0.25)) == ["0156" + "0bb8" + "0bb8" + "0000" + "0014" + "00fa"]


def test_a_vibration_never_lasts_for_ever():
    assert sent(Haptic(1.0, "ash", 1.0, 0.0))[0].endswith("0001")


@pytest.mark.parametrize(
    "command",
    [
        Drive(1.0, "ash", (0.1, 0.0), 0.0, 2.0),
        goal((math.nan, 0.1)),
        goal((-0.01, 0.1)),
        goal(speed=-0.1),
        goal(heading=math.inf),
        Haptic(1.0, "ash", -0.5, 1.0),
    ],
)
def test_what_must_not_reach_a_robot(command):
    with pytest.raises(DeviceError):
        sent(command)
