"""OpenPose's --write_json: BODY_25 or COCO-18, with or without hands (order: its doc/02_output.md)."""

from collections.abc import Mapping
from typing import Any

from armspan.body.skeleton import Keypoint, Size, Skeleton, named_points
from armspan.body.skeleton_numbers import items, mapping, shown, triples
from armspan.errors import DataError

_UPPER = ("nose", "neck", "rsh", "rel", "rwr", "lsh", "lel", "lwr")
BODY_25 = (
    *_UPPER,
    *(None, "rhip", "rkn", "ran", "lhip", "lkn", "lan", "reye", "leye", "rear", "lear"),
    *("ltoe", None, "lheel", "rtoe", None, "rheel"),
)
COCO_18 = (*_UPPER, "rhip", "rkn", "ran", "lhip", "lkn", "lan", "reye", "leye", "rear", "lear")
ORDERS: Mapping[int, tuple[str, tuple[str | None, ...]]] = {
    25: ("OpenPose BODY_25", BODY_25),
    18: ("OpenPose COCO-18", COCO_18),
}
HAND_POINTS = 21
"""Points of a hand, in one order for OpenPose, MediaPipe and COCO-WholeBody."""
_HAND = {5: "idxknuckle", 8: "idxtip", 12: "midtip"}


def hand_names(side: str) -> tuple[str | None, ...]:
    """Names of a hand's 21 points; ``side`` is l or r."""
    return tuple(side + _HAND[i] if i in _HAND else None for i in range(HAND_POINTS))


def read_openpose(document: dict[Any, Any], where: str, size: Size | None) -> list[Skeleton]:
    """The people of an OpenPose file, an object with "people".

    Raises:
        DataError: for what is not in OpenPose's form, and for coordinates from 0 to 1 (or -1 to 1) without ``size``.

    """
    people = items(document["people"], f"{where}: people")
    return [_read_person(person, f"{where}: people[{i}]", size) for i, person in enumerate(people)]


def _read_person(person: object, place: str, size: Size | None) -> Skeleton:
    fields = mapping(person, place)
    key = "pose_keypoints" if "pose_keypoints" in fields else "pose_keypoints_2d"
    if key not in fields:
        raise DataError(f'{place} is {shown(person)}; expected "pose_keypoints_2d", as OpenPose --write_json writes it')
    body = triples(fields[key], f"{place}.{key}")
    if len(body) not in ORDERS:
        raise DataError(
            f"{place}.{key} has {len(body)} points; expected 25 (BODY_25) or 18 (COCO): "
            "run OpenPose with --model_pose BODY_25"
        )
    source, names = ORDERS[len(body)]
    points = named_points(names, body)
    for side, hand in (("l", "hand_left_keypoints"), ("r", "hand_right_keypoints")):
        points |= _hand(fields, hand + key.removeprefix("pose_keypoints"), side, place)
    return Skeleton(_in_pixels(points, place, size), size, source)


def _hand(fields: dict[Any, Any], key: str, side: str, place: str) -> dict[str, Keypoint]:
    points = triples(fields.get(key, []), f"{place}.{key}")
    if points and len(points) != HAND_POINTS:
        raise DataError(f"{place}.{key} has {len(points)} points; expected {HAND_POINTS}, or an empty list")
    return named_points(hand_names(side), points)


def _in_pixels(points: dict[str, Keypoint], place: str, size: Size | None) -> dict[str, Keypoint]:
    """Undo OpenPose's --keypoint_scale 3 (0 to 1) and 4 (-1 to 1); pixels pass unchanged.

    Of one that lies wholly in the lower right quarter the two look alike: all lengths then come out double, which a
    scale taken from the person's own height undoes.
    """
    reach = [abs(value) for x, y, _ in points.values() for value in (x, y)]
    if not reach or max(reach) > 1.0:
        return points
    if size is None:
        raise DataError(
            f"{place} has coordinates from 0 to 1 (OpenPose --keypoint_scale), which need the picture's size: "
            "add --size 1920x1080 with its width and height in pixels"
        )
    middle = 1.0 if any(min(x, y) < 0 for x, y, _ in points.values()) else 0.0
    width, height = (side / (1.0 + middle) for side in size)
    return {name: ((x + middle) * width, (y + middle) * height, c) for name, (x, y, c) in points.items()}
