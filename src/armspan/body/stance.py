"""Whether a person stands in the pose that a view needs: arms out level (front), or pointing forward (side)."""

from math import hypot

import numpy as np

from armspan.body.anthropometry import Prior
from armspan.body.scale import View
from armspan.body.skeleton import TRUSTED, Skeleton, bend_between, facing, middle
from armspan.errors import DataError
from armspan.frames import Array
from armspan.records import Arm

STRAIGHT: dict[View, float] = {"front": 15.0, "side": 25.0}
"""Bend of the elbow [degrees] up to which an arm is straight; from the side, networks see straight ones bent by 11."""
LEVEL = 20.0
"""Slope [degrees] up to which an arm held out is level."""
FORWARD = 50.0
"""Slope [degrees] up to which an arm is stretched forward."""
WIDE, NARROW = 0.14, 0.13
"""Distance of the shoulders, share of the stature: at least, facing the camera; at most, seen from the side."""
LOWEST_HIPS = 0.42
"""Height of a standing person's hips above the floor, share of the stature, at least (0.52 is usual)."""
SHORTEST = 0.8
"""Share of the expected length below which an arm points toward the camera or away from it."""
_JOINTS = {"sh": "shoulder", "el": "elbow", "wr": "wrist"}


def check_pose(points: dict[str, Array], view: View, prior: Prior) -> None:
    """Check ``points`` (3,) [m, right, up and nearer] for the pose that ``view`` needs.

    Raises:
        DataError: where it is another, with what to do.

    """
    _check_placed(points, prior)
    _check_standing(points, prior)
    _check_turn(points, view, prior)
    _check_direction(points, view, prior)
    _check_straight(points, view, prior)


def forward_sign(points: dict[str, Array]) -> float:
    """+1.0 for a person who faces right in the picture, -1.0 left.

    Raises:
        DataError: where neither face nor feet show it.

    """
    ahead = facing(points)
    if ahead is None or ahead[0] == 0:
        raise DataError("Neither face nor feet show which way the person looks: take the side picture with both in it")
    return float(np.sign(ahead[0]))


def check_arm_is_there(skeleton: Skeleton, prior: Prior) -> None:
    """Check that shoulder, elbow and wrist of the pointing arm are found and in the picture.

    Raises:
        DataError: where one is not, with what to do.

    """
    arm, trusted = prior.told.arm, skeleton.trusted()
    for joint, name in _JOINTS.items():
        if skeleton.outside(arm[0] + joint):
            raise DataError(
                f"The {arm} {name} lies outside the picture: step back until the stretched arm is all in it"
            )
    for joint, name in _JOINTS.items():
        point = arm[0] + joint
        if point in trusted:
            continue
        if point in skeleton.points:
            sure = skeleton.points[point][2]
            raise DataError(
                f"The {arm} {name} was found with a confidence of {sure:.2f} only, and {TRUSTED:g} is needed: "
                "have the whole pointing arm in the picture, on the camera's side and free to see, in good light"
            )
        raise DataError(
            f"The {arm} {name} was not found in the picture: show the whole arm, stretched, with nothing before it"
        )


def _check_placed(points: dict[str, Array], prior: Prior) -> None:
    arm = prior.told.arm
    if not all(arm[0] + joint in points for joint in _JOINTS):
        raise DataError(f"The {arm} arm lies where the scale holds no more: hold the camera level, at chest height")


def _check_standing(points: dict[str, Array], prior: Prior) -> None:
    hips = middle(points, "lhip", "rhip")
    if hips is not None and hips[1] < LOWEST_HIPS * prior.stature:
        raise DataError(
            f"The hips are {hips[1]:.2f} m above the floor, as of a person who sits: stand up for the picture; "
            "where the user will sit, the seat's height says how high the eyes are"
        )


def _check_turn(points: dict[str, Array], view: View, prior: Prior) -> None:
    if "lsh" not in points or "rsh" not in points:
        return
    apart = float(points["lsh"][0] - points["rsh"][0])
    if view == "side" and abs(apart) > NARROW * prior.stature:
        raise DataError(
            f"The shoulders lie {abs(apart):.2f} m apart in the side picture, as of a person who faces the camera: "
            "turn the side to it"
        )
    if view == "front" and apart < -WIDE * prior.stature:
        raise DataError("The person is seen from behind: face the camera")
    if view == "front" and apart < WIDE * prior.stature:
        raise DataError(
            f"The shoulders lie {max(apart, 0.0):.2f} m apart in the front picture, as of a person who is turned away: "
            "face the camera"
        )


def _check_direction(points: dict[str, Array], view: View, prior: Prior) -> None:
    arm = prior.told.arm
    if view == "front" and (slope := slope_outward(points, arm)) > LEVEL:
        raise DataError(
            f"The {arm} arm is {slope:.0f} degrees off level in the front picture: hold both arms out level"
        )
    if view == "side" and (slope := _slope(points, arm, forward_sign(points))) > FORWARD:
        raise DataError(
            f"The {arm} arm is {slope:.0f} degrees off straight ahead in the side picture: "
            "stretch it forward, as to point"
        )


def held_out(points: dict[str, Array], arm: Arm) -> bool:
    """Whether an arm is all there, straight, and held out level to its side."""
    there = all(arm[0] + joint in points for joint in _JOINTS)
    return there and slope_outward(points, arm) <= LEVEL and elbow_bend(points, arm) <= STRAIGHT["front"]


def slope_outward(points: dict[str, Array], arm: Arm) -> float:
    """Angle [degrees] of the arm of a person who faces the camera, to straight outward and level."""
    return _slope(points, arm, 1.0 if arm == "left" else -1.0)


def _slope(points: dict[str, Array], arm: Arm, toward: float) -> float:
    return bend_between(np.array([toward, 0.0]), (points[arm[0] + "wr"] - points[arm[0] + "sh"])[:2])


def elbow_bend(points: dict[str, Array], arm: Arm) -> float:
    """Bend [degrees] of an elbow in the picture, 0 where the arm is straight."""
    shoulder, elbow, wrist = (points[arm[0] + joint] for joint in _JOINTS)
    return bend_between((elbow - shoulder)[:2], (wrist - elbow)[:2])


def length_to_wrist(points: dict[str, Array], arm: Arm) -> float:
    """Length [m] of an arm from the shoulder's point over the elbow to the wrist."""
    shoulder, elbow, wrist = (points[arm[0] + joint] for joint in _JOINTS)
    return hypot(*(elbow - shoulder)) + hypot(*(wrist - elbow))


def _check_straight(points: dict[str, Array], view: View, prior: Prior) -> None:
    arm = prior.told.arm
    if (bend := elbow_bend(points, arm)) > STRAIGHT[view]:
        raise DataError(f"The {arm} elbow is bent by {bend:.0f} degrees: stretch the arm")
    length, expected = length_to_wrist(points, arm), float(prior.mean[4]) - prior.hand
    if length < SHORTEST * expected:
        raise DataError(
            f"The {arm} arm measures {length:.2f} m to the wrist where {expected:.2f} m are expected: "
            "hold it across the picture, neither toward the camera nor away from it"
        )
