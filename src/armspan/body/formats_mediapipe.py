"""MediaPipe's landmarks: 33 of the body, 21 of a hand, as its Python, JavaScript and tasks interfaces write them."""

from math import dist
from typing import Any

from armspan.body.formats_openpose import HAND_POINTS, hand_names
from armspan.body.skeleton import Keypoint, Size, Skeleton, named_points
from armspan.body.skeleton_numbers import confidence, items, mapping, number, shown
from armspan.errors import DataError

BLAZEPOSE: tuple[str | None, ...] = (
    *("nose", None, "leye", None, None, "reye", None, "lear", "rear", None, None),
    *("lsh", "rsh", "lel", "rel", "lwr", "rwr", None, None, "lidxknuckle", "ridxknuckle", None, None),
    *("lhip", "rhip", "lkn", "rkn", "lan", "ran", "lheel", "rheel", "ltoe", "rtoe"),
)
BODY_POINTS = len(BLAZEPOSE)
BODIES = ("pose_landmarks", "poseLandmarks", "landmarks", "landmark")
HANDS = (
    *("hand_landmarks", "handLandmarks", "multi_hand_landmarks", "multiHandLandmarks"),
    *("left_hand_landmarks", "leftHandLandmarks", "right_hand_landmarks", "rightHandLandmarks"),
)
WORLDS = ("pose_world_landmarks", "poseWorldLandmarks", "world_landmarks", "worldLandmarks")
NORMALISED_REACH = 4.0
"""Landmarks run from 0 to 1 and a little beyond; a person whose every point lies within 4 is not in pixels."""
REACH_OF_WRIST = 0.5
"""A hand belongs to a wrist within this share of the distance from that wrist to its elbow."""


def is_landmark(value: object) -> bool:
    """Whether a value looks like one of MediaPipe's landmarks."""
    return isinstance(value, dict) and "x" in value and "y" in value


def read_mediapipe(document: dict[Any, Any], where: str, size: Size | None) -> list[Skeleton]:
    """The people of an object with landmarks under one of the names in `BODIES`, hands under those in `HANDS`.

    Raises:
        DataError: for world landmarks alone, for normalised landmarks without ``size``, and for other forms.

    """
    key = next((key for key in BODIES if document.get(key) is not None), None)
    if key is None and any(key in document for key in BODIES):
        return []  # null where nobody was seen
    if key is None:
        raise DataError(
            f"{where} has only MediaPipe's world landmarks, which describe a person of standard size whoever was "
            "seen; expected the picture's landmarks (pose_landmarks)"
        )
    bodies = [_body(one, place) for one, place in _groups(document[key], f"{where}: {key}")]
    hands = [
        _hand(one, place)
        for name in HANDS
        if document.get(name) is not None
        for one, place in _groups(document[name], f"{where}: {name}")
    ]
    return [_person(body, hands, where, size) for body in bodies]


def read_landmarks(landmarks: list[Any], where: str, size: Size | None) -> list[Skeleton]:
    """One person from a plain list of 33 landmarks, or several from a list of such lists."""
    return read_mediapipe({"landmarks": landmarks}, where, size)


def _groups(value: object, place: str) -> list[tuple[list[Any], str]]:
    """Lists of landmarks with their places, from one list, from a list of lists, or wrapped in {"landmark": ...}."""
    inner = _unwrapped(value, place)
    if not inner or is_landmark(inner[0]):
        return [(inner, place)] if inner else []
    return [(_unwrapped(one, f"{place}[{i}]"), f"{place}[{i}]") for i, one in enumerate(inner)]


def _unwrapped(value: object, place: str) -> list[Any]:
    return items(value["landmark"] if isinstance(value, dict) and "landmark" in value else value, place)


def _body(landmarks: list[Any], place: str) -> list[Keypoint | None]:
    if len(landmarks) != BODY_POINTS:
        raise DataError(f"{place} has {len(landmarks)} landmarks; expected {BODY_POINTS} of the body (MediaPipe pose)")
    points = [_point(one, f"{place}[{i}]") for i, one in enumerate(landmarks)]
    return [point if point[2] > 0 else None for point in points]


def _hand(landmarks: list[Any], place: str) -> list[Keypoint]:
    """A hand's points, all sure: its visibility is not filled in, and 0."""
    if len(landmarks) != HAND_POINTS:
        raise DataError(f"{place} has {len(landmarks)} landmarks; expected {HAND_POINTS} of a hand")
    return [(*_point(one, f"{place}[{i}]")[:2], 1.0) for i, one in enumerate(landmarks)]


def _point(landmark: object, place: str) -> Keypoint:
    fields = mapping(landmark, place)
    if not is_landmark(fields):
        raise DataError(f"{place} is {shown(fields)}; expected x, y and visibility")
    seen = fields.get("visibility")
    sure = 1.0 if seen is None else confidence(seen, f"{place}.visibility")
    return number(fields["x"], f"{place}.x"), number(fields["y"], f"{place}.y"), sure


def _person(body: list[Keypoint | None], hands: list[list[Keypoint]], where: str, size: Size | None) -> Skeleton:
    points = named_points(BLAZEPOSE, body)
    if points and max(max(abs(x), abs(y)) for x, y, _ in points.values()) > NORMALISED_REACH:
        return Skeleton(_with_hands(points, hands), size, "MediaPipe")
    if size is None:
        raise DataError(
            f"{where} has MediaPipe landmarks from 0 to 1, which need the picture's size: "
            "add --size 1920x1080 with its width and height in pixels"
        )
    in_pixels = {name: _scaled(point, size) for name, point in points.items()}
    return Skeleton(_with_hands(in_pixels, [[_scaled(p, size) for p in hand] for hand in hands]), size, "MediaPipe")


def _scaled(point: Keypoint, size: Size) -> Keypoint:
    return point[0] * size[0], point[1] * size[1], point[2]


def _with_hands(points: dict[str, Keypoint], hands: list[list[Keypoint]]) -> dict[str, Keypoint]:
    """Add the fingertips of each hand to the wrist that it is nearest to, as sure as that wrist.

    MediaPipe's handedness is not asked: its older interfaces call left and right as in a mirror, its newer ones not.
    """
    named = dict(points)
    for hand in hands:
        if (side := _side_of(hand, points)) is not None:
            sure = points[side + "wr"][2]
            tips = {name: p for name, p in named_points(hand_names(side), hand).items() if name.endswith("tip")}
            named |= {name: (x, y, sure) for name, (x, y, _) in tips.items()}
    return named


def _side_of(hand: list[Keypoint], points: dict[str, Keypoint]) -> str | None:
    sides = [side for side in "lr" if side + "wr" in points and side + "el" in points]
    if not sides:
        return None
    wrist = hand[0][:2]
    side = min(sides, key=lambda side: dist(wrist, points[side + "wr"][:2]))
    forearm = dist(points[side + "wr"][:2], points[side + "el"][:2])
    return side if dist(wrist, points[side + "wr"][:2]) <= REACH_OF_WRIST * forearm else None
