"""Robots that do at once what they are told, for tests of what they are told: each drives straight to its wish."""

import math

import numpy as np
import shapely
from scipy.spatial.distance import pdist

from armspan.records import RobotState, Sheet, Zone
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.limits import Limits

DT = 0.05
"""A tick [s]."""


def square(name, x, y, half=0.05):
    """A square zone about a place [m]."""
    return Zone(name, ((x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)))


def stage(width=1.0, height=1.0, limits=None, zones=(), user=None):
    """A sheet of a square metre, and where centres stay 45 mm from its edge; slots are 0.123 m apart at least."""
    return Stage(Sheet(width, height), limits or Limits(), np.random.default_rng(0), tuple(zones), user)


def standing(places, t=0.0):
    """Robots a, b, c ... at places, by name."""
    return {chr(97 + i): RobotState(t, chr(97 + i), (float(x), float(y)), 0.0) for i, (x, y) in enumerate(places)}


def moved(states, wishes, speeds=None, apart=0.0):
    """Ideal robots one tick later: each straight toward its wish at its speed, through others if need be.

    Where they are to stay ``apart`` [m], one that would come nearer than that to another, nearer than it is, waits.
    """
    new = dict(states)
    for wish in wishes:
        (x, y), (goal_x, goal_y) = new[wish.robot].xy, wish.xy
        reach = min(wish.speed, (speeds or {}).get(wish.robot, math.inf)) * DT
        share = min(1.0, reach / max(math.hypot(goal_x - x, goal_y - y), 1e-12))
        next_xy = (x + share * (goal_x - x), y + share * (goal_y - y))
        others = [state.xy for name, state in new.items() if name != wish.robot] if apart else []
        waits = any(math.dist(next_xy, other) < min(apart, math.dist((x, y), other)) for other in others)
        new[wish.robot] = RobotState(wish.t, wish.robot, (x, y) if waits else next_xy, 0.0)
    return new


def run(behaviour, states, seconds=20.0, pointed=None, speeds=None):
    """The states at each tick until the behaviour is done or the time is over; ``pointed`` may depend on time."""
    trace = [states]
    for tick in range(round(seconds / DT)):
        spot = pointed(tick * DT) if callable(pointed) else pointed
        wishes = behaviour.step(tick * DT, trace[-1], spot)
        if behaviour.done:
            break
        trace.append(moved(trace[-1], wishes, speeds))
    return trace


def xy(states):
    """Where robots are (n, 2) [m], in the order of their names."""
    return np.array([states[name].xy for name in sorted(states)])


def least(points):
    """The distance [m] between the two nearest of points; infinite for fewer than two."""
    return float(pdist(np.asarray(points, dtype=float)).min()) if len(points) > 1 else math.inf


class Raster:
    """Cells of ``side`` [m] of a square metre, or of an area (corners) on it, and which of them discs came over."""

    def __init__(self, side, area=None):
        self.side, self.line = side, np.arange(side / 2, 1.0, side)
        x, y = np.meshgrid(self.line, self.line)
        self.left = np.ones(x.shape, bool) if area is None else shapely.contains_xy(shapely.Polygon(area), x, y)
        self.cells = int(self.left.sum())

    def cover(self, x, y, radius):
        """A disc stands at a place: cells whose middle is under it are covered."""
        rows, columns = (self._near(middle, radius) for middle in (y, x))
        away = (self.line[rows, None] - y) ** 2 + (self.line[columns] - x) ** 2
        self.left[rows, columns] &= away > radius**2

    def _near(self, middle, radius):
        first, last = math.floor((middle - radius) / self.side), math.ceil((middle + radius) / self.side)
        return slice(max(0, first), max(0, last))

    @property
    def share(self):
        """The covered share of all cells."""
        return 1.0 - np.count_nonzero(self.left) / self.cells
