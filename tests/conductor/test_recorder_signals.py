"""What is between a band's samples and a take: gaps, signs of quaternions, and when an arm moved."""

import numpy as np
import pytest

from armspan.conductor.recorder_motion import gesture_span
from armspan.conductor.recorder_plan import Recording, asks_of
from armspan.conductor.recorder_trace import Trace

REST = (0.0,) * 6


def test_quaternions_are_interpolated_the_short_way():
    trace = Trace()
    a, b = np.radians(178.0) / 2, np.radians(182.0) / 2  # about z; w >= 0 puts them on opposite sides
    trace.push(0.0, (0.0, 0.0, np.sin(a), np.cos(a), *REST))
    trace.push(0.1, (0.0, 0.0, -np.sin(b), -np.cos(b), *REST))
    values = trace.on(np.array([0.0, 0.05, 0.1]))
    assert np.abs(values[:, 2]) == pytest.approx([np.sin(a), 1.0, np.sin(b)])
    assert values[1, [0, 1, 3]] == pytest.approx(0.0, abs=1e-9)
    assert (values[:, 3] >= -1e-12).all()


def test_gaps_of_a_trace():
    trace = Trace()
    for t in (0.0, 0.1, 0.2, 0.35, 0.4, 0.3):
        trace.push(t, (0.0, 0.0, 0.0, 1.0, t, *REST[1:]))
    values = trace.on(np.array([-0.05, 0.05, 0.2, 0.25, 0.35, 0.4, 0.45]))
    assert values[:, 4] == pytest.approx([np.nan, 0.05, 0.2, np.nan, 0.35, 0.4, np.nan], nan_ok=True)
    assert trace.silence(0.0, 0.4) == pytest.approx(0.15)
    assert trace.silence(0.1, 1.0) == pytest.approx(0.6)
    assert trace.silence(2.0, 3.0) == pytest.approx(1.0)
    trace.forget(0.2)
    assert trace.times == [0.2, 0.35, 0.4]
    assert np.isnan(Trace().on(np.arange(3.0))).all()


def test_a_span_is_found_over_an_arm_that_trembles_and_fidgets():
    times = np.arange(0, 800) / 100
    tremor = np.full(800, 0.1)
    wave = np.where((times > 3) & (times < 5), 2.0, 0.0)
    twitch = np.where((times > 6) & (times < 6.03), 1.5, 0.0)
    weak = np.where((times > 6.5) & (times < 7), 0.45, 0.0)
    rates = np.stack([tremor + twitch + weak, tremor + wave], axis=1)
    assert gesture_span(times, rates, 2.5, 2.2) == pytest.approx((3.01, 4.99))
    assert gesture_span(times, rates[:, :1], 2.5, 2.2) is None


def test_the_own_rest_tells_what_is_motion():
    times = np.arange(0, 800) / 100
    wave = np.where((times > 3) & (times < 5), 2.0, 0.0)
    for rest in (0.02, 0.11):
        slow = np.where((times >= 5) & (times < 6), 0.3, 0.0)
        span = gesture_span(times, (rest + wave + slow)[:, None], 2.5, 2.2)
        assert span == pytest.approx((3.01, 5.99 if rest < 0.1 else 4.99), abs=0.011)


def test_each_label_is_practised_before_any_is_taken_where_they_are_mixed():
    labels = ("a", "b", "c", "d")
    asks = asks_of(Recording(labels, 3, shuffle=True, dice=5))
    assert [ask.practice for ask in asks] == [True] * 4 + [False] * 12
    for label in labels:
        assert [ask.place for ask in asks if ask.label == label] == [0, 1, 2, 3]
