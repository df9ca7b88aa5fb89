"""What front and side pictures tell of a person whose measures are known."""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from armspan.body.anthropometry import Prior, prior
from armspan.body.fusion import fuse
from armspan.body.observation import MEASURES
from armspan.body.scale import HeightScale
from armspan.body.skeleton import Skeleton
from armspan.body.skeleton_formats import read_skeletons
from armspan.body.told import Told
from armspan.body.views import Seen, observe
from armspan.errors import DataError
from armspan.frames import Array
from filmed_person import FOCAL, SIZE, Person, film
from skeleton_files import COCO_18, coco_annotations, coco_results, mediapipe_tasks, openpifpaf, openpose, whole_body

Pixels = dict[str, tuple[float, float, float]]
View = Literal["front", "side"]
MAN = prior(Told(height_m=1.75, sex="man"))
LEFT = prior(Told(height_m=1.75, sex="man", arm="left", eye="left"))


class TapeScale:
    """A scale that knows where the level camera stands: exact in every plane."""

    sd_share = 0.01
    height_sd = 0.02
    notes = ("by tape",)

    def __init__(self, distance: float, height: float) -> None:
        self.distance, self.height = distance, height

    def nearer(self, distance: float) -> "TapeScale":
        return TapeScale(self.distance - distance, self.height)

    def place(self, points: Array) -> Array:
        x, y = (points - np.array(SIZE) / 2).T * self.distance / FOCAL
        return np.column_stack([x, self.height - y])


def skeleton(pixels: Pixels, *without: str) -> Skeleton:
    return Skeleton({name: point for name, point in pixels.items() if name not in without}, SIZE, "test")


def look(pixels: Pixels, view: View, told: Prior = MAN, *without: str) -> Seen:
    seen = skeleton(pixels, *without)
    return observe(seen, view, HeightScale.of(seen, told, view), told)


def values(seen: Seen) -> dict[str, float]:
    return {one.measure: one.value for one in seen.observations}


def sds(seen: Seen) -> dict[str, float]:
    return {one.measure: one.sd for one in seen.observations}


# --- accuracy ----------------------------------------------------------------------------------------------

# At 5 m and 1.3 m the eye is 3 % nearer than the shoulder, the far end of the arm no nearer: perspective alone.
FRONT_ERRORS = {"eye height": 0.004, "up": 0.014, "left": 0.004, "arm length": 0.012}
SIDE_ERRORS = {"eye height": 0.004, "up": 0.008, "forward": 0.008, "arm length": 0.016}


@pytest.mark.parametrize("arm", ["right", "left"])
def test_a_front_picture_finds_the_measures(arm: Literal["left", "right"]) -> None:
    told = MAN if arm == "right" else LEFT
    seen = look(film(Person().t_pose()), "front", told)
    truth = Person().measures(arm, arm)
    assert set(values(seen)) == set(FRONT_ERRORS)
    for measure, value in values(seen).items():
        assert abs(value - truth[measure]) < FRONT_ERRORS[measure], measure
    assert (values(seen)["left"] > 0) == (arm == "right")


@pytest.mark.parametrize("arm", ["right", "left"])
def test_a_side_picture_finds_the_measures(arm: Literal["left", "right"]) -> None:
    told = MAN if arm == "right" else LEFT
    seen = look(film(Person().pointing(arm), arm), "side", told)
    truth = Person().measures(arm, arm)
    assert set(values(seen)) == set(SIDE_ERRORS)
    for measure, value in values(seen).items():
        assert abs(value - truth[measure]) < SIDE_ERRORS[measure], measure
    assert values(seen)["forward"] > 0


@settings(derandomize=True, max_examples=50, deadline=None)
@given(
    st.floats(1.5, 2.0),
    st.floats(0.05, 0.16),
    st.floats(0.93, 0.94),
    st.floats(0.93, 1.07),
    st.floats(1.1, 1.5),
    st.floats(4.5, 8.0),
)
def test_bodies_of_all_sizes_come_out_within_two_standard_deviations(
    stature: float, forward: float, eye_share: float, arms: float, height: float, distance: float
) -> None:
    limbs = tuple(arms * stature * share for share in (0.171, 0.150, 0.104))
    person = Person(stature, eye_share * stature, forward, joint_width=0.206 * stature, limbs=limbs)
    told = prior(Told(height_m=stature))
    for view, pixels in (
        ("front", film(person.t_pose(), height=height, distance=distance)),
        ("side", film(person.pointing(), "right", height=height, distance=distance)),
    ):
        seen = look(pixels, view, told)  # type: ignore[arg-type]
        for one in seen.observations:
            assert abs(one.value - person.measures()[one.measure]) < 2.0 * one.sd, (view, one.measure)


def test_both_pictures_narrow_the_prior_and_move_it_to_the_person() -> None:
    """A man with short arms, a high shoulder and the head held back, who the regression cannot know."""
    person = replace(Person(), forward=0.085, acromion_share=0.835, limbs=(0.275, 0.240, 0.170))
    front = look(film(person.t_pose()), "front")
    side = look(film(person.pointing(), "right"), "side")
    fused = fuse(MAN, [*front.observations, *side.observations])
    assert fused.rejected == ()
    truth = np.array([person.measures()[measure] for measure in MEASURES])
    body = fused.body
    found = np.array([body.eye_height_m, *body.shoulder_to_eye_m, body.shoulder_to_fingertip_m])
    expected_error, error = np.abs(MAN.mean - truth), np.abs(found - truth)
    assert np.all(error[[1, 3, 4]] < 0.5 * expected_error[[1, 3, 4]])
    assert body.covariance is not None
    after = np.sqrt(np.diag(np.reshape(body.covariance, (5, 5))))
    assert np.all(after < np.sqrt(np.diag(MAN.covariance)))
    assert after[1] < 0.015
    assert after[4] < 0.016


@settings(derandomize=True, max_examples=40, deadline=None)
@given(st.floats(-10.0, 10.0), st.sampled_from(["right", "left"]))
def test_a_person_who_turns_a_little_measures_the_same_from_the_front(turn: float, arm: str) -> None:
    told = MAN if arm == "right" else LEFT
    straight = values(look(film(Person().t_pose()), "front", told))
    turned = values(look(film(Person().t_pose(), turn=turn), "front", told))
    for measure, near in (("arm length", 0.013), ("left", 0.004), ("up", 0.003)):
        assert abs(turned[measure] - straight[measure]) < near, measure


def test_one_arm_alone_is_doubted_more_than_two() -> None:
    one_hangs = Person().t_pose() | Person().arm("l", np.array([0.0, 0.2, -1.0]))
    one, two = look(film(one_hangs), "front"), look(film(Person().t_pose()), "front")
    assert_allclose(values(one)["arm length"], values(two)["arm length"], atol=0.002)
    assert sds(one)["arm length"] > 1.2 * sds(two)["arm length"]


def test_arms_of_two_lengths_are_averaged_from_the_front() -> None:
    """The left arm 20 mm longer: 10 mm in the mean."""
    longer = replace(Person(), limbs=(0.310, 0.272, 0.182))
    both = Person().t_pose() | longer.arm("l", np.array([0.0, 1.0, 0.0]))
    more = (
        values(look(film(both), "front"))["arm length"] - values(look(film(Person().t_pose()), "front"))["arm length"]
    )
    assert_allclose(more, 0.010, atol=0.001)


def test_another_arm_that_points_at_the_camera_is_left_out() -> None:
    toward = Person().t_pose() | Person().arm("l", np.array([0.8, 1.0, 0.0]))
    one, two = look(film(toward), "front"), look(film(Person().t_pose()), "front")
    assert_allclose(values(one)["arm length"], values(two)["arm length"], atol=0.002)
    assert sds(one)["arm length"] > 1.2 * sds(two)["arm length"]


def test_another_scale_tells_the_eyes_height_with_its_own_doubt() -> None:
    pixels = film(Person().t_pose(), distance=40.0)
    seen = observe(skeleton(pixels, "crown"), "front", TapeScale(40.0, 1.3), MAN)
    assert_allclose(values(seen)["eye height"], 1.636, atol=0.003)
    assert_allclose(sds(seen)["eye height"], np.sqrt(0.010**2 + 0.020**2 + 0.01636**2), rtol=0.01)
    length = values(seen)["arm length"]
    assert_allclose(sds(seen)["arm length"], np.sqrt(0.016**2 + 0.013**2 + (0.01 * length) ** 2))
    assert seen.notes[0] == "by tape"


@settings(derandomize=True, max_examples=40, deadline=None)
@given(st.floats(2.6, 4.0), st.floats(1.0, 1.5), st.sampled_from(["right", "left"]), st.booleans())
def test_where_the_camera_is_known_perspective_costs_next_to_nothing(
    distance: float, height: float, arm: str, far_side: bool
) -> None:
    """The truth stands in depths of its own: measured flat, eye and up are off by 20 mm from the front."""
    told, truth = (MAN, Person().measures()) if arm == "right" else (LEFT, Person().measures("left", "left"))
    scale = TapeScale(distance, height)
    seen_from = {"right": "left", "left": "right"}[arm] if far_side else arm
    front = film(Person().t_pose(), distance=distance, height=height)
    side = film(Person().pointing(arm), seen_from, distance=distance, height=height)
    wide = {name: point for name, point in front.items() if name[1:] not in ("toe", "heel")}
    for view, pixels in (("front", wide), ("side", side)):
        uncropped = Skeleton(pixels, None, "test")
        for one in observe(uncropped, view, scale, told).observations:  # type: ignore[arg-type]
            assert abs(one.value - truth[one.measure]) < 0.006, (view, one.measure)


def without_toes(pixels: Pixels) -> Skeleton:
    """As from near, where the toes are beyond the picture's lower edge."""
    return skeleton(pixels, "ltoe", "rtoe")


def test_a_known_focal_length_takes_the_perspective_out_of_up() -> None:
    """Camera at the chest, 3.2 m away: taken as if from afar, 13 mm of up are perspective."""
    seen = without_toes(film(Person().t_pose(), distance=3.2, height=1.26))
    scale, truth = HeightScale.of(seen, MAN, focal_px=FOCAL), Person().measures()["up"]
    afar = observe(seen, "front", replace(scale, distance=1000.0), MAN)
    assert abs(values(observe(seen, "front", scale, MAN))["up"] - truth) < 0.006
    assert values(afar)["up"] - truth > 0.010


@pytest.mark.parametrize("view", ["front", "side"])
def test_a_camera_of_unknown_distance_stands_between_two(view: View) -> None:
    """Either end is one standard deviation of the perspective off."""
    pixels = film(Person().t_pose()) if view == "front" else film(Person().pointing(), "right")
    seen = skeleton(pixels)
    scale = HeightScale.of(seen, MAN, view)
    near, far = (values(observe(seen, view, one, MAN)) for one in scale.possible())
    afar = sds(observe(seen, view, replace(scale, distance=1000.0), MAN))
    unknown = observe(seen, view, scale, MAN)
    assert abs(near["up"] - far["up"]) > 0.005
    for one in unknown.observations:
        ends = near[one.measure], far[one.measure]
        assert_allclose(one.value, np.mean(ends), atol=1e-9)
        assert_allclose(one.sd, np.hypot(afar[one.measure], (ends[0] - ends[1]) / 2), rtol=0.003)


@settings(derandomize=True, max_examples=40, deadline=None)
@given(st.floats(3.2, 8.0), st.floats(1.1, 1.3))
def test_wherever_an_unknown_camera_stands_up_is_within_its_doubt(distance: float, height: float) -> None:
    seen = without_toes(film(Person().t_pose(), distance=distance, height=height))
    (up,) = (one for one in observe(seen, "front", HeightScale.of(seen, MAN), MAN).observations if one.measure == "up")
    assert abs(up.value - Person().measures()["up"]) < up.sd


def test_a_pixel_that_a_scale_cannot_place_is_as_if_not_found() -> None:
    class Horizon(TapeScale):
        def nearer(self, distance: float) -> "Horizon":
            return Horizon(self.distance - distance, self.height)

        def place(self, points: Array) -> Array:
            placed = super().place(points)
            return np.where(placed[:, 1:] > 1.55, np.nan, placed)

    seen = observe(skeleton(film(Person().t_pose())), "front", Horizon(5.0, 1.3), MAN)
    assert set(values(seen)) == {"arm length"}


# --- every format ------------------------------------------------------------------------------------------


def documents(pixels: Pixels) -> dict[str, Any]:
    return {
        "BODY_25": openpose(pixels),
        "COCO-18": openpose(pixels, COCO_18, hands=False),
        "openpifpaf": openpifpaf(pixels),
        "whole body": whole_body(pixels),
        "COCO results": coco_results(pixels),
        "COCO annotations": coco_annotations(pixels, SIZE),
        "MediaPipe": mediapipe_tasks(pixels, SIZE),
    }


@pytest.mark.parametrize("name", documents({}))
@pytest.mark.parametrize("view", ["front", "side"])
def test_every_format_tells_the_same_of_the_same_person(name: str, view: View) -> None:
    pixels = film(Person().t_pose()) if view == "front" else film(Person().pointing(), "right")
    (person,) = read_skeletons(documents(pixels)[name], "picture.json", size=SIZE)
    seen = observe(person, view, HeightScale.of(person, MAN, view), MAN)
    hands = "ridxtip" in person.points
    heels = "rheel" in person.points
    without = ("crown",) + (() if heels else ("lheel", "rheel")) + (() if hands else ("ridxtip", "lidxtip"))
    direct = look(pixels, view, MAN, *without)
    assert values(seen) == pytest.approx(values(direct), abs=1e-9)
    assert sds(seen) == pytest.approx(sds(direct), abs=1e-12)
    full = look(pixels, view)
    for measure, value in values(seen).items():
        assert abs(value - values(full)[measure]) < 0.012
    assert any("hand of" in note for note in seen.notes) != hands
    assert seen.observations[0].source.startswith(f"{view} picture, ")
    assert person.source in seen.observations[0].source


# --- what can be had, and notes ----------------------------------------------------------------------------


def test_a_scale_made_of_the_eyes_tells_nothing_of_their_height() -> None:
    seen = look(film(Person().t_pose()), "front", MAN, "crown")
    assert "eye height" not in values(seen)
    assert "eye height is not told: the scale was made of it, or it is a standing person's" in seen.notes


def test_a_user_who_sits_is_not_told_the_standing_eyes_height() -> None:
    sitting = prior(Told(height_m=1.75, sex="man", seat_height_m=0.45))
    assert "eye height" not in values(look(film(Person().t_pose()), "front", sitting))


def test_without_a_fingertip_the_hand_is_the_priors() -> None:
    pixels = film(Person().t_pose())
    with_tip, without = look(pixels, "front"), look(pixels, "front", MAN, "ridxtip")
    assert_allclose(values(without)["arm length"] - values(with_tip)["arm length"], (MAN.hand - 0.182) / 2, atol=0.002)
    assert sds(without)["arm length"] > sds(with_tip)["arm length"]
    assert any(note.startswith("right index fingertip not found: a hand of 0.18") for note in without.notes)


def test_a_curled_finger_is_not_taken_for_a_short_hand() -> None:
    pixels = film(Person().t_pose())
    curled = pixels | {"ridxtip": pixels["ridxknuckle"]}
    seen = look(curled, "front")
    assert any("index fingertip found 0.08" in note for note in seen.notes)
    assert_allclose(values(seen)["arm length"], values(look(pixels, "front", MAN, "ridxtip"))["arm length"])


def test_without_eyes_the_arm_alone_is_told() -> None:
    for view, pixels in (("front", film(Person().t_pose())), ("side", film(Person().pointing(), "right"))):
        seen = look(pixels, view, MAN, "leye", "reye")  # type: ignore[arg-type]
        assert set(values(seen)) == {"arm length"}
        sideways = "left" if view == "front" else "forward"
        assert f"eye height and {sideways} and up not told: the eye was not found" in seen.notes


def test_without_the_sighting_eye_the_side_to_side_is_not_told() -> None:
    seen = look(film(Person().t_pose()), "front", MAN, "reye")
    assert set(values(seen)) == {"eye height", "up", "arm length"}
    assert "left not told: the eye was not found" in seen.notes


def test_of_an_unknown_sighting_eye_the_arms_is_taken_and_doubted() -> None:
    either = prior(Told(height_m=1.75, sex="man", eye="both"))
    pixels = film(Person().t_pose())
    one, other = look(pixels, "front", either), look(pixels, "front")
    assert values(one) == pytest.approx(values(other))
    assert sds(one)["left"] > 0.03 > sds(other)["left"]


def test_unsure_points_are_left_out_and_named() -> None:
    pixels = film(Person().t_pose())
    unsure = pixels | {"ridxtip": (*pixels["ridxtip"][:2], 0.2), "nose": (*pixels["nose"][:2], 0.1)}
    seen = look(unsure, "front")
    assert "not used, as less sure than 0.3 or outside the picture: nose, ridxtip" in seen.notes


def test_the_notes_say_what_the_shoulder_point_is_taken_for() -> None:
    (pivot,) = [note for note in look(film(Person().t_pose()), "front").notes if note.startswith("pivot")]
    assert pivot == "pivot of the arm 10 mm above and 22 mm outside the shoulder point, give or take 13"


# --- refusals ----------------------------------------------------------------------------------------------


def refused(pixels: Pixels, view: View, words: str, told: Prior = MAN, *without: str) -> None:
    with pytest.raises(DataError, match=words) as said:
        look(pixels, view, told, *without)
    assert "\n" not in str(said.value)


@pytest.mark.parametrize(("point", "name"), [("rsh", "shoulder"), ("rel", "elbow"), ("rwr", "wrist")])
def test_an_arm_that_is_not_all_there(point: str, name: str) -> None:
    pixels = film(Person().t_pose())
    x, y, _ = pixels[point]
    refused(pixels, "front", f"The right {name} was not found in the picture", MAN, point)
    refused(
        pixels | {point: (x, y, 0.2)}, "front", f"The right {name} was found with a confidence of 0.20 only, and 0.3"
    )
    refused(pixels | {point: (-30.0, y, 0.9)}, "front", f"The right {name} lies outside the picture: step back")


def test_an_arm_that_ends_outside_is_said_before_an_unsure_elbow() -> None:
    pixels = film(Person().t_pose())
    cut = pixels | {"rel": (5.0, pixels["rel"][1], 0.1), "rwr": (-30.0, pixels["rwr"][1], 0.1)}
    refused(cut, "front", "The right wrist lies outside the picture: step back")


@pytest.mark.parametrize("view", ["front", "side"])
def test_a_bent_elbow(view: View) -> None:
    pixels = film(Person().t_pose()) if view == "front" else film(Person().pointing(slope=0.0, bend=28.0), "right")
    if view == "front":
        x, y, sure = pixels["rwr"]
        pixels["rwr"] = (x + 5.0, y - 40.0, sure)
    refused(pixels, view, r"The right elbow is bent by \d\d degrees: stretch the arm")


def test_a_nearly_straight_elbow_passes() -> None:
    look(film(Person().pointing(slope=0.0, bend=12.0), "right"), "side")


def test_an_arm_that_hangs_in_the_front_picture() -> None:
    hanging = Person().trunk() | Person().arm("r", np.array([0.0, -0.4, -1.0]))
    refused(film(hanging), "front", r"The right arm is 68 degrees off level in the front picture: hold both arms out")


def test_an_arm_that_is_not_stretched_forward_in_the_side_picture() -> None:
    refused(
        film(Person().pointing(slope=70.0), "right"), "side", r"is 7\d degrees off straight ahead in the side picture"
    )
    backward = Person().trunk() | Person().arm("r", np.array([-1.0, 0.0, 0.0]))
    refused(film(backward, "right"), "side", "is 180 degrees off straight ahead")


def test_the_other_view_is_told() -> None:
    refused(
        film(Person().t_pose()), "side", r"The shoulders lie 0\.3\d m apart in the side picture.*turn the side to it"
    )
    refused(
        film(Person().pointing(), "right"), "front", r"apart in the front picture, as of a person who is turned away"
    )
    refused(film(Person().t_pose(), "back"), "front", "The person is seen from behind: face the camera")


def test_an_arm_that_points_at_the_camera() -> None:
    toward = Person().trunk() | Person().arm("r", np.array([1.0, -0.9, 0.0]))
    refused(film(toward), "front", r"The right arm measures 0\.\d\d m to the wrist where 0\.5\d m are expected")


def test_a_person_who_sits_is_asked_to_stand() -> None:
    """Sitting shows no bent knee from the front: the thighs point at the camera."""
    person = Person().t_pose()
    for name, point in person.items():
        if name[1:] in ("kn", "an", "heel", "toe"):
            point += [0.42, 0.0, 0.0]
        if name[1:] == "kn":
            point[2] = 0.50
    sunk = {n: p - [0, 0, 0.40] if n[1:] not in ("kn", "an", "heel", "toe") else p for n, p in person.items()}
    refused(film(sunk), "front", r"The hips are 0\.\d\d m above the floor, as of a person who sits: stand up")


def test_an_arm_that_no_scale_can_place() -> None:
    class Nowhere(TapeScale):
        def nearer(self, distance: float) -> "Nowhere":
            return self

        def place(self, points: Array) -> Array:
            return np.full_like(points, np.nan)

    with pytest.raises(DataError, match="The right arm lies where the scale holds no more: hold the camera level"):
        observe(skeleton(film(Person().t_pose())), "front", Nowhere(5.0, 1.3), MAN)


def test_a_side_picture_without_face_and_feet() -> None:
    feet, face = ("ltoe", "rtoe"), ("nose", "leye", "reye", "lear", "rear")
    refused(film(Person().pointing(), "right"), "side", "Neither face nor feet show which way", MAN, *feet, *face)


ANYWHERE = st.tuples(st.floats(-100.0, 2000.0), st.floats(-100.0, 1500.0), st.floats(0.0, 1.0))


@settings(derandomize=True, max_examples=300, deadline=None)
@given(st.data(), st.sampled_from(["front", "side"]))
def test_points_anywhere_give_finite_measures_or_one_sentence(data: st.DataObject, view: View) -> None:
    pixels = film(Person().t_pose()) if view == "front" else film(Person().pointing(), "right")
    for name in data.draw(st.sets(st.sampled_from(sorted(pixels)), max_size=4)):
        pixels[name] = data.draw(ANYWHERE)
    for name in data.draw(st.sets(st.sampled_from(sorted(pixels)), max_size=4)):
        del pixels[name]
    try:
        seen, refusal = look(pixels, view).observations, ""
    except DataError as error:
        seen, refusal = (), str(error)
    assert bool(seen) != bool(refusal)
    assert "\n" not in refusal
    assert len({one.measure for one in seen}) == len(seen)
    assert all(np.isfinite(one.value) and one.sd > 0 for one in seen)
