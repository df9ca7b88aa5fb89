"""Skeleton files of other programs, told apart by what is in them."""

import math
from collections.abc import Callable
from typing import Any

from armspan.body import formats_coco, formats_mediapipe, formats_openpose
from armspan.body.skeleton import NAMES, Keypoint, Size, Skeleton, skeleton_document
from armspan.body.skeleton_numbers import confidence, items, mapping, number, picture_size, shown
from armspan.errors import DataError, known_names

__all__ = ["read_skeletons", "skeleton_document"]

KNOWN = (
    "OpenPose (--write_json), openpifpaf (--json-output), COCO results or annotations, MediaPipe landmarks, "
    "or a skeleton written by Armspan"
)
Reader = Callable[[dict[Any, Any], str, Size | None], list[Skeleton]]


def read_skeletons(document: object, where: str, *, size: Size | None = None) -> list[Skeleton]:
    """The people in a decoded JSON ``document``, the one that looks largest first.

    The format is told by structure. ``where`` names the document in errors; ``size`` is the picture's (width, height)
    [px], needed where coordinates run from 0 to 1; a size in the document itself gives way to it.

    Raises:
        DataError: for a document of another kind, one with nobody in it, one with a number that cannot be, or a
            ``size`` that does not hold the person.

    """
    if size is not None:
        size = picture_size(size, "The picture's size")
    people = [one for one in _read(document, where, size) if one.points]
    if not people:
        raise DataError(f"{where} has nobody in it: take another picture, with the whole person in it")
    people.sort(key=_prominence, reverse=True)
    if size is not None:
        _check_size(people[0], where, size)
    return people


def _check_size(skeleton: Skeleton, where: str, size: Size) -> None:
    outside = sum(skeleton.outside(name) for name in skeleton.points)
    if 2 * outside > len(skeleton.points):
        farthest = (max(0, math.ceil(max(p[axis] for p in skeleton.points.values()))) for axis in (0, 1))
        reach = " x ".join(map(str, farthest))
        raise DataError(
            f"{where}: {outside} of {len(skeleton.points)} points lie outside a picture of {size[0]} x {size[1]} "
            f"pixels, reaching to {reach}: check the size, width first"
        )


def _read(document: object, where: str, size: Size | None) -> list[Skeleton]:
    if isinstance(document, list | tuple):
        return _read_list(list(document), where, size)
    if isinstance(document, dict):
        return _reader(document, where)(document, where, size)
    raise DataError(f"{where} is {shown(document)}; expected {KNOWN}")


def _read_list(entries: list[Any], where: str, size: Size | None) -> list[Skeleton]:
    first = entries[0] if entries else {"keypoints": None}
    if formats_mediapipe.is_landmark(first) or isinstance(first, list | tuple):
        return formats_mediapipe.read_landmarks(entries, where, size)
    if isinstance(first, dict) and "keypoints" in first:
        return formats_coco.read_predictions(entries, where, size)
    raise DataError(f"{where} is a list that begins with {shown(first)}; expected {KNOWN}")


def _reader(document: dict[Any, Any], where: str) -> Reader:
    if "armspan_skeleton" in document:
        return _read_own
    if "people" in document:
        return formats_openpose.read_openpose
    if "annotations" in document:
        return formats_coco.read_annotations
    if "predictions" in document:
        return _read_predictions
    if "keypoints" in document:
        return lambda one, where, size: formats_coco.read_predictions([one], where, size)
    if any(key in document for key in formats_mediapipe.BODIES + formats_mediapipe.WORLDS):
        return formats_mediapipe.read_mediapipe
    raise DataError(f"{where} is {shown(document)}; expected {KNOWN}")


def _read_predictions(document: dict[Any, Any], where: str, size: Size | None) -> list[Skeleton]:
    place = f"{where}: predictions"
    return formats_coco.read_predictions(items(document["predictions"], place), place, size)


def _read_own(document: dict[Any, Any], where: str, size: Size | None) -> list[Skeleton]:
    version = document["armspan_skeleton"]
    if version != 1 or isinstance(version, bool):
        raise DataError(f"{where}: armspan_skeleton is {shown(version)}; this Armspan reads 1: write the file again")
    points = mapping(document.get("points"), f"{where}: points")
    own, score, source = document.get("size"), document.get("score"), document.get("source")
    written = None if own is None else picture_size(own, f"{where}: size")
    sure = None if score is None else confidence(score, f"{where}: score")
    named = {name: _own_point(name, point, where) for name, point in points.items()}
    return [Skeleton(named, size or written, source if isinstance(source, str) else "Armspan", sure)]


def _own_point(name: object, point: object, where: str) -> Keypoint:
    if name not in NAMES:
        raise DataError(f"{where}: " + known_names("point", str(name)[:40], NAMES))
    place = f"{where}: points.{name}"
    values = items(point, place)
    if len(values) != 3:
        raise DataError(f"{place} has {len(values)} numbers; expected x, y and confidence")
    x, y = (number(value, f"{place}[{i}]") for i, value in enumerate(values[:2]))
    return x, y, confidence(values[2], f"{place}[2]")


def _prominence(skeleton: Skeleton) -> float:
    """Height in the picture [px] of what was found, weighed with how sure it is."""
    heights = [y for _, y, _ in skeleton.points.values()]
    sure = sum(c for _, _, c in skeleton.points.values()) / len(heights)
    return (max(heights) - min(heights)) * sure
