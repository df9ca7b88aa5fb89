"""The filter as a whole moves crowds: ideal discs that follow at once, and discs that follow late."""

from collections import deque

import numpy as np
import pytest

from armspan.records import GoTo, RobotState, Sheet
from armspan.swarm.limits import Limits
from armspan.swarm.safety import SafetyFilter

BEAT, FINE = 0.05, 0.01


def swap(n, radius, seed):
    """Places on a ring, each robot to go to the one across."""
    angle = 2 * np.pi * np.arange(n) / n + np.random.default_rng(seed).uniform(0, 6.28)
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return ring + radius + 0.06, radius + 0.06 - ring


def drive(start, goal, size, latency=0.0, seconds=60.0, still=()):
    """Drive discs by the filter until they are there: the time it took, and the least distance of centres seen."""
    limits, names = Limits(body_radius_m=0.0375, latency_s=latency), [f"r{k:02d}" for k in range(len(start))]
    safety = SafetyFilter(limits, Sheet(size, size), np.random.default_rng(1))
    at, target, speed = start.copy(), start.copy(), np.zeros(len(start))
    late, least = deque(), np.inf
    movers = [k for k in range(len(start)) if k not in still]
    for k in range(round(seconds / BEAT)):
        t = k * BEAT
        states = {name: RobotState(t, name, tuple(xy), 0.0) for name, xy in zip(names, at.tolist(), strict=True)}
        late.append(
            (t + latency, safety.admit(t, [GoTo(t, names[m], tuple(goal[m]), 0.15, t + 0.3) for m in movers], states))
        )
        for fine in range(round(BEAT / FINE)):
            while late and late[0][0] <= t + fine * FINE + 1e-9:
                for command in late.popleft()[1]:
                    row = names.index(command.robot)
                    target[row], speed[row] = command.xy, command.speed
            way = target - at
            length = np.hypot(*way.T)
            at = at + way * np.minimum(1.0, speed * FINE / np.maximum(length, 1e-12))[:, None]
            gaps = np.hypot(*np.moveaxis(at[:, None] - at, 2, 0)) + 9.0 * np.eye(len(at))
            least = min(least, gaps.min())
        if np.hypot(*(at - goal)[movers].T).max() < 0.008:
            return t, least
    return None, least


@pytest.mark.parametrize(("n", "radius"), [(2, 0.3), (4, 0.35), (8, 0.44), (12, 0.55)])
@pytest.mark.parametrize("latency", [0.0, 0.1])
def test_a_ring_of_robots_changes_sides(n, radius, latency):
    start, goal = swap(n, radius, seed=n)
    took, least = drive(start, goal, 2 * radius + 0.12, latency)
    assert took is not None
    assert took < 40
    assert least >= 2 * 0.0375 + 0.01 - 1e-6


def test_two_that_meet_keep_to_one_side():
    start = np.array([[0.1, 0.5], [0.9, 0.5]])
    took, least = drive(start, start[::-1], 1.0)
    assert took < 0.8 / 0.15 + 2.0
    assert least >= 0.085 - 1e-6


def test_one_gets_past_a_robot_that_stands_in_the_way_and_has_nothing_to_do():
    start = np.array([[0.1, 0.5], [0.5, 0.5]])
    took, least = drive(start, np.array([[0.9, 0.5], [0.5, 0.5]]), 1.0, still=(1,))
    assert took is not None
    assert least >= 0.085 - 1e-6


def test_robots_that_hold_their_places_let_another_through():
    wall = np.array([[0.5, y] for y in np.arange(0.05, 1.0, 0.1125)])
    start = np.vstack([[0.1, 0.5], wall])
    took, _ = drive(start, np.vstack([[0.9, 0.5], wall]), 1.0)
    assert took is not None
