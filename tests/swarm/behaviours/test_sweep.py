import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.errors import ConfigError
from armspan.records import RobotState, Sheet
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.sweep import Sweep
from armspan.swarm.limits import Limits
from ideal_robots import Raster

DT = 0.05
U_SHAPE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.7, 1.0), (0.7, 0.3), (0.3, 0.3), (0.3, 1.0), (0.0, 1.0)]


def stage(body=0.0375, size=(1.0, 1.0)):
    return Stage(Sheet(*size), Limits(body_radius_m=body), np.random.default_rng(0))


def line(count):
    return {f"r{i}": ((i + 0.5) / count, 0.5) for i in range(count)}


def ring(count):
    turns = 2 * math.pi * np.arange(count) / count
    return {f"r{i}": (0.5 + 0.25 * math.cos(a), 0.5 + 0.25 * math.sin(a)) for i, a in enumerate(turns)}


def states_of(t, places):
    return {name: RobotState(t, name, (float(xy[0]), float(xy[1])), 0.0) for name, xy in places.items()}


class Discs:
    """Ideal discs of 75 mm that drive straight to their wishes, and a raster of 5 mm of what came under them."""

    def __init__(self, on, starts, area=None, away=lambda name, t: False):
        self.places = {name: (float(x), float(y)) for name, (x, y) in starts.items()}
        self.stage, self.away, self.t = on, away, 0.0
        self.raster, self.covered = Raster(0.005, area), []
        self.behaviour = Sweep(on, states_of(0.0, self.places), area)

    def present(self):
        here = {name: xy for name, xy in self.places.items() if not self.away(name, self.t)}
        return states_of(self.t, here)

    def run(self, seconds):
        while self.t < seconds and not self.behaviour.done:
            states = self.present()
            wishes = self.behaviour.step(self.t, states, None)
            assert [wish.robot for wish in wishes] == sorted(states)
            for wish in wishes:
                self.drive(wish)
            self.covered.append(self.raster.share)
            self.t += DT
        return self

    def drive(self, wish):
        for at, size in zip(wish.xy, (self.stage.sheet.width_m, self.stage.sheet.height_m), strict=True):
            assert self.stage.margin - 1e-9 <= at <= size - self.stage.margin + 1e-9
        assert abs(wish.until - self.t - self.stage.limits.lease_s) < 1e-9
        (x, y), (goal_x, goal_y) = self.places[wish.robot], wish.xy
        share = min(1.0, wish.speed * DT / max(math.hypot(goal_x - x, goal_y - y), 1e-12))
        new = x + share * (goal_x - x), y + share * (goal_y - y)
        self.raster.cover(*new, 0.0375)  # every 7.5 mm: a way's rim is 0.2 mm short in between
        self.places[wish.robot] = new

    def seconds_to(self, share):
        return DT * (1 + int(np.argmax(np.array(self.covered) >= share))) if self.covered[-1] >= share else math.inf


@cache
def swept(starts, count):
    """The whole square, swept by so many."""
    return Discs(stage(), starts(count)).run(120)


@cache
def without_one():
    """The same with four of which one drops out after six seconds."""
    return Discs(stage(), line(4), away=lambda name, t: name == "r1" and t > 6.0).run(120)


@pytest.mark.parametrize("starts", [line, ring])
@pytest.mark.parametrize(
    ("count", "t90", "t95", "t99"), [(1, 89.8, 94.9, 98.7), (4, 23.5, 24.8, 26.0), (6, 17.2, 18.4, 18.8)]
)
def test_the_square_is_swept_faster_than_the_anchors(starts, count, t90, t95, t99):
    """Boustrophedon strips of the same disc (the way to the start not counted there) took t90, t95 and t99 [s]."""
    discs = swept(starts, count)
    assert discs.behaviour.done
    assert discs.seconds_to(0.9) < t90
    assert discs.seconds_to(0.95) < t95
    assert discs.seconds_to(0.99) <= t99


def test_no_area_is_swept_faster_than_its_bound():
    """Were t50 below half of A / (n v d), the simulation or the raster would be wrong."""
    assert swept(line, 4).seconds_to(0.5) > 0.5 * 1.0 / (4 * 0.15 * 0.075) - 0.5


def test_a_polygon_that_is_not_convex():
    discs = Discs(stage(), ring(3), U_SHAPE).run(120)
    assert discs.behaviour.done
    assert discs.covered[-1] > 0.98


def test_done_robots_hold_their_places():
    discs = Discs(stage(), line(2)).run(120)
    states = discs.present()
    for wish in discs.behaviour.step(discs.t, states, None):
        assert math.dist(wish.xy, states[wish.robot].xy) < 0.011
    nudged = {name: (x, y + 0.02) for name, (x, y) in discs.places.items()}
    held = discs.behaviour.step(discs.t + DT, states_of(discs.t + DT, nudged), None)
    assert all(math.dist(wish.xy, discs.places[wish.robot]) < 1e-6 for wish in held)


def test_the_lanes_of_a_robot_that_drops_out_are_swept_by_others():
    discs = without_one()
    assert discs.behaviour.done
    assert discs.covered[-1] > 0.985


def test_one_that_comes_back_takes_part_again():
    discs = Discs(stage(), line(4), away=lambda name, t: name == "r1" and 6.0 < t < 12.0)
    discs.run(12.1)
    was = discs.places["r1"]
    discs.run(120)
    assert discs.behaviour.done
    assert discs.covered[-1] > 0.985
    assert math.dist(was, discs.places["r1"]) > 0.1
    assert discs.t < without_one().t


def test_a_short_absence_changes_nothing_but_time():
    discs = Discs(stage(), line(4), away=lambda name, t: name == "r1" and 6.0 < t < 8.0).run(120)
    assert discs.covered[-1] > 0.985
    assert discs.t < swept(line, 4).t + 2.1


def test_all_gone_is_not_done_and_a_stranger_can_finish():
    discs = Discs(stage(), line(2), away=lambda name, t: t > 3.0).run(20)
    assert not discs.behaviour.done
    discs.places = {"new": (0.5, 0.5)}
    discs.away = lambda name, t: False
    discs.run(200)
    assert discs.behaviour.done
    assert discs.covered[-1] > 0.98


def test_without_robots_it_waits_for_one():
    discs = Discs(stage(), {})
    assert discs.behaviour.step(0.0, {}, None) == []
    assert not discs.behaviour.done
    discs.places = {"late": (0.5, 0.5)}
    discs.run(200)
    assert discs.behaviour.done
    assert discs.covered[-1] > 0.985


def test_a_robot_that_is_held_up_leaves_its_lane_for_later():
    """A robot that never moves gives up lane by lane; what it leaves, the other sweeps."""
    discs = Discs(stage(), line(2))
    drive = discs.drive
    discs.drive = lambda wish: drive(wish) if wish.robot == "r0" else None
    discs.run(300)
    assert discs.behaviour.done
    assert discs.covered[-1] > 0.985


def test_what_nobody_can_reach_is_left_in_the_end():
    """A stone on the sheet that stops every robot before it: the rest is swept all the same."""
    discs = Discs(stage(), line(2))
    stone, drive = (0.3, 0.3), discs.drive

    def halting(wish):
        before = discs.places[wish.robot]
        drive(wish)
        if math.dist(discs.places[wish.robot], stone) < 0.05:
            discs.places[wish.robot] = before

    discs.drive = halting
    discs.run(400)
    assert discs.behaviour.done
    assert discs.covered[-1] > 0.9


def test_two_runs_are_equal():
    one, other = (Discs(stage(), ring(5)).run(5.0) for _ in range(2))
    assert one.places == other.places


def test_neighbours_keep_their_distance_once_they_sweep():
    discs = Discs(stage(), ring(4)).run(4.0)
    gaps = []
    while not discs.behaviour.done:
        discs.run(discs.t + DT / 2)
        places = np.array(list(discs.places.values()))
        gaps.append(min(math.dist(a, b) for i, a in enumerate(places) for b in places[:i]))
    assert min(gaps) > discs.stage.spacing


@settings(max_examples=12, derandomize=True, deadline=None)
@given(
    st.integers(1, 5),
    st.integers(0, 10_000),
    st.lists(st.tuples(st.floats(0, 20), st.floats(0, 10)), max_size=3),
)
def test_nothing_is_forgotten_whoever_comes_and_goes(count, seed, gaps):
    """Robots anywhere, some away for a while: in the end all is swept, and each wish lies inside the sheet."""
    rng = np.random.default_rng(seed)
    starts = {f"r{i}": rng.uniform(0.05, 0.55, 2) for i in range(count)}
    absent = {f"r{i % count}": (begin, begin + length) for i, (begin, length) in enumerate(gaps)}
    away = lambda name, t: name in absent and absent[name][0] <= t < absent[name][1]  # noqa: E731
    area = [(0.1, 0.1), (0.6, 0.1), (0.6, 0.25), (0.3, 0.25), (0.3, 0.6), (0.1, 0.6)]
    discs = Discs(stage(), starts, area, away).run(120)
    assert discs.behaviour.done
    assert discs.covered[-1] > 0.975


def test_what_cannot_be_swept_is_refused():
    with pytest.raises(ConfigError, match="crosses itself"):
        Sweep(stage(), {}, [(0.1, 0.1), (0.9, 0.9), (0.9, 0.1), (0.1, 0.9)])
