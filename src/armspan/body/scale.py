"""From a picture's pixels to metres in the plane of the person's body.

Both pictures are to be taken with the camera level, at chest height and at least 4 m off. Nearer or lower ones stretch
what is near the lens (4 % of the arm at 2.3 m), which no scale along the body shows.
"""

from dataclasses import dataclass, replace
from math import atan2, degrees, hypot
from typing import Literal, Protocol, TypeAlias

import numpy as np

from armspan.body.anthropometry import REPORTED_SD, TAPE_SD, Prior
from armspan.body.skeleton import Keypoint, Skeleton, bend_between, facing, middle
from armspan.errors import DataError
from armspan.frames import Array

View: TypeAlias = Literal["front", "side"]
"""front: facing the camera, arms out level (T pose); side: seen from the side, the pointing arm stretched forward."""


class Scale(Protocol):
    """What turns a picture's pixels into metres in the body's plane."""

    @property
    def sd_share(self) -> float:
        """Standard deviation of every length, as a share of it."""
        ...

    @property
    def height_sd(self) -> float:
        """Standard deviation of where the floor lies [m]."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """What had to be assumed."""
        ...

    def place(self, points: Array) -> Array:
        """Pixels (n, 2) as metres (n, 2): right in the picture, and up above the floor the person stands on."""
        ...

    def nearer(self, distance: float) -> "Scale":
        """The scale of a plane so much nearer to the camera [m]; the same one where that is not known."""
        ...


ANKLE_HEIGHT, ANKLE_SD = 0.098, 0.012
"""A skeleton's ankle above the sole of the foot [m]: the networks see it some 20 mm too high (24 rendered bodies)."""
HEEL_HEIGHT, HEEL_SD = 0.035, 0.015
"""A skeleton's heel above the sole of the foot [m] (the same bodies, bare and shod)."""
EYE_SHARE, EYE_SD = 0.9345, 0.009
"""A standing person's eye above the bare sole: share of the stature, and doubt [m] (ANSUR II)."""
CROWN_SD = 0.015
"""Doubt of the crown [m]: hair."""
POINT_SD = 0.006
"""Doubt of a skeleton's points at either end [m]."""
UPRIGHT = 4.0
"""Lean [degrees] that a person seen from the side may have of their own; beyond it the picture is tilted (assumed)."""
ANKLE_BEHIND = 0.025
"""How far a standing person's ankle lies behind the shoulder, share of the stature (plumb line, assumed)."""
CHEST = 0.72
"""Height of the camera above the floor, share of the stature (assumed).

Not the middle of the picture, which lies there only if the camera was level and nothing was cropped: from 3 m away,
tilted by 7 degrees, it puts *up* from the side off by 44 to 47 mm, this by 14 to 16 (24 rendered bodies).
"""
FAR_ENOUGH = 4.0
"""Distance of the camera [m] from which a picture may be measured without a camera model."""
UNKNOWN_DISTANCE = (2.0, 5.0)
"""Between these distances [m] stands a camera of which nothing is known (assumed): from nearer, a telephone's picture
does not hold a person with arms stretched out; from farther on, perspective changes little."""
STRAIGHT_KNEE = 35.0
"""Bend of a knee [degrees] beyond which a person does not stand."""


@dataclass(frozen=True, slots=True, eq=False)
class HeightScale:
    """The scale of a person who stands upright and whose height is known.

    ``foot`` (2,) [px] lies at ``foot_place`` (2,) [m, right and up]; ``right`` and ``up`` (2,) are unit vectors in the
    picture; ``pixel`` is the size of one [m]; heights near the top are off by ``top_sd`` [m]. ``from_eyes`` says that
    the eyes' expected height made the scale, which then tells nothing of them. The camera looks straight at the place
    ``ahead`` (2,) [m, right and up] from ``distance`` [m], where that is known; ``notes`` say what all this rests on.
    """

    foot: Array
    foot_place: Array
    right: Array
    up: Array
    pixel: float
    sd_share: float
    height_sd: float
    top_sd: float
    from_eyes: bool
    notes: tuple[str, ...]
    ahead: Array
    distance: float | None = None

    @classmethod
    def of(
        cls, skeleton: Skeleton, prior: Prior, view: View = "front", *, focal_px: float | None = None
    ) -> "HeightScale":
        """The scale from the stature typed: crown to heels where both are known, else eyes, else ankles.

        The eyes stand as high as the prior expects. The vertical is the body's own, from the ankles to the shoulders;
        from the side only where it is off the picture's by more than `UPRIGHT`, as a standing body leans by itself.
        Where the focal length [px] is known, of a picture that was not cropped, so is the distance of the camera.

        Raises:
            DataError: where neither heels nor ankles, or neither crown nor eyes are in the picture, or nobody stands.

        """
        points = skeleton.trusted()
        _check_standing(points)
        sole = prior.told.sole_m
        foot_name, foot, foot_height, foot_sd = _foot(points, sole)
        top_name, top, top_height, top_sd = _top(points, prior)
        up = _vertical(points, foot, view)
        length = float((top - foot) @ up)
        if length < 1.0:
            raise DataError(f"The {foot_name} lie above the {top_name} in the picture: turn it upright")
        top_sd = hypot(top_sd, POINT_SD, _stature_sd(prior))
        pixel = (top_height - foot_height) / length
        distance = None if focal_px is None else focal_px * pixel
        right = np.array([-up[1], up[0]])
        shoulders = middle(points, "lsh", "rsh")
        beside = 0.0 if shoulders is None else float((shoulders - foot) @ right)
        return cls(
            foot=foot,
            foot_place=np.array([0.0, foot_height]),
            right=right,
            up=up,
            pixel=pixel,
            sd_share=hypot(top_sd, foot_sd) / (top_height - foot_height),
            height_sd=foot_sd,
            top_sd=top_sd,
            from_eyes=top_name == "eyes",
            notes=(_assumption(top_name, top_height, foot_name, foot_height, up, distance),),
            ahead=np.array([beside * pixel, CHEST * prior.stature + sole]),
            distance=distance,
        )

    def place(self, points: Array) -> Array:
        """Pixels (n, 2) as metres (n, 2), right of the feet and above the floor."""
        offsets = (np.asarray(points, dtype=float) - self.foot) * self.pixel
        return np.column_stack([offsets @ self.right, offsets @ self.up]) + self.foot_place

    def nearer(self, distance: float) -> "HeightScale":
        """The scale of a plane so much nearer to the camera [m], where the camera's distance is known."""
        if self.distance is None:
            return self
        share = max(0.0, 1.0 - distance / self.distance)
        place = self.ahead + share * (self.foot_place - self.ahead)
        return replace(self, pixel=share * self.pixel, foot_place=place)

    def possible(self) -> "tuple[HeightScale, HeightScale]":
        """The scales of the nearest and of the farthest camera that an unknown one may be (`UNKNOWN_DISTANCE`)."""
        near, far = UNKNOWN_DISTANCE
        return replace(self, distance=near), replace(self, distance=far)


def _assumption(top_name: str, top: float, foot_name: str, foot: float, up: Array, distance: float | None) -> str:
    tilt = degrees(atan2(up[0], -up[1]))
    upright = f"upright in a picture tilted by {tilt:.0f} degrees" if abs(tilt) >= 1.0 else "upright"
    return (
        f"scale: {top_name} {top:.3f} m and {foot_name} {foot:.3f} m above the floor, the person {upright}, "
        f"the camera level at chest height and {_distance_in_words(distance)}"
    )


def _distance_in_words(distance: float | None) -> str:
    if distance is None:
        return "{:g} to {:g} m away".format(*UNKNOWN_DISTANCE)
    if distance >= FAR_ENOUGH:
        return f"{distance:.1f} m away"
    return f"only {distance:.1f} m away: take the picture again from {FAR_ENOUGH:g} m or more"


def _check_standing(points: dict[str, Keypoint]) -> None:
    for side in "lr":
        joints = [points.get(side + joint) for joint in ("hip", "kn", "an")]
        hip, knee, ankle = (None if p is None else np.array(p[:2]) for p in joints)
        if hip is None or knee is None or ankle is None:
            continue
        if (bend := bend_between(knee - hip, ankle - knee)) > STRAIGHT_KNEE:
            raise DataError(
                f"A knee is bent by {bend:.0f} degrees, but the scale from the height needs a person who stands: "
                "stand upright, or use the printed marker"
            )


def _foot(points: dict[str, Keypoint], sole: float) -> tuple[str, Array, float, float]:
    if (heels := middle(points, "lheel", "rheel")) is not None:
        return "heels", heels, HEEL_HEIGHT + sole, HEEL_SD
    if (ankles := middle(points, "lan", "ran")) is not None:
        return "ankles", ankles, ANKLE_HEIGHT + sole, ANKLE_SD
    raise DataError("The feet are not seen: show the whole body down to the shoes, in good light")


def _top(points: dict[str, Keypoint], prior: Prior) -> tuple[str, Array, float, float]:
    sole = prior.told.sole_m
    if (crown := middle(points, "crown")) is not None:
        return "crown", crown, prior.stature + sole, CROWN_SD
    if (eyes := middle(points, "leye", "reye")) is not None:
        standing = prior.told.seat_height_m is None
        return "eyes", eyes, float(prior.mean[0]) if standing else EYE_SHARE * prior.stature + sole, EYE_SD
    raise DataError("The eyes are not seen in the picture: show the face, without sunglasses")


def _stature_sd(prior: Prior) -> float:
    return REPORTED_SD if prior.told.self_reported else TAPE_SD["stature"]


def _vertical(points: dict[str, Keypoint], foot: Array, view: View) -> Array:
    """The vertical in the picture (2,), a unit vector."""
    picture = np.array([0.0, -1.0])
    ankles, shoulders = middle(points, "lan", "ran"), middle(points, "lsh", "rsh")
    body = (shoulders if shoulders is not None else foot + picture) - (ankles if ankles is not None else foot)
    if (length := hypot(*body)) < 1.0:
        return picture
    up = body / length
    if view == "front":
        return up
    lean = _lean(points, up)
    return lean if bend_between(lean, picture) > UPRIGHT else picture


def _lean(points: dict[str, Keypoint], up: Array) -> Array:
    """The vertical of a body seen from the side, whose ankles lie a little behind the shoulders."""
    ahead = facing(points)
    right = np.array([-up[1], up[0]])
    side = 0.0 if ahead is None else float(np.sign(ahead @ right))
    corrected = up - side * ANKLE_BEHIND / 0.75 * right
    return np.asarray(corrected / hypot(*corrected))
