"""The nearest allowed point to a wished one, for many robots at once: half-planes and a disc.

The incremental algorithm for linear programs in the plane (de Berg et al., Computational Geometry, 3rd ed., ch. 4),
with the disc of van den Berg et al. 2011 ("Reciprocal n-body collision avoidance", sec. 5): one line after another, and
where a line is broken the new point lies on it. Rows are robots; all rows are worked on together.
"""

import numpy as np
from numpy.typing import NDArray

from armspan.frames import Array

_EASE = 1e-12


def nearest_allowed(wished: Array, normals: Array, offsets: Array, radius: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The points (n, 2) nearest to ``wished`` (n, 2) that keep ``normals @ x <= offsets`` and ``|x| <= radius``.

    ``normals`` (n, k, 2) are of length one, ``offsets`` (n, k) may be inf for a line that is not there, ``radius`` is
    (n,). The second result (n,) tells where there is such a point; elsewhere the first is of no use.
    """
    x = _within(wished, radius)
    possible = np.ones(len(x), dtype=bool)
    for k in range(offsets.shape[1]):
        broken = np.einsum("ni,ni->n", normals[:, k], x) > offsets[:, k] + 1e-10
        rows = np.flatnonzero(broken & possible)
        if rows.size:
            x[rows], possible[rows] = _on_line(
                wished[rows], normals[rows, : k + 1], offsets[rows, : k + 1], radius[rows]
            )
    return x, possible


def least_broken(wished: Array, normals: Array, offsets: Array, radius: Array, hard: int) -> Array:
    """As `nearest_allowed`, where need be with the lines after the first ``hard`` ones shifted by what it takes.

    The origin must be allowed by the hard lines.
    """
    x, possible = nearest_allowed(wished, normals, offsets, radius)
    rows = np.flatnonzero(~possible)
    if not rows.size:
        return x
    soft = np.arange(offsets.shape[1]) >= hard
    some = (wished[rows], normals[rows], radius[rows])
    low = np.zeros(rows.size)
    high = np.maximum(-np.where(np.isfinite(offsets[rows]) & soft, offsets[rows], 0.0).min(axis=1), 0.0)
    for _ in range(12):
        shift = (low + high) / 2
        _, fits = nearest_allowed(some[0], some[1], offsets[rows] + shift[:, None] * soft, some[2])
        high, low = np.where(fits, shift, high), np.where(fits, low, shift)
    shifted, fits = nearest_allowed(some[0], some[1], offsets[rows] + (high + 1e-9)[:, None] * soft, some[2])
    x[rows] = np.where(fits[:, None], shifted, 0.0)
    return x


def _within(x: Array, radius: Array) -> Array:
    length = np.hypot(x[:, 0], x[:, 1])
    shortened: Array = x * np.minimum(1.0, radius / np.maximum(length, _EASE))[:, None]
    return shortened


def _on_line(wished: Array, normals: Array, offsets: Array, radius: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The point of the last line that is nearest to ``wished`` and keeps the lines before it."""
    normal, offset = normals[:, -1], offsets[:, -1]
    along = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    foot = normal * offset[:, None]
    half = np.sqrt(np.maximum(radius**2 - offset**2, 0.0))
    slope = np.einsum("nki,ni->nk", normals[:, :-1], along)
    room = offsets[:, :-1] - np.einsum("nki,ni->nk", normals[:, :-1], foot)
    level = np.abs(slope) < 1e-9
    at = room / np.where(level, 1.0, slope)
    high = np.minimum(half, np.where(~level & (slope > 0), at, np.inf).min(axis=1, initial=np.inf))
    low = np.maximum(-half, np.where(~level & (slope < 0), at, -np.inf).max(axis=1, initial=-np.inf))
    possible = (low <= high) & (np.abs(offset) <= radius) & ~(level & (room < -1e-10)).any(axis=1)
    share = np.clip(np.einsum("ni,ni->n", along, wished), low, np.maximum(high, low))
    return foot + along * share[:, None], possible
