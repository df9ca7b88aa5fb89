"""Discs that cannot overlap: who touches whom, pushed apart and slowed down."""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from armspan.frames import Array

Mask: TypeAlias = NDArray[np.bool_]
Pair: TypeAlias = tuple[int, int]

SKIN = 0.04  # [m] how much farther than touching a pair is watched, so that the search is rare
APART = 0.001  # [m] a contact lasts until the discs are this far apart
OVERLAP = 0.0001  # [m] what is left of an overlap
SWEEPS = 8


class Discs:
    """n discs of one radius [m] on a plane; ``contacts`` counts the pairs that came to touch.

    ``stride`` is the farthest that a disc moves between two calls [m].
    """

    def __init__(self, radius: float, stride: float) -> None:
        self.contacts = 0
        self._reach = 2 * radius
        self._every = max(1, int(SKIN / (4 * stride)))  # both of a pair move, and may be pushed as far again
        self._wait = 0
        self._watched: NDArray[np.intp] = np.zeros((2, 0), dtype=np.intp)
        self._touching: set[Pair] = set()

    def part(self, xy: Array, velocity: Array, solid: Mask) -> None:
        """Push overlapping discs apart and take away the speed at which they approach; in place.

        ``xy`` and ``velocity`` are (2, n) [m, m/s]; ``solid`` (n,) is False for a disc that is lifted.
        """
        if self._wait == 0:
            tree = cKDTree(xy.T)
            self._watched = tree.query_pairs(self._reach + SKIN, output_type="ndarray").T
            self._wait = self._every
        self._wait -= 1
        if self._watched.size:
            self._touch(self._near(xy, solid), xy, velocity)

    def disturb(self) -> None:
        """A disc was put elsewhere: look at all pairs anew."""
        self._wait = 0

    def _near(self, xy: Array, solid: Mask) -> list[Pair]:
        a, b = self._watched
        gap = xy[:, a] - xy[:, b]
        near = np.hypot(gap[0], gap[1]) < self._reach + APART
        if not near.any():
            return []
        near &= solid[a] & solid[b]
        return list(zip(a[near].tolist(), b[near].tolist(), strict=True))

    def _touch(self, near: list[Pair], xy: Array, velocity: Array) -> None:
        touching = set(near)
        self.contacts += len(touching - self._touching)
        self._touching = touching
        if near:
            x, y = xy.tolist()
            velocity[:] = _slowed(near, self._reach, x, y, *velocity.tolist())
            self._spread(near, x, y)
            xy[:] = x, y

    def _spread(self, near: list[Pair], x: list[float], y: list[float]) -> None:
        """Push each overlapping pair apart by halves, again and again, until little is left."""
        for _ in range(SWEEPS):
            worst = 0.0
            for a, b in near:
                dx, dy = x[a] - x[b], y[a] - y[b]
                distance = math.hypot(dx, dy)
                overlap = self._reach - distance
                if overlap > 0.0:
                    worst = max(worst, overlap)
                    ux, uy = (dx / distance, dy / distance) if distance > 0.0 else (1.0, 0.0)
                    x[a] += ux * overlap / 2
                    y[a] += uy * overlap / 2
                    x[b] -= ux * overlap / 2
                    y[b] -= uy * overlap / 2
            if worst < OVERLAP:
                return
        self.disturb()  # a crowd: others may have been pushed into reach


def _slowed(
    near: list[Pair], reach: float, x: list[float], y: list[float], vx: list[float], vy: list[float]
) -> tuple[list[float], list[float]]:
    """The velocities after every overlapping pair's approach is taken away: equal masses, no bounce."""
    for a, b in near:
        dx, dy = x[a] - x[b], y[a] - y[b]
        square = dx * dx + dy * dy
        approach = dx * (vx[a] - vx[b]) + dy * (vy[a] - vy[b])
        if approach < 0.0 and square < reach * reach:
            half = approach / square / 2
            vx[a], vy[a] = vx[a] - half * dx, vy[a] - half * dy
            vx[b], vy[b] = vx[b] + half * dx, vy[b] + half * dy
    return vx, vy
