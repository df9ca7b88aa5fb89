"""Reciprocal avoidance: which velocities keep a robot clear of its neighbours for the next while.

Optimal reciprocal collision avoidance (van den Berg, Guy, Lin, Manocha, "Reciprocal n-body collision avoidance", ISRR
2009 / Springer 2011, sec. 4), for all pairs of neighbours at once.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armspan.frames import Array

_EASE = 1e-9


@dataclass(frozen=True, slots=True)
class Pairs:
    """Neighbours: robot ``first`` (p,) sees ``second`` (p,); every pair of two movers is there both ways round."""

    first: NDArray[np.intp]
    second: NDArray[np.intp]


def avoidance_lines(
    at: Array,
    velocity: Array,
    expected: Array,
    pairs: Pairs,
    reach: Array,
    share: Array,
    horizon: float,
    interval: float,
) -> tuple[Array, Array]:
    """For each pair the half-plane of velocities left to the first robot: ``normals @ v <= offsets``, (p, 2) and (p,).

    ``at`` and ``velocity`` are (n, 2) [m, m/s]; ``expected`` (p, 2) is the velocity at which the first robot of a pair
    must expect the second; ``reach`` (p,) is the distance of centres [m] to be kept, ``share``
    (p,) how much of the avoiding is the first robot's (a half where both do it, one where the other does nothing).
    Robots keep clear for ``horizon`` [s]; those that are too near already part within ``interval`` [s].
    """
    gap = at[pairs.second] - at[pairs.first]
    speed = velocity[pairs.first] - expected
    square = np.einsum("pi,pi->p", gap, gap)
    near = square <= reach**2
    time = np.where(near, interval, horizon)
    from_tip = speed - gap / time[:, None]
    tip_square = np.einsum("pi,pi->p", from_tip, from_tip)
    inward = np.einsum("pi,pi->p", from_tip, gap)
    on_cap = near | ((inward < 0) & (inward**2 > reach**2 * tip_square))
    cap_normal, cap_change = _from_cap(from_tip, np.sqrt(tip_square), reach / time, gap)
    leg_normal, leg_change = _from_leg(gap, square, speed, reach)
    normal = np.where(on_cap[:, None], cap_normal, leg_normal)
    change = np.where(on_cap[:, None], cap_change, leg_change)
    allowed = velocity[pairs.first] + share[:, None] * change
    return -normal, -np.einsum("pi,pi->p", normal, allowed)


def _from_cap(from_tip: Array, length: Array, radius: Array, gap: Array) -> tuple[Array, Array]:
    """The way out of the round end of the velocity obstacle: its direction, and the change of velocity."""
    away = np.where((length > _EASE)[:, None], from_tip, -gap + _EASE)
    normal = away / np.maximum(np.hypot(away[:, 0], away[:, 1]), _EASE)[:, None]
    return normal, normal * (radius - length)[:, None]


def _from_leg(gap: Array, square: Array, speed: Array, reach: Array) -> tuple[Array, Array]:
    """The way out over the nearer of the two straight sides."""
    leg = np.sqrt(np.maximum(square - reach**2, 0.0))
    left = gap[:, 0] * speed[:, 1] - gap[:, 1] * speed[:, 0] > 0
    side = np.where(left, 1.0, -1.0)
    x = gap[:, 0] * leg - side * gap[:, 1] * reach
    y = side * gap[:, 0] * reach + gap[:, 1] * leg
    along = np.stack([x, y], axis=1) / np.maximum(square, _EASE)[:, None]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) * side[:, None]
    return normal, normal * (-np.einsum("pi,pi->p", normal, speed))[:, None]
