import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.records import RobotState, Sheet
from armspan.swarm.behaviours.potential import Potential, capped, creep, edge_forces, push, robot_forces, slowed
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.limits import Limits

DT = 0.05


def stage(size=1.0):
    return Stage(Sheet(size, size), Limits(), np.random.default_rng(0))


def states_of(t, places):
    return {name: RobotState(t, name, (float(xy[0]), float(xy[1])), 0.0) for name, xy in places.items()}


def run(behaviour, places, seconds, t=0.0):
    while t < seconds and not behaviour.done:
        for wish in behaviour.step(t, states_of(t, places), None):
            assert math.hypot(*wish.velocity) <= 0.15 + 1e-9
            assert (wish.turn, wish.until) == (0.0, pytest.approx(t + 0.3))
            places[wish.robot] = places[wish.robot] + DT * np.array(wish.velocity)
        t += DT
    return t


def test_the_push_in_the_labs_units():
    """500000 kg mm³/s² at 100 mm is 50 kg mm/s², at 200 mm 12.5; mu = 1 kg/s makes mm/s of them."""
    assert push(np.array([0.1, 0.2, 0.3]), 5e-4) == pytest.approx([0.050 - 0.0125, 0.0, 0.0])


def test_forces_by_hand():
    """Two robots 0.1 m apart push each other straight apart; the third sees nobody."""
    places = np.array([[0.4, 0.5], [0.5, 0.5], [0.8, 0.5]])
    assert robot_forces(places, 5e-4) == pytest.approx(np.array([[-0.0375, 0.0], [0.0375, 0.0], [0.0, 0.0]]))
    corner = np.array([[0.1, 0.95]])
    expected = [[0.0375, -(5e-4 / 0.05**2 - 0.0125)]]
    assert edge_forces(corner, np.array([1.0, 1.0]), 5e-4) == pytest.approx(np.array(expected))


def test_a_constant_force_ends_in_its_terminal_speed():
    """m / mu is 0.2 s: after that long 63 % of F / mu, whatever the step."""
    force = np.array([[0.05, 0.0]])
    once = slowed(np.zeros((1, 2)), force, 0.2)
    assert once[0, 0] == pytest.approx(0.05 * (1 - math.exp(-1)))
    twice = slowed(slowed(np.zeros((1, 2)), force, 0.1), force, 0.1)
    assert twice == pytest.approx(once)
    assert capped(np.array([[0.3, 0.4], [0.0, 0.0]]), 0.15) == pytest.approx(np.array([[0.09, 0.12], [0.0, 0.0]]))


def test_speeds_are_raised_to_creeping_but_those_at_rest():
    factors = creep(np.array([0.0, 0.0019, 0.002, 0.01, 0.025, 0.1]))
    assert factors == pytest.approx([1.0, 1.0, 12.5, 2.5, 1.0, 1.0])


def test_robots_that_are_to_move_are_told_to_creep():
    """At 0.18 m 5e-4 (1 / 0.18² - 1 / 0.2²) is 2.93 mN: 2.93 (1 - exp(-5 t)) mm/s, 2 mm/s after 0.23 s."""
    places = {"a": np.array([0.41, 0.5]), "b": np.array([0.59, 0.5])}
    behaviour = Potential(stage(), states_of(0.0, places))
    told = [[wish.velocity for wish in behaviour.step(k * DT, states_of(k * DT, places), None)] for k in range(40)]
    exact = 2.932e-3 * (1 - np.exp(-5 * DT * np.arange(5)))
    expected = np.concatenate([exact, np.full(35, 0.025)])
    assert np.array(told)[:, 0] == pytest.approx(np.stack([-expected, 0 * expected], axis=1), abs=1e-6)
    assert np.array(told)[:, 1] == pytest.approx(np.stack([expected, 0 * expected], axis=1), abs=1e-6)
    assert not behaviour.done


def test_creeping_keeps_the_direction():
    places = {"a": np.array([0.41, 0.41]), "b": np.array([0.51, 0.56])}  # 0.18 m: 2.8 mm/s away from each other
    behaviour = Potential(stage(), states_of(0.0, places))
    for k in range(20):
        first, _ = behaviour.step(k * DT, states_of(k * DT, places), None)
    assert first.velocity == pytest.approx((-0.025 * 0.5547, -0.025 * 0.83205), abs=1e-6)


def test_what_hardly_moves_is_at_rest_and_not_told_to_creep():
    """At 0.19 m the push is 1.35 mN: 1.35 mm/s, below 2 mm/s."""
    places = {"a": np.array([0.405, 0.5]), "b": np.array([0.595, 0.5])}
    behaviour = Potential(stage(), states_of(0.0, places))
    for k in range(40):
        _, second = behaviour.step(k * DT, states_of(k * DT, places), None)
    assert second.velocity == pytest.approx((1.350e-3, 0.0), abs=1e-6)
    assert behaviour.done


@pytest.mark.parametrize("count", [4, 9, 16])
def test_a_heap_spreads_out_and_comes_to_rest(count):
    rng = np.random.default_rng(count)
    places = {f"r{i:02d}": rng.uniform(0.4, 0.6, 2) for i in range(count)}
    behaviour = Potential(stage(), states_of(0.0, places))
    run(behaviour, places, 60.0)
    assert behaviour.done
    stops = np.array(list(places.values()))
    gaps = [math.dist(a, b) for i, a in enumerate(stops) for b in stops[:i]]
    assert min(gaps) > 0.15
    assert 0.15 < stops.min() < stops.max() < 0.85


def test_two_in_one_place_part_opposite_ways():
    places = {"a": np.array([0.5, 0.5]), "b": np.array([0.5, 0.5])}
    behaviour = Potential(stage(), states_of(0.0, places))
    run(behaviour, places, 10.0)
    assert math.dist(places["a"], places["b"]) > 0.15
    assert (places["a"] + places["b"]) / 2 == pytest.approx(np.array([0.5, 0.5]))


def test_rest_must_last_a_second_and_ends_when_one_is_pushed():
    places = {"a": np.array([0.3, 0.5]), "b": np.array([0.7, 0.5])}
    behaviour = Potential(stage(), states_of(0.0, places))
    assert run(behaviour, places, 10.0) == pytest.approx(1.1, abs=0.06)
    places["b"] = np.array([0.35, 0.5])
    for t in (2.0, 2.05):
        behaviour.step(t, states_of(t, places), None)
    assert not behaviour.done


def test_one_that_comes_back_begins_at_rest():
    places = {"a": np.array([0.5, 0.5]), "b": np.array([0.55, 0.5])}
    behaviour = Potential(stage(), states_of(0.0, places))
    run(behaviour, places, 0.5)
    alone = states_of(0.5, {"a": places["a"]})
    assert [wish.robot for wish in behaviour.step(0.5, alone, None)] == ["a"]
    apart = states_of(0.5, {"a": places["a"], "b": np.array([0.9, 0.9])})
    back = {wish.robot: wish.velocity for wish in behaviour.step(0.5, apart, None)}
    assert back["b"] == (0.0, 0.0)


def test_without_robots_nothing_is_done():
    behaviour = Potential(stage(), {})
    for t in (0.0, 1.0, 2.0):
        assert behaviour.step(t, {}, None) == []
    assert not behaviour.done


@settings(max_examples=30, derandomize=True, deadline=None)
@given(st.lists(st.tuples(st.floats(-0.1, 1.1), st.floats(-0.1, 1.1)), min_size=1, max_size=12))
def test_wishes_are_finite_and_capped_wherever_robots_are(places):
    named = {f"r{i:02d}": np.array(xy) for i, xy in enumerate(places)}
    behaviour = Potential(stage(), states_of(0.0, named))
    run(behaviour, named, 0.5)
    assert all(np.isfinite(xy).all() for xy in named.values())
