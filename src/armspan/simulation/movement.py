"""Minimum-jerk movements that may overlap.

A hand that is sent elsewhere on its way does not stop first: the new movement is added to what is left of
the old one (Flash and Henis 1991, superposed submovements). Each one starts and ends with zero velocity and
acceleration, so the sum is twice continuously differentiable whenever it is replanned.
"""

import numpy as np

from armspan.frames import Array


def minimum_jerk(share: Array) -> Array:
    """The share of the way that is done, 0 to 1, at a ``share`` of the time (Flash and Hogan 1985, eq. 3)."""
    s = np.minimum(np.maximum(share, 0.0), 1.0)
    return np.asarray(s * s * s * (10.0 + s * (6.0 * s - 15.0)))


class Movements:
    """A point (d,) that is moved by overlapping minimum-jerk steps."""

    def __init__(self, origin: Array) -> None:
        self.goal: Array = np.array(origin, dtype=float)
        self._origin: Array = self.goal.copy()
        self._starts: Array = np.empty(0)
        self._durations: Array = np.empty(0)
        self._steps: Array = np.empty((len(self.goal), 0))

    def move(self, step: Array, start: float, duration: float) -> None:
        """Add a ``step`` (d,) that takes ``duration`` [s] from ``start`` [s] on."""
        self.goal = self.goal + step
        self._starts = np.append(self._starts, start)
        self._durations = np.append(self._durations, duration)
        self._steps = np.column_stack([self._steps, step])

    def forget(self, before: float) -> None:
        """Fold the steps that were over ``before`` [s] into the origin: they are no longer told apart."""
        over = self._starts + self._durations <= before
        if not over.any():
            return
        self._origin = self._origin + self._steps[:, over].sum(axis=1)
        self._starts, self._durations = self._starts[~over], self._durations[~over]
        self._steps = self._steps[:, ~over]

    def at(self, times: Array) -> Array:
        """The point (d, m) at ``times`` (m,) [s]."""
        if not self._starts.size:
            return np.repeat(self._origin[:, None], len(times), axis=1)
        shares = (times - self._starts[:, None]) / self._durations[:, None]
        return np.asarray(self._origin[:, None] + self._steps @ minimum_jerk(shares))
