"""The five measures that are expected of a person who typed a few, and how far they may lie off.

What the survey of `ansur` holds is regressed on what was typed. It does not hold four things, which stand
here as constants with a doubt of their own: where the shoulder's pivot lies, how far the index finger
reaches, how far the eye lies in front of the shoulder, and how a person sits.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from armspan.body.ansur import ANSUR, SIZES, Size
from armspan.body.told import Told
from armspan.frames import Array

PIVOT_BELOW, PIVOT_SD = 0.015, 0.017
"""How far the pivot lies below the acromion [m].

The skeleton's joint lies 43 mm lower (rendered bodies, MakeHuman), the centre about which the whole shoulder
turns while the arm is raised 0 to 2 % of the trunk's height off the acromion (Amabile et al. 2016, J Biomech
49:1938): a judgement between the two.
"""

INDEX_SHORT = 0.007
"""How much earlier a pointing index finger ends than the middle finger, to which hands are measured [m]."""

REACH_SD = 0.008
"""Doubt of the arm's length beside the pivot's: the index finger, and how much shorter a lower pivot makes it."""

FORWARD_SHARE, FORWARD_SD = 0.067, 0.022
"""How far the eye lies in front of the shoulder: its share of the stature (rendered bodies), and the head's posture."""

UNSURE_EYE_SD = 0.035
"""Doubt sideways [m] where it is not known which eye sights: half the pupils' distance, and the rest."""

SEAT_SD = 0.025
"""Doubt of a seated eye's height [m]: the cushion gives way, and nobody sits as erect as in a survey (assumed)."""

TAPE_SD: Mapping[Size, float] = {"stature": 0.005, "span": 0.010, "acromion height": 0.010, "forearm and hand": 0.007}
"""How far a size measured with a tape at home lies off [m] (assumed)."""

REPORTED_BIAS, REPORTED_SD = 0.019, 0.027
"""Self-reported less measured stature [m], mean and standard deviation in ANSUR II."""


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What is expected of a person: ``mean`` (5,) [m] and ``covariance`` (5, 5) [m²] in the order of `MEASURES`.

    Eye height is above the floor, soles included. ``upper_arm`` runs from the pivot to the elbow and
    ``elbow_to_fingertip`` on to the index fingertip, ``hand`` from the wrist crease to it; ``stature`` is
    barefoot; all in metres, the likeliest values.
    """

    mean: Array
    covariance: Array
    upper_arm: float
    elbow_to_fingertip: float
    hand: float
    stature: float
    told: Told


def prior(told: Told, seen: Mapping[Size, tuple[float, float]] | None = None) -> Prior:
    """The five measures expected of the person who typed ``told``.

    ``seen`` are sizes of the survey measured in another way, a picture's span for one: (value, standard
    deviation) [m]. A span tells more of the arm than the distance from shoulder to fingertip seen with the arms
    out level: there the survey's arms end 97 mm (men, SD 13) or 86 mm (women) nearer to the acromion than the
    arm is long, as the shoulder moves inward while the arm is raised sideways.

    The survey's arm runs from the acromion down the hanging arm to the middle fingertip. A pivot that lies
    lower by some length on that arm leaves an arm shorter by the same length, and raises the eye above the
    pivot by it: hence `PIVOT_BELOW` with opposite signs, and a doubt which up and the arm's length share,
    fully and inversely correlated. Rendered bodies say 20 mm shorter for 43 mm lower, as the joint lies
    inward too; `REACH_SD` covers the difference. The arm then ends at the index finger, `INDEX_SHORT` earlier.
    """
    person = ANSUR.given(typed_sizes(told)).given(seen or {})
    weights = np.array([_weights(combination) for combination in _measures(told)])
    covariance = weights @ person.covariance @ weights.T + _doubts(told)
    if told.eye == "both":
        covariance[2, 2] = UNSURE_EYE_SD**2
    sizes = dict(zip(SIZES, person.mean.tolist(), strict=True))
    return Prior(
        mean=weights @ person.mean + _offsets(told),
        covariance=(covariance + covariance.T) / 2.0,
        upper_arm=sizes["upper arm"] - PIVOT_BELOW,
        elbow_to_fingertip=sizes["forearm"] + sizes["hand"] - INDEX_SHORT,
        hand=sizes["hand"] - INDEX_SHORT,
        stature=sizes["stature"],
        told=told,
    )


def typed_sizes(told: Told) -> dict[Size, tuple[float, float]]:
    """What was typed as sizes of the survey: (value, standard deviation) [m]."""
    typed: dict[Size, tuple[float, float]] = {}
    if told.height_m is not None:
        bias, sd = (REPORTED_BIAS, REPORTED_SD) if told.self_reported else (0.0, TAPE_SD["stature"])
        typed["stature"] = (told.height_m - bias, sd)
    if told.sex is not None:
        typed["man"] = (1.0 if told.sex == "man" else 0.0, 0.0)
    taped: dict[Size, float | None] = {
        "span": told.span_m,
        "acromion height": told.shoulder_height_m,
        "forearm and hand": told.forearm_hand_m,
    }
    typed |= {name: (value, TAPE_SD[name]) for name, value in taped.items() if value is not None}
    return typed


def _weights(combination: Mapping[Size, float]) -> Array:
    return np.array([combination.get(name, 0.0) for name in SIZES])


def _measures(told: Told) -> tuple[Mapping[Size, float], ...]:
    """The five measures as sums of the survey's sizes, the acromion taken as pivot."""
    shoulder = _left(told.arm)
    eye = _left(told.arm if told.eye == "both" else told.eye)
    return (
        {"eye height": 1.0} if told.seat_height_m is None else {"eye over seat": 1.0},
        {"stature": FORWARD_SHARE},
        {"half pupils": eye, "half breadth": -shoulder},
        {"eye height": 1.0, "acromion height": -1.0},
        {"upper arm": 1.0, "forearm": 1.0, "hand": 1.0},
    )


def _left(side: str) -> float:
    """+1.0 for what is on the left, -1.0 on the right."""
    return 1.0 if side == "left" else -1.0


def _offsets(told: Told) -> Array:
    floor = told.sole_m if told.seat_height_m is None else told.seat_height_m
    return np.array([floor, 0.0, 0.0, PIVOT_BELOW, -PIVOT_BELOW - INDEX_SHORT])


def _doubts(told: Told) -> Array:
    """Covariance (5, 5) [m²] of what the survey does not hold."""
    pivot = PIVOT_SD * np.array([0.0, 0.0, 0.0, 1.0, -1.0])
    seat = 0.0 if told.seat_height_m is None else SEAT_SD
    return np.diag([seat**2, FORWARD_SD**2, 0.0, 0.0, REACH_SD**2]) + np.outer(pivot, pivot)
