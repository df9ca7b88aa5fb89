"""Skeleton files of every program give the same person; what is wrong in them is told with its place."""

import json
import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from armspan.body.skeleton import Skeleton
from armspan.body.skeleton_formats import read_skeletons, skeleton_document
from armspan.errors import DataError
from filmed_person import SIZE, Person, film
from skeleton_files import (
    BODY_25,
    COCO_17,
    COCO_18,
    as_read,
    coco_annotations,
    coco_results,
    flat,
    hand,
    landmarks,
    mediapipe_tasks,
    openpifpaf,
    openpose,
    whole_body,
)

PIXELS = film(Person().t_pose())
BLAZEPOSE = [name for name in BODY_25 if name != "neck"]
TIPS = {"lidxtip", "ridxtip", "lmidtip", "rmidtip"}
KNUCKLES = {"lidxknuckle", "ridxknuckle"}
DOCUMENTS: dict[str, tuple[Any, set[str], str]] = {
    "BODY_25": (
        openpose(PIXELS),
        {*BODY_25} - {"midhip", "lsmalltoe", "rsmalltoe"} | TIPS | KNUCKLES,
        "OpenPose BODY_25",
    ),
    "COCO-18": (openpose(PIXELS, COCO_18, hands=False), {*COCO_18}, "OpenPose COCO-18"),
    "openpifpaf": (openpifpaf(PIXELS), {*COCO_17}, "openpifpaf"),
    "openpifpaf in an object": ({"predictions": openpifpaf(PIXELS)}, {*COCO_17}, "openpifpaf"),
    "one person of openpifpaf": (openpifpaf(PIXELS)[0], {*COCO_17}, "openpifpaf"),
    "whole body": (
        whole_body(PIXELS),
        {*COCO_17, "ltoe", "rtoe", "lheel", "rheel"} | TIPS | KNUCKLES,
        "openpifpaf",
    ),
    "COCO results": (coco_results(PIXELS), {*COCO_17}, "COCO results"),
    "COCO annotations": (coco_annotations(PIXELS, SIZE), {*COCO_17}, "COCO annotations"),
    "MediaPipe tasks": (
        mediapipe_tasks(PIXELS, SIZE),
        {*COCO_17, "ltoe", "rtoe", "lheel", "rheel"} | TIPS | KNUCKLES,
        "MediaPipe",
    ),
}


def refused(document: object, words: str, size: tuple[int, int] | None = SIZE) -> str:
    with pytest.raises(DataError, match=words) as told:
        read_skeletons(document, "front.json", size=size)
    assert "front.json" in str(told.value) or "size" in str(told.value)
    assert "\n" not in str(told.value)
    return str(told.value)


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_format_gives_the_same_points_by_the_same_names(name: str) -> None:
    document, expected, source = DOCUMENTS[name]
    (person,) = read_skeletons(as_read(document), "front.json", size=SIZE)
    assert set(person.points) == expected
    assert person.source == source
    assert person.size == SIZE
    for point, (x, y, _) in person.points.items():
        assert_allclose((x, y), PIXELS[point][:2], atol=1e-9)


@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_own_form_keeps_a_skeleton_whole(name: str) -> None:
    (person,) = read_skeletons(DOCUMENTS[name][0], "front.json", size=SIZE)
    assert read_skeletons(as_read(skeleton_document(person)), "own.json") == [person]


def test_confidences_come_through() -> None:
    (person,) = read_skeletons(openpifpaf(PIXELS | {"nose": (1.0, 2.0, 0.25)}), "front.json")
    assert person.points["nose"] == (1.0, 2.0, 0.25)
    assert person.score == 0.8
    assert read_skeletons(coco_results(PIXELS), "front.json")[0].score == 0.7


# --- OpenPose ----------------------------------------------------------------------------------------------


def test_points_that_openpose_did_not_find_are_absent() -> None:
    some = {name: point for name, point in PIXELS.items() if name not in ("rwr", "leye")}
    (person,) = read_skeletons(openpose(some), "front.json")
    assert not {"rwr", "leye"} & set(person.points)
    assert "rel" in person.points


@pytest.mark.parametrize("middle", [0.0, 1.0])
def test_openposes_normalised_coordinates_are_undone_with_the_size(middle: float) -> None:
    share = {
        name: (x / SIZE[0] * (1 + middle) - middle, y / SIZE[1] * (1 + middle) - middle, c)
        for name, (x, y, c) in PIXELS.items()
    }
    (person,) = read_skeletons(openpose(share), "front.json", size=SIZE)
    for name, point in person.points.items():
        assert_allclose(point, PIXELS[name], atol=1e-9)
    refused(openpose(share), r"people\[0\].* from 0 to 1 .*--size 1920x1080", size=None)


def test_another_model_of_openpose_is_refused_with_the_one_to_use() -> None:
    refused({"people": [{"pose_keypoints_2d": [1.0] * 45}]}, r"has 15 points; expected 25 .* or 18 .*BODY_25")


def test_a_hand_of_another_size_is_refused() -> None:
    document = openpose(PIXELS)
    document["people"][0]["hand_right_keypoints_2d"] = [1.0, 2.0, 0.5]
    refused(document, r"people\[0\].hand_right_keypoints_2d has 1 points; expected 21")


# --- COCO --------------------------------------------------------------------------------------------------


def test_cocos_marks_become_confidences_and_its_picture_gives_the_size() -> None:
    marked = {name: (x, y, {"nose": 0, "rwr": 1}.get(name, 2)) for name, (x, y, _) in PIXELS.items()}
    document = coco_annotations(PIXELS, (1000, 800))
    document["annotations"][0]["keypoints"] = flat(COCO_17, marked)
    (person,) = read_skeletons(document, "front.json")
    assert "nose" not in person.points
    assert person.points["rwr"][2] == 0.5
    assert person.points["lwr"][2] == 1.0
    assert person.size == (1000, 800)
    assert read_skeletons(document, "front.json", size=SIZE)[0].size == SIZE


def test_a_mark_that_coco_does_not_have_is_refused() -> None:
    document = coco_annotations(PIXELS, SIZE)
    document["annotations"][0]["keypoints"][5] = 3
    refused(document, r"annotations\[0\].keypoints\[5\] is 3; expected v of a COCO annotation: 0, 1 or 2")


def test_people_of_several_pictures_are_refused() -> None:
    results = [*coco_results(PIXELS), coco_results(PIXELS)[0] | {"image_id": 8}]
    refused(results, r"people of 2 pictures \(image_id 7, 8 .*keep the entries of one image_id")


def test_an_annotation_without_points_is_passed_over() -> None:
    document = coco_annotations(PIXELS, SIZE)
    document["annotations"].insert(0, {"image_id": 7, "num_keypoints": 0, "keypoints": [0] * 51})
    assert len(read_skeletons(document, "front.json")) == 1


# --- MediaPipe ---------------------------------------------------------------------------------------------


def bodies() -> list[dict[str, float]]:
    return mediapipe_tasks(PIXELS, SIZE)["pose_landmarks"][0]


@pytest.mark.parametrize(
    "wrap",
    [
        lambda body: body,
        lambda body: [body],
        lambda body: {"landmarks": body},
        lambda body: {"landmarks": [body], "worldLandmarks": [[{"x": 0.0, "y": 0.0}] * 33]},
        lambda body: {"pose_landmarks": body},
        lambda body: {"pose_landmarks": {"landmark": body}},
        lambda body: {"poseLandmarks": body, "leftHandLandmarks": None},
        lambda body: {"landmark": body},
    ],
)
def test_every_way_of_writing_landmarks_gives_the_person(wrap: Callable[[object], object]) -> None:
    (person,) = read_skeletons(wrap(bodies()), "front.json", size=SIZE)
    assert_allclose(person.points["rwr"], PIXELS["rwr"], atol=1e-9)


def test_landmarks_need_the_size_of_the_picture() -> None:
    refused(bodies(), "front.json has MediaPipe landmarks from 0 to 1, .*add --size 1920x1080", size=None)


def test_landmarks_in_pixels_do_not() -> None:
    in_pixels = [one | {"x": one["x"] * SIZE[0], "y": one["y"] * SIZE[1]} for one in bodies()]
    (person,) = read_skeletons(in_pixels, "front.json")
    assert_allclose(person.points["rwr"], PIXELS["rwr"], atol=1e-9)
    assert person.size is None


@pytest.mark.parametrize("key", ["worldLandmarks", "pose_world_landmarks", "poseWorldLandmarks"])
def test_world_landmarks_alone_are_refused_and_why(key: str) -> None:
    refused({key: [bodies()]}, "only MediaPipe's world landmarks, which describe a person of standard size")


def test_a_hand_goes_to_the_wrist_it_is_at_whatever_handedness_says() -> None:
    document = mediapipe_tasks(PIXELS, SIZE)
    for names in (["Left", "Right"], ["Right", "Left"]):
        document["handedness"] = [[{"category_name": name}] for name in names]
        (person,) = read_skeletons(document, "front.json", size=SIZE)
        assert_allclose(person.points["ridxtip"][:2], PIXELS["ridxtip"][:2], atol=1e-9)
        assert_allclose(person.points["lidxtip"][:2], PIXELS["lidxtip"][:2], atol=1e-9)


def test_hands_of_the_holistic_form_are_read() -> None:
    document = {
        "poseLandmarks": bodies(),
        "rightHandLandmarks": landmarks(hand("r", PIXELS), PIXELS, SIZE),
        "leftHandLandmarks": None,
    }
    for one in document["rightHandLandmarks"] or []:
        del one["visibility"]
    (person,) = read_skeletons(document, "front.json", size=SIZE)
    assert "lidxtip" not in person.points
    assert_allclose(person.points["ridxtip"][:2], PIXELS["ridxtip"][:2], atol=1e-9)


def test_a_fingertip_is_as_sure_as_its_wrist() -> None:
    document = mediapipe_tasks(PIXELS | {"rwr": (*PIXELS["rwr"][:2], 0.4)}, SIZE)
    (person,) = read_skeletons(document, "front.json", size=SIZE)
    assert person.points["ridxtip"][2] == 0.4
    assert person.points["lidxtip"][2] == 0.9


def test_a_hand_far_from_every_wrist_is_nobodys() -> None:
    far = [{"x": 0.01, "y": 0.01}] * 21
    (person,) = read_skeletons({"pose_landmarks": [bodies()], "hand_landmarks": [far]}, "front.json", size=SIZE)
    assert not TIPS & set(person.points)


def test_a_hand_alone_is_not_a_person() -> None:
    refused({"landmarks": [[{"x": 0.5, "y": 0.5}] * 21]}, r"landmarks\[0\] has 21 landmarks; expected 33 of the body")


# --- several people, nobody, other documents ---------------------------------------------------------------


def test_of_several_people_the_largest_comes_first() -> None:
    far = film(Person().t_pose(), distance=9.0)
    document = openpose(far)
    document["people"] += openpose(PIXELS)["people"]
    near, behind = read_skeletons(document, "front.json")
    assert_allclose(near.points["rwr"], PIXELS["rwr"])
    assert_allclose(behind.points["rwr"], far["rwr"])


@pytest.mark.parametrize(
    "document",
    [
        {"version": 1.3, "people": []},
        {"people": [{"pose_keypoints_2d": [0] * 75}]},
        [],
        {"annotations": []},
        {"predictions": []},
        {"pose_landmarks": []},
        {"landmarks": []},
        {"poseLandmarks": None, "rightHandLandmarks": None},
        {"armspan_skeleton": 1, "points": {}},
        [{"keypoints": [0] * 51}],
    ],
)
def test_nobody_is_told(document: object) -> None:
    refused(document, "^front.json has nobody in it: take another picture")


@pytest.mark.parametrize("document", [None, 3, "text", True, {}, {"body": 1}, [1], ["a"], [{}], [{"a": 1}], [None]])
def test_a_document_of_another_kind_is_answered_with_those_that_are_read(document: object) -> None:
    refused(document, "expected OpenPose .*, openpifpaf .*, COCO results or annotations, MediaPipe landmarks")


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("abc", "is 'abc'; expected a number"),
        (None, "is None; expected a number"),
        (True, "is True; expected a number"),
        ([[1.0], 2.0], "is a list of 2; expected a number"),
        (math.nan, "is nan; expected a place in a picture"),
        (math.inf, "is inf; expected a place in a picture"),
        (1e7, r"is 10000000.0; expected a place in a picture, a finite number below a million"),
        (10**400, "is a number of more than 20 digits; expected a place in a picture"),
    ],
)
def test_a_number_that_cannot_be_is_told_with_its_place(value: object, said: str) -> None:
    document = openpose(PIXELS)
    document["people"][0]["pose_keypoints_2d"][10] = value
    refused(document, r"^front.json: people\[0\].pose_keypoints_2d\[10\] " + said)
    predictions = openpifpaf(PIXELS)
    predictions[0]["keypoints"][3] = value
    refused(predictions, r"^front.json\[0\].keypoints\[3\] " + said)
    body = bodies()
    body[16]["y"] = value  # type: ignore[assignment]
    refused({"landmarks": body}, r"^front.json: landmarks\[16\].y " + said)


@pytest.mark.parametrize("sure", [-0.1, 250])
def test_a_confidence_that_cannot_be_is_told(sure: float) -> None:
    document = openpose(PIXELS)
    document["people"][0]["pose_keypoints_2d"][11] = sure
    refused(document, rf"pose_keypoints_2d\[11\] is {sure}; expected a confidence from 0 to 1")


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ({"people": {}}, "people is an object with nothing in it; expected a list"),
        ({"people": [3]}, r"people\[0\] is 3; expected an object"),
        ({"people": [{"pose": []}]}, r"people\[0\] is an object with 'pose'; expected \"pose_keypoints_2d\""),
        ({"people": [{"pose_keypoints_2d": [1.0, 2.0]}]}, "has 2 numbers; expected x, y and confidence"),
        ([{"keypoints": [1.0] * 48}], r"front.json\[0\].keypoints has 16 points; expected 17, 23, 133"),
        ([{"keypoints": 5}], r"front.json\[0\].keypoints is 5; expected a list"),
        ([{"keypoints": [1.0] * 51}, 4], r"front.json\[1\] is 4; expected an object"),
        ({"annotations": [{"image_id": 1}]}, r"annotations\[0\] is an object with 'image_id'; expected \"keypoints\""),
        ({"landmarks": [{"x": 0.1, "y": 0.2}] * 32}, "landmarks has 32 landmarks; expected 33"),
        ([{"x": 0.1, "y": 0.2}] * 32 + [{"x": 0.1}], r"landmarks\[32\] is an object with 'x'; expected x, y"),
        ({"armspan_skeleton": 2}, "armspan_skeleton is 2; this Armspan reads 1"),
        ({"armspan_skeleton": 1, "points": {"nose": [1, 2]}}, "points.nose has 2 numbers; expected x, y and conf"),
        ({"armspan_skeleton": 1, "points": {"noes": [1, 2, 1]}}, "'noes' does not exist; .*Did you mean 'nose'"),
        ({"armspan_skeleton": 1, "size": [0, 5], "points": {}}, "size is 0, 5; expected width and height"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(document: object, said: str) -> None:
    refused(document, said)


@pytest.mark.parametrize("size", [(0, 5), (1920, -1), (1920.5, 1080), (math.nan, 1), (10**400, 1)])
def test_a_picture_has_a_size_of_whole_pixels(size: tuple[int, int]) -> None:
    refused(openpose(PIXELS), r"size is .+, .+; expected width and height of the picture in pixels", size=size)


def test_a_size_that_does_not_hold_the_person_is_told() -> None:
    told = r"points lie outside a picture of 640 x 480 pixels, reaching to \d{4} x \d{3,4}: check the size, width first"
    refused(openpose(PIXELS), told, size=(640, 480))
    assert read_skeletons(openpose(PIXELS), "front.json", size=SIZE)


# --- any document whatever ---------------------------------------------------------------------------------

KEYS = [
    *("people", "pose_keypoints_2d", "pose_keypoints", "hand_left_keypoints_2d", "keypoints", "image_id", "score"),
    *("annotations", "images", "predictions", "landmarks", "landmark", "pose_landmarks", "poseLandmarks", "x", "y"),
    *("worldLandmarks", "hand_landmarks", "visibility", "num_keypoints", "id", "width", "height", "points", "nose"),
    *("armspan_skeleton", "size", "source"),
]
LEAVES = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.sampled_from([0, 1, 2, 17, 10**400])
    | st.floats()
    | st.text(max_size=4)
    | st.sampled_from([[0.5] * 75, [2] * 51, [300.0, 200.0, 1.0] * 18, [{"x": 0.3, "y": 0.4}] * 33, [1, 2, 1]])
)
DOCUMENT = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(KEYS) | st.text(max_size=3), inner, max_size=4)
    ),
    max_leaves=12,
)


def read_or_refuse(document: object, size: tuple[int, int] | None) -> None:
    try:
        people = read_skeletons(document, "any.json", size=size)
    except DataError as error:
        refusal, people = str(error), []
    else:
        refusal = ""
    assert bool(people) != bool(refusal)
    assert len(refusal) < 700
    assert "\n" not in refusal
    for person in people:
        assert isinstance(person, Skeleton)
        assert all(math.isfinite(value) for point in person.points.values() for value in point)
        assert all(0 <= sure <= 1 for _, _, sure in person.points.values())
        json.dumps(skeleton_document(person))


@settings(derandomize=True, max_examples=400, deadline=None)
@given(DOCUMENT, st.none() | st.just((1920, 1080)))
def test_any_document_gives_people_or_one_sentence(document: object, size: tuple[int, int] | None) -> None:
    read_or_refuse(document, size)


@settings(derandomize=True, max_examples=300, deadline=None)
@given(st.sampled_from(sorted(DOCUMENTS)), st.lists(st.integers(0, 10_000), min_size=1, max_size=5), LEAVES)
def test_a_spoilt_document_gives_people_or_one_sentence(name: str, way: list[int], value: Any) -> None:
    document = as_read(DOCUMENTS[name][0])
    at = document
    for step in way[:-1]:
        keys = list(at) if isinstance(at, dict) else range(len(at))
        inner = at[keys[step % len(keys)]] if keys else None
        if not isinstance(inner, dict | list) or not inner:
            break
        at = inner
    keys = list(at) if isinstance(at, dict) else list(range(len(at)))
    at[keys[way[-1] % len(keys)]] = value
    read_or_refuse(document, SIZE)
