"""What hands, batteries and curves do to emulated robots: all by bytes in and bytes out."""

import math

import numpy as np
import pytest

from armspan.devices.cellulo.faults import Faults, Trouble
from armspan.devices.cellulo.firmware import Firmware
from armspan.devices.cellulo.keys import Keys
from armspan.devices.cellulo.wire import COMMANDS, EVENTS
from armspan.errors import ConfigError
from armspan.records import Sheet
from armspan.simulation.bodies import Plant

QUIET = {"dead_zone": 0.0, "saturation": 9.0, "position_noise": 0.0, "heading_noise": 0.0, "latency": (0.0, 0.0)}
IDEAL = Plant(lag=0.0, gain=(1.0, 1.0), **QUIET)


def robot(plant=IDEAL, xy=(0.2, 0.2), **faults):
    return Firmware([xy], np.zeros(1), Sheet(1.0, 1.0), np.random.default_rng(1), plant, Faults(**faults))


def say(firmware, t, name, **args):
    firmware.feed(t, 0, COMMANDS.encode(name, **args))


def told(firmware, until, since=0.0, step=0.001):
    """(ms, name, args) of all that a robot tells, poses left out."""
    heard = []
    for k in range(round(since / step), round(until / step) + 1):
        heard += [(k, EVENTS.decode(packet)) for _, packet in firmware.advance(k * step)]
    return [(ms, p.name, p.args) for ms, p in heard if not p.name.startswith("pose")]


def names(heard):
    return [(name, ms) for ms, name, _ in heard]


# --- keys ------------------------------------------------------------------------------------------------


def test_a_touch_a_long_touch_and_its_end_are_sampled_every_32_ms():
    firmware = robot()
    firmware.advance(0.5)
    firmware.touch(0.5, 0, [3])
    firmware.touch(3.0, 0)
    heard = told(firmware, 3.5, 0.5)
    assert heard == [
        (512, "touchBegan", {"key": 3}),
        (2528, "longTouch", {"key": 3}),
        (3008, "touchReleased", {"key": 3}),
    ]


def test_two_fingers_are_two_touches():
    firmware = robot()
    firmware.advance(0.1)
    firmware.touch(0.1, 0, [0, 5])
    firmware.touch(0.5, 0, [5])
    heard = [(name, args["key"]) for _, name, args in told(firmware, 0.6, 0.1)]
    assert heard == [("touchBegan", 0), ("touchBegan", 5), ("touchReleased", 0)]


def test_a_second_generation_robot_does_not_feel_its_keys():
    firmware = robot(generation="v2")
    firmware.advance(0.1)
    say(firmware, 0.1, "setGestureEnabled", enabled=1)
    firmware.touch(0.2, 0, [3])
    assert told(firmware, 3.0, 0.1) == []


def test_a_hold_is_told_where_it_is_wanted():
    firmware = robot()
    firmware.advance(0.1)
    firmware.touch(0.1, 0, grasp=12)
    assert told(firmware, 0.5, 0.1) == []
    say(firmware, 0.5, "setGestureEnabled", enabled=1)
    firmware.touch(1.0, 0, grasp=9.9)
    firmware.touch(1.5, 0, grasp=11)
    say(firmware, 2.0, "setGestureEnabled", enabled=0)
    heard = [(ms, args["gesture"]) for ms, name, args in told(firmware, 2.5, 0.5) if name == "gestureChanged"]
    assert heard == [(512, 1), (1024, 0), (1504, 1), (2000, 0)]


def test_a_robot_that_must_be_held_moves_only_then():
    firmware = robot()
    say(firmware, 0.0, "setGestureEnabled", enabled=1)
    say(firmware, 0.0, "setLocomotionInteractivityMode", mode=1)
    say(firmware, 0.0, "setGoalVelocity", vx_mm_s=50, vy_mm_s=0, w_rad_s=0)
    firmware.advance(1.0)
    assert firmware.truth().xy[0, 0] == pytest.approx(0.2)
    firmware.touch(1.0, 0, grasp=20)
    firmware.touch(2.0, 0)
    firmware.advance(3.0)
    assert firmware.truth().xy[0, 0] == pytest.approx(0.25, abs=0.002)


def test_three_fingers_switch_it_off_and_four_on_again():
    firmware = robot(boot_s=0.5)
    firmware.advance(0.1)
    firmware.touch(0.1, 0, [0, 2, 4])
    firmware.touch(3.5, 0)
    heard = [(name, ms) for name, ms in names(told(firmware, 6.0, 0.1)) if not name.startswith("touch")]
    assert heard == [("longTouch", 2144)] * 3 + [("shuttingDown", 3136)]
    assert firmware.asleep(0)
    assert not firmware.lights(6.0).any()
    say(firmware, 6.0, "ping")
    assert told(firmware, 7.0, 6.0) == []
    firmware.touch(7.0, 0, [0, 1, 2, 3])
    heard = names(told(firmware, 11.0, 7.0))
    assert ("bootComplete", 10516) in heard
    assert not firmware.asleep(0)
    assert firmware.lights(11.5)[0, 5] == pytest.approx([0x600 / 4095] * 3)


@pytest.mark.parametrize("keys", [[0, 2], [0, 2, 4, 5], [0, 1, 2]])
def test_other_fingers_do_not(keys):
    pad = Keys()
    pad.feel(keys)
    heard = {name for k in range(150) for name, _ in pad.sample(32.0 * k)}
    assert "off" not in heard
    assert ("on" in heard) == (len(keys) >= 4)


def test_a_touched_light_is_brighter_unless_it_should_not_be():
    firmware = robot()
    firmware.touch(0.0, 0, [2])
    firmware.advance(0.2)
    assert firmware.lights(0.2)[0, [1, 2], 0] * 4095 == pytest.approx([0x600, 0x600 + 0x800])
    say(firmware, 0.2, "setLEDResponseMode", mode=1)
    firmware.advance(0.3)
    assert firmware.lights(0.3)[0] * 4095 == pytest.approx(np.full((6, 3), 0x600))
    say(firmware, 0.3, "setLEDResponseMode", mode=2)
    say(firmware, 0.3, "setGestureEnabled", enabled=1)
    firmware.advance(0.5)
    assert firmware.lights(0.5)[0] * 4095 == pytest.approx(np.tile([0, 2055, 0], (6, 1)))
    firmware.touch(0.5, 0)
    firmware.advance(0.7)
    assert firmware.lights(0.7)[0] * 4095 == pytest.approx(np.full((6, 3), 0x600))


# --- power -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("state", "colour", "flashes"), [(2, (0, 1, 0), 2), (3, (0, 1, 0), 4), (1, (1, 0, 0), 10)])
def test_a_battery_that_changes_is_told_and_flashes(state, colour, flashes):
    firmware = robot()
    firmware.advance(0.1)
    firmware.charge(0.1, 0, state)
    firmware.charge(0.2, 0, state)
    assert [args["state"] for _, name, args in told(firmware, 0.4, 0.1) if name == "batteryStateChanged"] == [state]
    lit = [bool(np.allclose(firmware.lights(0.4 + k / 100)[0, 0], colour)) for k in range(530)]
    begins = sum(not before and now for before, now in zip([False, *lit], lit, strict=False))
    assert begins == min(flashes, 10)


def test_a_low_battery_says_so_after_a_while_and_sleeps():
    firmware = robot()
    firmware.advance(0.5)
    firmware.charge(0.5, 0, 1)
    heard = names(told(firmware, 9.0, 0.5))
    assert ("batteryStateChanged", 500) in heard
    assert ("lowBattery", 6200) in heard
    assert firmware.asleep(0)


def test_a_battery_that_is_charged_in_time_does_not_sleep():
    firmware = robot()
    firmware.charge(0.5, 0, 1)
    firmware.charge(3.0, 0, 2)
    assert "lowBattery" not in [name for name, _ in names(told(firmware, 9.0))]
    assert not firmware.asleep(0)


# --- haptics ---------------------------------------------------------------------------------------------


def pushed(firmware, velocity, seconds=0.6):
    """Let a hand drag the robot; what its motors then add [mm/s, rad/s] and after 0.3 s of rest."""
    t = firmware._frames * 0.011
    firmware.push(t, 0, velocity, seconds)
    firmware.advance(t + seconds - 0.05)
    during = firmware.motion.driven[:, 0].copy()
    firmware.advance(t + seconds + 1.0)
    return during, firmware.motion.driven[:, 0].copy()


def test_haptic_assist_helps_or_resists_by_its_share_and_fades():
    for coefficient, speed, fade in ((0.6, 100.0, 1.0), (-0.3, 80.0, 1.0), (0.6, 33.0, 0.6)):
        firmware = robot(Plant(lag=0.0, gain=(0.0, 0.0), **QUIET))
        say(firmware, 0.0, "setHapticBackdriveAssist", x_coeff=coefficient, y_coeff=coefficient, theta_coeff=0)
        firmware.advance(0.2)
        during, after = pushed(firmware, (speed / 1000, 0.0, 0.0))
        assert during == pytest.approx([coefficient * fade * speed, 0.0, 0.0], abs=0.5)
        assert not after.any()


def test_haptic_assist_turns():
    firmware = robot(Plant(lag=0.0, gain=(0.0, 0.0), **QUIET))
    say(firmware, 0.0, "setHapticBackdriveAssist", x_coeff=0, y_coeff=0, theta_coeff=0.5)
    firmware.advance(0.2)
    during, _ = pushed(firmware, (0.0, 0.0, 2.0))
    assert during == pytest.approx([0, 0, 1.0], abs=0.03)


def test_casual_assist_gives_six_tenths_above_70_mm_s_and_the_square_of_less():
    for speed, fade in ((140.0, 1.0), (35.0, 0.25)):
        firmware = robot(Plant(lag=0.0, gain=(0.0, 0.0), **QUIET))
        say(firmware, 0.0, "setCasualBackdriveAssistEnabled", enabled=1)
        firmware.advance(0.2)
        during, after = pushed(firmware, (0.0, speed / 1000, 0.0))
        assert during == pytest.approx([0.0, 0.6 * fade * speed, 0.0], abs=0.5)
        assert not after.any()


def test_casual_assist_of_a_held_robot_goes_with_the_hand():
    firmware = robot(Plant(lag=0.0, gain=(0.0, 0.0), **QUIET))
    say(firmware, 0.0, "setGestureEnabled", enabled=1)
    say(firmware, 0.0, "setCasualBackdriveAssistEnabled", enabled=1)
    firmware.touch(0.0, 0, grasp=30)
    firmware.advance(0.2)
    during, _ = pushed(firmware, (0.1, 0.0, 0.0), 1.0)
    assert during == pytest.approx([100.0, 0.0, 0.0], abs=2.0)


def test_one_assist_turns_the_other_off_and_clearing_haptics_turns_none_off():
    firmware = robot()
    backdrive = firmware.motion.backdrive
    say(firmware, 0.0, "setHapticBackdriveAssist", x_coeff=0.5, y_coeff=0, theta_coeff=0)
    say(firmware, 0.0, "clearHapticFeedback")
    firmware.advance(0.1)
    assert backdrive._help[0, 0] == 0.5
    say(firmware, 0.1, "setCasualBackdriveAssistEnabled", enabled=1)
    firmware.advance(0.2)
    assert (backdrive._help[0, 0], bool(backdrive._casual[0])) == (0.0, True)
    say(firmware, 0.2, "setHapticBackdriveAssist", x_coeff=0, y_coeff=-0.5, theta_coeff=0)
    firmware.advance(0.3)
    assert (backdrive._help[1, 0], bool(backdrive._casual[0])) == (-0.5, False)
    say(firmware, 0.3, "setHapticBackdriveAssist", x_coeff=0, y_coeff=0, theta_coeff=0)
    firmware.advance(0.4)
    assert not backdrive.on


def test_vibration_on_motion_shakes_only_who_moves():
    firmware = robot(Plant(lag=0.0, gain=(0.0, 0.0), **QUIET))
    say(firmware, 0.0, "vibrateOnMotion", coeff=0.5, period_ms=44)
    firmware.advance(0.5)
    assert not firmware.motion.driven.any()
    firmware.push(0.5, 0, (0.1, 0.01, 0.0), 2.0)  # y stays below 15 mm/s
    seen = []
    for k in range(100, 160):
        firmware.advance(k * 0.011)
        seen.append(firmware.motion.driven[:, 0].copy())
    assert np.abs(np.array(seen)[:, 0]) == pytest.approx(50.0, abs=0.5)
    assert not np.array(seen)[:, 1:].any()
    flips = np.flatnonzero(np.diff(np.sign(np.array(seen)[:, 0])))
    assert (np.diff(flips) == 4).all()
    say(firmware, 1.8, "clearHapticFeedback")
    firmware.advance(2.0)
    assert not firmware.motion.driven.any()


# --- raw motors ------------------------------------------------------------------------------------------


def test_raw_pwm_lasts_until_the_next_frame():
    firmware = robot()
    firmware.advance(0.110)
    say(firmware, 0.112, "setAllMotorOutputs", m1=2056, m2=-1556, m3=-1556)  # (50, 0, 0) mm/s
    firmware.advance(0.115)
    assert firmware.motion.motors()[:, 0].tolist() == [2056, -1556, -1556]
    firmware.advance(0.121)
    assert firmware.motion.motors()[:, 0].tolist() == [0, 0, 0]
    assert firmware.truth().xy[0] == pytest.approx([0.2 + 0.05 * 0.009, 0.2], abs=2e-6)
    say(firmware, 0.122, "setMotorOutput", motor=2, output=-4095)
    firmware.advance(0.123)
    assert firmware.motion.motors()[:, 0].tolist() == [0, -4095, 0]


def test_raw_pwm_of_a_lifted_robot_is_nothing():
    firmware = robot()
    firmware.lift(0.1, 0)
    firmware.advance(0.5)
    say(firmware, 0.5, "setMotorOutput", motor=1, output=4095)
    firmware.advance(0.505)
    assert firmware.motion.motors()[:, 0].tolist() == [0, 0, 0]


# --- curves ----------------------------------------------------------------------------------------------


def curve(firmware, t, start, *segments):
    say(firmware, t, "polyBezierInit", x0_mm=start[0], y0_mm=start[1])
    for segment in segments:
        keys = ("x1_mm", "y1_mm", "x2_mm", "y2_mm", "x3_mm", "y3_mm")
        say(firmware, t, "polyBezierAppend", **dict(zip(keys, segment, strict=True)))


K = 0.5522847  # a quarter of a circle
QUARTERS = (
    (400, 300 + 100 * K, 300 + 100 * K, 400, 300, 400),
    (300 - 100 * K, 400, 200, 300 + 100 * K, 200, 300),
)


def followed(firmware, until, since=0.0):
    way, heard = [], []
    for k in range(round(since / 0.011), round(until / 0.011)):
        heard += [(k * 0.011, EVENTS.decode(packet).name) for _, packet in firmware.advance(k * 0.011)]
        way.append((*1000 * firmware.truth().xy[0], math.degrees(firmware.truth().heading[0])))
    return np.array(way), [t for t, name in heard if name == "trackingGoalReached"]


def test_half_a_circle_is_followed_at_its_speed_and_its_end_is_told():
    firmware = robot(xy=(0.35, 0.28))
    curve(firmware, 0.0, (400, 300), *QUARTERS)
    say(firmware, 0.0, "setGoalPolyBezier", v_mm_s=80, w_rad_s=0)
    way, reached = followed(firmware, 8.0)
    assert len(reached) == 1
    on = way[np.hypot(way[:, 0] - 400, way[:, 1] - 300).argmin() + 10 :]
    off = np.hypot(on[:, 0] - 300, on[:, 1] - 300) - 100
    assert np.abs(off).max() < 3.0  # the carrot is 12 mm ahead and cuts the bend
    assert way[-1, :2] == pytest.approx([200, 300], abs=2.6)
    assert (way[:, 2] % 360 < 1e-6).all()
    moving = np.hypot(*np.diff(on[20:300, :2], axis=0).T) / 0.011
    assert np.median(moving) == pytest.approx(80, abs=1)
    assert reached[0] == pytest.approx(math.pi * 100 / 80, abs=2.5)  # and the way to its beginning


def test_a_curve_turns_as_it_is_told_or_keeps_to_the_way():
    firmware = robot(xy=(0.4, 0.3))
    curve(firmware, 0.0, (400, 300), *QUARTERS)
    say(firmware, 0.0, "setGoalPolyBezier", v_mm_s=80, w_rad_s=0.5)
    way, _ = followed(firmware, 2.0)
    assert way[-1, 2] == pytest.approx(math.degrees(0.5 * 2.0), abs=2)
    firmware = robot(xy=(0.4, 0.3))
    curve(firmware, 0.0, (400, 300), *QUARTERS)
    say(firmware, 0.0, "setGoalPolyBezierAligned", v_mm_s=80, theta_deg=90, w_max_rad_s=4)
    way, reached = followed(firmware, 6.0)
    middle = way[len(way) // 3]
    course = math.degrees(math.atan2(middle[0] - 300, -(middle[1] - 300)))  # along the circle, clockwise
    assert (middle[2] - 90 - course + 180) % 360 - 180 == pytest.approx(0, abs=20)
    assert len(reached) == 1


def test_a_curve_is_dropped_for_another_goal_and_cleared():
    firmware = robot(xy=(0.4, 0.3))
    curve(firmware, 0.0, (400, 300), *QUARTERS)
    say(firmware, 0.0, "setGoalPolyBezier", v_mm_s=80, w_rad_s=0)
    firmware.advance(1.0)
    assert firmware.motion.driven.any()
    say(firmware, 1.0, "clearTracking")
    firmware.advance(1.1)
    assert not firmware.motion.driven.any()


def test_at_most_a_hundred_segments_and_no_number_that_is_none():
    firmware = robot()
    curve(firmware, 0.0, (10, 10), *[(20 + k,) * 6 for k in range(103)])
    firmware.feed(0.0, 0, b"\x01.\x7f\xc0\x00\x00\x7f\xc0\x00\x00")
    firmware.advance(0.1)
    chain = firmware.units[0].chain
    assert (len(chain.segments), chain.end, chain.start) == (100, (119, 119), (10, 10))


# --- pictures, quirks ------------------------------------------------------------------------------------


def test_a_picture_is_120_lines_of_the_dots_below():
    firmware = robot()
    say(firmware, 0.5, "requestFrame")
    lines = [(ms, args) for ms, name, args in told(firmware, 1.5) if name == "frameLine"]
    assert [args["line"] for _, args in lines] == list(range(120))
    assert lines[-1][0] - lines[0][0] == pytest.approx(119 * 192 * 10 / 921.6, abs=12)
    picture = np.array([list(args["pixels"]) for _, args in lines])
    assert picture.shape == (120, 188)
    dark = (picture < 100).mean()
    assert dark == pytest.approx(math.pi * 0.1**2 / 0.508**2, rel=0.1)  # a dot of 0.1 mm for each 0.508 mm square


@pytest.mark.parametrize(
    "packet",
    ["014501ff00000c", "014503ff00007f", "014502ff000000", "01450aff000000", "014d047fff", "014d00ffff", "014c09"],
)
def test_numbers_beyond_the_robots_do_no_harm(packet):
    firmware = robot()
    firmware.feed(0.0, 0, bytes.fromhex(packet))
    say(firmware, 0.1, "ping")
    assert "acknowledged" in [name for _, name, _ in told(firmware, 2.0)]
    firmware.lights(2.0)


# --- faults ----------------------------------------------------------------------------------------------


def test_what_is_told_comes_in_bursts():
    firmware = robot(burst_s=0.25)
    say(firmware, 0.0, "setPoseBcastPeriod", period_ms=0)
    say(firmware, 0.0, "setTimestampingEnabled", enabled=1)
    arrivals = [k for k in range(1001) for _ in firmware.advance(k / 1000)]
    assert set(arrivals) == {0, 250, 500, 750, 1000}
    assert arrivals.count(500) == pytest.approx(23, abs=1)


def test_a_radio_that_sniffs_is_late_after_a_second_of_silence():
    late = []
    for k in range(20):
        firmware = Firmware([(0.2, 0.2)], [0.0], Sheet(1, 1), np.random.default_rng(k), IDEAL, Faults(sniff_s=0.2))
        firmware.lift(0.0, 0)
        for at in (2.0, 2.5):
            say(firmware, at, "ping")
        acks = [ms for ms, name, _ in told(firmware, 4.0) if name == "acknowledged"]
        late.append((acks[0] - 2000, acks[1] - 2500))
    first, second = np.array(late).T
    assert first.max() > 150
    assert first.max() <= 401  # both ways
    assert second.max() <= 1


def test_the_first_commands_after_a_start_are_lost():
    firmware = robot(deaf=2, boot_s=0.5)
    for k in range(3):
        say(firmware, 0.1 * k, "ping")
    say(firmware, 0.5, "reset")
    for k in range(4):
        say(firmware, 1.2 + 0.1 * k, "ping")
    acks = [ms for ms, name, _ in told(firmware, 2.0) if name == "acknowledged"]
    assert acks == [200, 1400, 1500]


def test_an_old_robot_says_nothing():
    firmware = robot(generation="old")
    for name in ("ping", "queryBatteryState", "reset"):
        say(firmware, 0.1, name)
    assert [packet for k in range(300) for packet in firmware.advance(k / 100)] == []


def test_a_load_slows_and_stalls():
    ways = {}
    for grams in (0.0, 100.0):
        for speed in (50, 120):
            firmware = robot(Plant(gain=(1.0, 1.0), dead_zone=0.015, position_noise=0, heading_noise=0))
            firmware.load(0.0, 0, grams)
            say(firmware, 0.0, "setGoalVelocity", vx_mm_s=speed, vy_mm_s=0, w_rad_s=0)
            firmware.advance(2.0)
            ways[grams, speed] = firmware.truth().xy[0, 0] - 0.2
    assert ways[100.0, 50] == 0.0
    assert ways[0.0, 50] > 0.09
    assert ways[100.0, 120] == pytest.approx(0.75 * ways[0.0, 120], rel=0.01)
    firmware.load(2.0, 0, 0.0)
    firmware.advance(2.1)
    assert firmware.bodies.gain[0] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "trouble"),
    [
        ("link-loss@5", Trouble("link-loss", 5.0, 3.0)),
        ("kidnap:r1@0.5+2", Trouble("kidnap", 0.5, 2.0, "r1")),
        ("silence:r2@5+1.5/20", Trouble("silence", 5.0, 1.5, "r2", 20.0)),
    ],
)
def test_troubles_in_words(text, trouble):
    assert Trouble.parse(text) == trouble


@pytest.mark.parametrize("text", ["earthquake@5", "kidnap", "kidnap@x", "load@1+5/2", "kidnap@1.2.3"])
def test_troubles_that_are_none(text):
    with pytest.raises(ConfigError):
        Trouble.parse(text)


def test_troubles_come_again():
    trouble = Trouble("silence", 1.0, 0.5, every=2.0)
    turns = [(k, *trouble.turns((k - 1) / 100, k / 100)) for k in range(1, 601)]
    assert [k for k, begins, _ in turns if begins] == [100, 300, 500]
    assert [k for k, _, ends in turns if ends] == [150, 350, 550]


def test_truth_is_told_in_the_sheet():
    firmware = Firmware([(1.2, 0.7)], [-0.5], Sheet(1, 1, (1.0, 0.5)), np.random.default_rng(0), IDEAL)
    firmware.lift(0.0, 0)
    firmware.advance(0.1)
    told = firmware.truth()
    assert told.xy == pytest.approx(np.array([[0.2, 0.2]]))
    assert told.heading == pytest.approx([2 * math.pi - 0.5])
    assert told.lifted.tolist() == [True]
