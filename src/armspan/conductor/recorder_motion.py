"""When an arm moved: the gesture in a take, found against the take's own rest."""

import numpy as np

from armspan.frames import Array

MOVED = 0.6
"""Rate [rad/s] that a gesture exceeds somewhere; a hanging arm's sway stays well below."""

_FLOOR, _CEILING = 0.15, 0.5
_OVER_REST = 4.0
_SMOOTHED = 9
_BRIEF = 0.08


def arm_rates(values: Array) -> Array:
    """Smoothed rates [rad/s] of a wrist's rows (n, 10), (n,); zero in gaps."""
    rates = np.nan_to_num(np.linalg.norm(values[:, 7:10], axis=1))
    return np.convolve(rates, np.full(_SMOOTHED, 1.0 / _SMOOTHED), mode="same")


def gesture_span(times: Array, rates: Array, cue: float, earliest: float) -> tuple[float, float] | None:
    """Start and end [s] of the motion after ``earliest`` [s], or None where nothing moved.

    ``rates`` (n, wrists) [rad/s] at ``times`` (n,) [s]; before ``cue`` [s] the arms were at rest, and that tells the
    rate above which an arm moves. Stretches of motion that are brief or weak, such as fidgeting, do not count.
    """
    rest = rates[times < cue]
    usual = float(np.median(rest)) if len(rest) else 0.0
    level = float(np.clip(_OVER_REST * usual, _FLOOR, _CEILING))
    fastest = rates.max(axis=1)
    moving = (fastest > level) & (times >= earliest)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], moving, [False]]).astype(int)))
    strong = [
        (first, last - 1)
        for first, last in edges.reshape(-1, 2)
        if fastest[first:last].max() >= max(MOVED, 2 * level) and times[last - 1] - times[first] >= _BRIEF
    ]
    if not strong:
        return None
    return float(times[strong[0][0]]), float(times[strong[-1][1]])
