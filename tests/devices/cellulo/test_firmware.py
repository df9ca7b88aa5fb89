import json
import math
from pathlib import Path

import numpy as np
import pytest

from armspan.devices.cellulo.firmware import Faults, Firmware
from armspan.devices.cellulo.wire import COMMANDS, EVENTS
from armspan.errors import ConfigError
from armspan.records import Sheet
from armspan.simulation.bodies import Plant

IDEAL = Plant(
    lag=0.0, gain=(1.0, 1.0), dead_zone=0.0, saturation=9.0, position_noise=0.0, heading_noise=0.0, latency=(0.0, 0.0)
)
PAPER = Sheet(0.8, 0.6)


def robots(xy=((0.1, 0.1),), plant=IDEAL, **faults):
    return Firmware(xy, np.zeros(len(xy)), PAPER, np.random.default_rng(1), plant, Faults(**faults))


def say(firmware, t, name, robot=0, **args):
    firmware.feed(t, robot, COMMANDS.encode(name, **args))


def told(firmware, until, robot=0, step=0.001):
    """(ms, packet) of all that a robot tells."""
    heard = []
    for k in range(round(until / step) + 1):
        heard += [(k, EVENTS.decode(packet)) for who, packet in firmware.advance(k * step) if who == robot]
    return heard


def names(heard):
    return [packet.name for _, packet in heard]


def test_at_boot_it_is_back_on_paper_and_tells_its_pose_ten_times_a_second():
    heard = told(robots(), 0.5)
    assert [(ms, packet.name) for ms, packet in heard[:2]] == [(0, "kidnapChanged"), (0, "poseChanged")]
    assert heard[0][1].args == {"kidnapped": False}
    assert heard[1][1].raw == (19685, 19685, 0)
    assert [ms for ms, _ in heard[1:]] == [0, 110, 220, 330, 440]


def test_20_ms_stamped_are_22_between_frames_and_its_own_clock():
    firmware = robots()
    say(firmware, 0.0, "setPoseBcastPeriod", period_ms=20)
    say(firmware, 0.0, "setTimestampingEnabled", enabled=1)
    heard = [(ms, packet) for ms, packet in told(firmware, 1.0) if packet.name == "poseChangedTimestamped"]
    assert np.diff([ms for ms, _ in heard]).tolist() == [22] * (len(heard) - 1)
    offsets = {packet.args["timestamp_ms"] - ms for ms, packet in heard}
    assert len(heard) == 46
    assert len(offsets) == 1
    assert offsets != {0}


def test_an_ideal_robot_reaches_its_goal_at_the_recorded_millisecond():
    firmware = robots()
    firmware.advance(0.0)
    firmware.feed(0.001, 0, bytes.fromhex("014e000099ca00004ce52710"))  # (200, 100) mm, at 100 mm/s
    heard = told(firmware, 3.0)
    assert [ms for ms, packet in heard if packet.name == "trackingGoalReached"] == [1353]
    assert firmware.bodies.pose[0, 0] == pytest.approx(0.19748, abs=2e-5)


RECORDED = Path(__file__).parents[4] / "shared" / "vectors" / "cellulo_firmware.json"


def recorded():
    if not RECORDED.exists():
        pytest.skip(f"what the firmware did is not beside the repository: {RECORDED} is absent")
    return json.loads(RECORDED.read_text())


def test_recorded_runs_on_an_ideal_plant_from_their_bytes():
    runs = recorded()["motion"]["closed_loop_ideal_plant"]
    assert runs
    for run in runs:
        x, y, theta = run["start"]
        firmware = Firmware([(x / 1000, y / 1000)], [math.radians(theta)], Sheet(2, 2), np.random.default_rng(1), IDEAL)
        firmware.advance(0.0)
        firmware.feed(0.001, 0, bytes.fromhex(run["command_hex"]))
        reached = [ms for ms, packet in told(firmware, 5.0, step=0.011) if packet.name == "trackingGoalReached"]
        assert [11 * k for k in reached] == [run["goal_event_ms"]], run["name"]


def test_a_goal_holds_for_ever():
    firmware = robots()
    say(firmware, 0.0, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)
    firmware.advance(10.0)
    assert firmware.bodies.velocity[:, 0] == pytest.approx([0.05, 0, 0])


def test_clearing_stops():
    firmware = robots()
    say(firmware, 0.0, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)
    firmware.advance(0.5)
    say(firmware, 0.5, "clearTracking")
    firmware.advance(0.6)
    assert not firmware.bodies.velocity.any()


@pytest.mark.parametrize(
    ("name", "args", "rests"),
    [
        ("setGoalXCoordinate", {"x_mm": 150, "v_max_mm_s": 100}, (147.5, 100.0, 0.0)),
        ("setGoalYCoordinate", {"y_mm": 150, "v_max_mm_s": 100}, (100.0, 147.5, 0.0)),
        ("setGoalOrientation", {"theta_deg": 90, "w_max_rad_s": 3}, (100.0, 100.0, 88.0)),
        (
            "setGoalXThetaCoordinate",
            {"x_mm": 150, "theta_deg": 90, "v_max_mm_s": 100, "w_max_rad_s": 3},
            (147.5, 100.0, 88.0),
        ),
        (
            "setGoalYThetaCoordinate",
            {"y_mm": 150, "theta_deg": 90, "v_max_mm_s": 100, "w_max_rad_s": 3},
            (100.0, 147.5, 88.0),
        ),
    ],
)
def test_goals_of_some_coordinates_leave_the_others(name, args, rests):
    firmware = robots()
    say(firmware, 0.0, name, **args)
    firmware.advance(4.0)
    x, y, theta = firmware.bodies.pose[:, 0]
    assert (1000 * x, 1000 * y, math.degrees(theta)) == pytest.approx(rests, abs=0.1)


def test_a_lifted_robot_says_so_after_ten_frames_and_resumes_its_goal():
    firmware = robots()
    say(firmware, 0.0, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)
    firmware.lift(0.5, 0)
    firmware.put_down(1.0, 0, (0.3, 0.3), 0.0)
    heard = told(firmware, 1.2)
    kidnaps = [(ms, packet.args["kidnapped"]) for ms, packet in heard if packet.name == "kidnapChanged"]
    assert kidnaps == [(0, False), (506 + 99, True), (1001, False)]
    assert not any(610 < ms < 1000 for ms, _ in heard)
    assert firmware.bodies.velocity[0, 0] == pytest.approx(0.05)


def test_questions_are_answered():
    firmware = robots()
    say(firmware, 0.0, "ping")
    say(firmware, 0.0, "queryBatteryState")
    heard = [packet for _, packet in told(firmware, 0.05)]
    assert [packet.name for packet in heard[:2]] == ["acknowledged", "batteryStateChanged"]
    assert heard[1].args["state_name"] == "discharging"


def test_a_reset_robot_is_deaf_then_tells_that_it_is_there_with_the_settings_of_a_boot():
    firmware = robots(boot_s=0.5)
    say(firmware, 0.0, "setTimestampingEnabled", enabled=1)
    say(firmware, 0.0, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)
    say(firmware, 0.1, "reset")
    say(firmware, 0.3, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)
    heard = [(ms, packet) for ms, packet in told(firmware, 1.0) if ms > 110]
    assert names(heard)[:3] == ["bootComplete", "kidnapChanged", "poseChanged"]
    assert heard[0][0] == pytest.approx(605, abs=6)
    assert not firmware.bodies.velocity.any()


def test_a_robot_that_was_shut_down_is_silent():
    firmware = robots()
    say(firmware, 0.0, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)
    say(firmware, 0.2, "shutdown")
    firmware.advance(0.25)
    assert not firmware.bodies.velocity.any()
    assert not firmware.asleep(0)  # its lights fade first: 0x600 loses a tenth in 10 ms, then one by one
    heard = told(firmware, 2.0)
    assert "shuttingDown" not in names(heard)
    assert max(ms for ms, _ in heard) == pytest.approx(750, abs=120)
    assert firmware.asleep(0)
    assert not firmware.lights(2.0).any()


def test_lights_and_vibration_and_hold_mode():
    firmware = robots()
    say(firmware, 0.0, "setVisualEffect", effect=1, red=255, green=0, blue=0, value=2)
    firmware.advance(2.0)
    lights = firmware.lights(2.0)[0]
    assert lights[2] == pytest.approx([1, 0, 0], abs=0.01)
    assert lights[3] == pytest.approx([0x600 / 4095] * 3, abs=0.01)
    say(firmware, 2.0, "simpleVibrate", i_x=20, i_y=0, i_theta=0, period_ms=50, duration_ms=0)
    firmware.advance(2.1)
    assert abs(firmware.bodies.velocity[0, 0]) == pytest.approx(0.02)
    say(firmware, 2.1, "clearHapticFeedback")
    firmware.advance(2.2)
    assert not firmware.bodies.velocity.any()
    say(firmware, 2.2, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)
    say(firmware, 2.2, "setLocomotionInteractivityMode", mode=1)
    firmware.advance(2.5)
    assert not firmware.bodies.velocity.any()


def test_a_touched_key_is_told():
    firmware = robots()
    firmware.press(0.2, 0, "longTouch", 3)
    heard = [(ms, packet.args) for ms, packet in told(firmware, 0.3) if packet.name == "longTouch"]
    assert heard == [(pytest.approx(209, abs=11), {"key": 3})]


def test_packets_are_late_within_the_radios_bounds_and_in_order():
    firmware = robots(plant=Plant(latency=(0.005, 0.030)), latency_s=0.1)
    for k in range(200):
        say(firmware, 0.01 * k, "ping")
    heard = told(firmware, 3.0)
    pongs = np.array([ms for ms, packet in heard if packet.name == "acknowledged"]) / 1000
    assert len(pongs) == 200
    assert (np.diff(pongs) >= 0).all()
    late = pongs - 0.01 * np.arange(200)
    assert late.min() >= 0.21
    assert late.max() <= 0.261 + 0.011


def test_a_share_of_the_commands_is_lost():
    firmware = robots(drop=0.3)
    for k in range(1000):
        say(firmware, 0.001 * k, "ping")
    assert names(told(firmware, 1.1)).count("acknowledged") == pytest.approx(700, abs=45)


def test_bytes_between_packets_do_not_disturb():
    firmware = robots()
    firmware.feed(0.0, 0, bytes.fromhex("ff0101500150"))
    assert names(told(firmware, 0.05)).count("acknowledged") == 1


def test_faults_that_are_none():
    with pytest.raises(ConfigError, match=r"a share of 1.5 cannot be dropped; expected 0 to 1"):
        Faults(drop=1.5)
    with pytest.raises(ConfigError, match="a latency of -1"):
        Faults(latency_s=-1)
