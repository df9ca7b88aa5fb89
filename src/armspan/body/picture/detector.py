"""Where people are: BlazePose's detector, a single-shot detector on the whole picture.

Bazarevsky et al. 2020: besides a box for the face it finds where the hips' middle is and how large and how inclined
the circle about the whole person is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from armspan.body.picture.networks import Network
from armspan.body.picture.regions import Pixels, Region, crop, upright
from armspan.frames import Array

SIDE = 224
"""The network's picture, in pixels."""
CELLS = ((8, 2), (16, 2), (32, 6))
"""Pixels a cell is wide, and the guesses made in each; the three layers of 32 pixels are one."""
LIKELY = 0.5
SAME = 0.3
"""Boxes that share so much of their union are one person's."""
PARTS = (1.0, 0.6, 0.36)
"""What is shown to the network, over the picture's longer side."""
GROWN = 2 * 1.25
"""The landmarks' square over the circle's radius."""

_HIPS, _CIRCLE = 0, 1


@dataclass(frozen=True, slots=True, eq=False)
class Detections:
    """N people: scores (N,) from 0 to 1, boxes (N, 4) as left, top, right, bottom, points (N, 4, 2).

    Places are shares of the network's picture, or pixels of the whole one. The points are the hips' middle, a point of
    the circle about the whole person, and the same two for the upper body.
    """

    scores: Array
    boxes: Array
    points: Array

    def __getitem__(self, chosen: Array | list[int]) -> "Detections":
        return Detections(self.scores[chosen], self.boxes[chosen], self.points[chosen])


def detect(image: Pixels, network: Network, parts: Sequence[float] = PARTS) -> list[Region]:
    """The squares about the people in a picture, the surest first.

    The network was made for one person: others, even in full view, often get no likely guess until that one is gone.
    One who fills less than a third of its picture is overlooked, so that it is shown ever smaller ``parts`` of the
    picture until there is somebody.
    """
    for part in parts:
        found = merged([look(image, square, network) for square in squares(image, part)])
        if len(found.scores):
            return [upright(each[_HIPS], each[_CIRCLE], GROWN) for each in found[apart(found)].points]
    return []


def squares(image: Pixels, part: float) -> list[Region]:
    """Squares over the whole picture, each half on the next; their side is a ``part`` of the picture's longer one."""
    height, width = image.shape[:2]
    side = part * max(width, height)
    rights, downs = (_middles(length, side) for length in (width, height))
    return [Region(np.array([right, down]), side) for down in downs for right in rights]


def _middles(length: float, side: float) -> Array:
    if length <= side:
        return np.array([length / 2])
    return np.linspace(side / 2, length - side / 2, 1 + int(np.ceil((length - side) / (side / 2))))


def look(image: Pixels, square: Region, network: Network) -> Detections:
    """The likely guesses in one square, in the picture [px]."""
    raw, logits = network(2 * crop(image, square, SIDE) - 1)
    found = decode(raw, logits.ravel())
    corners = square.to_picture(found.boxes.reshape(-1, 2, 2))
    return Detections(found.scores, corners.reshape(-1, 4), square.to_picture(found.points))


def merged(several: list[Detections]) -> Detections:
    """All guesses in one."""
    return Detections(
        np.concatenate([each.scores for each in several]),
        np.concatenate([each.boxes for each in several]),
        np.concatenate([each.points for each in several]),
    )


def anchors() -> Array:
    """The centres (2254, 2) of the cells in the order of the network's guesses, as shares of its picture."""
    layers = []
    for stride, guesses in CELLS:
        along = (np.arange(SIDE // stride) + 0.5) * stride / SIDE
        down, right = np.meshgrid(along, along, indexing="ij")
        layers.append(np.repeat(np.column_stack([right.ravel(), down.ravel()]), guesses, axis=0))
    return np.concatenate(layers)


def decode(raw: Array, logits: Array) -> Detections:
    """The likely ones among the guesses ``raw`` (2254, 12): centre, width and height, four points, all in pixels.

    Centre and points are told from the guess's anchor; ``logits`` (2254,) are the logarithms of the odds.
    """
    scores = expit(logits)
    likely = np.flatnonzero(scores >= LIKELY)
    places = raw[likely].reshape(-1, 6, 2) / SIDE
    cells = anchors()[likely]
    centres, sizes = cells + places[:, 0], places[:, 1]
    boxes = np.hstack([centres - sizes / 2, centres + sizes / 2])
    return Detections(scores[likely], boxes, cells[:, None] + places[:, 2:])


def apart(found: Detections) -> list[int]:
    """One guess for each person, the surest first: non-maximum suppression."""
    kept: list[int] = []
    for each in np.argsort(-found.scores, kind="stable"):
        if all(shared(found.boxes[each], found.boxes[other]) <= SAME for other in kept):
            kept.append(int(each))
    return kept


def shared(one: Array, other: Array) -> float:
    """The common area of two boxes (left, top, right, bottom) over their union's."""
    sides = np.minimum(one[2:], other[2:]) - np.maximum(one[:2], other[:2])
    common = float(np.prod(np.maximum(sides, 0)))
    union = float(np.prod(one[2:] - one[:2]) + np.prod(other[2:] - other[:2])) - common
    return common / union if union > 0 else 0.0
