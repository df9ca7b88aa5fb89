"""Minimum-jerk movements, and random processes that are as large as they say."""

import numpy as np
import pytest

from armspan.simulation.fluctuation import Band, Fluctuation
from armspan.simulation.movement import Movements, minimum_jerk


def test_minimum_jerk_by_hand():
    # 10 s³ - 15 s⁴ + 6 s⁵ at 1/4: 10/64 - 15/256 + 6/1024
    assert minimum_jerk(np.array([-1.0, 0.0, 0.25, 0.5, 1.0, 3.0])) == pytest.approx(
        [0.0, 0.0, 0.103515625, 0.5, 1.0, 1.0]
    )


def test_overlapping_steps_add_up():
    moves = Movements(np.array([1.0, 2.0]))
    moves.move(np.array([1.0, 0.0]), 0.0, 1.0)
    moves.move(np.array([0.0, 4.0]), 0.5, 1.0)
    first, second = moves.at(np.array([0.0, 0.5, 1.0, 9.0]))
    assert first == pytest.approx([1.0, 1.5, 2.0, 2.0])
    assert second == pytest.approx([2.0, 2.0, 4.0, 6.0])
    assert moves.goal == pytest.approx([2.0, 6.0])


def test_forgetting_what_is_over_changes_nothing_after_it():
    moves = Movements(np.array([0.0]))
    for k in range(20):
        moves.move(np.array([0.1 * k]), 0.1 * k, 0.3)
    times = np.linspace(1.2, 4.0, 50)
    before = moves.at(times)
    moves.forget(1.2)
    assert moves.at(times) == pytest.approx(before)
    assert moves.at(np.array([0.0])) != pytest.approx(0.0)  # the beginning is gone


def test_a_process_has_the_spread_and_the_rates_it_says():
    bands = [Band(0, 2.0, 0.2, 2.0, 6), Band(1, 0.3, 8.0, 11.0, 3)]
    process = Fluctuation(bands, 3, np.random.default_rng(1))
    times = np.arange(0.0, 400.0, 0.01)
    slow, fast, nothing = process.at(times)
    assert slow.std() == pytest.approx(2.0, rel=0.05)
    assert fast.std() == pytest.approx(0.3, rel=0.05)
    assert not nothing.any()
    power = np.abs(np.fft.rfft(fast)) ** 2
    rates = np.fft.rfftfreq(len(times), 0.01)
    inside = (rates > 7.9) & (rates < 11.1)
    assert power[inside].sum() > 0.99 * power.sum()


def test_a_process_does_not_depend_on_how_it_is_asked():
    process = Fluctuation([Band(0, 1.0, 0.1, 5.0, 5)], 1, np.random.default_rng(2))
    times = np.linspace(0.0, 10.0, 101)
    one_by_one = [process.at(times[k : k + 1])[0, 0] for k in range(101)]
    assert process.at(times)[0] == pytest.approx(one_by_one)
