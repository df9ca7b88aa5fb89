"""The points of one body: BlazePose's landmark network on a turned square, asked several times, the median taken.

Bazarevsky et al. 2020. One answer moves by a pixel or so of the network's picture, a centimetre on the body, when the
square moves a little, and is not the mirror picture's answer mirrored; the median over several squares is steadier and
outlives the odd look in which an arm goes astray. The heat maps the network was trained with place a point better than
the numbers it tells.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import expit

from armspan.body.picture.networks import Network
from armspan.body.picture.regions import Pixels, Region, crop, upright
from armspan.frames import Array

SIDE = 256
"""The network's picture, in pixels."""
POINTS = 33
GROWN = 2 * 1.25
"""The next square over the circle's radius."""
LIKELY = 0.5
"""Below, there is no person in the square; and a heat map that is nowhere hotter says nothing."""
AGREED = 0.015
"""The looks' usual distance over the square: 0.002 to 0.010 for people, 0.02 to 0.05 for a likeness in a chart."""

_HIPS, _CIRCLE = 33, 34
"""The aids among the 39 points of the network: the hips' middle, a point of the circle about the whole person."""
_ALL = 39
_REACH = 3
"""Cells of a heat map that count, each way from the point told."""
_OTHERS: tuple[dict[str, float], ...] = ({}, {"grown": 1.1, "turned": 0.06}, {"grown": 0.95, "turned": -0.06})
_PAIRS = ((1, 4), (2, 5), (3, 6), (7, 8), (9, 10), *((left, left + 1) for left in range(11, POINTS, 2)))
"""Left and right of the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """N points: places (N, 2) [px] in the picture, confidences (N,) from 0 to 1; and the whole's score."""

    places: Array
    confidences: Array
    score: float


def body_points(image: Pixels, region: Region, network: Network) -> Points | None:
    """A body's 33 points, None where the square holds nobody or the looks do not agree on what it holds."""
    rough = look(image, region, network)
    if rough.score < LIKELY:
        return None
    better = upright(rough.places[_HIPS], rough.places[_CIRCLE], GROWN)
    squares = [replace(better.moved(**other), mirrored=way) for other in _OTHERS for way in (False, True)]
    looks = [look(image, square, network) for square in squares]
    found = middle(looks, POINTS)
    return found if found.score >= LIKELY and spread(looks) < AGREED * better.size else None


def look(image: Pixels, region: Region, network: Network) -> Points:
    """The network's 39 points as seen in one square."""
    told, score, _, heat, *_ = network(crop(image, region, SIDE))
    table = told.reshape(_ALL, 5)
    places = region.to_picture(refined(table[:, :2] / SIDE, expit(heat)))
    confidences = expit(table[:, 3:]).min(axis=1)
    order = exchanged() if region.mirrored else list(range(_ALL))
    return Points(places[order], confidences[order], float(score.squeeze()))


def refined(places: Array, heat: Array) -> Array:
    """Places (N, 2), 0 to 1, moved to the heat's centre about them; ``heat`` (rows, columns, N) is from 0 to 1.

    A place stays where its map has no heat nearby. A cell is at its number, as was found from mirrored pictures, where
    half a cell would show.
    """
    cells = np.array([heat.shape[1], heat.shape[0]])
    moved = places.copy()
    for each, cell in enumerate((places * cells).astype(int)):
        low, high = np.maximum(cell - _REACH, 0), np.minimum(cell + _REACH + 1, cells)
        near = heat[low[1] : high[1], low[0] : high[0], each]
        if near.size and near.max() >= LIKELY:
            right, down = np.arange(low[0], high[0]), np.arange(low[1], high[1])
            moved[each] = np.array([near.sum(0) @ right, near.sum(1) @ down]) / near.sum() / cells
    return moved


def exchanged() -> list[int]:
    """The order of the network's points with left and right exchanged."""
    other = dict(_PAIRS) | {right: left for left, right in _PAIRS}
    return [other.get(each, each) for each in range(_ALL)]


def spread(looks: list[Points]) -> float:
    """How far a point of one look usually is from its median over all [px]."""
    places = np.array([each.places[:POINTS] for each in looks])
    return float(np.median(np.linalg.norm(places - np.median(places, axis=0), axis=-1)))


def middle(looks: list[Points], count: int) -> Points:
    """The median of the first ``count`` points over several looks."""
    places = np.median([each.places[:count] for each in looks], axis=0)
    confidences = np.median([each.confidences[:count] for each in looks], axis=0)
    return Points(places, confidences, float(np.median([each.score for each in looks])))
