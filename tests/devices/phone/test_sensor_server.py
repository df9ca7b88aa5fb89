import json
import math
from urllib.parse import parse_qs, urlsplit

import pytest

from armspan.devices.phone.band import Band
from armspan.devices.phone.sensor_server import FORCE, GAME, MAGNETIC, RATE, SENSORS, SensorServer, query
from armspan.errors import DeviceError
from armspan.records import ImuSample, Link
from devices.promises import check_events, check_rest

G = 9.80665
BOOT = 3_925_657_519_043_709
TILTED = [math.sin(math.radians(30)), 0.0, 0.0, math.cos(math.radians(30))]
UP = [0.0, G * math.sin(math.radians(60)), G * math.cos(math.radians(60))]


def text(kind, k, values, late_ns=0):
    taken = BOOT + k * 20_000_000 + late_ns
    return json.dumps({"accuracy": 3, "timestamp": taken, "type": kind, "values": values}).encode()


def heard(device, kinds, count=60, start=0):
    events = []
    for k in range(start, start + count):
        for late, (kind, values) in enumerate(kinds.items()):
            events += device.feed(text(kind, k, values, late * 3_000_000), k * 0.02 + 0.01)
    return events


def samples_of(events):
    return [event for event in events if isinstance(event, ImuSample)]


def test_three_sensors_become_one_band():
    device = SensorServer(Band("wrist"))
    events = heard(device, {FORCE: UP, RATE: [0.01, 0.02, 0.03], GAME: TILTED})
    check_events(events)
    told = samples_of(events)
    check_rest(told)
    assert len(told) >= 60 - 17
    assert told[-1].acc == pytest.approx(UP)
    assert told[-1].gyr == pytest.approx((0.01, 0.02, 0.03))
    assert told[-1].quat == pytest.approx((TILTED[3], *TILTED[:3]))
    assert told[-1].t - told[0].t == pytest.approx(0.02 * (len(told) - 1), abs=1e-6)
    assert [event for event in events if isinstance(event, Link)] == [Link(told[0].t, "wrist", up=True)]


def test_the_magnetic_one_has_a_fifth_number_and_the_oldest_no_fourth():
    for values in ([*TILTED, 0.05], TILTED[:3]):
        device = SensorServer(Band("wrist"))
        told = samples_of(heard(device, {FORCE: UP, RATE: [0, 0, 0], MAGNETIC: values}))
        assert told[-1].quat == pytest.approx((TILTED[3], *TILTED[:3]))


def test_a_phone_without_attitude_sends_what_it_feels():
    told = samples_of(heard(SensorServer(Band("wrist")), {FORCE: UP, RATE: [0, 0, 0]}))
    assert told[-1].quat is None
    assert told[-1].acc == pytest.approx(UP)


def test_a_new_connection_is_a_new_heading():
    device = SensorServer(Band("wrist"))
    kinds = {FORCE: UP, RATE: [0, 0, 0], GAME: TILTED}
    events = [*heard(device, kinds), *device.band.lose(1.3)]
    device.begin()
    events += heard(device, kinds, start=100)
    links = [(event.up, event.fresh) for event in events if isinstance(event, Link)]
    assert links == [(True, False), (False, False), (True, True)]
    check_events(events)


def test_a_phone_that_began_anew_is_followed():
    device = SensorServer(Band("wrist"))
    kinds = {FORCE: UP, RATE: [0, 0, 0]}
    events = heard(device, kinds)
    for k in range(60):
        for kind, values in kinds.items():
            data = json.dumps({"timestamp": k * 20_000_000, "type": kind, "values": values}).encode()
            events += device.feed(data, 100 + k * 0.02)
    check_events(events)
    assert samples_of(events)[-1].t == pytest.approx(101.18, abs=0.05)


def test_what_is_asked_for_can_be_read_by_the_app():
    url = query("ws://192.168.1.23:8080/", SENSORS[0])
    parts = urlsplit(url)
    assert (parts.scheme, parts.netloc, parts.path) == ("ws", "192.168.1.23:8080", "/sensors/connect")
    assert json.loads(parse_qs(parts.query)["types"][0]) == [
        "android.sensor.accelerometer",
        "android.sensor.gyroscope",
        "android.sensor.game_rotation_vector",
    ]


def test_other_sensors_tell_nothing():
    assert SensorServer(Band("wrist")).feed(text("android.sensor.light", 0, [12.0]), 1.0) == []


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"{}",
        b"\xff",
        b"[" * 10_000,
        text(RATE, 0, [0.0, 0.0]),
        text(RATE, 0, [0.0, 0.0, math.nan]),
        text(FORCE, 0, [0.0, 0.0, 1e30]),
        text(GAME, 0, [0.0]),
        text(GAME, 0, [1.0, 1.0, 1.0, 1.0]),
        json.dumps({"timestamp": -1, "type": RATE, "values": [0, 0, 0]}).encode(),
        json.dumps({"timestamp": 2**80, "type": RATE, "values": [0, 0, 0]}).encode(),
        json.dumps({"timestamp": 1, "type": RATE, "values": None}).encode(),
    ],
)
def test_what_cannot_be_read_is_a_device_error(data):
    device = SensorServer(Band("wrist"))
    with pytest.raises(DeviceError):
        device.feed(data, 1.0)
    assert device.band.counters.malformed == 1
    assert len(samples_of(heard(device, {FORCE: UP, RATE: [0, 0, 0]}))) > 40
