"""The way of one robot round others that stand still."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from armspan.frames import Array
from armspan.records import Sheet

CELL = 0.015
"""Width [m] of the grid on which a way is looked for."""

SLACK = 0.001
"""How much nearer [m] than its ends a step between two cells may pass: a chord cuts a corner by half of this."""


def nearest_pass(start: Array, end: Array, others: Array) -> Array:
    """Least distance (n,) [m] of each other (n, 2) to the segment from ``start`` to ``end`` (2,)."""
    way = end - start
    share = np.clip((others - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    return np.asarray(np.linalg.norm(start + share[:, None] * way - others, axis=1))


def is_free(start: Array, end: Array, others: Array, clear: float | Array) -> bool:
    """Whether a straight way keeps ``clear`` [m] of each other, or, where it begins nearer, comes no nearer."""
    if len(others) == 0:
        return True
    kept = np.minimum(clear, np.linalg.norm(others - start, axis=1))
    return bool((nearest_pass(start, end, others) >= kept - SLACK).all())


def next_point(start: Array, goal: Array, others: Array, sheet: Sheet, margin: float, clear: float) -> Array | None:
    """The farthest point (2,) [m] of the shortest way that can be reached straight, or None without a way.

    Ways are looked for on a grid, ``margin`` [m] inside the sheet, that keeps ``clear`` [m] of the others (n, 2), or
    as much as start and goal leave.
    """
    if len(others) == 0:
        return goal
    kept = np.minimum(clear, np.linalg.norm(others - goal, axis=1))
    if is_free(start, goal, others, kept):
        return goal
    xs = np.arange(margin, sheet.width_m - margin + 1e-9, CELL)
    ys = np.arange(margin, sheet.height_m - margin + 1e-9, CELL)
    cells = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1)
    kept = np.minimum(kept, np.linalg.norm(others - start, axis=1))
    free = np.asarray((np.linalg.norm(cells[:, :, None] - others, axis=-1) >= kept).all(axis=-1), dtype=bool)
    points = cells.reshape(-1, 2)
    last = _exit(goal, points, free.ravel(), others, kept)
    if last is None:
        return None
    length, before = dijkstra(_neighbours(free), indices=last, return_predecessors=True)
    at = _entry(start, points, length, others, kept)
    reached = None
    while at is not None and is_free(start, points[at], others, kept):
        reached = points[at]
        at = int(before[at]) if before[at] >= 0 else None
    return reached


def _entry(start: Array, points: Array, length: Array, others: Array, kept: Array) -> int | None:
    """The cell near ``start`` from which the way (lengths in cells) is shortest, among those in free sight."""
    away = np.linalg.norm(points - start, axis=1)
    near = np.flatnonzero((away < 6 * CELL) & np.isfinite(length))
    for cell in near[np.argsort(away[near] / CELL + length[near], kind="stable")]:
        if is_free(start, points[cell], others, kept):
            return int(cell)
    return None


def _exit(goal: Array, points: Array, free: NDArray[np.bool_], others: Array, kept: Array) -> int | None:
    """The free cell nearest to ``goal`` from which it is in free sight."""
    away = np.linalg.norm(points - goal, axis=1)
    near = np.flatnonzero((away < 6 * CELL) & free)
    for cell in near[np.argsort(away[near], kind="stable")]:
        if is_free(points[cell], goal, others, kept):
            return int(cell)
    return None


def _neighbours(free: NDArray[np.bool_]) -> coo_array:
    """Steps between free cells (w, h), straight and slanting, with their lengths."""
    number = np.arange(free.size).reshape(free.shape)
    rows, columns, lengths = [], [], []
    for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
        here = (slice(None, -dx or None), slice(max(0, -dy), -dy if dy > 0 else None))
        there = (slice(dx, None), slice(max(0, dy), dy if dy < 0 else None))
        both = free[here] & free[there]
        rows.append(number[here][both])
        columns.append(number[there][both])
        lengths.append(np.full(int(both.sum()), float(np.hypot(dx, dy))))
    edges = (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns)))
    graph = coo_array(edges, shape=(free.size, free.size))
    return graph + graph.T
