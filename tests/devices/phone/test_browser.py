import json
import math

import numpy as np
import pytest

from armspan.devices.phone.band import Band
from armspan.devices.phone.browser import LARGEST, Browser
from armspan.errors import DeviceError
from armspan.records import ImuSample, Link, Press, Tap
from devices.promises import check_events, check_rest

G = 9.80665
UP = [0.0, G * math.sin(math.radians(60)), G * math.cos(math.radians(60))]


def says(**text):
    return json.dumps(text).encode()


def sample(n, *, a=UP, r=(0.0, 0.0, 0.0), t=None, **more):
    return says(n=n, t=1000.0 + n * 16.0 if t is None else t, a=list(a), r=list(r), **more)


def browser(apple=False, page="one"):
    device = Browser(Band("wrist"))
    assert device.feed(says(hello={"page": page, "apple": apple}), 0.0) == []
    return device


def heard(device, count=60, start=0, **more):
    return [event for n in range(start, start + count) for event in device.feed(sample(n, **more), 0.5 + n * 0.016)]


def samples_of(events):
    return [event for event in events if isinstance(event, ImuSample)]


def test_angles_and_quaternion_say_the_same():
    angles = samples_of(heard(browser(), o=[0.0, 60.0, 0.0]))[-1].quat
    turn = [math.sin(math.radians(30)), 0.0, 0.0, math.cos(math.radians(30))]
    assert samples_of(heard(browser(), q=turn))[-1].quat == pytest.approx(angles)
    assert angles == pytest.approx((turn[3], *turn[:3]))


def test_an_apple_phone_counts_the_other_way_round():
    for apple in (True, False):  # what the page believes is not needed where there is an attitude
        told = samples_of(heard(browser(apple), a=[-value for value in UP], o=[0.0, 60.0, 0.0]))
        assert told[-1].acc == pytest.approx(UP)
    alone = samples_of(heard(browser(apple=True), a=[-value for value in UP]))
    assert alone[-1].acc == pytest.approx(UP)
    assert alone[-1].quat is None


def test_rates_are_degrees_about_x_y_and_z():
    told = samples_of(heard(browser(), r=[90.0, -180.0, 45.0]))[-1]
    assert told.gyr == pytest.approx((math.pi / 2, -math.pi, math.pi / 4))


def test_an_attitude_that_is_a_moment_old_is_turned_on():
    device = browser()
    # turning about z by 90 deg/s: after 16 ms it stands 1.44 degrees further than it was read
    events = device.feed(sample(0, a=[0, 0, G], r=[0, 0, 90.0], o=[30.0, 0.0, 0.0], u=984.0), 0.5)
    half = math.radians(30.0 + 1.44) / 2
    assert samples_of(events)[0].quat == pytest.approx((math.cos(half), 0, 0, math.sin(half)))


def test_an_attitude_that_is_too_old_is_none():
    for read, known in ((1000.0 - 90.0, True), (1000.0 - 150.0, False), (1000.0 + 150.0, False)):
        [*_, told] = browser().feed(sample(0, o=[0.0, 60.0, 0.0], u=read), 0.5)
        assert (told.quat is not None) is known


def test_times_are_the_pages_and_steady_whenever_they_arrive():
    rng, device = np.random.default_rng(2), browser()
    events = []
    for n in range(600):
        events += device.feed(sample(n, o=[0, 60, 0]), 7.0 + n * 0.016 + float(rng.exponential(0.01)))
    check_events(events)
    told = samples_of(events)
    check_rest(told)
    later = np.array([event.t for event in told[100:]])
    assert np.diff(later) == pytest.approx(0.016, abs=0.0005)
    assert later[-1] == pytest.approx(7.0 + 599 * 0.016, abs=0.002)


def test_losses_are_counted_by_number_and_gaps_by_time():
    device = browser()
    heard(device)
    heard(device, start=70)
    heard(device, count=5, start=131)
    counters = device.band.counters
    assert (counters.lost, counters.gaps) == (11, 1)  # one sample alone is lost, but no gap
    assert counters.longest == pytest.approx(11 * 0.016, abs=1e-6)


def test_a_moment_without_attitude_is_bridged():
    device = browser()
    heard(device, o=[0, 60, 0])
    told = samples_of(heard(device, count=10, start=60))
    assert all(event.quat is not None for event in told)
    assert told[-1].quat == pytest.approx((math.cos(math.radians(30)), math.sin(math.radians(30)), 0, 0))


def test_stop_and_taps_come_with_their_band():
    device = browser()
    assert device.feed(b'{"stop":1}', 3.0) == [Press(3.0, "stop", "wrist")]
    assert device.feed(b'{"tap":2}', 3.5) == [Tap(3.5, "wrist", 2)]


def test_another_page_is_another_heading_and_the_same_page_is_not():
    device = browser()
    events = heard(device, o=[0, 60, 0])
    device.feed(says(hello={"page": "one"}), 2.0)
    events += heard(device, start=60, o=[0, 60, 0])
    device.feed(says(hello={"page": "two"}), 3.0)
    events += [e for n in range(9) for e in device.feed(sample(n, t=5.0 + n * 16, o=[0, 60, 0]), 4.0 + n * 0.016)]
    assert [(event.up, event.fresh) for event in events if isinstance(event, Link)] == [(True, False), (True, True)]
    check_events(events)
    assert device.band.counters.lost == 0


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"null",
        b"{}",
        b"\xc3\x28",
        b"[" * 2000,
        b'{"n":0}',
        b'{"surprise":1}',
        b'{"hello":1}',
        b'{"hello":{}}',
        b'{"tap":0}',
        b'{"tap":10}',
        b'{"tap":-1}',
        b'{"tap":1.5}',
        sample(-1),
        sample(2**70),
        sample(0, t=-5),
        sample(0, t=math.nan),
        sample(0, a=[0, 0]),
        sample(0, a=[0, 0, math.nan]),
        sample(0, a=[0, 0, 1e308]),
        sample(0, a=[None, None, None]),
        sample(0, r=[0, 0, 6000.0]),
        sample(0, o=[0, 0, 1e9]),
        sample(0, q=[0, 0, 0, 0]),
        sample(0, q=[1, 1, 1, 1]),
        sample(0, o=[0.0] * (LARGEST // 4)),
    ],
)
def test_what_cannot_be_read_is_a_device_error(data):
    device = browser()
    with pytest.raises(DeviceError):
        device.feed(data, 1.0)
    assert device.band.counters.malformed == 1
    assert len(samples_of(heard(device))) == 60
