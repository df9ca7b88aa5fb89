"""Numbers and lists out of a decoded JSON document, each complaint with its place in it."""

from collections.abc import Callable
from typing import Any

from armspan.body.skeleton import Keypoint, Size
from armspan.errors import DataError

FARTHEST_PX = 1e6
"""No picture is as wide; what lies farther out is not a place in a picture."""
SUREST = 2.0
"""Confidences a little above 1 are written by some networks and are taken as 1; above this they are something else."""

HIDDEN = 0.5
"""Confidence of a point that a COCO annotator placed without seeing it."""


def number(value: object, place: str) -> float:
    """A finite number of any size a picture can have.

    Raises:
        DataError: for anything else (a truth value, a text, NaN, infinity, 1e300).

    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{place} is {shown(value)}; expected a number")
    if not abs(value) <= FARTHEST_PX:  # false for NaN too, and whole numbers too large for a float compare well
        raise DataError(f"{place} is {shown(value)}; expected a place in a picture, a finite number below a million")
    return float(value)


def confidence(value: object, place: str) -> float:
    """A confidence, from 0 to 1."""
    if (sure := number(value, place)) < 0 or sure > SUREST:
        raise DataError(f"{place} is {shown(value)}; expected a confidence from 0 to 1")
    return min(sure, 1.0)


def mapping(value: object, place: str) -> dict[Any, Any]:
    """A JSON object."""
    if not isinstance(value, dict):
        raise DataError(f"{place} is {shown(value)}; expected an object in braces")
    return value


def items(value: object, place: str) -> list[Any]:
    """A JSON list."""
    if not isinstance(value, list | tuple):
        raise DataError(f"{place} is {shown(value)}; expected a list in brackets")
    return list(value)


def annotated(value: object, place: str) -> float:
    """COCO's v (0, 1, 2: not there, placed but hidden, seen) as a confidence."""
    if isinstance(value, bool) or value not in (0, 1, 2):
        raise DataError(f"{place} is {shown(value)}; expected v of a COCO annotation: 0, 1 or 2")
    return {0: 0.0, 1: HIDDEN, 2: 1.0}[int(value)]


def triples(value: object, place: str, sure: Callable[[object, str], float] = confidence) -> list[Keypoint | None]:
    """The points of a flat list x, y, confidence, x, y, confidence, ...; None where the confidence is 0."""
    flat = items(value, place)
    if len(flat) % 3:
        raise DataError(f"{place} has {len(flat)} numbers; expected x, y and confidence of every point")
    return [_triple(flat[i : i + 3], place, i, sure) for i in range(0, len(flat), 3)]


def _triple(values: list[Any], place: str, first: int, sure: Callable[[object, str], float]) -> Keypoint | None:
    x, y = (number(values[i], f"{place}[{first + i}]") for i in range(2))
    how_sure = sure(values[2], f"{place}[{first + 2}]")
    return (x, y, how_sure) if how_sure > 0 else None


def picture_size(value: object, place: str) -> Size:
    """Width and height [px] of a picture, both whole and above zero."""
    sides = items(value, place)
    if len(sides) != 2 or not all(_is_side(side) for side in sides):
        raise DataError(f"{place} is {shown(value)}; expected width and height of the picture in pixels, as 1920, 1080")
    return int(sides[0]), int(sides[1])


def _is_side(side: object) -> bool:
    if isinstance(side, bool) or not isinstance(side, int | float):
        return False
    return 1 <= side <= FARTHEST_PX and side == int(side)


def shown(value: object) -> str:
    """A value in a sentence: short, on one line."""
    if isinstance(value, dict):
        return "an object with " + (", ".join(map(repr, list(value)[:4]))[:80] or "nothing in it")
    if isinstance(value, list | tuple):
        few = 0 < len(value) <= 3 and not any(isinstance(one, dict | list | tuple) for one in value)
        return ", ".join(map(shown, value)) if few else f"a list of {len(value)}"
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 10**20:
        return "a number of more than 20 digits"  # writing one of 5000 digits out is an error of its own
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."
