"""Notifications of a band as samples: orientations without a clock, raw samples with one, and the button."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from armspan.devices.metawear.boards import board_named
from armspan.devices.metawear.button import Button
from armspan.devices.metawear.core import Band, light, vibration
from armspan.devices.metawear.counters import StreamCounters
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.metawear.handshake import Identity, Met
from armspan.devices.metawear.notifications import Corrected, Fused, LogTime, Quaternion, Ranges
from armspan.devices.metawear.setup import SetUp
from armspan.devices.metawear.streams import FusionStream, RawStream, gravity_in_sensor, turned
from armspan.records import Haptic, ImuSample, Link, Tap

EXACT = settings(derandomize=True, database=None, deadline=None, max_examples=100)
TICK = 48 / 32768
ADDRESS = "E8:C9:8F:52:7B:07"


def wxyz(rotation):
    return tuple(rotation.as_quat(scalar_first=True).tolist())


def orientation(rotation):
    return Quaternion(*wxyz(rotation))


units = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: math.hypot(*q) > 0.1)


# --- orientations ----------------------------------------------------------------------------------------


@EXACT
@given(units)
def test_the_force_on_a_sensor_at_rest_is_up_in_its_own_axes(q):
    rotation = Rotation.from_quat(q, scalar_first=True)
    np.testing.assert_allclose(gravity_in_sensor(wxyz(rotation)), rotation.inv().apply([0, 0, 9.80665]), atol=1e-9)


@EXACT
@given(units, st.tuples(*[st.floats(-30, 30)] * 3), st.booleans())
def test_a_rate_is_that_of_the_turn_in_the_sensors_axes(q, rate, flipped):
    old = Rotation.from_quat(q, scalar_first=True)
    new = old * Rotation.from_rotvec(np.array(rate) * 0.02)  # turned in its own axes
    told = wxyz(new)
    if flipped:
        told = tuple(-part for part in told)
    np.testing.assert_allclose(turned(wxyz(old), told, 0.02), rate, atol=1e-6)


def test_orientations_become_samples_by_hand():
    stream = FusionStream("right")
    turn = [Rotation.from_rotvec([0.01 * k, 0.0, 0.0]) for k in range(10)]
    samples = [sample for k in range(10) for sample in stream.hear(orientation(turn[k]), 5.0 + 0.01 * k)]
    assert len(samples) == 9  # the first does not tell how fast it turns
    for k, sample in enumerate(samples, start=1):
        assert sample.t == pytest.approx(5.0 + 0.01 * k)
        assert sample.gyr == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)
        assert sample.acc == pytest.approx((0.0, 9.80665 * math.sin(0.01 * k), 9.80665 * math.cos(0.01 * k)), abs=1e-6)
        assert sample.mag is None
        assert sample.quat == pytest.approx(wxyz(turn[k]))


def test_a_fusion_that_is_not_alive_sends_zeros_which_are_no_orientation():
    stream = FusionStream("right")
    assert stream.hear(Quaternion(0.0, 0.0, 0.0, 0.0), 1.0) == []
    assert stream.counters.refused == 1
    assert stream.heard == -math.inf


def test_a_long_gap_is_one_gap_and_no_rate_spans_it():
    stream = FusionStream("right")
    for k in range(300):
        stream.hear(orientation(Rotation.identity()), 0.01 * k)
    turned_meanwhile = orientation(Rotation.from_rotvec([0.0, 0.0, 2.0]))
    assert stream.hear(turned_meanwhile, 5.99) == []
    (sample,) = stream.hear(turned_meanwhile, 6.00)
    assert sample.gyr == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    (gap,) = stream.counters.latest_gaps
    assert gap.t == pytest.approx(5.99, abs=1e-3)
    assert gap.seconds == pytest.approx(3.0, abs=1e-3)
    assert gap.samples == 299
    assert (stream.counters.lost, stream.counters.gaps) == (299, 1)


def test_a_sample_that_is_lost_does_not_double_the_rate():
    stream = FusionStream("right")
    rates = []
    for k in range(600):
        if k % 97 != 50:
            samples = stream.hear(orientation(Rotation.from_rotvec([0.0, 0.0, 0.02 * k])), 0.01 * k)
            rates += [sample.gyr[2] for sample in samples]
    assert max(rates[300:]) <= 2.0 * 5 / 4 + 1e-6
    assert np.median(rates) == pytest.approx(2.0, abs=1e-3)


def test_whole_samples_carry_what_came_before_their_orientation():
    stream = FusionStream("right", whole=True)
    assert stream.hear(orientation(Rotation.identity()), 1.0) == []
    stream.hear(Corrected("corrected_acc", (0.5, 0.0, 1.0), 3), 1.01)
    stream.hear(Corrected("corrected_gyro", (0.0, 180.0, 0.0), 3), 1.01)
    stream.hear(Corrected("corrected_mag", (20.0, 1.0, -40.0), 3), 1.01)
    (sample,) = stream.hear(orientation(Rotation.identity()), 1.01)
    assert sample.acc == pytest.approx((4.903325, 0.0, 9.80665))
    assert sample.gyr == pytest.approx((0.0, math.pi, 0.0))
    assert sample.mag == (20.0, 1.0, -40.0)


# --- raw samples -----------------------------------------------------------------------------------------


def fused(tick, acc=(0.0, 0.0, 1.0), gyro=(0.0, 0.0, 0.0)):
    return Fused(2, tick % 2**32, acc, gyro)


def ticks_at(t):
    return round(t / TICK)


def test_raw_samples_come_with_the_boards_time_by_hand():
    stream = RawStream("right")
    stream.refer(LogTime(ticks_at(100.0), 5), 10.0)
    (first,) = stream.hear(fused(ticks_at(100.1), (0.0, 0.0, 1.0), (90.0, 0.0, 0.0)), 10.1)
    assert first.t == pytest.approx(10.1, abs=2 * TICK)
    assert first.acc == pytest.approx((0.0, 0.0, 9.80665))
    assert first.gyr == pytest.approx((math.pi / 2, 0.0, 0.0))
    assert first.quat is None
    (late,) = stream.hear(fused(ticks_at(100.11)), 10.16)  # fifty milliseconds late
    assert late.t == pytest.approx(10.11, abs=2 * TICK)


def test_what_is_missing_is_told_by_the_ticks():
    stream = RawStream("right")
    began = 2**32 - ticks_at(1.0)  # wraps after a second
    times = [0.01 * k for k in range(400) if k not in (50, 120, 121, 122) and not 200 <= k < 240]
    voids = []
    for t in times:
        stream.hear(fused(began + ticks_at(t)), 20.0 + t)
        voids.append(stream.void)
    assert [gap.samples for gap in stream.counters.latest_gaps] == [1, 3, 40]
    assert (stream.counters.samples, stream.counters.lost, stream.counters.gaps) == (356, 44, 3)
    assert voids.count(True) == 1  # nobody knows how far the arm turned in 0.4 s
    assert stream.counters.latest_gaps[2].seconds == pytest.approx(0.41, abs=2 * TICK)


@pytest.mark.parametrize("rate", [99.0, 101.0])
def test_a_chip_may_be_a_hundredth_off_and_a_long_gap_is_counted_right(rate):
    stream = RawStream("right")
    for k in [*range(3000), *range(4000, 4010)]:
        stream.hear(fused(ticks_at(k / rate)), k / rate)
    assert stream.counters.lost == pytest.approx(1000, abs=2)
    assert stream.counters.gaps == 1


def test_a_tick_that_came_already_is_no_sample():
    stream = RawStream("right")
    stream.hear(fused(1000), 1.0)
    assert stream.hear(fused(1000), 1.01) == []
    assert stream.counters.refused == 1


def test_a_board_that_began_anew_counts_from_zero_and_time_goes_on():
    stream = RawStream("right")
    for k in range(100):
        stream.hear(fused(5_000_000 + ticks_at(0.01 * k)), 10.0 + 0.01 * k)
    stream.renew()
    stream.refer(LogTime(10, 6), 13.0)
    (sample,) = stream.hear(fused(20), 13.1)
    assert sample.t == pytest.approx(13.0 + 10 * TICK, abs=2 * TICK)
    assert stream.counters.gaps == 0


# --- counters --------------------------------------------------------------------------------------------


def test_losses_that_were_none_are_taken_back():
    counters = StreamCounters()
    counters.gap(1.0, 0.02, 1)
    counters.gap(2.0, 0.04, 3)
    counters.take_back(2)
    assert (counters.lost, counters.gaps, counters.latest_gaps[-1].samples) == (2, 2, 1)
    counters.take_back(2)
    assert (counters.lost, counters.gaps, len(counters.latest_gaps)) == (0, 0, 0)


# --- the button ------------------------------------------------------------------------------------------


def taps(button, *presses, until=100.0):
    told = []
    for t in presses:
        for tap in button.due(t):
            told.append((t, tap))
        told += [(t, tap) for tap in button.hear(1, t)]
        told += [(t, tap) for tap in button.hear(0, t + 0.05)]
    return told + [(until, tap) for tap in button.due(until)]


def test_presses_far_apart_are_single_taps_told_when_no_other_can_follow():
    button = Button("right")
    told = taps(button, 1.0, 2.0)
    assert [(tap.t, tap.count) for _, tap in told] == [(1.0, 1), (2.0, 1)]
    assert button.wake() == math.inf


def test_a_double_click_is_one_tap():
    assert [tap for _, tap in taps(Button("right"), 1.0, 1.39)] == [Tap(1.39, "right", 2)]
    assert [tap.count for _, tap in taps(Button("right"), 1.0, 1.41)] == [1, 1]


def test_the_third_press_is_told_at_once():
    told = taps(Button("right"), 1.0, 1.2, 1.4, 1.6)
    assert told[0] == (1.4, Tap(1.4, "right", 3))
    assert [tap.count for _, tap in told] == [3, 1]


def test_a_button_waits_no_longer_than_it_must():
    button = Button("right")
    button.hear(1, 5.0)
    assert button.pending
    assert button.wake() == pytest.approx(5.4)
    assert button.due(5.39) == []
    assert button.due(5.41) == [Tap(5.0, "right", 1)]
    assert not button.pending


def test_a_press_whose_word_was_lost_is_known_by_its_release():
    button = Button("right")
    assert button.hear(0, 1.0) == []
    assert button.hear(1, 1.2) == []
    assert button.hear(1, 1.4) == [Tap(1.4, "right", 3)]  # a release was lost too


# --- a band ----------------------------------------------------------------------------------------------


def band(**entry):
    known = Band(MetaWearEntry("right", ADDRESS, **entry))
    known.linked()
    known.meet(Met(Identity(model="5", mac=ADDRESS), board_named("mmrl_current")))
    known.begin(SetUp(Ranges(16, 2000, {2: "fused"} if entry else {}), 2 if entry else None), LogTime(0, 5), 1.0)
    return known


def quaternion_packet(*q):
    return b"\x19\x07" + struct.pack("<4f", *q)


def fused_packet(tick):
    return b"\x09\x03\x02" + struct.pack("<I6h", tick, 0, 0, 2048, 0, 0, 0)


def test_a_band_tells_that_it_is_there_with_its_first_sample():
    known = band()
    assert known.hear(quaternion_packet(1, 0, 0, 0), 1.0) == []
    up, sample = known.hear(quaternion_packet(1, 0, 0, 0), 1.01)
    assert up == Link(1.01, "right", True, True)
    assert isinstance(sample, ImuSample)
    assert known.lost(2.0, "gone") == [Link(2.0, "right", False)]
    assert known.lost(3.0, "still gone") == []
    assert known.report.trouble == "still gone"


def test_what_a_board_sends_before_it_is_known_to_be_as_it_was_counts_for_nothing():
    known = band()
    for k in range(3):
        known.hear(quaternion_packet(1, 0, 0, 0), 1.0 + 0.01 * k)
    known.lost(1.1, "gone")
    known.linked()
    assert known.hear(quaternion_packet(1, 0, 0, 0), 2.0) == []
    known.resume()
    known.hear(quaternion_packet(1, 0, 0, 0), 2.1)
    assert known.hear(quaternion_packet(1, 0, 0, 0), 2.11)[0] == Link(2.11, "right", True, False)


def test_a_gap_in_raw_samples_makes_the_heading_void():
    known = band(profile="raw")
    up, _ = known.hear(fused_packet(100), 1.0)
    assert up == Link(1.0, "right", True, True)
    assert len(known.hear(fused_packet(107), 1.01)) == 1
    fresh, _ = known.hear(fused_packet(107 + ticks_at(0.3)), 1.31)
    assert fresh == Link(1.31, "right", True, True)


def test_packets_that_make_no_sense_are_counted():
    known = band()
    for data in (b"", b"\x19", b"\x19\x07\x00", quaternion_packet(math.nan, 0, 0, 0), b"\x77\x01\x02"):
        assert known.hear(data, 1.0) == []
    assert known.report.streams["fusion"].refused == 5


@pytest.mark.parametrize(
    ("colour", "writes"),
    [
        ((0, 0, 0), ["020201"]),
        ((255, 0, 0), ["020201", "020301021f1f0000f4010000e8030000ff", "020101"]),
        ((0, 1, 255), ["020201", "0203000201010000f4010000e8030000ff", "020302021f1f0000f4010000e8030000ff", "020101"]),
    ],
)
def test_lights_by_hand(colour, writes):
    assert [write.hex() for write in light(board_named("mmrl_current"), colour)] == writes


def test_vibrations_by_hand():
    board = board_named("mmrl_current")
    assert [write.hex() for write in vibration(board, Haptic(0.0, "right", 1.0, 0.5))] == ["0801f8f40100"]
    assert [write.hex() for write in vibration(board, Haptic(0.0, "right", 7.0, 1e6))] == ["0801f8ffff00"]
    assert vibration(board, Haptic(0.0, "right", 1.0, 0.0)) == []
