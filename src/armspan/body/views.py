"""What a front and a side picture tell of the five measures.

A skeleton's shoulder point lies near the joint; `PIVOT_ABOVE` and its like lead from it to the body's pivot. Standard
deviations are those found on rendered bodies, bare and clothed, widened for real clothes and cameras not quite level.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot
from typing import Literal

import numpy as np

from armspan.body.anthropometry import Prior
from armspan.body.depth import depths_of, place
from armspan.body.observation import Measure, Observation
from armspan.body.scale import FAR_ENOUGH, HeightScale, Scale, View
from armspan.body.skeleton import TRUSTED, Skeleton, middle
from armspan.body.stance import check_arm_is_there, check_pose, forward_sign, held_out, length_to_wrist
from armspan.frames import Array
from armspan.records import Arm

PIVOT_ABOVE = 0.010
"""How far the pivot lies above a skeleton's shoulder point [m].

The rig's joint lies 28 mm below it, but the networks see the shoulder of a raised arm 17 (front) to 35 mm (side)
above the joint (24 rendered bodies).
"""
PIVOT_OUTSIDE = 0.022
"""How far outward of the shoulder point the pivot lies [m], seen from the front (the same bodies)."""
PIVOT_REACH: dict[View, float] = {"front": 0.026, "side": 0.036}
"""How much longer the arm is from the pivot than from the shoulder point [m] (the same bodies)."""
EYE_AHEAD = 0.005
"""How far the eye lies ahead of where it is seen from the side [m] (the same bodies)."""
PIVOT_DOUBT = 0.013
"""Standard deviation of each of these [m]: two networks differ by 10 mm."""
SD: dict[Measure, float] = {"eye height": 0.010, "forward": 0.018, "left": 0.008, "up": 0.012, "arm length": 0.016}
"""Standard deviations of one picture [m], without those of scale and pivot."""
TOO_NEAR = 2.0
"""How many times greater doubts are of a picture from nearer than `FAR_ENOUGH` that only a height gives its scale."""
ONE_ARM_SD = 0.016
"""Further doubt of an arm measured alone [m]: a person turned by 6 degrees holds its end nearer the camera, or farther;
of two arms held out the mean stays."""
UNLIKE = 0.12
"""Share by which two arms of a person who faces the camera may differ in the picture."""
TURN_SD = 0.012
"""Further doubt [m] of how far sideways an eye lies, which is nearer the camera, where not both sides are known."""
HAND_SD = 0.010
"""Doubt of a hand's length that is taken from the prior [m]."""
HAND_SHARES = (0.75, 1.2)
"""A fingertip between these shares of the expected hand's length from the wrist is believed; a curled one is not."""


@dataclass(frozen=True, slots=True)
class Seen:
    """What a picture tells, and what is to be known of how: what was assumed, left out or filled in."""

    observations: tuple[Observation, ...]
    notes: tuple[str, ...]


def observe(skeleton: Skeleton, view: View, scale: Scale, prior: Prior) -> Seen:
    """The measures that one view shows of the pointing arm and the sighting eye, with their standard deviations.

    ``front``: facing the camera, arms out level: eye height, left, up, arm length. ``side``: the pointing arm
    stretched forward, the camera at the person's side: eye height, forward, up, arm length. Points below `TRUSTED`
    confidence or outside the picture are not used; of eye or fingertip a note tells, what the arm needs must be there.

    Raises:
        DataError: where the arm is not all in the picture, or is bent, or the pose is not that of the view.

    """
    check_arm_is_there(skeleton, prior)
    body = _Placed.of(skeleton, view, scale, prior)
    check_pose(body.points, view, prior)
    seen, filled = _measured(skeleton, view, scale, prior)
    if isinstance(scale, HeightScale) and scale.distance is None:
        near, far = (_measured(skeleton, view, one, prior)[0] for one in scale.possible())
        seen = {measure: _between(near[measure], far[measure]) for measure in seen}
    observations = [
        _observation(measure, *seen[measure], scale, f"{view} picture, {skeleton.source}") for measure in seen
    ]
    notes = [*_assumptions(scale), *body.unsure, *filled, *_not_told(view, seen, scale, prior)]
    return Seen(tuple(observations), tuple(notes))


def _measured(
    skeleton: Skeleton, view: View, scale: Scale, prior: Prior
) -> tuple[dict[Measure, tuple[float, float]], list[str]]:
    """Each measure's (value, sd) [m] without the doubt of the scale, and notes on hands that are filled in."""
    points = _Placed.of(skeleton, view, scale, prior).points
    length, filled = _arm_length(points, view, prior)
    seen: dict[Measure, tuple[float, float]] = {"arm length": length}
    shoulder = points[prior.told.arm[0] + "sh"]
    if (eyes := middle(points, "leye", "reye")) is not None:
        seen |= _up(eyes, shoulder) | _eye_height(skeleton, eyes, scale, prior)
        seen |= _forward(points, eyes, shoulder) if view == "side" else _left(points, prior)
    return seen, filled


def _between(near: tuple[float, float], far: tuple[float, float]) -> tuple[float, float]:
    """What is told where the camera's distance is not known, from what two distances tell: (value, sd) [m].

    Perspective goes with the distance's inverse: the value is that of the middle one, and either end one standard
    deviation off.
    """
    return (near[0] + far[0]) / 2.0, hypot(max(near[1], far[1]), (near[0] - far[0]) / 2.0)


@dataclass(frozen=True, slots=True)
class _Placed:
    """The trusted points of a skeleton (3,) [m, right, up and nearer] and what is to be said of the others."""

    points: dict[str, Array]
    unsure: tuple[str, ...]

    @classmethod
    def of(cls, skeleton: Skeleton, view: View, scale: Scale, prior: Prior) -> "_Placed":
        trusted = skeleton.trusted()
        depths = depths_of(place(trusted, scale), view, prior)
        left_out = ", ".join(name for name in skeleton.points if name not in trusted)
        why = f"not used, as less sure than {TRUSTED:g} or outside the picture: {left_out}"
        return cls(place(trusted, scale, depths), (why,) if left_out else ())


def _arm_length(points: dict[str, Array], view: View, prior: Prior) -> tuple[tuple[float, float], list[str]]:
    """Pivot to index fingertip along the arm: (value, sd) [m], and notes on hands that are filled in.

    From the front it is the mean of both arms, which a person who turns a little does not change.
    """
    arms: list[Arm] = [prior.told.arm]
    other: Arm = "left" if prior.told.arm == "right" else "right"
    if view == "front" and held_out(points, other) and _alike(points):
        arms.append(other)
    hands = [_hand(points, arm, prior) for arm in arms]
    length = float(np.mean([length_to_wrist(points, arm) + hand for arm, (hand, _) in zip(arms, hands, strict=True)]))
    alone = ONE_ARM_SD if len(arms) == 1 else 0.0
    filled = [note for _, note in hands if note]
    sd = hypot(SD["arm length"], PIVOT_DOUBT, alone, HAND_SD if filled else 0.0)
    return (length + PIVOT_REACH[view], sd), filled


def _alike(points: dict[str, Array]) -> bool:
    """Whether both arms are of about one length, so that neither points toward the camera or away from it."""
    left, right = length_to_wrist(points, "left"), length_to_wrist(points, "right")
    return abs(left - right) <= UNLIKE * (left + right) / 2.0


def _hand(points: dict[str, Array], arm: Arm, prior: Prior) -> tuple[float, str]:
    """Wrist to index fingertip [m], and what is to be said where it is the prior's."""
    tip = points.get(arm[0] + "idxtip")
    hand = None if tip is None else hypot(*(tip - points[arm[0] + "wr"]))
    if hand is not None and HAND_SHARES[0] * prior.hand <= hand <= HAND_SHARES[1] * prior.hand:
        return hand, ""
    why = "not found" if hand is None else f"found {hand:.3f} m from the wrist"
    return prior.hand, f"{arm} index fingertip {why}: a hand of {prior.hand:.3f} m is added, as expected of this height"


def _up(eyes: Array, shoulder: Array) -> dict[Measure, tuple[float, float]]:
    return {"up": (float(eyes[1] - shoulder[1]) - PIVOT_ABOVE, hypot(SD["up"], PIVOT_DOUBT))}


def _eye_height(skeleton: Skeleton, eyes: Array, scale: Scale, prior: Prior) -> dict[Measure, tuple[float, float]]:
    """Height of the eyes; below a crown of known height both stand in one plane, whatever their depth."""
    if _knows_eye_height(scale, prior):
        return {}
    if not isinstance(scale, HeightScale):
        height = float(eyes[1])
        return {"eye height": (height, hypot(SD["eye height"], scale.height_sd, scale.sd_share * height))}
    below_crown = middle(place(skeleton.trusted(), scale), "leye", "reye")
    height = float((eyes if below_crown is None else below_crown)[1])
    return {"eye height": (height, hypot(SD["eye height"], scale.top_sd))}


def _knows_eye_height(scale: Scale, prior: Prior) -> bool:
    """Whether the eye's height went into the scale, or is not that of a user who sits."""
    return prior.told.seat_height_m is not None or (isinstance(scale, HeightScale) and scale.from_eyes)


def _forward(points: dict[str, Array], eyes: Array, shoulder: Array) -> dict[Measure, tuple[float, float]]:
    return {"forward": (forward_sign(points) * float(eyes[0] - shoulder[0]) + EYE_AHEAD, SD["forward"])}


def _left(points: dict[str, Array], prior: Prior) -> dict[Measure, tuple[float, float]]:
    """Shoulder to sighting eye, each from the middle of its pair where known, which a turn of the person leaves."""
    told = prior.told
    eye, shoulder = (told.arm if told.eye == "both" else told.eye)[0] + "eye", told.arm[0] + "sh"
    if eye not in points:
        return {}
    both = all(name in points for name in ("leye", "reye", "lsh", "rsh"))
    from_shoulder = float(points[eye][0] - points[shoulder][0])
    if both:
        apart = float(points["lsh"][0] - points["rsh"][0]), float(points["leye"][0] - points["reye"][0])
        from_shoulder = (_left_sign(eye) * apart[1] - _left_sign(shoulder) * apart[0]) / 2.0
    turned = 0.0 if both else TURN_SD
    unsure = float(np.sqrt(prior.covariance[2, 2])) if told.eye == "both" else 0.0
    value = from_shoulder - _left_sign(shoulder) * PIVOT_OUTSIDE
    return {"left": (value, hypot(SD["left"], PIVOT_DOUBT, turned, unsure))}


def _left_sign(name: str) -> float:
    """+1.0 for what is on the person's left, -1.0 on the right."""
    return 1.0 if name[0] == "l" else -1.0


def _observation(measure: Measure, value: float, sd: float, scale: Scale, source: str) -> Observation:
    share = 0.0 if measure == "eye height" else scale.sd_share  # a height's is already in it
    near = isinstance(scale, HeightScale) and scale.distance is not None and scale.distance < FAR_ENOUGH
    return Observation(measure, value, hypot(sd, share * value) * (TOO_NEAR if near else 1.0), source)


def _assumptions(scale: Scale) -> list[str]:
    pivot = (
        f"pivot of the arm {1000 * PIVOT_ABOVE:.0f} mm above and {1000 * PIVOT_OUTSIDE:.0f} mm outside the shoulder "
        f"point, give or take {1000 * PIVOT_DOUBT:.0f}"
    )
    return [*scale.notes, pivot]


def _not_told(view: View, seen: Iterable[Measure], scale: Scale, prior: Prior) -> list[str]:
    """Why a measure that this view could show is not among those seen."""
    sideways: Literal["forward", "left"] = "forward" if view == "side" else "left"
    missing = [measure for measure in ("eye height", sideways, "up") if measure not in seen]
    notes = []
    if "eye height" in missing and "up" not in missing:
        missing.remove("eye height")
        notes.append("eye height is not told: the scale was made of it, or it is a standing person's")
    return [*notes, f"{' and '.join(missing)} not told: the eye was not found"] if missing else notes
