"""Who may go where: for each robot a convex cell that no other robot's way can enter.

A robot's *way* is the hull of where it was last heard and of every goal that it may still be driving to: the last one,
and those before it that a late or lost command has not replaced yet. Whatever happens to the link or to this program,
a robot that tracks position goals stays on its way. Between each two ways a line is drawn, as in buffered Voronoi
cells (Zhou, Wang, Bandyopadhyay, Schwager 2017, "Fast, on-line collision avoidance for dynamic vehicles using buffered
Voronoi cells", RA-L 2(2)), there for points; new goals keep to their own side of it. So ways that were apart stay
apart.
"""

import numpy as np

from armspan.frames import Array
from armspan.swarm.orca import Pairs

_ROUNDS = 8


def separate(first: Array, second: Array) -> tuple[Array, Array]:
    """The direction (p, 2) of the shortest way from each first hull to the second, and its length (p,) [m].

    ``first`` and ``second`` (p, k, 2) are points, some of which may be repeated. Where hulls overlap the length is
    negative or zero, and the direction no more than a guess (Gilbert, Johnson, Keerthi 1988, "A fast procedure for
    computing the distance between complex objects", in the plane: two corners of the difference are kept).
    """
    one = two = second.mean(axis=1) - first.mean(axis=1)
    best, direction = np.full(len(first), -np.inf), _unit(one)
    rows = np.arange(len(first))
    for _ in range(_ROUNDS):
        unit = _unit(_nearest_to_zero(one, two))
        along_a, along_b = np.einsum("pki,pi->pk", first, unit), np.einsum("pki,pi->pk", second, unit)
        i, j = along_a.argmax(axis=1), along_b.argmin(axis=1)
        apart = along_b[rows, j] - along_a[rows, i]
        better = apart > best
        best, direction = np.where(better, apart, best), np.where(better[:, None], unit, direction)
        corner = second[rows, j] - first[rows, i]
        sides = [(one, two), (one, corner), (two, corner)]
        lengths = np.stack([np.linalg.norm(_nearest_to_zero(*side), axis=1) for side in sides])
        keep = lengths.argmin(axis=0)[:, None]
        one, two = np.where(keep == 2, two, one), np.where(keep == 0, two, corner)
    return direction, best


def _nearest_to_zero(one: Array, two: Array) -> Array:
    """The point (p, 2) of each segment that is nearest to zero."""
    step = two - one
    share = -np.einsum("pi,pi->p", one, step) / np.maximum(np.einsum("pi,pi->p", step, step), 1e-18)
    nearest: Array = one + np.clip(share, 0.0, 1.0)[:, None] * step
    return nearest


def cell_lines(
    ways: Array, at: Array, wished: Array, moving: Array, pairs: Pairs, clear: float
) -> tuple[Array, Array, Array]:
    """The line between the two robots of each pair: ``normal`` (p, 2), and what it leaves to the first and the second.

    The first may have a new goal with ``normal @ (goal - at) <= ahead``, the second with ``-normal @ (goal - at) <=
    behind``, (p,) each. ``ways`` (n, k, 2) and ``at`` (n, 2) are in ``sheet`` [m]; ``wished`` (n, 2) are the wished
    goals from ``at``; ``moving`` (n,) is 1 for a robot that may get a new goal now and 0 for others. ``clear`` is the
    distance of ways to be kept [m]. What is free between two ways goes to the one that asks for it, in proportion
    where both do, and the rest to both. Where less than ``clear`` is left nobody comes nearer.
    """
    a, b = pairs.first, pairs.second
    normal, apart = separate(ways[a], ways[b])
    front = np.einsum("pki,pi->pk", ways[a] - at[a][:, None], normal).max(axis=1)
    back = np.einsum("pki,pi->pk", ways[b] - at[b][:, None], -normal).max(axis=1)
    free = np.maximum(apart - clear, 0.0)
    ask_a = np.maximum(np.einsum("pi,pi->p", wished[a], normal) - front, 0.0) * moving[a]
    ask_b = np.maximum(np.einsum("pi,pi->p", wished[b], -normal) - back, 0.0) * moving[b]
    asked = ask_a + ask_b
    given = free / np.maximum(np.maximum(asked, free), 1e-12)
    rest = np.maximum(free - asked, 0.0) / np.maximum(moving[a] + moving[b], 1.0)
    kept = apart >= clear
    # Ways that overlap have no line between them: there the places themselves must not come nearer.
    normal = np.where((apart > 0)[:, None], normal, _unit(at[b] - at[a]))
    ahead = np.where(kept, front + ask_a * given + rest * moving[a], 0.0)
    behind = np.where(kept, back + ask_b * given + rest * moving[b], 0.0)
    return normal, np.maximum(ahead, 0.0), np.maximum(behind, 0.0)


def _unit(vector: Array) -> Array:
    length = np.hypot(vector[:, 0], vector[:, 1])
    safe = np.where(length > 1e-12, length, 1.0)
    unit: Array = np.where((length > 1e-12)[:, None], vector / safe[:, None], np.array([1.0, 0.0]))
    return unit
