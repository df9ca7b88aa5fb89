import math

import pytest

from armspan.devices.toio.robot import Placement, Robot
from armspan.devices.toio.wire import Packet, decode, encode
from armspan.errors import DeviceError
from armspan.records import Drive, GoTo, Haptic, Light, Link, RobotState, Stop, Touch

STANDSTILL = ("motor", bytes.fromhex("01010100020100"))


def place(x=250, y=250, angle=0):
    args = {"x": x, "y": y, "angle_deg": angle, "sensor_x": x, "sensor_y": y, "sensor_angle_deg": angle}
    return Packet("idPosition", "id", args)


def robot(t=0.0):
    """A cube that is there, at (279.3, 279.3) mm of the ring mat, and that has been told to stand still."""
    cube = Robot("ash", Placement())
    assert cube.linked(t, True) == [Link(t, "ash", True)]
    for k in range(3):
        assert cube.motion(t + 0.03 * k) == [STANDSTILL]
    assert cube.motion(t + 0.06) == []
    cube.hear(place(), t + 0.07)
    return cube


def go(t, x=0.32, y=0.2793, speed=0.15, lease=0.3, **more):
    return GoTo(t, "ash", (x, y), speed, t + lease, **more)


def pulse(write):
    characteristic, data = write
    packet = decode(characteristic, data)
    return packet.args if packet.name == "motorTimed" else None


def test_a_place_is_told_on_the_sheet():
    cube = Robot("ash", Placement(corner=(545.0, 45.0), origin=(0.01, 0.02)))
    up, state = cube.hear(place(950, 451, 90), 1.5)
    assert up == Link(1.5, "ash", True)
    assert isinstance(state, RobotState)
    # 405 and 406 position IDs of 560/411 mm
    assert state.xy == pytest.approx((0.55182 - 0.01, 0.55319 - 0.02), abs=1e-4)
    assert (state.t, state.robot, state.held, state.battery) == (1.5, "ash", False, None)
    assert state.heading == pytest.approx(math.pi / 2)


def test_a_lifted_cube_is_held_where_it_was_and_forgets_its_goal():
    cube = robot()
    cube.take(go(0.1), 0.1)
    assert pulse(cube.motion(0.1)[0])
    (held,) = cube.hear(Packet("idMissed", "id", {}), 0.15)
    assert (held.held, held.xy) == (True, pytest.approx((0.2793, 0.2793), abs=1e-4))
    assert cube.hear(Packet("idStandard", "id", {"value": 1, "angle_deg": 0}), 0.16) == []  # told already
    assert cube.motion(0.16) == [STANDSTILL]
    (back,) = cube.hear(place(60, 60), 0.3)
    assert not back.held
    assert [write for k in range(20) for write in cube.motion(0.3 + 0.02 * k) if pulse(write)] == []


def test_the_battery_is_a_share_in_every_state():
    cube = robot()
    cube.hear(Packet("battery", "battery", {"percent": 70}), 0.1)
    assert cube.hear(place(), 0.2)[0].battery == 0.7


def test_the_button_is_key_zero_and_long_after_a_second():
    cube = robot()
    assert cube.hear(Packet("button", "button", {"pressed": True}), 1.0) == [Touch(1.0, "ash", 0, "began")]
    assert cube.watch(1.9) == []
    assert cube.wake() == pytest.approx(2.0)
    assert cube.watch(2.0) == [Touch(2.0, "ash", 0, "long")]
    assert cube.watch(2.1) == []
    assert cube.hear(Packet("button", "button", {"pressed": False}), 2.2) == [Touch(2.2, "ash", 0, "released")]


def test_a_goal_is_driven_to_by_pulses_twenty_times_a_second_until_its_lease_ends():
    cube = robot()
    cube.take(go(0.1), 0.1)
    times, t = [], 0.1
    while t < 0.6:
        for write in cube.motion(t):
            args = pulse(write)
            if args is None:
                break
            assert args["left"] > 8
            assert 10 <= args["duration_ms"] <= min(200, 1000 * (0.4 - t) + 1)
            times.append(t)
        cube.hear(place(), t)
        t = round(t + 0.005, 6)
    assert times == pytest.approx([0.1, 0.15, 0.2, 0.25, 0.3, 0.35], abs=0.026)
    assert len(times) == 6
    assert cube.motion(0.6) == []  # stopped three times, meanwhile


def test_the_end_of_a_lease_is_a_stop_three_times():
    cube = robot()
    cube.take(go(0.1, lease=0.05), 0.1)
    cube.motion(0.1)
    assert cube.wake() == pytest.approx(0.15)
    assert [cube.motion(t) for t in (0.151, 0.16, 0.182, 0.212, 0.3)] == [
        [STANDSTILL],
        [],
        [STANDSTILL],
        [STANDSTILL],
        [],
    ]


def test_a_stop_comes_first_and_voids_the_goal():
    cube = robot()
    cube.take(go(0.1), 0.1)
    cube.take(Stop(0.1), 0.1)
    assert cube.motion(0.1) == [STANDSTILL]
    cube.hear(place(), 0.5)
    cube.take(Stop(0.5, "ash"), 0.5)
    cube.take(go(0.5), 0.5)
    assert cube.motion(0.5) == [STANDSTILL]
    assert pulse(cube.motion(0.521)[0])
    assert [pulse(write) is None for k in range(9) for write in cube.motion(0.53 + 0.01 * k)] == [False]


def test_a_new_goal_does_not_wait_for_the_next_refresh():
    cube = robot()
    cube.take(go(0.1), 0.1)
    cube.motion(0.1)
    cube.take(go(0.125, y=0.30), 0.125)
    assert cube.wake() == pytest.approx(0.125)
    assert cube.motion(0.125)


def test_a_cube_that_is_not_seen_is_not_driven():
    cube = robot()
    cube.take(go(0.4), 0.4)
    assert cube.motion(0.4) == [STANDSTILL]  # its place is of 0.07


def test_a_cube_that_jumps_was_carried_and_stops():
    cube = robot()
    cube.take(go(0.1), 0.1)
    cube.motion(0.1)
    cube.hear(place(400, 60), 0.12)
    assert cube.motion(0.12) == [STANDSTILL]
    assert [write for k in range(9) for write in cube.motion(0.13 + 0.02 * k) if pulse(write)] == []


def test_a_velocity_and_what_is_not_finite_are_refused():
    cube = robot()
    with pytest.raises(DeviceError, match=r"'ash'.*cannot drive sideways.*GoTo"):
        cube.take(Drive(0.0, "ash", (0.1, 0.0), 0.0, 0.3), 0.0)
    with pytest.raises(DeviceError, match="not finite"):
        cube.take(go(0.0, x=math.nan), 0.0)
    with pytest.raises(DeviceError, match="0 to 255"):
        cube.take(Light(0.0, "ash", (0, 0, 256)), 0.0)


def test_one_light_shows_the_brightest_of_six():
    cube = robot()
    cube.take(Light(0.0, "ash", (9, 0, 0)), 0.0)
    assert cube.signs() == [encode("light", duration_ms=0, red=9, green=0, blue=0)]
    cube.take(Light(0.0, "ash", (0, 99, 0), 2), 0.0)
    cube.take(Light(0.0, "ash", (0, 0, 0), 3), 0.0)
    assert cube.signs() == [encode("light", duration_ms=0, red=0, green=99, blue=0)]
    cube.take(Light(0.0, "ash", (0, 0, 0)), 0.0)
    assert cube.signs() == [encode("light", duration_ms=0, red=0, green=0, blue=0)]
    assert cube.signs() == []


def test_a_haptic_is_a_hum_as_long():
    cube = robot()
    cube.take(Haptic(0.0, "ash", 0.5, 0.2), 0.0)
    ((characteristic, data),) = cube.signs()
    assert (characteristic, decode("sound", data).args["notes"][0]["duration_ms"]) == ("sound", 200)
    cube.take(Haptic(0.0, "ash", 0.0, 0.2), 0.0)
    assert cube.signs() == []


def test_who_is_gone_takes_nothing_and_who_comes_back_stands_still():
    cube = robot()
    cube.take(go(0.1), 0.1)
    assert cube.linked(0.2, False) == [Link(0.2, "ash", False)]
    assert cube.linked(0.3, False) == []
    cube.take(go(0.3), 0.3)
    cube.take(Light(0.3, "ash", (9, 9, 9)), 0.3)
    assert (cube.motion(0.3), cube.signs()) == ([], [])
    assert cube.linked(1.0, True) == [Link(1.0, "ash", True)]
    assert cube.motion(1.0) == [STANDSTILL]


def test_a_silent_cube_is_lost_after_three_seconds():
    cube = robot()
    assert cube.watch(3.0) == []
    assert cube.watch(3.08) == [Link(3.08, "ash", False)]


def test_times_never_fall():
    cube = robot()
    cube.hear(place(), 2.0)
    assert cube.hear(place(), 1.9)[0].t == 2.0


@pytest.mark.parametrize(("version", "old"), [("2.1.0", True), ("2.2.0", False), ("2.4.0", False), ("x.y.z", True)])
def test_old_system_software_is_told(version, old):
    cube = robot()
    packet = Packet("version", "configuration", {"version": version})
    if not old:
        assert cube.hear(packet, 0.1) == []
        return
    with pytest.raises(DeviceError, match=f"'ash'.*protocol {version}; 2.2 or later.*update"):
        cube.hear(packet, 0.1)
