import math

import numpy as np
import pytest

from armspan.devices.toio.cube import Cube
from armspan.devices.toio.wire import decode, encode

HERE = (250, 250, 0)


class Bench:
    """A cube whose camera reads what the test says, a hundredth of a second at a time."""

    def __init__(self, sight=HERE):
        self.cube, self.sight, self.t, self.heard = Cube(), sight, 0.0, []
        self.run(0.02)

    def tell(self, name, **args):
        characteristic, data = encode(name, **args)
        self.cube.write(self.t, characteristic, data)

    def write(self, characteristic, text):
        self.cube.write(self.t, characteristic, bytes.fromhex(text))

    def run(self, seconds, sight="same"):
        if sight != "same":
            self.sight = sight
        for _ in range(round(seconds / 0.01)):
            self.t = round(self.t + 0.01, 6)
            for characteristic, data in self.cube.frame(self.t, self.sight):
                self.heard.append((self.t, decode(characteristic, data)))

    def times(self, name, since=0.0):
        return [t for t, packet in self.heard if packet.name == name and t > since]

    def last(self, name):
        return [packet.args for _, packet in self.heard if packet.name == name][-1]


def test_an_untimed_command_goes_on_for_ever_linked_or_not():
    bench = Bench()
    bench.tell("motor", left=30, right=-30)
    bench.run(5.0)
    bench.cube.unlinked()
    bench.run(60.0)
    assert bench.cube.wheels == (30, -30)
    bench.tell("motor", left=0, right=0)
    assert bench.cube.wheels == (0, 0)


def test_a_timed_command_ends_by_itself():
    bench = Bench()
    bench.tell("motorTimed", left=50, right=40, duration_ms=200)
    bench.run(0.19)
    assert bench.cube.wheels == (50, 40)
    bench.run(0.02)
    assert bench.cube.wheels == (0, 0)
    bench.tell("motorTimed", left=50, right=40, duration_ms=0)  # no limit
    bench.run(10.0)
    assert bench.cube.wheels == (50, 40)


def test_a_later_command_takes_an_earlier_ones_place():
    bench = Bench()
    bench.tell("motorTimed", left=50, right=50, duration_ms=500)
    bench.run(0.1)
    bench.tell("motorTimed", left=20, right=20, duration_ms=1000)
    bench.run(0.9)
    assert bench.cube.wheels == (20, 20)


@pytest.mark.parametrize("text", ["", "0101016401021464", "01010164010114", "0909", "020101640202ff", "ff"])
def test_what_is_wrong_is_thrown_away_in_silence(text):
    bench = Bench()
    bench.tell("motor", left=9, right=9)
    before = len(bench.heard)
    bench.write("motor", text)
    bench.run(0.01)
    assert bench.cube.wheels == (9, 9)
    assert [p.name for _, p in bench.heard[before:] if p.characteristic != "id"] == []


def test_places_are_told_as_often_as_was_set():
    bench = Bench()
    start = bench.t
    bench.run(3.0)
    assert np.diff(bench.times("idPosition", start)) == pytest.approx(0.3, abs=0.011)  # calm: it stands still
    bench.tell("setIdNotification", interval_ms=20, condition=0)
    start = bench.t
    bench.run(1.0)
    assert np.diff(bench.times("idPosition", start)) == pytest.approx(0.02)
    assert bench.last("idNotificationSet") == {"result": 0}
    assert bench.last("idPosition") | {"sensor_x": 0, "sensor_y": 0} == {
        "x": 250,
        "y": 250,
        "angle_deg": 0,
        "sensor_x": 0,
        "sensor_y": 0,
        "sensor_angle_deg": 0,
    }
    bench.cube.unlinked()  # settings are forgotten
    start = bench.t
    bench.run(3.0)
    assert 8 <= len(bench.times("idPosition", start)) <= 12


def test_only_changes_are_told_where_that_was_asked():
    bench = Bench()
    bench.tell("setIdNotification", interval_ms=10, condition=1)
    bench.run(0.1)
    start = bench.t
    bench.run(1.0)
    bench.run(0.1, (251, 250, 1))
    assert bench.times("idPosition", start) == []
    bench.run(0.1, (252, 250, 1))
    assert len(bench.times("idPosition", start)) == 1


def test_the_sensor_lies_as_in_the_specifications_example():
    bench = Bench((709, 383, 306))
    told = bench.last("idPosition")
    assert (told["sensor_x"], told["sensor_y"]) == pytest.approx((700, 386), abs=1)


def test_a_lifted_cube_says_so_once_after_seventy_milliseconds():
    bench = Bench()
    start = bench.t
    bench.run(1.0, None)
    assert bench.times("idMissed", start) == pytest.approx([start + 0.07], abs=0.011)
    assert bench.times("idPosition", start) == []
    bench.run(0.1, HERE)
    bench.run(0.05, None)  # shorter than it takes
    bench.run(0.5, HERE)
    assert len(bench.times("idMissed", start)) == 1
    bench.tell("setIdMissed", sensitivity_ms=500)
    start = bench.t
    bench.run(1.0, None)
    assert bench.times("idMissed", start) == pytest.approx([start + 0.5], abs=0.011)


TARGET = {"id": 7, "timeout_s": 2, "movement": 0, "max_speed": 80, "change": 0, "angle_deg": 90, "angle_mode": 0}


def test_a_target_is_driven_to_and_its_end_is_told():
    bench = Bench()
    bench.tell("motorTarget", **TARGET, x=300, y=250)
    bench.run(0.1)
    assert min(bench.cube.wheels) > 60  # it lies ahead
    bench.run(0.1, (250, 250, 180))
    assert max(bench.cube.wheels) < -60  # behind: this movement may go backward
    bench.run(0.1, (290, 250, 0))  # within 15: now the angle
    assert bench.cube.wheels[0] > 0 > bench.cube.wheels[1]
    bench.run(0.1, (290, 250, 87))
    assert bench.cube.wheels == (0, 0)
    assert bench.last("motorReply") == {"id": 7, "result": 0, "result_name": "reached"}
    assert len(bench.times("motorReply")) == 1


@pytest.mark.parametrize(
    ("more", "then", "result"),
    [
        ({}, lambda bench: bench.run(2.1), 1),
        ({}, lambda bench: bench.run(0.1, None), 2),
        ({"x": 0xFFFF, "y": 0xFFFF, "angle_mode": 6}, lambda bench: bench.run(0.1), 3),
        ({}, lambda bench: bench.tell("motor", left=0, right=0), 5),
    ],
)
def test_how_a_target_may_end(more, then, result):
    bench = Bench()
    bench.tell("motorTarget", **(TARGET | {"x": 400, "y": 250} | more))
    bench.run(0.05)
    then(bench)
    bench.run(0.05)
    assert bench.last("motorReply")["result"] == result
    assert bench.cube.wheels == (0, 0)


def test_a_target_at_too_low_a_speed_is_not_supported():
    bench = Bench()
    bench.write("motor", "03070500090000bc0282015a00")
    bench.run(0.01)
    assert bench.last("motorReply") == {"id": 7, "result": 6, "result_name": "not supported"}


def test_several_targets_are_driven_to_in_turn_and_one_more_may_wait():
    spots = [
        {"x": 300, "y": 250, "angle_deg": 0, "angle_mode": 5},
        {"x": 300, "y": 300, "angle_deg": 0, "angle_mode": 5},
    ]
    aim = {key: TARGET[key] for key in ("timeout_s", "movement", "max_speed", "change")}
    bench = Bench()
    bench.tell("motorTargets", id=1, add=False, targets=spots, **aim)
    bench.tell("motorTargets", id=2, add=True, targets=spots[:1], **aim)
    bench.tell("motorTargets", id=3, add=True, targets=spots[:1], **aim)
    bench.run(0.05)
    assert bench.last("motorTargetsReply") == {"id": 3, "result": 7, "result_name": "cannot be added"}
    bench.run(0.05, (300, 250, 0))
    bench.run(0.05, (300, 300, 0))
    assert bench.last("motorTargetsReply")["id"] == 1
    bench.run(0.05, (300, 250, 0))
    assert bench.last("motorTargetsReply") == {"id": 2, "result": 0, "result_name": "reached"}


def test_acceleration_is_gradual_only_from_one_such_command_to_the_next():
    straight = {"turn_deg_s": 0, "turn_back": False, "back": False, "turn_first": False, "duration_ms": 1000}
    bench = Bench()
    bench.tell("motorAcceleration", speed=20, acceleration=5, **straight)
    bench.run(0.01)
    assert bench.cube.wheels == (20, 20)
    bench.tell("motorAcceleration", speed=50, acceleration=5, **straight)
    bench.run(0.2)
    assert bench.cube.wheels == (30, 30)
    bench.run(0.85)
    assert bench.cube.wheels == (0, 0)
    bench.tell("motorAcceleration", speed=0, acceleration=0, **(straight | {"turn_deg_s": 180}))
    bench.run(0.01)
    # pi rad/s over half of 26.6 mm is 41.8 mm/s, at 2.81 mm/s a value
    assert bench.cube.wheels == (15, -15)
    assert math.pi * 13.3 / (4.3 * math.pi * 12.5 / 60) == pytest.approx(14.8, abs=0.1)


def test_light_button_battery_and_version():
    bench = Bench()
    bench.tell("light", duration_ms=160, red=255, green=1, blue=2)
    bench.run(0.1)
    assert bench.cube.light == (255, 1, 2)
    bench.run(0.1)
    assert bench.cube.light == (0, 0, 0)
    bench.tell("light", duration_ms=0, red=9, green=9, blue=9)
    bench.run(9.0)
    assert bench.cube.light == (9, 9, 9)
    bench.cube.press(True)
    bench.run(0.02)
    assert bench.last("button") == {"pressed": True}
    assert decode("button", bench.cube.read("button")).args == {"pressed": True}
    bench.cube.battery = 60
    bench.run(5.1)
    assert np.diff(bench.times("battery")) == pytest.approx(5.0, abs=0.02)
    assert bench.last("battery") == {"percent": 60}
    bench.tell("requestVersion")
    bench.run(0.01)
    assert bench.last("version") == {"version": "2.4.0"}


def test_wheel_speeds_are_told_where_that_was_asked():
    bench = Bench()
    bench.tell("setMotorSpeed", enabled=True)
    bench.tell("motor", left=50, right=-200)
    bench.run(0.2)
    assert bench.last("motorSpeeds") == {"left": 50, "right": 115}
    assert len(bench.times("motorSpeeds")) == 1
