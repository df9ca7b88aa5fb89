import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.errors import ConfigError
from armspan.records import RobotState, Sheet
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.random_walk import RandomWalk
from armspan.swarm.limits import Limits
from ideal_robots import Raster

DT = 0.1
MODES = ("ballistic", "run-and-tumble", "correlated")


def stage(seed=0, body=0.0375):
    return Stage(Sheet(1.0, 1.0), Limits(body_radius_m=body), np.random.default_rng(seed))


def states_of(t, places):
    return {f"r{i:04d}": RobotState(t, f"r{i:04d}", (float(x), float(y)), 0.0) for i, (x, y) in enumerate(places)}


def step(behaviour, t, places, low=0.0375):
    """Ideal discs drive straight to their wishes for a tick; the directions (n,) [rad] in which they do."""
    headings = []
    for i, wish in enumerate(behaviour.step(t, states_of(t, places), None)):
        assert all(low - 1e-9 <= x <= 1 - low + 1e-9 for x in wish.xy)
        assert wish.speed == 0.15
        assert abs(wish.until - t - 0.3) < 1e-9
        (x, y), (goal_x, goal_y) = places[i], wish.xy
        headings.append(math.atan2(goal_y - y, goal_x - x))
        share = min(1.0, wish.speed * DT / max(math.hypot(goal_x - x, goal_y - y), 1e-12))
        places[i] = (x + share * (goal_x - x), y + share * (goal_y - y))
    return np.array(headings)


def seconds_to_90_percent(mode, count, seed):
    rng = np.random.default_rng(seed + 100)
    places = [tuple(rng.uniform(0.1, 0.9, 2).tolist()) for _ in range(count)]
    raster, behaviour, t = Raster(0.01), RandomWalk(stage(seed), {}, mode=mode), 0.0
    while raster.share < 0.9 and t < 900:
        for place in places:  # every 15 mm: a way's rim is 0.8 mm short in between
            raster.cover(*place, 0.0375)
        step(behaviour, t, places)
        t += DT
    return t


@pytest.mark.parametrize(
    ("mode", "count", "anchor"),
    [("ballistic", 6, 38.2), ("run-and-tumble", 4, 68.8), ("correlated", 4, 63.6)],
)
def test_coverage_takes_as_long_as_the_anchors(mode, count, anchor):
    """Medians of six walks of a 75 mm disc at 150 mm/s on a square metre; two sets of six differ by a fifth at most."""
    median = np.median([seconds_to_90_percent(mode, count, seed) for seed in range(6)])
    assert median == pytest.approx(anchor, rel=0.25)


def test_a_ballistic_robot_goes_straight_until_the_edge_and_then_inward():
    behaviour, places = RandomWalk(stage(3), {}), [(0.5, 0.5)]
    turns, last = 0, None
    for k in range(600):
        was = places[0]
        (heading,) = step(behaviour, k * DT, places)
        if last is not None and abs(math.remainder(heading - last, math.tau)) > 1e-3:
            turns += 1
            assert min(*was, *(1.0 - at for at in was)) < 0.0375 + 0.0101
        last = heading
    assert turns > 5


def test_headings_are_even_over_the_circle():
    """The first headings of many robots: each quarter has its quarter of them."""
    behaviour = RandomWalk(stage(5), {})
    headings = step(behaviour, 0.0, [(0.5, 0.5)] * 2000)
    quarters = np.histogram(headings, bins=4, range=(-math.pi, math.pi))[0]
    assert quarters == pytest.approx(np.full(4, 500), abs=80)


def test_a_run_lasts_two_seconds():
    behaviour, places = RandomWalk(stage(1), {}, mode="run-and-tumble"), [(0.5, 0.5)]
    headings = [step(behaviour, k * DT, places)[0] for k in range(25)]
    changes = [k for k in range(1, 25) if abs(headings[k] - headings[k - 1]) > 1e-3]
    assert changes == [20]


def test_a_correlated_heading_drifts_as_the_root_of_time():
    """Of many robots, the mean cosine of the drift after a second is exp(-sigma² / 2) = 0.607."""
    behaviour = RandomWalk(stage(2), {}, mode="correlated")
    places = [(0.5, 0.5)] * 600
    drift = np.zeros(600)
    before = step(behaviour, 0.0, places)
    for k in range(1, 11):
        now = step(behaviour, k * DT, places)
        drift, before = drift + np.remainder(now - before + math.pi, math.tau) - math.pi, now
    assert np.cos(drift).mean() == pytest.approx(math.exp(-0.5), abs=0.06)


def test_a_blocked_robot_turns_elsewhere():
    behaviour, place = RandomWalk(stage(4), {}), [(0.5, 0.5)]
    headings = [step(behaviour, k * DT, list(place))[0] for k in range(9)]
    assert len(set(np.round(headings[:7], 6))) == 1
    assert abs(headings[8] - headings[0]) > 1e-3


def test_it_is_never_done_and_asks_nothing_of_the_absent():
    behaviour = RandomWalk(stage(), states_of(0.0, [(0.5, 0.5)]))
    assert behaviour.step(0.0, {}, None) == []
    assert not behaviour.done


def test_an_unknown_mode_is_answered_with_those_that_exist():
    with pytest.raises(ConfigError, match="Did you mean 'ballistic'"):
        RandomWalk(stage(), {}, mode="balistic")


@settings(max_examples=25, derandomize=True, deadline=None)
@given(
    st.sampled_from(MODES),
    st.integers(0, 1000),
    st.lists(st.tuples(st.floats(-0.2, 1.2), st.floats(-0.2, 1.2)), min_size=1, max_size=5),
)
def test_wishes_stay_inside_wherever_robots_are_and_are_the_same_twice(mode, seed, starts):
    ends = []
    for _ in range(2):
        behaviour, places = RandomWalk(stage(seed, 0.045), {}, mode=mode), list(starts)
        for k in range(40):
            step(behaviour, k * DT, places, 0.045)
        ends.append(places)
    assert ends[0] == ends[1]
