import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.devices.receptor.steady import Steady
from armspan.records import Hit


def play(steady, *said):
    """What is told when (t, robot, on) are said; None lets time pass."""
    told = []
    for t, robot, on in said:
        told += steady.advance(t) if robot is None else steady.take(t, robot, on)
    return told


def test_a_hit_is_told_at_once_and_once():
    assert play(Steady(0.03, 0.0), (1.0, "a", True), (1.1, "a", True), (9.0, None, None)) == [Hit(1.0, "a", True)]


def test_the_end_is_told_later_with_the_time_at_which_it_was():
    steady = Steady(0.03, 0.0)
    assert play(steady, (1.0, "a", True), (1.5, "a", False)) == [Hit(1.0, "a", True)]
    assert steady.due() == pytest.approx(1.53)
    assert steady.advance(1.529) == []
    assert steady.advance(1.53) == [Hit(1.5, "a", False)]
    assert steady.due() == math.inf


def test_chatter_is_one_hit():
    said = [(1.0 + 0.01 * k, "a", k % 2 == 0) for k in range(11)]
    told = play(Steady(0.03, 0.0), *said, (1.105, "a", False), (2.0, None, None))
    assert told == [Hit(1.0, "a", True), Hit(1.105, "a", False)]


def test_a_gap_longer_than_chatter_is_a_gap():
    told = play(Steady(0.03, 0.0), (1.0, "a", True), (1.1, "a", False), (1.2, "a", True))
    assert told == [Hit(1.0, "a", True), Hit(1.1, "a", False), Hit(1.2, "a", True)]


def test_what_was_not_hit_cannot_be_lost():
    assert play(Steady(0.03, 0.0), (1.0, "a", False), (2.0, None, None)) == []


def test_a_hit_that_is_not_repeated_expires():
    steady = Steady(0.03, 1.0)
    told = play(steady, (1.0, "a", True), (1.8, "a", True), (2.7, None, None))
    assert told == [Hit(1.0, "a", True)]
    assert steady.due() == pytest.approx(2.8)
    assert steady.advance(3.5) == [Hit(2.8, "a", False)]


def test_robots_are_apart_and_all_end_when_nobody_is_there():
    steady = Steady(0.03, 0.0)
    play(steady, (1.0, "b", True), (1.1, "a", True), (1.2, "a", False))
    assert steady.clear(1.21) == [Hit(1.21, "a", False), Hit(1.21, "b", False)]
    assert steady.clear(2.0) == []


@given(
    st.lists(st.tuples(st.floats(0.0, 0.1), st.sampled_from("ab"), st.booleans()), max_size=60),
    st.sampled_from([0.0, 0.5]),
)
@settings(derandomize=True)
def test_what_is_told_alternates_in_order_of_time(said, expire):
    steady, t, told = Steady(0.03, expire), 0.0, []
    for step, robot, on in said:
        t += step
        told += steady.take(t, robot, on)
    told += steady.advance(t + 10.0)
    for robot in "ab":
        mine = [hit for hit in told if hit.robot == robot]
        assert [hit.on for hit in mine] == [k % 2 == 0 for k in range(len(mine))]
        assert [hit.t for hit in mine] == sorted(hit.t for hit in mine)
