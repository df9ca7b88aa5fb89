"""COCO's keypoints as openpifpaf's predictions, COCO results or COCO annotations: 17, 23 with feet, 133 whole body."""

from collections.abc import Callable
from typing import Any

from armspan.body.formats_openpose import hand_names
from armspan.body.skeleton import Size, Skeleton, named_points
from armspan.body.skeleton_numbers import annotated, confidence, items, mapping, picture_size, shown, triples
from armspan.errors import DataError

COCO_17 = (
    *("nose", "leye", "reye", "lear", "rear", "lsh", "rsh", "lel", "rel", "lwr", "rwr"),
    *("lhip", "rhip", "lkn", "rkn", "lan", "ran"),
)
FEET = ("ltoe", None, "lheel", "rtoe", None, "rheel")
FACE_POINTS = 68
WHOLE_BODY: tuple[str | None, ...] = (*COCO_17, *FEET, *[None] * FACE_POINTS, *hand_names("l"), *hand_names("r"))
ORDERS = {17: COCO_17, 23: (*COCO_17, *FEET), 133: WHOLE_BODY}
Sure = Callable[[object, str], float]


def read_predictions(people: list[Any], place: str, size: Size | None) -> list[Skeleton]:
    """The people of a list of {"keypoints": [...], "score": ...}: openpifpaf's, or COCO results with "image_id".

    Raises:
        DataError: for what is not of this form, or people of several pictures.

    """
    fields = [mapping(person, f"{place}[{i}]") for i, person in enumerate(people)]
    _one_picture(fields, place)
    source = "COCO results" if any("image_id" in one for one in fields) else "openpifpaf"
    return [_read_person(one, f"{place}[{i}]", size, source, confidence) for i, one in enumerate(fields)]


def read_annotations(document: dict[Any, Any], where: str, size: Size | None) -> list[Skeleton]:
    """The people of COCO annotations {"annotations": [...], "images": [...]}, their points marked with v = 0, 1 or 2.

    The picture's size is the document's own where ``size`` is None.
    """
    place = f"{where}: annotations"
    people = items(document["annotations"], place)
    fields = [mapping(person, f"{place}[{i}]") for i, person in enumerate(people)]
    _one_picture(fields, place)
    size = size or _size_of_picture(document, fields, where)
    with_points = [(i, one) for i, one in enumerate(fields) if one.get("num_keypoints") != 0]
    return [_read_person(one, f"{place}[{i}]", size, "COCO annotations", annotated) for i, one in with_points]


def _read_person(fields: dict[Any, Any], place: str, size: Size | None, source: str, sure: Sure) -> Skeleton:
    if "keypoints" not in fields:
        raise DataError(f'{place} is {shown(fields)}; expected "keypoints", 17 times x, y and confidence (COCO order)')
    points = triples(fields["keypoints"], f"{place}.keypoints", sure)
    if len(points) not in ORDERS:
        known = ", ".join(map(str, ORDERS))
        raise DataError(f"{place}.keypoints has {len(points)} points; expected {known} (COCO, with feet, whole body)")
    named = named_points(ORDERS[len(points)], points)
    score = fields.get("score")
    return Skeleton(named, size, source, None if score is None else confidence(score, f"{place}.score"))


def _one_picture(people: list[dict[Any, Any]], place: str) -> None:
    pictures = {shown(one["image_id"]) for one in people if "image_id" in one}
    if len(pictures) > 1:
        few = ", ".join(sorted(pictures)[:3])
        raise DataError(
            f"{place} has people of {len(pictures)} pictures (image_id {few} ...); expected those of one: "
            "keep the entries of one image_id"
        )


def _size_of_picture(document: dict[Any, Any], people: list[dict[Any, Any]], where: str) -> Size | None:
    place = f"{where}: images"
    pictures = [mapping(one, f"{place}[{i}]") for i, one in enumerate(items(document.get("images", []), place))]
    wanted = people[0].get("image_id") if people else None
    for i, picture in enumerate(pictures):
        if picture.get("id") == wanted and "width" in picture and "height" in picture:
            return picture_size([picture["width"], picture["height"]], f"{place}[{i}], width and height,")
    return None
