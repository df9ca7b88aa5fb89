"""One person's points written as other programs write them."""

import json
from collections.abc import Mapping
from typing import Any

Pixels = Mapping[str, tuple[float, float, float]]


def words(text: str) -> list[str]:
    return text.split()


# Written out from each program's own documentation, independently of armspan's tables.
BODY_25 = words(
    "nose neck rsh rel rwr lsh lel lwr midhip rhip rkn ran lhip lkn lan reye leye rear lear ltoe "
    "lsmalltoe lheel rtoe rsmalltoe rheel"
)
COCO_18 = words("nose neck rsh rel rwr lsh lel lwr rhip rkn ran lhip lkn lan reye leye rear lear")
COCO_17 = words("nose leye reye lear rear lsh rsh lel rel lwr rwr lhip rhip lkn rkn lan ran")
BLAZEPOSE = words(
    "nose leyein leye leyeout reyein reye reyeout lear rear lmouth rmouth lsh rsh lel rel lwr rwr "
    "lpinky rpinky lidxknuckle ridxknuckle lthumb rthumb lhip rhip lkn rkn lan ran lheel rheel ltoe "
    "rtoe"
)


def flat(names: list[str], points: Pixels) -> list[float]:
    return [value for name in names for value in points.get(name, (0.0, 0.0, 0.0))]


def hand(side: str, points: Pixels) -> list[str]:
    names = [f"{side}hand{i}" for i in range(21)]
    names[0], names[5], names[8], names[12] = (side + end for end in ("wr", "idxknuckle", "idxtip", "midtip"))
    return names


def openpose(points: Pixels, names: list[str] = BODY_25, *, hands: bool = True) -> dict[str, Any]:
    person: dict[str, Any] = {"person_id": [-1], "pose_keypoints_2d": flat(names, points), "face_keypoints_2d": []}
    for side, word in (("l", "left"), ("r", "right")):
        person[f"hand_{word}_keypoints_2d"] = flat(hand(side, points), points) if hands else []
        person[f"hand_{word}_keypoints_3d"] = []
    return {"version": 1.3, "people": [person]}


def openpifpaf(points: Pixels) -> list[dict[str, Any]]:
    return [{"keypoints": flat(COCO_17, points), "bbox": [1, 2, 3, 4], "score": 0.8, "category_id": 1}]


def whole_body(points: Pixels) -> list[dict[str, Any]]:
    feet = words("ltoe lsmalltoe lheel rtoe rsmalltoe rheel")
    names = [*COCO_17, *feet, *[f"face{i}" for i in range(68)], *hand("l", points), *hand("r", points)]
    return [{"keypoints": flat(names, points), "bbox": [1, 2, 3, 4], "score": 0.8, "category_id": 1}]


def coco_results(points: Pixels) -> list[dict[str, Any]]:
    return [{"image_id": 7, "category_id": 1, "keypoints": flat(COCO_17, points), "score": 0.7}]


def coco_annotations(points: Pixels, size: tuple[int, int]) -> dict[str, Any]:
    marked = {name: (x, y, 2) for name, (x, y, _) in points.items()}
    return {
        "images": [{"id": 7, "width": size[0], "height": size[1], "file_name": "front.jpg"}],
        "annotations": [{"id": 1, "image_id": 7, "num_keypoints": 17, "keypoints": flat(COCO_17, marked)}],
        "categories": [{"id": 1, "name": "person"}],
    }


def landmarks(names: list[str], points: Pixels, size: tuple[int, int]) -> list[dict[str, float]]:
    def one(name: str) -> dict[str, float]:
        x, y, sure = points.get(name, (0.0, 0.0, 0.0))
        return {"x": x / size[0], "y": y / size[1], "z": 0.0, "visibility": sure}

    return [one(name) for name in names]


def mediapipe_tasks(points: Pixels, size: tuple[int, int]) -> dict[str, Any]:
    hands = [landmarks(hand(side, points), points, size) for side in "rl"]
    return {
        "pose_landmarks": [landmarks(BLAZEPOSE, points, size)],
        "pose_world_landmarks": [[{"x": 0.1, "y": 0.2, "z": 0.3}] * 33],
        "hand_landmarks": [[one | {"visibility": 0.0} for one in each] for each in hands],  # as they are written
        "handedness": [[{"category_name": "Left", "score": 0.9}], [{"category_name": "Right", "score": 0.9}]],
    }


def as_read(document: object) -> Any:
    """The document after a trip through a JSON file."""
    return json.loads(json.dumps(document))
