"""What one wrist's band told, and the same on the uniform clock of a take."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from armspan.conductor.wrist import WRIST, Row
from armspan.frames import Array

RATE = 100.0
"""Samples a second of a recorded take [Hz]."""

BRIDGED = 0.1
"""Longest gap [s] between two samples that a straight line bridges; cells in a longer one stay empty."""

_QUATERNION = slice(0, 4)


@dataclass(slots=True)
class Trace:
    """The rows of one wrist, in order of time."""

    times: list[float] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)

    def push(self, t: float, row: Row) -> None:
        """Take a row; one that is not later than the last is passed over."""
        if not self.times or t > self.times[-1]:
            self.times.append(t)
            self.rows.append(row)

    def forget(self, before: float) -> None:
        """Drop what is older than ``before`` [s]."""
        count = bisect_left(self.times, before)
        del self.times[:count], self.rows[:count]

    def silence(self, start: float, end: float) -> float:
        """The longest time [s] without a sample from ``start`` to ``end`` [s]."""
        heard = self.times[bisect_left(self.times, start) : bisect_right(self.times, end)]
        return float(np.max(np.diff([start, *heard, end])))

    def on(self, grid: Array) -> Array:
        """The rows at the times of ``grid`` (n,) [s]: (n, 10), on straight lines, NaN in gaps.

        Quaternions are interpolated on the shorter way and normalised, with w >= 0 again.
        """
        first = max(0, bisect_left(self.times, float(grid[0])) - 1)
        last = bisect_right(self.times, float(grid[-1])) + 1
        times, rows = np.array(self.times[first:last]), np.array(self.rows[first:last])
        if len(times) < 2:
            return np.full((len(grid), len(WRIST)), np.nan)
        rows[:, _QUATERNION] = _on_one_side(rows[:, _QUATERNION])
        values = np.stack([np.interp(grid, times, column) for column in rows.T], axis=1)
        q = values[:, _QUATERNION]
        q *= np.where(q[:, 3:] < 0, -1.0, 1.0) / np.linalg.norm(q, axis=1, keepdims=True)
        values[np.logical_not(_bridged(grid, times))] = np.nan
        return values


def _on_one_side(quaternions: Array) -> Array:
    """The same attitudes (n, 4), each quaternion with the sign that is nearer to the one before."""
    turned = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0
    signs = np.concatenate([[1.0], np.where(turned, -1.0, 1.0)]).cumprod()
    return np.asarray(quaternions * signs[:, None])


def _bridged(grid: Array, times: Array) -> NDArray[np.bool_]:
    """Which times of ``grid`` lie on a sample, or between two that are near each other."""
    after = np.searchsorted(times, grid, side="left").clip(1, len(times) - 1)
    inside = (grid >= times[0]) & (grid <= times[-1])
    near = times[after] - times[after - 1] <= BRIDGED + 1e-9
    at_sample = (np.abs(grid - times[after]) < 1e-9) | (np.abs(grid - times[after - 1]) < 1e-9)
    return np.asarray(inside & (near | at_sample))
