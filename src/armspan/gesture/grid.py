"""Samples with their own clocks onto one grid: bridged, averaged over each cell, gaps kept as NaN.

Grid point k lies at k / rate seconds and stands for the cell before it. A cell's value is the mean of the straight
line through the samples, which does not alias when the samples come faster than the grid, and never looks ahead of
the first sample at or after the grid point.
"""

import numpy as np

from armspan.frames import Array
from armspan.gesture.takes import GAP


def bridge(times: Array, values: Array, longest: float = GAP) -> Array:
    """``values`` (n, c) with gaps of up to ``longest`` seconds filled by straight lines, column by column."""
    filled = values.copy()
    for column in filled.T:
        there = np.isfinite(column)
        if there.all() or not there.any():
            continue
        known = times[there]
        after = np.searchsorted(known, times)
        left, right = known[np.maximum(after - 1, 0)], known[np.minimum(after, len(known) - 1)]
        near = ~there & (right - left <= longest) & (np.minimum(abs(times - left), abs(right - times)) <= longest)
        column[near] = np.interp(times[near], known, column[there])
    return filled


def cells(rate: float, start: float, end: float) -> tuple[int, int]:
    """First and one past the last grid point whose cell lies within ``start`` to ``end`` [s]."""
    first = int(np.ceil(start * rate - 1e-6)) + 1
    return first, max(first, int(np.floor(end * rate + 1e-6)) + 1)


def on_grid(times: Array, values: Array, rate: float, first: int, last: int, longest: float = GAP) -> Array:
    """Cell means (last - first, c) of ``values`` (n, c) at rising ``times`` (n,) for grid points ``first`` .. ``last``.

    A cell that a gap of more than ``longest`` seconds reaches into, or that lies outside the samples, is NaN.
    """
    edges = (np.arange(first - 1, last) / rate).astype(float)
    if len(times) < 2 or last <= first:
        return np.full((max(0, last - first), values.shape[1]), np.nan)
    steps = np.diff(times)
    areas = np.concatenate(
        [np.zeros((1, values.shape[1])), np.cumsum((values[1:] + values[:-1]) / 2 * steps[:, None], 0)]
    )
    at = np.clip(np.searchsorted(times, edges, side="right") - 1, 0, len(times) - 2)
    into = np.clip(edges - times[at], 0.0, steps[at])
    slope = (values[at + 1] - values[at]) / steps[at][:, None]
    upto = areas[at] + into[:, None] * (values[at] + slope * into[:, None] / 2)
    means = np.diff(upto, axis=0) * rate
    wide = np.concatenate([[0], np.cumsum(steps > longest)])
    after = np.clip(np.searchsorted(times, edges, side="left"), 0, len(times) - 1)
    gap = wide[after[1:]] - wide[at[:-1]] > 0
    outside = (edges[:-1] < times[0] - 1e-9) | (edges[1:] > times[-1] + 1e-9)
    means[gap | outside] = np.nan
    return np.asarray(means)


def stretched(times: Array, values: Array, length: int) -> Array:
    """``values`` (n, c) brought to ``length`` points over the whole of their time: (length, c).

    Where there are more than one and a half samples a point they are averaged, else interpolated; samples that lie on
    the points already are left as they are.
    """
    points = np.linspace(times[0], times[-1], length)
    if len(times) <= 1.5 * length:
        return np.stack([np.interp(points, times, column) for column in values.T], axis=1)
    cell = (times[-1] - times[0]) / length
    return on_grid(times - times[0], values, 1.0 / cell, 1, length + 1, np.inf)
