import json
import math

import numpy as np
import pytest

from armspan.devices.phone.band import Band
from armspan.devices.phone.sensor_logger import PATIENCE, SensorLogger
from armspan.devices.phone.voices import LoggerVoice, lying_still
from armspan.errors import DeviceError
from armspan.records import ImuSample, Link
from devices.promises import check_events, check_rest

G = 9.80665
UTC = 1_790_000_000_000_000_000
TILTED = (math.cos(math.radians(30)), math.sin(math.radians(30)), 0.0, 0.0)
"""Turned by 60 degrees about x: the top edge up, so that the force has y = g sin 60 and z = g cos 60."""
FORCE = (0.0, G * math.sin(math.radians(60)), G * math.cos(math.radians(60)))


def logger(watch=False):
    return SensorLogger(Band("wrist"), watch=watch)


def reading(name, k, **values):
    return {"name": name, "time": UTC + k * 10_000_000, "values": values}


def xyz(name, k, three):
    return reading(name, k, **dict(zip("xyz", three, strict=True)))


def push(number, payload, session="s", device="d"):
    return json.dumps({"messageId": number, "sessionId": session, "deviceId": device, "payload": payload}).encode()


def phone(k, motion, gravity, gyr=(0.1, 0.2, 0.3), q=TILTED, total=None):
    w, x, y, z = q
    found = [xyz("accelerometer", k, motion), xyz("gravity", k, gravity), xyz("gyroscope", k, gyr)]
    if total is not None:
        found.append(xyz("totalacceleration", k, total))
    return [*found, reading("orientation", k, qx=x, qy=y, qz=z, qw=w, roll=0, pitch=0, yaw=0)]


def samples_of(events):
    return [event for event in events if isinstance(event, ImuSample)]


def minus(three):
    return tuple(-value for value in three)


@pytest.mark.parametrize(
    ("told", "expected"),
    [  # the phone is accelerated by 2 m/s² along its x: UNITS.md, COORDINATES.md
        (((2.0, 0.0, 0.0), FORCE), (2.0, FORCE[1], FORCE[2])),  # Android, or standardised
        (((-2.0, 0.0, 0.0), minus(FORCE)), (2.0, FORCE[1], FORCE[2])),  # iOS: both the other way round
    ],
)
def test_the_force_points_up_on_either_platform(told, expected):
    events = logger().feed(push(0, [item for k in range(60) for item in phone(k, *told)]), 5.0)
    last = samples_of(events)[-1]
    assert last.acc == pytest.approx(expected)
    assert last.gyr == pytest.approx((0.1, 0.2, 0.3))
    assert last.quat == pytest.approx(TILTED)
    assert events[0] == Link(events[1].t, "wrist", up=True)


def test_the_total_acceleration_of_android_is_taken_as_it_is():
    readings = [item for k in range(60) for item in phone(k, (0.0, 0.0, 0.0), FORCE, total=(0.5, *FORCE[1:]))]
    assert samples_of(logger().feed(push(0, readings), 5.0))[-1].acc == pytest.approx((0.5, *FORCE[1:]))


def wrist(k, motion, gravity, q=TILTED, gyr=(0.1, 0.2, 0.3)):
    values = {}
    for name, three in (("acceleration", motion), ("gravity", gravity), ("rotationRate", gyr)):
        values |= {f"{name}{axis}": value for axis, value in zip("XYZ", three, strict=True)}
    values |= {f"quaternion{axis}": value for axis, value in zip("WXYZ", q, strict=True)}
    return reading("wrist motion", k, **values)


@pytest.mark.parametrize(
    ("motion", "gravity"),
    [
        ((-2.0 / G, 0.0, 0.0), tuple(-value / G for value in FORCE)),  # Apple Watch: in g, the other way round
        ((2.0, 0.0, 0.0), FORCE),  # standardised, and Wear OS
        ((-2.0, 0.0, 0.0), minus(FORCE)),  # m/s², yet the other way round: the attitude tells
    ],
)
def test_the_watch_speaks_in_any_unit_and_sign(motion, gravity):
    told = samples_of(logger(watch=True).feed(push(0, [wrist(k, motion, gravity) for k in range(60)]), 5.0))
    assert told[-1].acc == pytest.approx((2.0, *FORCE[1:]))
    assert told[-1].quat == pytest.approx(TILTED)


def test_an_apple_watch_without_attitude_is_known_by_its_unit():
    readings = [wrist(k, (0.0, 0.0, 0.0), tuple(-value / G for value in FORCE)) for k in range(60)]
    for item in readings:
        item["values"] = {key: value for key, value in item["values"].items() if not key.startswith("quaternion")}
    last = samples_of(logger(watch=True).feed(push(0, readings), 5.0))[-1]
    assert last.acc == pytest.approx(FORCE)
    assert last.quat is None


def test_phone_and_watch_in_one_push_are_told_apart():
    payload = [item for k in range(60) for item in (*phone(k, (0, 0, 0), FORCE), wrist(k, (1.0, 0, 0), FORCE))]
    data = push(0, payload)
    assert samples_of(logger().feed(data, 1.0))[-1].acc == pytest.approx(FORCE)
    assert samples_of(logger(watch=True).feed(data, 1.0))[-1].acc == pytest.approx((1.0, *FORCE[1:]))


def pushes(voice, seconds, rate=60.0):
    """The pushes of an emulated phone lying still, with the times [s] at which they leave."""
    samples, found = lying_still(rate, TILTED), []
    for k in range(int(seconds / 0.005)):
        for data in voice.tell(samples(k * 0.005), k * 0.005):
            found.append((k * 0.005, data))
    return found


def test_pushes_that_overtake_each_other_are_told_in_order():
    rng = np.random.default_rng(1)
    sent = pushes(LoggerVoice("ios", 0.1), 10.0)
    arrivals = sorted((t + float(rng.uniform(0, 0.25)), data) for t, data in sent)
    assert [data for _, data in arrivals] != [data for _, data in sent]
    device, events = logger(), []
    for arrived, data in arrivals:
        events += device.feed(data, arrived)
    check_events(events)
    told = samples_of(events)
    check_rest(told[-100:])
    counters = device.band.counters
    assert (counters.lost, counters.late, counters.gaps) == (0, 0, 0)
    assert len(told) >= 10.0 * 60 - 6 - 19
    steps = np.diff([sample.t for sample in told])
    assert np.median(steps) == pytest.approx(1 / 60, rel=0.05)


def test_a_push_that_never_comes_is_given_up_and_counted():
    sent = pushes(LoggerVoice("android", 0.1), 3.0)
    missing = [entry for k, entry in enumerate(sent) if k not in (10, 11, 20)]
    device, events = logger(), []
    for arrived, data in missing:
        events += device.watch(arrived) + device.feed(data, arrived)
    events += device.watch(3.0 + PATIENCE)
    check_events(events)
    counters = device.band.counters
    assert (counters.lost, counters.gaps, counters.late) == (3, 2, 0)
    assert counters.longest == pytest.approx(0.2, abs=0.03)
    assert len(samples_of(events)) == counters.samples


def test_a_new_recording_is_a_new_heading():
    device = logger()
    first, second = (LoggerVoice("android", 0.1, session=name) for name in ("one", "two"))
    events = [event for arrived, data in pushes(first, 2.0) for event in device.feed(data, arrived)]
    second.epoch_ns += 3_000_000_000
    events += [event for arrived, data in pushes(second, 2.0) for event in device.feed(data, arrived + 3.0)]
    assert [(event.up, event.fresh) for event in events if isinstance(event, Link)] == [(True, False), (True, True)]
    check_events(events)
    assert device.band.counters.lost == 0


def test_silence_is_told_and_mended():
    device, events = logger(), []
    for arrived, data in pushes(LoggerVoice("android", 0.2), 8.0):
        if not 3.0 <= arrived < 6.0:
            events += device.feed(data, arrived)
        events += device.watch(arrived)
    links = [(event.up, round(event.t, 1)) for event in events if isinstance(event, Link)]
    assert [up for up, _ in links] == [True, False, True]
    assert 3.8 <= links[1][1] <= 4.4
    check_events(events)


def test_a_seconds_batches_are_no_silence():
    device, events, rng = logger(), [], np.random.default_rng(3)
    for k in range(60):
        late = 0.5 if k in (29, 30, 31, 32, 33) else 0.0
        t = k * 0.1 + max(late - max(0, k - 29) * 0.1, float(rng.uniform(0.0, 0.09)))
        events += device.watch(t)
        if k % 10 == 9:  # a second of a hundred samples
            payload = [item for j in range(k * 10 - 90, k * 10 + 10) for item in phone(j, (0, 0, 0), FORCE)]
            events += device.feed(push(k // 10, payload), t)
    assert [event.up for event in events if isinstance(event, Link)] == [True]
    assert device.band.counters.wait == pytest.approx(0.99 + 0.5, abs=0.1)


def test_a_pushs_readings_may_stand_in_any_order():
    rng, found = np.random.default_rng(4), []
    for shuffled in (False, True):
        device, events = logger(), []
        for batch in range(3):
            payload = [item for k in range(batch * 100, batch * 100 + 100) for item in phone(k, (0, 0, 0), FORCE)]
            if shuffled:
                payload = [payload[k] for k in rng.permutation(len(payload))]
            events += device.feed(push(batch, payload), batch + 1.0)
        assert device.band.counters.steps == 0
        found.append(events)
    assert found[0] == found[1]
    assert len(samples_of(found[0])) == 300 - 31


def test_the_apps_own_test_and_other_sensors_tell_nothing():
    device = logger()
    assert device.feed(push(0, []), 1.0) == []
    others = [{"name": "location", "time": UTC, "values": {"latitude": "?"}}, {"name": "heart rate", "time": UTC}]
    assert device.feed(push(1, others), 1.0) == []
    assert device.feed(b"{}", 1.0) == []


GOOD = {"name": "gyroscope", "time": UTC, "values": {"x": 0, "y": 0, "z": 0}}


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"[]",
        b"hello",
        b"\xff\xfe",
        b'{"payload": 3}',
        b'{"payload": [3]}',
        b'{"payload": [{"name": "gyroscope"}]}',
        b'{"messageId": "x"}',
        b'{"messageId": 1e400}',
        b"[" * 100_000,
        json.dumps({"payload": [GOOD | {"values": {"x": 0, "y": 0}}]}).encode(),
        json.dumps({"payload": [GOOD | {"values": {"x": "0", "y": 0, "z": 0}}]}).encode(),
        json.dumps({"payload": [GOOD | {"values": {"x": math.nan, "y": 0, "z": 0}}]}).encode(),
        json.dumps({"payload": [GOOD | {"values": {"x": 1e300, "y": 0, "z": 0}}]}).encode(),
        json.dumps({"payload": [GOOD | {"values": {"x": 101, "y": 0, "z": 0}}]}).encode(),
        json.dumps({"payload": [GOOD | {"values": None}]}).encode(),
        json.dumps({"payload": [GOOD | {"time": -1}]}).encode(),
        json.dumps({"payload": [GOOD | {"time": 1e300}]}).encode(),
        json.dumps({"payload": [GOOD | {"time": "now"}]}).encode(),
        json.dumps({"payload": [GOOD, reading("orientation", 0, qw=0, qx=0, qy=0, qz=0)]}).encode(),
    ],
)
def test_what_cannot_be_read_is_a_device_error_and_leaves_nothing(data):
    device = logger()
    with pytest.raises(DeviceError):
        device.feed(data, 1.0)
    assert device.band.counters.malformed == 1
    told = device.feed(push(0, [item for k in range(60) for item in phone(k, (0, 0, 0), FORCE)]), 2.0)
    assert len(samples_of(told)) == 60 - 31
