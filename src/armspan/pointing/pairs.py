"""Pairs: where the arm was while it pointed at a known point, one row for each thing that was learnt.

Samples of one stop share one human error, so a stop is one pair however long it lasted (Gromov et al. 2018
weigh every sample, which only makes the answer look surer than it is).
"""

from dataclasses import dataclass

import numpy as np

from armspan.errors import CalibrationError
from armspan.frames import Array
from armspan.pointing.rays import unit

STILL_M = 0.05
"""How far [m] the points of one stop may lie from their middle: a robot at rest is known to millimetres."""

LEVEL_M = 0.1
"""How far [m] points may lie above or below their middle and still be places on one sheet."""

DISTINCT_M = 0.01
"""Points nearer than this [m] are one place."""

CORRELATION_S = 3.0
"""Time [s] after which the error of an arm that follows a moving point is a new one: 1.5 to 5 s in three sessions of
Gromov et al. 2018 (integrated autocorrelation of the residuals)."""

LINE_SHARE = 0.03
"""Points whose spread across their line is below this share of their spread along it lie on one line."""


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Attitudes of the arm and the points pointed at, one row each.

    ``user_from_forearm`` and ``user_from_upperarm`` (one band: None) are (n, 3, 3), ``points`` (n, 3) [m] in
    ``sheet``, ``counts`` (n,) how many samples a row stands for. ``stops`` names the rows of still data;
    for moving data it is None. ``weights`` (n,) tell how many independent gestures a row is worth.
    """

    user_from_forearm: Array
    user_from_upperarm: Array | None
    points: Array
    counts: Array
    weights: Array
    stops: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Area:
    """Where the calibrated points lie: their ``centre`` (3,) [m] and scatter (2, 2) [m²] along the sheet."""

    centre: Array
    scatter: Array


def still_pairs(
    user_from_forearm: Array, user_from_upperarm: Array | None, points: Array, stops: tuple[str, ...]
) -> Pairs:
    """One pair for each stop, in the order they were made: the median attitude and the median point.

    The median leaves out the moment in which the arm still settles.

    Raises:
        CalibrationError: if the points of one stop lie apart.

    """
    names = tuple(dict.fromkeys(stops))
    rows = [[i for i, name in enumerate(stops) if name == wanted] for wanted in names]
    for name, row in zip(names, rows, strict=True):
        _check_still(name, points[row])
    return Pairs(
        _medians(user_from_forearm, rows),
        None if user_from_upperarm is None else _medians(user_from_upperarm, rows),
        np.stack([np.median(points[row], axis=0) for row in rows]),
        np.array([len(row) for row in rows], dtype=float),
        np.ones(len(rows)),
        names,
    )


def moving_pairs(user_from_forearm: Array, user_from_upperarm: Array | None, points: Array, times: Array) -> Pairs:
    """Pairs of an arm that follows a moving point, at ``times`` (n,) [s].

    Samples nearer than the correlation time of the error share what they tell.
    """
    count = len(points)
    independent = 1.0 + (times[-1] - times[0]) / CORRELATION_S
    weights = np.full(count, min(1.0, independent / count))
    return Pairs(user_from_forearm, user_from_upperarm, points, np.ones(count), weights)


def area(pairs: Pairs) -> Area | None:
    """The area that still points span on one level sheet; None for other layouts, and for moving points."""
    centre = pairs.points.mean(axis=0)
    offsets = pairs.points - centre
    scatter = offsets[:, :2].T @ offsets[:, :2] / len(offsets)
    level = float(np.abs(offsets[:, 2]).max()) < LEVEL_M
    if pairs.stops is None or not level or np.linalg.eigvalsh(scatter)[0] < STILL_M**2 / 4.0:
        return None
    return Area(centre, scatter)


def _medians(attitudes: Array, rows: list[list[int]]) -> Array:
    middles = np.stack([np.median(attitudes[row], axis=0) for row in rows])
    return unit(middles.swapaxes(1, 2)).swapaxes(1, 2)


def _check_still(name: str, points: Array) -> None:
    apart = float(np.sqrt(((points - np.median(points, axis=0)) ** 2).sum(axis=1)).max())
    if apart > STILL_M:
        raise CalibrationError(
            f"Stop {name!r} has points {apart:.2f} m from its middle, but a stop is one place: give each place its "
            "own stop, or leave the column `stop` out where the robot moves"
        )


def check_layout(points: Array) -> None:
    """Whether points (n, 3) [m] can place a user: three places or more, not on one line.

    Raises:
        CalibrationError: if they cannot.

    """
    places = _distinct(points)
    if len(places) < 3:
        raise CalibrationError(
            f"The pairs hold {len(places)} distinct point{'s' if len(places) != 1 else ''}, but at least 3 that are "
            "not on one line are needed: point at more places, best the four corners of the area"
        )
    offsets = places - places.mean(axis=0)
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(offsets.T @ offsets), 0.0))
    if spread[1] < LINE_SHARE * spread[2]:
        raise CalibrationError(
            f"The {len(places)} points lie on one line, which leaves the user's place open: point at places that "
            "span an area, best its four corners"
        )


def _distinct(points: Array) -> Array:
    cells = np.round(points / DISTINCT_M)
    _, first = np.unique(cells, axis=0, return_index=True)
    return points[first]
