"""What robots may still be driving to: every goal that has left, until it has surely been replaced."""

import numpy as np
from numpy.typing import NDArray

from armspan.frames import Array


class Courses:
    """The goals of n robots: ``velocity`` (n, 2) [m/s] is the one last wished for, ``until`` (n,) [s] its lease.

    ``kept`` goals are remembered for each.
    """

    def __init__(self, kept: int) -> None:
        self._kept = kept
        self.number: dict[str, int] = {}
        self._names: list[str] = []
        self.velocity: Array = np.zeros((0, 2))
        self.until: Array = np.zeros(0)
        self.sent: Array = np.zeros(0)
        self._goals: Array = np.zeros((0, self._kept, 2))
        self._ends: Array = np.zeros((0, self._kept))
        self._last: NDArray[np.intp] = np.zeros(0, dtype=np.intp)

    def know(self, names: list[str]) -> NDArray[np.intp]:
        """The rows of robots, new ones included."""
        fresh = [name for name in names if name not in self.number]
        if fresh:
            for name in fresh:
                self.number[name] = len(self.number)
            self._names += fresh
            more = len(fresh)
            self.velocity = np.vstack([self.velocity, np.zeros((more, 2))])
            self.until = np.append(self.until, np.full(more, -np.inf))
            self.sent = np.append(self.sent, np.full(more, -np.inf))
            self._goals = np.vstack([self._goals, np.zeros((more, self._kept, 2))])
            self._ends = np.vstack([self._ends, np.full((more, self._kept), -np.inf)])
            self._last = np.append(self._last, np.zeros(more, dtype=np.intp))
        return np.array([self.number[name] for name in names], dtype=np.intp)

    def lapsed(self, t: float) -> list[str]:
        """The robots whose lease has run out at ``t`` [s], those that have none left out."""
        rows = np.flatnonzero((self.until > -np.inf) & (self.until <= t + 1e-9))
        return [self._names[row] for row in rows]

    def ways(self, rows: NDArray[np.intp], at: Array, heard: Array) -> Array:
        """The points (n, 1 + kept, 2) [m] whose hull each robot stays in.

        ``at`` (n, 2) is where it was ``heard`` (n,) [s] last: only a robot that was heard after a goal's end has
        surely left it.
        """
        live = self._ends[rows] > heard[:, None]
        goals = np.where(live[:, :, None], self._goals[rows], at[:, None])
        return np.concatenate([at[:, None], goals], axis=1)

    def set_out(
        self, rows: NDArray[np.intp], goals: Array, velocity: Array, t: float, until: Array, keep: float
    ) -> None:
        """New goals (k, 2) [m] left at ``t`` [s]; the ones before may be driven to for ``keep`` [s] more."""
        self.velocity[rows], self.until[rows], self.sent[rows] = velocity, until, t
        last = self._last[rows]
        self._ends[rows, last] = np.minimum(self._ends[rows, last], t + keep)
        moved = np.abs(self._goals[rows, last] - goals).max(axis=1) > 0
        last = np.where(moved, (last + 1) % self._kept, last)
        self._last[rows] = last
        self._goals[rows, last] = goals
        self._ends[rows, last] = np.inf

    def stop(self, rows: NDArray[np.intp], end: float) -> None:
        """Robots were told to stop: their goals end at ``end`` [s], when that has arrived if it ever does."""
        self.velocity[rows], self.until[rows] = 0.0, -np.inf
        self._ends[rows] = np.minimum(self._ends[rows], end)
