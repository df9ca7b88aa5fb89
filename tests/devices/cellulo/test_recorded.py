"""What EPFL's own firmware did, asked of the emulated robots through the bytes of their commands.

The recordings lie beside the repository; the robots' bodies stand still or are ideal, and their cameras see no noise.
"""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from armspan.devices.cellulo.firmware import Firmware
from armspan.devices.cellulo.wire import COMMANDS, EVENTS
from armspan.records import Sheet
from armspan.simulation.bodies import Plant

VECTORS = Path(__file__).parents[4] / "shared" / "vectors"
QUIET = {"dead_zone": 0.0, "saturation": 9.0, "position_noise": 0.0, "heading_noise": 0.0, "latency": (0.0, 0.0)}
STILL = Plant(gain=(0.0, 0.0), **QUIET)
IDEAL = Plant(lag=0.0, gain=(1.0, 1.0), turn_saturation=99.0, **QUIET)
FRAME = 0.011
PAPER = Sheet(2.0, 2.0)


def recorded(name):
    path = VECTORS / name
    if not path.exists():
        pytest.skip(f"what was recorded is not beside the repository: {path} is absent")
    return json.loads(path.read_text())


def robot(pose=(100.0, 100.0, 0.0), plant=STILL):
    x, y, theta = pose
    firmware = Firmware([(x / 1000, y / 1000)], [math.radians(theta)], PAPER, np.random.default_rng(1), plant)
    firmware.age_ms[0] = 0
    firmware.units[0].battery = 4  # as in the recording: no charger, no battery
    return firmware


def say(firmware, t, name, **args):
    firmware.feed(t, 0, COMMANDS.encode(name, **args))


def motors(firmware):
    return firmware.motion.motors()[:, 0].tolist()


def close(got, expected):
    return expected[0] is None or np.abs(np.array(got) - expected).max() <= 1


# --- motors ----------------------------------------------------------------------------------------------


def test_every_velocity_gives_the_pwm():
    for case in recorded("cellulo_firmware.json")["motion"]["velocity_to_pwm"]:
        firmware = robot((100, 100, case["theta_deg"]))
        firmware.advance(0.0)
        vx, vy, w = case["goal_velocity"]
        say(firmware, 0.001, "setGoalVelocity", vx_mm_s=vx, vy_mm_s=vy, w_rad_s=w)
        firmware.advance(FRAME)
        assert close(motors(firmware), case["motors"]), case


def test_the_ramp_of_a_pose_goal():
    case = recorded("cellulo_firmware.json")["motion"]["pose_goal_static_ramp"]
    firmware = robot(case["pose"])
    firmware.advance(0.0)
    x, y, theta, v, w = case["goal"]
    say(firmware, 0.001, "setGoalPose", x_mm=x, y_mm=y, theta_deg=theta, v_max_mm_s=v, w_max_rad_s=w)
    for k, row in enumerate(case["frames"], 1):
        told = firmware.advance(k * FRAME)
        assert close(motors(firmware), row["motors"]), (k, row)
        assert firmware.motion.tracked[:, 0] == pytest.approx(row["tracker"], abs=2e-4)
        assert bool(row["uart"]) == any(packet[1:2] == b"G" for _, packet in told)


def test_the_closed_loops_from_their_bytes():
    for case in recorded("cellulo_firmware.json")["motion"]["closed_loop_ideal_plant"]:
        firmware, reached, rows = robot(case["start"], IDEAL), [], {}
        firmware.advance(0.0)
        firmware.feed(0.001, 0, bytes.fromhex(case["command_hex"]))
        for k in range(1, case["last"][0] // 11 + 1):
            told = firmware.advance(k * FRAME)
            reached += [11 * k for _, packet in told if packet == EVENTS.encode("trackingGoalReached")]
            rows[11 * k] = [*firmware.motion.tracked[:, 0], *motors(firmware)]
        assert reached == [case["goal_event_ms"]], case["name"]
        for row in (*case["trace_every5"], case["last"]):
            got = rows[row[0]]
            assert got[:3] == pytest.approx(row[4:7], abs=0.0201), (case["name"], row)  # a count is 0.02 mm/s
            assert close(got[3:], row[7:]), (case["name"], row)
        told = firmware.truth()
        where = [*(1000 * told.xy[0]), math.degrees((told.heading[0] + math.pi) % (2 * math.pi) - math.pi)]
        assert where == pytest.approx(case["last"][1:4], abs=0.03)


def test_what_keeps_the_motors_off():
    motion = recorded("cellulo_firmware.json")["motion"]
    firmware = robot()
    firmware.advance(0.0)
    say(firmware, 0.001, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)

    def seen(t, case):
        firmware.advance(t)
        pwm, tracker, _ = case
        assert close(motors(firmware), pwm), (t, motors(firmware), case)
        assert firmware.motion.tracked[:, 0].tolist() == tracker

    seen(0.1, motion["kidnap"]["before"])
    firmware.lift(0.1, 0)
    seen(0.4, motion["kidnap"]["while_kidnapped"])
    firmware.put_down(0.4, 0, (0.1, 0.1), 0.0)
    seen(0.5, motion["kidnap"]["after"])
    say(firmware, 0.5, "setGestureEnabled", enabled=1)
    say(firmware, 0.5, "setLocomotionInteractivityMode", mode=1)
    seen(0.6, motion["requires_hold"]["not_held"])
    firmware.touch(0.6, 0, grasp=12)
    seen(0.7, motion["requires_hold"]["held"])
    say(firmware, 0.7, "setLocomotionInteractivityMode", mode=0)
    before = motors(firmware)
    firmware.blind(0.7, 0, 1.5)
    seen(2.1, motion["no_new_frame"])
    assert motors(firmware) == before
    seen(2.3, motion["gap_1500ms"])
    say(firmware, 2.3, "clearTracking")
    seen(2.4, motion["clear_tracking"])


def test_the_simple_vibration():
    cases = {name: case for name, case in recorded("cellulo_firmware.json")["motion"].items() if "Vibrate" in name}
    assert cases
    for name, case in cases.items():
        _, *push, period, duration, step = name.split("_")
        period, duration, step = (int("".join(filter(str.isdigit, text))) for text in (period, duration, step))
        plant = Plant(gain=(0.0, 0.0), frame=step / 1000, **QUIET)
        firmware = robot(plant=plant)
        x, y, theta = (float(number) for number in push)
        firmware.advance(0.0)
        say(firmware, 0.0, "simpleVibrate", i_x=x, i_y=y, i_theta=theta, period_ms=period, duration_ms=duration)
        for k, row in enumerate(case, 1):
            firmware.advance(k * step / 1000)
            assert close(motors(firmware), row), (name, k)


# --- what is told ----------------------------------------------------------------------------------------


def test_when_poses_are_told_and_with_what_bytes():
    for name, case in recorded("cellulo_firmware.json")["pose_broadcast"].items():
        firmware = robot(plant=IDEAL)
        firmware.age_ms[0] = 1000
        for text in case["setup"]:
            firmware.feed(0.0, 0, bytes.fromhex(text))
        still, heard = name.startswith("still"), {}
        for k in range(case["n_frames"]):
            x = 11000 if still else 11000 + 11 * k
            firmware.bodies.pose[:, 0] = x * 0.00508e-3, 20000 * 0.00508e-3, math.pi / 2
            firmware.bodies.lifted[0] = name.startswith("kidnap") and 3 <= k < 18
            for _, packet in firmware.advance(k * FRAME):
                heard[1000 + 11 * k] = heard.get(1000 + 11 * k, "") + packet.hex()
        # the recording's "still" stubbed what tells motion, and went on counting x: there only x is not compared
        assert [(t, blank(text) if still else text) for t, text in heard.items()] == [
            (t, blank(text) if still else text) for t, text in case["tx"]
        ], name


def blank(text):
    """A pose's hex digits without its x."""
    at = max(text.find("0150"), text.find("0153")) + 4
    return text[:at] + text[at + 8 :]


def test_commands_are_answered_with_the_recorded_bytes():
    data = recorded("cellulo.json")
    for case in data["commands"]:
        if "reply_hex" in case:
            assert answer(robot(), case["hex"])[0] == case["reply_hex"], case["name"]
    for case in data["command_stream_cases"]:
        firmware = robot()
        reply, heard = answer(firmware, case["hex"])
        assert reply == case["reply_hex"], case["case"]
        assert heard == case["packets_processed"]
        assert firmware.localisation.period[0] == case["bcast_period_after"]


def answer(firmware, text):
    """What a robot says to bytes within a millisecond, and how many packets it made of them; poses left out."""
    firmware.advance(0.0)
    unit, parsed = firmware.units[0], []
    feed = unit.ears.feed
    unit.ears.feed = lambda data: parsed.append(feed(data)) or parsed[-1]
    firmware.feed(0.001, 0, bytes.fromhex(text))
    told = [packet.hex() for _, packet in firmware.advance(0.002)]
    return "".join(told), sum(map(len, parsed))


def test_commands_reach_what_the_firmware_called():
    """The functions that EPFL's firmware called, with their arguments, as changes of the emulated robots' state."""
    for case in recorded("cellulo.json")["commands"]:
        firmware = robot()
        firmware.advance(0.0)
        firmware.feed(0.001, 0, bytes.fromhex(case["hex"]))
        firmware.advance(0.002)
        for key, value in case.get("firmware_state", {}).items():
            assert state(firmware)[key] == value, case
        for call in case.get("firmware_calls", ()):
            check_call(firmware, call["fn"], call["args"], case["hex"])


def state(firmware):
    unit = firmware.units[0]
    return {
        "bcastPeriod": firmware.localisation.period[0],
        "timestamping": firmware.localisation.stamped[0],
        "frameRequest": unit.wanted_picture,
        "autoexposure": unit.exposure == 0,
        "currentExposurePixels": unit.exposure,
        "gestureEnabled": unit.feels,
    }


GOALS = {"Pose": "xyt", "Position": "xy", "XCoordinate": "x", "YCoordinate": "y", "Orientation": "t"}
GOALS |= {"XThetaCoordinate": "xt", "YThetaCoordinate": "yt"}


def check_call(firmware, name, args, text):
    motion, unit = firmware.motion, firmware.units[0]
    if name.startswith("setGoal") and name[7:] in GOALS:
        axes = ["xyt".index(axis) for axis in GOALS[name[7:]]]
        assert motion._goal[axes, 0].tolist() == args[: len(axes)], text
        assert np.flatnonzero(motion._controlled[:, 0]).tolist() == axes
        limits = motion._limit[:, 0].tolist()
        wanted = args[len(axes) :]
        told = [limit for limit, has in zip(limits, (min(axes) < 2, 2 in axes), strict=True) if has]
        assert told == pytest.approx(wanted, abs=1e-4), text
    elif name == "setGoalVelocity":
        assert motion.tracked[:, 0] == pytest.approx(args, abs=1e-5)
    elif name == "setLEDResponseMode":
        assert unit.response == args[0]
    elif name == "setExposureTime":
        assert unit.exposure == args[0]
    elif name == "hapticBackdriveAssist":
        assert motion.backdrive._help[:, 0] == pytest.approx(args, abs=1e-4)
    elif name == "polyBezierInit":
        assert unit.chain.start == pytest.approx(args)
    elif name == "polyBezierAppend":
        assert np.ravel(unit.chain.segments[0]) == pytest.approx(args)
    elif name == "setGoalPolyBezier":
        follower = motion._curves[0]
        assert (follower.v, follower.w, follower.angle) == (*args, None)
    elif name == "setGoalPolyBezierAligned":
        follower = motion._curves[0]
        assert (follower.v, 100 * follower.angle, follower.w) == tuple(args)
    elif name == "setMotorOutput":
        assert motors(firmware)[args[0] - 1] == args[1]


# --- lights ----------------------------------------------------------------------------------------------


def test_the_lights_of_every_effect():
    for name, case in recorded("cellulo_firmware.json")["led"].items():
        firmware = robot()
        say(firmware, 0.0, "setVisualEffect", effect=0, red=0, green=0, blue=0, value=0)  # dark, as in the recording
        firmware.advance(5.0)
        assert not firmware.lights(5.0).any()
        for text in case["cmds"]:
            firmware.feed(5.0, 0, bytes.fromhex(text))
        for ms, colours in case["colors_12bit"]:
            firmware.advance(5.0 + ms / 1000)
            got = np.rint(firmware.lights(5.0 + ms / 1000)[0] * 4095)
            np.testing.assert_array_equal(got, colours, f"{name} at {ms} ms")
