import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.clock import Bursts, DeviceClock, StreamClock

EXACT = settings(derandomize=True, database=None, deadline=None, max_examples=100)
TICK = 1 / 1024


def counted(measured, ppm=0.0, started=-3.7, bits=None, tick=TICK):
    """The ticks of a device at the session times ``measured``; its clock is ``ppm`` fast and began before."""
    ticks = [math.floor((t - started) * (1 + ppm * 1e-6) / tick) for t in measured]
    return ticks if bits is None else [count % (1 << bits) for count in ticks]


def mapped(clock, ticks, arrived):
    return np.array([clock.seconds(count, t) for count, t in zip(ticks, arrived, strict=True)])


def bound(measured, delays, drift, ppm, window):
    """How late a time may be: as the least delayed of the last ``window`` packets, and the drift since.

    With delays d >= 0 and an offset O(s) that drifts at most by ppm, the lower envelope that may rise at
    ``drift`` is at most d_i + (drift + ppm) (s_k - s_i) + drift d_k above O(s_k) for every packet i before k.
    """
    late = np.empty(len(measured))
    for k in range(len(measured)):
        ago = measured[k] - measured[max(0, k - window) : k + 1]
        least = np.min(delays[max(0, k - window) : k + 1] + (drift + abs(ppm) * 1e-6) * ago)
        late[k] = least + drift * delays[k]
        if k:  # a map that comes down lets time go on at half its speed
            late[k] = max(late[k], late[k - 1] - 0.5 * (measured[k] - measured[k - 1]))
    return late


# --- offset, drift, jitter -------------------------------------------------------------------------------


def test_packets_without_delay_are_mapped_to_when_they_were_measured():
    measured = np.arange(200) * 0.0625  # a whole number of ticks
    times = mapped(DeviceClock(tick=TICK), counted(measured, started=-2.0), measured)
    np.testing.assert_allclose(times, measured, atol=1e-12)


def test_the_least_delayed_packet_sets_the_offset_by_hand():
    clock = DeviceClock(tick=0.01, drift=0.0)
    assert clock.seconds(100, arrived=5.030) == pytest.approx(5.030)
    assert clock.seconds(101, arrived=5.025) == pytest.approx(5.035)  # 15 ms less late: half a tick on, not back
    assert clock.seconds(102, arrived=5.500) == pytest.approx(5.040)  # the radio slept, the band did not
    assert clock.seconds(103, arrived=5.510) == pytest.approx(5.045)  # 5.045 is what the second packet says
    assert clock.seconds(104, arrived=5.520) == pytest.approx(5.055)


@EXACT
@given(
    st.lists(st.tuples(st.integers(1, 40), st.floats(0.0, 0.3)), min_size=2, max_size=60),
    st.booleans(),
)
def test_times_rise_with_the_ticks_and_never_stand_still(steps, spaced):
    ticks = np.cumsum([step for step, _ in steps])
    measured = ticks * 0.01
    arrived = np.maximum.accumulate(measured + [delay for _, delay in steps])
    clock = DeviceClock(tick=0.01, spacing=0.01 if spaced else None)
    times = mapped(clock, [int(count) for count in ticks], arrived)
    assert (np.diff(times) >= 0.5 * np.diff(measured) - 1e-9).all()


def test_the_offset_rises_no_faster_than_the_drift_by_hand():
    clock = DeviceClock(tick=1.0, drift=1e-3)
    assert clock.seconds(0, arrived=10.0) == 10.0
    assert clock.seconds(100, arrived=110.05) == pytest.approx(110.05)  # 50 ms in 100 s could be drift
    # The next is 0.95 s later than that, of which 100.95 s explain 0.10095 s: 200 + 10.05 + 0.10095.
    assert clock.seconds(200, arrived=211.00) == pytest.approx(210.15095, abs=1e-9)


@pytest.mark.parametrize("ppm", [-100.0, -20.0, 0.0, 20.0, 100.0])
def test_an_hour_of_drift_and_jitter_stays_within_the_bound(ppm):
    random = np.random.default_rng(7)
    measured = np.arange(0.0, 3600.0, 0.1)
    delays = 0.004 + random.exponential(0.020, len(measured))
    late = mapped(DeviceClock(tick=TICK), counted(measured, ppm), measured + delays) - measured
    assert late.min() > -TICK  # never before it was measured, but for the tick that is not over yet
    assert (late < bound(measured, delays, 200e-6, ppm, window=100) + TICK).all()
    # An hour at 100 ppm is 0.36 s; what is left is the least of the delays of the last seconds.
    settled = late[100:]
    assert settled.max() < 0.010
    assert settled.mean() < 0.008


@EXACT
@given(
    st.floats(-100.0, 100.0),
    st.lists(st.tuples(st.floats(0.001, 0.5), st.floats(0.0, 0.3)), min_size=1, max_size=60),
)
def test_whatever_the_delays_a_time_is_never_early_and_late_within_the_bound(ppm, steps):
    measured = np.cumsum([step for step, _ in steps])
    arrived = np.maximum.accumulate(measured + [delay for _, delay in steps])  # a stream keeps its order
    late = mapped(DeviceClock(tick=TICK), counted(measured, ppm), arrived) - measured
    assert late.min() > -TICK - 1e-9
    assert (late < bound(measured, arrived - measured, 200e-6, ppm, window=60) + TICK + 1e-9).all()


def test_a_clock_that_runs_away_faster_than_the_drift_lags_by_the_difference():
    measured = np.arange(0.0, 1000.0, 0.5)
    slow = mapped(DeviceClock(tick=TICK, drift=200e-6), counted(measured, ppm=-500.0), measured)
    assert slow[-1] - measured[-1] == pytest.approx(-(500e-6 - 200e-6) * 1000.0, abs=2e-3)


# --- wrap-around -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("bits", [8, 16, 24, 32])
def test_a_counter_that_wraps_is_mapped_like_one_that_does_not(bits):
    random = np.random.default_rng(bits)
    measured = np.cumsum(random.uniform(0.01, 0.12, 3000))  # at most 123 of a byte's 256 ticks
    arrived = measured + random.exponential(0.01, len(measured))
    started = -((1 << bits) - 500) * TICK  # 500 ticks before the first wrap
    whole = mapped(DeviceClock(tick=TICK), counted(measured, 30.0, started), arrived)
    wrapped = mapped(DeviceClock(tick=TICK, bits=bits), counted(measured, 30.0, started, bits), arrived)
    np.testing.assert_allclose(wrapped, whole, atol=1e-9)


def test_packets_around_the_wrap_in_any_order_by_hand():
    clock = DeviceClock(tick=0.01, bits=8, drift=0.0)
    arrivals = [
        (250, 1.00),
        (253, 1.03),
        (2, 1.08),
        (255, 1.09),
        (254, 1.10),
        (4, 1.11),
        (3, 1.12),
        (6, 1.13),
    ]
    measured = [1.00, 1.03, 1.08, 1.05, 1.04, 1.10, 1.09, 1.12]
    np.testing.assert_allclose([clock.seconds(*packet) for packet in arrivals], measured, atol=1e-12)


def test_a_late_packet_from_before_the_first_one():
    clock = DeviceClock(tick=0.01, bits=8, drift=0.0)
    assert clock.seconds(1, arrived=2.0) == pytest.approx(2.0)
    assert clock.seconds(255, arrived=2.01) == pytest.approx(1.98)
    assert clock.seconds(3, arrived=2.02) == pytest.approx(2.02)


@EXACT
@given(st.integers(0, 255), st.lists(st.integers(1, 60), min_size=3, max_size=80), st.randoms())
def test_late_packets_are_mapped_to_when_they_were_measured_and_shift_no_other(first, steps, random):
    ticks = np.cumsum([first, *steps])
    measured = (ticks - first) * 0.01
    places = sorted(range(len(ticks)), key=lambda place: place + random.uniform(0.0, 2.0))
    latest = np.maximum.accumulate(ticks[places])
    if places[0] != 0:  # an offset can only be right once a packet has come in time
        places, latest = sorted(places), ticks
    arrived = (latest - first) * 0.01
    clock = DeviceClock(tick=0.01, bits=8, drift=0.0)
    times = mapped(clock, [int(count) % 256 for count in ticks[places]], arrived)
    np.testing.assert_allclose(times, measured[places], atol=1e-9)


@pytest.mark.parametrize(("step", "read_as"), [(128, 1.28), (129, -1.27), (255, -0.01), (1, 0.01), (0, 0.0)])
def test_more_than_half_a_counter_ahead_is_an_old_packet(step, read_as):
    clock = DeviceClock(tick=0.01, bits=8, drift=0.0)
    clock.seconds(200, arrived=10.0)
    assert clock.seconds((200 + step) % 256, arrived=12.0) == pytest.approx(10.0 + read_as)


# --- bursts ----------------------------------------------------------------------------------------------


def radio(seed, *, rate=100.0, seconds=60.0, interval=None, between=None, loss=0.0, late=0.0005):
    """Times measured and arrivals [s] of what was not lost, and how many were.

    Everything measured since the last connection event arrives with the next, ``late`` on average: events come every
    ``interval``, or at random gaps ``between`` two bounds, or at once.
    """
    random = np.random.default_rng(seed)
    measured = 5.0 + random.uniform() + np.arange(round(seconds * rate)) / rate
    if interval is None and between is None:
        arrived = measured + 0.001 + random.exponential(late, len(measured))
    else:
        low, high = between or (interval, interval)
        gaps = random.uniform(low, high, round((seconds + 10) / low))
        events = random.uniform(0.0, 0.05) + np.cumsum(gaps)
        event = np.searchsorted(events, measured)
        arrived = events[event] + random.exponential(late, len(events))[event]
    arrived = np.maximum.accumulate(arrived)
    kept = random.uniform(size=len(measured)) >= loss
    return measured[kept], arrived[kept], int((~kept).sum())


def off_ms(times, measured, settled=12.0):
    """Errors [ms] once the map has settled."""
    return 1000 * (times - measured)[measured > measured[0] + settled]


LINKS = [
    {"interval": 0.0075},
    {"interval": 0.030},
    {"interval": 0.050},
    {"interval": 0.04875},
    {"between": (0.030, 0.050)},
    {},
]
STEADY = LINKS[1:3]
"""Intervals in step with the samples: a slow rate looks like losses in a steady rhythm, and may be taken for it."""


@pytest.mark.parametrize("link", LINKS, ids=str)
@pytest.mark.parametrize("rate", [100.0, 100.5])
def test_a_bands_ticks_are_mapped_to_five_milliseconds(link, rate):
    late = []
    for seed in range(6):
        measured, arrived, _ = radio(seed, rate=rate, loss=0.01, **link)
        clock = DeviceClock(48 / 32768, bits=32, spacing=0.01)
        ticks = counted(measured, ppm=20.0, started=-300.0, bits=32, tick=48 / 32768)
        late.append(off_ms(mapped(clock, ticks, arrived), measured))
    late = np.abs(np.concatenate(late))
    if link in STEADY and rate == 100.0:  # bursts that keep step with the samples: a part of one cannot be known
        assert np.percentile(late, 50) < 5.5
        assert np.percentile(late, 95) < 8.0
    else:
        assert np.percentile(late, 95) < 2.5
        assert late.max() < 5.0


def test_a_third_of_what_nobody_can_know_is_taken_off_by_hand():
    bursts = Bursts(spacing=0.01, window=1.0)
    for k in range(25):  # five packets every 50 ms, the last of each 1 ms behind the envelope
        for lag in (0.041, 0.031, 0.021, 0.011, 0.001):
            bursts.add(arrived=0.05 * k, lag=lag)
    assert bursts.waited == pytest.approx((0.010 - 0.001) / 3)


def test_packets_that_come_alone_wait_for_nothing():
    bursts = Bursts(spacing=0.01, window=1.0)
    for k in range(300):
        bursts.add(arrived=0.01 * k, lag=0.001)
    assert bursts.waited == 0.0


# --- streams without ticks -------------------------------------------------------------------------------


def streamed(clock, arrived):
    return np.array([clock.seconds(t) for t in arrived])


def test_a_stream_that_comes_at_once_by_hand():
    clock = StreamClock(spacing=0.01)
    times = streamed(clock, [1.00, 1.01, 1.02, 1.03])
    np.testing.assert_allclose(times, [1.00, 1.01, 1.02, 1.03], atol=1e-9)
    assert clock.lost == 0


def test_a_burst_is_spread_out_and_the_next_corrects_it_by_hand():
    clock = StreamClock(spacing=0.01)
    first = streamed(clock, [1.05] * 5)  # measured at 1.01 to 1.05: only the last of them tells
    np.testing.assert_allclose(np.diff(first), 0.005, atol=1e-9)
    later = streamed(clock, np.repeat([1.10, 1.15, 1.20], 5))
    np.testing.assert_allclose(later[-5:], [1.16, 1.17, 1.18, 1.19, 1.20], atol=1e-9)


def test_a_long_silence_is_counted_when_it_ends_by_hand():
    clock = StreamClock(spacing=0.01)
    streamed(clock, np.arange(500) * 0.01)
    after = streamed(clock, 6.99 + np.arange(20) * 0.01)
    assert clock.lost == 200 - 1
    np.testing.assert_allclose(after, 6.99 + np.arange(20) * 0.01, atol=1e-3)


@pytest.mark.parametrize("link", LINKS, ids=str)
@pytest.mark.parametrize("rate", [99.5, 100.0, 100.5])
def test_a_stream_without_losses_has_none_and_is_mapped_well(link, rate):
    late, lost = [], []
    for seed in range(4):
        measured, arrived, _ = radio(seed, rate=rate, **link)
        clock = StreamClock(spacing=0.01)
        times = streamed(clock, arrived)
        assert (np.diff(times) >= 0.0).all()
        late.append(off_ms(times, measured))
        lost.append(clock.lost)
        if link not in STEADY:
            assert clock.period == pytest.approx(1 / rate, rel=1e-4)
    late = np.abs(np.concatenate(late))
    assert np.percentile(late, 50) < 5.0
    assert np.percentile(late, 95) < (8.0 if link in STEADY else 3.0)
    assert np.mean(lost) <= (40 if link in STEADY else 1)  # of six thousand


@pytest.mark.parametrize("link", LINKS, ids=str)
@pytest.mark.parametrize("rate", [99.5, 100.0, 100.5])
def test_losses_are_counted_and_do_not_shift_the_map_by_more_than_a_sample(link, rate):
    late, off = [], []
    for seed in range(4):
        measured, arrived, lost = radio(seed, rate=rate, loss=0.01, **link)
        clock = StreamClock(spacing=0.01)
        times = streamed(clock, arrived)
        assert (np.diff(times) >= 0.0).all()
        late.append(off_ms(times, measured))
        off.append(clock.lost - lost)
    late = np.abs(np.concatenate(late))
    assert np.percentile(late, 50) < 5.0
    at_once = link in ({}, {"interval": 0.0075})
    assert np.percentile(late, 95) < (3.0 if at_once else 11.0)
    assert np.mean(np.abs(off)) <= (3 if at_once else 15)  # of sixty


@EXACT
@given(st.lists(st.floats(0.0, 0.4), min_size=1, max_size=200))
def test_whatever_comes_when_the_times_of_a_stream_rise(gaps):
    arrived = 3.0 + np.cumsum(gaps)
    times = streamed(StreamClock(spacing=0.01), arrived)
    assert (np.diff(times) > 0.0).all()
    assert np.isfinite(times).all()
