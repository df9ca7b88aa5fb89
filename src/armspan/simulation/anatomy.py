"""The sizes of a virtual person's body, and what a helper with a tape measure would write down."""

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from armspan import records
from armspan.frames import Array
from armspan.records import Vec3
from armspan.simulation.arm import Arm
from armspan.simulation.habits import Aim, Elbow, Feedback, SetUp, Steadiness, Trunk

Posture: TypeAlias = Literal["natural", "straight"]
Side: TypeAlias = records.Arm

PIVOT_SD = 0.015
"""How well a helper finds the shoulder's pivot under the skin [m]: 1 to 4 cm below the shoulder's top."""


@dataclass(frozen=True, slots=True)
class Person:
    """One person: true sizes [m] and habits; those that are left out are flawless.

    ``shoulder_to_eye`` runs from the pivot of the pointing shoulder to the dominant eye (forward, left, up)
    when the person stands upright and looks ahead; ``eye_height`` is above the floor, also when seated.
    """

    eye_height: float
    shoulder_to_eye: Vec3
    upper_arm: float
    forearm: float
    hand: float
    arm: records.Arm = "right"
    dominant_eye: Side = "right"
    eyes_apart: float = 0.063
    stature: float = 1.7
    posture: Posture = "straight"
    seated: bool = False
    aim: Aim = field(default_factory=Aim)
    elbow: Elbow = field(default_factory=Elbow)
    trunk: Trunk = field(default_factory=Trunk)
    setup: SetUp = field(default_factory=SetUp)
    feedback: Feedback = field(default_factory=Feedback)
    steadiness: Steadiness = field(default_factory=Steadiness)

    @property
    def lengths(self) -> Arm:
        """The arm's three lengths."""
        return Arm(self.upper_arm, self.forearm, self.hand)

    @property
    def shoulder_offset(self) -> float:
        """How far the pivot lies to the left of the middle between the eyes [m]; negative on the right."""
        return -self.shoulder_to_eye[1] + sideways(self.dominant_eye) * self.eyes_apart / 2.0


def sideways(side: Side) -> float:
    """+1.0 for the left, -1.0 for the right: y points left."""
    return 1.0 if side == "left" else -1.0


@dataclass(frozen=True, slots=True)
class Sizes:
    """Body measures [m] of an erect, barefoot person; seated eye height is above the seat."""

    eye_height: float
    acromion_height: float
    half_biacromial: float
    eyes_apart: float
    acromion_elbow: float
    forearm: float
    hand: float
    seated_eye_height: float


# Linear in (1, stature [m], man) with what is left over: ANSUR II, 2012 US Army survey, 4082 men and 1986
# women, least squares; rows as in `Sizes`, in mm. Hand is to the middle fingertip.
_COEFFICIENTS = np.array(
    [
        [-43.9, 960.0, 0.3],
        [-112.0, 888.6, -7.9],
        [58.6, 76.2, 15.4],
        [45.9, 9.7, 1.1],
        [-23.5, 205.6, -2.2],
        [-21.7, 161.5, 5.9],
        [20.3, 98.7, -0.4],
        [158.0, 362.1, 10.6],
    ]
)
_RESIDUAL_SD = np.array([8.3, 15.4, 7.9, 3.4, 10.6, 10.9, 7.5, 21.2])
_RESIDUAL_CORRELATION = np.array(
    [
        [1.00, 0.19, 0.00, 0.02, 0.12, 0.12, 0.10, 0.10],
        [0.19, 1.00, -0.09, 0.08, 0.29, 0.16, 0.09, -0.25],
        [0.00, -0.09, 1.00, 0.18, 0.08, 0.13, 0.22, 0.02],
        [0.02, 0.08, 0.18, 1.00, 0.12, 0.25, 0.27, -0.19],
        [0.12, 0.29, 0.08, 0.12, 1.00, 0.34, 0.22, -0.36],
        [0.12, 0.16, 0.13, 0.25, 0.34, 1.00, 0.40, -0.51],
        [0.10, 0.09, 0.22, 0.27, 0.22, 0.40, 1.00, -0.28],
        [0.10, -0.25, 0.02, -0.19, -0.36, -0.51, -0.28, 1.00],
    ]
)


def draw_sizes(stature: float, man: bool, rng: np.random.Generator) -> Sizes:
    """Sizes of one body of that ``stature`` [m] and sex (ANSUR II, 2012)."""
    expected = _COEFFICIENTS @ np.array([1.0, stature, float(man)])
    spread = np.linalg.cholesky(_RESIDUAL_CORRELATION) @ rng.standard_normal(len(expected))
    return Sizes(*((expected + _RESIDUAL_SD * spread) / 1000.0).tolist())


def measured_body(person: Person, rng: np.random.Generator, *, tape_sd: float = 0.01) -> records.Body:
    """What a helper with a tape measure would write down: the truth with errors of ``tape_sd`` [m].

    The forward distance, which no tape can be laid along, errs twice as much; and the pivot is taken too
    high or too low by `PIVOT_SD`, which the height and, by about half, the arm's lengths share.
    """
    tape: Array = tape_sd * rng.standard_normal(7) * [1.0, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    pivot = PIVOT_SD * float(rng.standard_normal()) * (tape_sd > 0.0)
    forward, left, up = person.shoulder_to_eye
    lower = person.forearm + person.hand
    eye, ahead, aside, above, whole, upper, rest = tape.tolist()
    return records.Body(
        eye_height_m=person.eye_height + eye,
        shoulder_to_eye_m=(forward + ahead, left + aside, up + above - pivot),
        shoulder_to_fingertip_m=person.upper_arm + lower + whole + pivot / 2.0,
        arm=person.arm,
        upper_arm_m=person.upper_arm + upper + pivot / 2.0,
        elbow_to_fingertip_m=lower + rest,
    )
