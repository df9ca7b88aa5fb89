"""How moving robots pass each other: reciprocal avoidance, a rule of the road, and dice against deadlock.

Reciprocal avoidance alone locks up where a crowd is symmetric. So robots that meet keep to one side, as in a
roundabout, and one that gets no nearer to its goal goes somewhere else for a moment.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from armspan.frames import Array
from armspan.swarm.halfplanes import least_broken
from armspan.swarm.orca import Pairs, avoidance_lines

HORIZON = 1.0
"""Seconds for which velocities are to be free of collisions."""

NEIGHBOURS = 10
"""The nearest neighbours that count, as in RVO2."""

ASIDE = 0.5
"""Angle [rad] by which a robot turns aside (clockwise from above) for one that comes towards it."""

YIELD = 0.8
"""How much of the avoiding is left to a robot that stands at its goal, by one that is still on its way."""

PATIENCE = 1.5
_PROGRESS = 0.02
_THERE = 0.05
_HOME = 0.03
_PART = 0.3


@dataclass(slots=True)
class Crowd:
    """The robots at one moment: (n, 2) places [m], velocities [m/s] and goals [m]; (n,) top speeds [m/s].

    ``heard`` (n,) [s] is when each was there, ``moving`` (n,) are those that get a new goal now, ``steady`` (n,) those
    whose goal is a place and not a velocity.
    """

    at: Array
    heard: Array
    velocity: Array
    goal: Array
    speed: Array
    moving: NDArray[np.bool_]
    steady: NDArray[np.bool_]


@dataclass(slots=True)
class _Progress:
    """What is remembered of each robot's way to its goal."""

    goal: Array = field(default_factory=lambda: np.full((0, 2), np.inf))
    best: Array = field(default_factory=lambda: np.zeros(0))
    since: Array = field(default_factory=lambda: np.zeros(0))
    tries: Array = field(default_factory=lambda: np.zeros(0))
    until: Array = field(default_factory=lambda: np.zeros(0))
    detour: Array = field(default_factory=lambda: np.zeros((0, 2)))

    def grow(self, n: int) -> None:
        """Make room for n robots."""
        more = n - len(self.best)
        if more > 0:
            self.goal = np.vstack([self.goal, np.full((more, 2), np.inf)])
            self.best, self.since = np.append(self.best, np.full(more, np.inf)), np.append(self.since, np.zeros(more))
            self.tries, self.until = (
                np.append(self.tries, np.zeros(more)),
                np.append(self.until, np.full(more, -np.inf)),
            )
            self.detour = np.vstack([self.detour, np.zeros((more, 2))])


class Avoidance:
    """Chooses velocities that bring robots to their goals past each other.

    ``reach`` [m] is the distance that two centres should keep, ``bounds`` the lowest and highest place (2,) [m].
    """

    def __init__(self, reach: float, bounds: tuple[Array, Array], rng: np.random.Generator) -> None:
        self.reach, self._bounds, self._rng = reach, bounds, rng
        self._progress = _Progress()

    def choose(self, t: float, rows: NDArray[np.intp], crowd: Crowd, pairs: NDArray[np.intp], step: float) -> Array:
        """Velocities (n, 2) [m/s] for the moving robots; ``pairs`` (p, 2) are all neighbours, each once.

        ``rows`` (n,) are the robots' lasting numbers, ``step`` [s] is how often this is asked.
        """
        way = crowd.goal - crowd.at
        away = np.hypot(way[:, 0], way[:, 1])
        wished = way * (np.minimum(crowd.speed, away / step) / np.maximum(away, 1e-9))[:, None]
        detour = self._detours(t, rows, crowd, away)
        pairs_ = Pairs(np.concatenate([pairs[:, 0], pairs[:, 1]]), np.concatenate([pairs[:, 1], pairs[:, 0]]))
        turned = self._keep_aside(crowd, wished, away, pairs_)
        wished = np.where(np.isnan(detour), turned, detour * crowd.speed[:, None])
        return self._avoid(crowd, wished, pairs_, away < _HOME, step)

    def _detours(self, t: float, rows: NDArray[np.intp], crowd: Crowd, away: Array) -> Array:
        """A random direction (n, 2) for each robot that has got no nearer for a while, nan for the others."""
        memory = self._progress
        memory.grow(int(rows.max(initial=-1)) + 1)
        moved = np.abs(memory.goal[rows] - crowd.goal).max(axis=1) > 2 * _PROGRESS
        nearer = away < memory.best[rows] - _PROGRESS
        fresh = moved | nearer | (away < _THERE) | ~crowd.moving | ~crowd.steady
        memory.goal[rows] = np.where(fresh[:, None], crowd.goal, memory.goal[rows])
        memory.best[rows] = np.where(fresh, away, memory.best[rows])
        memory.since[rows] = np.where(fresh, t, memory.since[rows])
        memory.tries[rows] = np.where(fresh, 0.0, memory.tries[rows])
        waited = t - np.maximum(memory.since[rows], memory.until[rows])
        stuck = rows[(waited > PATIENCE * np.minimum(1.0 + 0.25 * memory.tries[rows], 6.0)) & ~fresh]
        if stuck.size:
            angle = self._rng.uniform(-np.pi, np.pi, stuck.size)
            memory.detour[stuck] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
            # The longer nothing helped, the farther away: out of a pocket between a wall and a robot, say.
            farther = np.minimum(1.0 + 0.5 * memory.tries[stuck], 5.0)
            memory.until[stuck] = t + self._rng.uniform(0.3, 1.2, stuck.size) * farther
            memory.tries[stuck] += 1.0
        on = (memory.until[rows] > t) & ~fresh
        return np.where(on[:, None], memory.detour[rows], np.nan)

    def _keep_aside(self, crowd: Crowd, wished: Array, away: Array, pairs: Pairs) -> Array:
        """The wished velocities, turned aside where another one comes from ahead."""
        gap = crowd.at[pairs.second] - crowd.at[pairs.first]
        distance = np.hypot(gap[:, 0], gap[:, 1])
        speed = np.hypot(wished[:, 0], wished[:, 1])[pairs.first]
        ahead = np.einsum("pi,pi->p", gap, wished[pairs.first]) > 0.5 * distance * speed
        closing = np.einsum("pi,pi->p", gap, wished[pairs.second] - wished[pairs.first]) < 0
        near = (distance < self.reach + 0.3) & (distance < 1.4 * away[pairs.first])
        meets = np.zeros(len(wished), dtype=bool)
        meets[pairs.first[ahead & closing & near]] = True
        c, s = np.cos(ASIDE), np.sin(ASIDE)
        turned: Array = wished @ np.array([[c, s], [-s, c]])
        return np.where(meets[:, None], turned, wished)

    def _avoid(self, crowd: Crowd, wished: Array, pairs: Pairs, home: NDArray[np.bool_], step: float) -> Array:
        """The velocities nearest to the wished ones that avoid the neighbours; who is at home gives way."""
        n = len(wished)
        gap = crowd.at[pairs.second] - crowd.at[pairs.first]
        order = np.lexsort((np.einsum("pi,pi->p", gap, gap), pairs.first))
        order = order[crowd.moving[pairs.first[order]]]
        rank = ranks(pairs.first[order], n)
        order, rank = order[rank < NEIGHBOURS], rank[rank < NEIGHBOURS]
        seen = Pairs(pairs.first[order], pairs.second[order])
        share = np.where(crowd.moving[seen.second], 0.5, 1.0)
        yields = home[seen.first] & ~home[seen.second] & crowd.moving[seen.second]
        passes = home[seen.second] & ~home[seen.first] & crowd.moving[seen.second]
        share = np.where(yields, YIELD, np.where(passes, 1.0 - YIELD, share))
        expected = np.where(yields[:, None], wished[seen.second], crowd.velocity[seen.second])
        reach = np.full(len(order), self.reach)
        normal, offset = avoidance_lines(crowd.at, crowd.velocity, expected, seen, reach, share, HORIZON, _PART)
        walls, room = wall_lines(crowd.at, self._bounds)
        normals, offsets = table(n, seen.first, rank, normal, offset)
        normals, offsets = (
            np.concatenate([walls, normals], axis=1),
            np.concatenate([np.maximum(room, 0.0) / step, offsets], axis=1),
        )
        return least_broken(wished, normals, offsets, crowd.speed, 4)


def neighbours(at: Array, reach: float) -> NDArray[np.intp]:
    """All pairs (p, 2) of places (n, 2) nearer than ``reach`` [m], each once."""
    pairs: NDArray[np.intp] = cKDTree(at).query_pairs(reach, output_type="ndarray")
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def wall_lines(at: Array, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
    """The four sides of the sheet as half-planes from each place: (n, 4, 2), and the room (n, 4) [m] to each.

    Less than none where a robot is too near to a side, or beyond.
    """
    low, high = bounds
    normals = np.tile(np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]), (len(at), 1, 1))
    room = np.stack([high[0] - at[:, 0], at[:, 0] - low[0], high[1] - at[:, 1], at[:, 1] - low[1]], axis=1)
    return normals, room


def ranks(owner: NDArray[np.intp], n: int) -> NDArray[np.intp]:
    """The place of each entry among those of its owner (sorted, 0 to n - 1)."""
    count = np.bincount(owner, minlength=n)
    return np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)


def table(n: int, owner: NDArray[np.intp], rank: NDArray[np.intp], normal: Array, offset: Array) -> tuple[Array, Array]:
    """Lines (p, 2), (p,) put together by their owners: (n, k, 2) and (n, k), inf where there is none."""
    width = int(rank.max(initial=-1)) + 1
    normals, offsets = np.zeros((n, width, 2)), np.full((n, width), np.inf)
    normals[:, :, 0] = 1.0
    normals[owner, rank], offsets[owner, rank] = normal, offset
    return normals, offsets
