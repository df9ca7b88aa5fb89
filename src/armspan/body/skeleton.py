"""A person's points in a picture, under one set of names whatever found them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import atan2, degrees, hypot
from typing import TypeAlias

import numpy as np

from armspan.errors import DataError, known_names
from armspan.frames import Array

Keypoint: TypeAlias = tuple[float, float, float]
"""x [px, to the right], y [px, down] and confidence (0 to 1)."""

Size: TypeAlias = tuple[int, int]
"""Width and height of a picture [px]."""

Points: TypeAlias = Mapping[str, Keypoint] | Mapping[str, Array]
"""Points by name, in pixels with their confidence or (2,) in metres."""

NAMES: tuple[str, ...] = (
    *("nose", "leye", "reye", "lear", "rear", "neck", "lsh", "rsh", "lel", "rel", "lwr", "rwr"),
    *("lhip", "rhip", "lkn", "rkn", "lan", "ran", "lheel", "rheel", "ltoe", "rtoe", "crown"),
    *("lidxknuckle", "ridxknuckle", "lidxtip", "ridxtip", "lmidtip", "rmidtip"),
)
"""All points that a skeleton may have; l and r are the person's own left and right."""

TRUSTED = 0.3
"""Confidence below which a point counts as not found."""


@dataclass(frozen=True, slots=True)
class Skeleton:
    """One person's ``points`` by name [px, origin in the picture's upper left corner]; what was not found is absent.

    ``size`` is the picture's, where it is known; ``source`` says what found the points; ``score`` how sure it was of
    the person (0 to 1).

    Raises:
        DataError: for a point of another name.

    """

    points: Mapping[str, Keypoint]
    size: Size | None
    source: str
    score: float | None = None

    def __post_init__(self) -> None:
        for name in self.points:
            if name not in NAMES:
                raise DataError(known_names("Skeleton point", name, NAMES))

    def trusted(self) -> dict[str, Keypoint]:
        """The points of at least `TRUSTED` confidence that lie inside the picture."""
        return {name: p for name, p in self.points.items() if p[2] >= TRUSTED and self._holds(p)}

    def outside(self, name: str) -> bool:
        """Whether a point was placed outside the picture."""
        return name in self.points and not self._holds(self.points[name])

    def _holds(self, point: Keypoint) -> bool:
        return self.size is None or (0 <= point[0] <= self.size[0] and 0 <= point[1] <= self.size[1])


def skeleton_document(skeleton: Skeleton) -> dict[str, object]:
    """Armspan's own form of a skeleton, ready for JSON; `read_skeletons` reads it."""
    return {
        "armspan_skeleton": 1,
        "source": skeleton.source,
        "size": list(skeleton.size) if skeleton.size else None,
        "score": skeleton.score,
        "points": {name: list(point) for name, point in skeleton.points.items()},
    }


def named_points(names: Iterable[str | None], points: Iterable[Keypoint | None]) -> dict[str, Keypoint]:
    """The points that are there (neither None nor without a name here) by name."""
    pairs = zip(names, points, strict=False)
    return {name: point for name, point in pairs if name is not None and point is not None}


def middle(points: Points, *names: str) -> Array | None:
    """Mean (2,) of those of the named points that are there."""
    there = [np.asarray(points[name])[:2] for name in names if name in points]
    return np.mean(there, axis=0) if there else None


def facing(points: Points) -> Array | None:
    """Which way (2,) a person seen from the side faces: ears to nose or eyes, else heels to toes."""
    for back, front in ((("lear", "rear"), ("nose", "leye", "reye")), (("lheel", "rheel"), ("ltoe", "rtoe"))):
        behind, ahead = middle(points, *back), middle(points, *front)
        if behind is not None and ahead is not None and hypot(*(ahead - behind)) > 0:
            return ahead - behind
    return None


def bend_between(first: Array, second: Array) -> float:
    """Angle [degrees] between two vectors (2,), 0 where they go the same way."""
    cross = first[0] * second[1] - first[1] * second[0]
    return abs(degrees(atan2(float(cross), float(first @ second))))
