"""Drawing people: sizes from anthropometry, habits from motion capture of people who point without a cursor.

Most numbers restate or were fitted to two open data sets: 13 people pointing at 27 targets 5 times each in
virtual reality (TorSalve, modelling-human-pointing), and straight arms that follow a flying robot (Gromov,
Gambardella, Giusti, IROS 2018). Those who point with the left arm are the mirror image.
"""

from dataclasses import replace
from typing import Literal

import numpy as np

from armspan.errors import ConfigError
from armspan.records import Arm, Vec2, Vec3
from armspan.simulation.anatomy import Person, Posture, draw_sizes, sideways
from armspan.simulation.habits import Aim, Coefficients, Elbow, Feedback, SetUp, Steadiness, Surface, Trunk

_STATURE = {"man": (1.756, 0.069), "woman": (1.628, 0.064)}
_SEAT = 0.45
_SURFACE_SHAPE = np.array([1.0, 1.0, 0.7, 0.7, 0.7, 0.5])


def draw_person(
    rng: np.random.Generator,
    *,
    arm: Arm = "right",
    posture: Posture = "straight",
    stature: float | None = None,
    sex: Literal["man", "woman"] | None = None,
    seated: bool = False,
) -> Person:
    """Draw one person; what is not told is drawn too.

    With ``posture`` "straight" the person was asked to stretch the arm and to face the front, with "natural"
    to nothing: then the elbow is bent and the shoulder turned in. ``stature`` is in metres.

    Raises:
        ConfigError: on a stature that is not a grown person's.

    """
    if sex is None:
        sex = "man" if rng.uniform() < 0.5 else "woman"
    if stature is None:
        stature = float(rng.normal(*_STATURE[sex]))
    if not 1.2 <= stature <= 2.3:
        raise ConfigError(f"stature {stature:g} m: expected 1.2 to 2.3 m; is it in another unit?")
    side = sideways(arm)
    return replace(
        _draw_body(stature, sex == "man", arm, seated, rng),
        posture=posture,
        aim=_draw_aim(side, rng),
        elbow=_draw_elbow(side, posture, rng),
        trunk=_draw_trunk(side, posture, rng),
        setup=_draw_setup(rng),
        feedback=_draw_feedback(rng),
        steadiness=_draw_steadiness(seated, rng),
    )


def _draw_body(stature: float, man: bool, arm: Arm, seated: bool, rng: np.random.Generator) -> Person:
    sizes = draw_sizes(stature, man, rng)
    # The joint's centre lies below the bony top of the shoulder and nearer to the neck than its edge.
    below, inside = float(rng.normal(0.018, 0.008)), float(rng.normal(0.025, 0.006))
    # Sighting dominance: the eye of the writing hand's side in about 7 of 10 (Lopes-Ferreira et al. 2013).
    other: Arm = "left" if arm == "right" else "right"
    eye: Arm = arm if rng.uniform() < 0.72 else other
    aside = sideways(eye) * sizes.eyes_apart / 2.0 - sideways(arm) * (sizes.half_biacromial - inside)
    forward = 0.067 * stature + float(rng.normal(0.0, 0.022))
    return Person(
        eye_height=_SEAT + sizes.seated_eye_height if seated else sizes.eye_height,
        shoulder_to_eye=(forward, aside, sizes.eye_height - sizes.acromion_height + below),
        upper_arm=sizes.acromion_elbow - below,
        forearm=sizes.forearm,
        hand=sizes.hand - 0.007,  # the index finger ends short of the middle one
        arm=arm,
        dominant_eye=eye,
        eyes_apart=sizes.eyes_apart,
        stature=stature,
        seated=seated,
    )


def _pair(means: Vec2, sds: Vec2, side: float, rng: np.random.Generator) -> Vec2:
    # Degrees; a mean to the left is that of a right arm.
    left, up = np.radians(rng.normal(means, sds))
    return -side * float(left), float(up)


def _coefficients(means_deg: Vec3, sd_deg: float, rng: np.random.Generator) -> Coefficients:
    # The means belong to azimuth, elevation and distance: a mirrored person keeps them.
    azimuth, elevation, distance = means_deg
    mean = np.array([azimuth, elevation, 0.0, 0.0, 0.0, distance])
    drawn = np.radians(mean + sd_deg * _SURFACE_SHAPE * rng.standard_normal(6)).tolist()
    return (drawn[0], drawn[1], drawn[2], drawn[3], drawn[4], drawn[5])


def _spread(median: Vec2, share: float, rng: np.random.Generator) -> Vec2:
    # Standard deviations differ between people by a factor, the same sideways and up.
    left, up = np.radians(np.array(median) * np.exp(share * rng.standard_normal()))
    return float(left), float(up)


SLIP = 0.015
"""Share of gestures that end tens of degrees elsewhere: 8 of 810 in the six people at hand, more in all 13."""


def _draw_aim(side: float, rng: np.random.Generator) -> Aim:
    """Errors of aim, seen from the dominant eye.

    The study's bias, az -2.3 deg (sd 2), is seen from between the eyes; the dominant eye's 3 cm aside make
    2.2 deg of it one way or the other, so that what is left over is smaller.
    """
    surface = Surface(_coefficients((0.0, 0.0, 0.0), 1.7, rng), _coefficients((0.0, 0.0, 1.2), 1.7, rng))
    bias = _pair((-1.5, 0.7), (1.4, 1.5), side, rng)
    return Aim(bias, surface, repeat=_spread((0.62, 0.66), 0.15, rng), slip=SLIP)


def _draw_elbow(side: float, posture: Posture, rng: np.random.Generator) -> Elbow:
    """The bend of the elbow.

    Asked to stretch the arm, a person still keeps some 3 deg at the fingertip, which is 7 deg at the elbow;
    what varies of it, with what varies of the aim, leaves 1 to 1.7 deg in the robot-following recordings.
    """
    stretched = _pair((2.5, -0.8), (1.2, 1.0), side, rng)
    return _straight_elbow(stretched, rng) if posture == "straight" else _bent_elbow(stretched, side, rng)


def _straight_elbow(stretched: Vec2, rng: np.random.Generator) -> Elbow:
    roll, upper_roll = np.radians(rng.normal(0.0, (15.0, 10.0))).tolist()
    return Elbow(
        bend=stretched,
        surface=Surface(_coefficients((0.0, 0.0, 0.0), 0.8, rng), _coefficients((0.0, -0.4, 0.0), 0.8, rng)),
        repeat=_spread((0.6, 0.5), 0.2, rng),
        stretched=stretched,
        wrist=_pair((0.0, 0.0), (1.5, 1.5), -1.0, rng),
        wrist_repeat=float(np.radians(0.7)),
        roll=roll,
        upper_roll=upper_roll,
        roll_repeat=float(np.radians(4.0)),
    )


def _bent_elbow(stretched: Vec2, side: float, rng: np.random.Generator) -> Elbow:
    # The elbow stands out to its own side, by a little in most and by much in some (13 deg, sd 9). Some also
    # keep it less alike than others: within a person 2 to 7 deg.
    inward, above = float(rng.gamma(1.7, 7.0)), float(rng.normal(-4.2, 5.0))
    loose = float(np.exp(0.65 * rng.standard_normal() - 0.42))
    roll, upper_roll = np.radians(rng.normal(15.0, (25.0, 15.0))).tolist()
    return Elbow(
        bend=(-side * float(np.radians(inward)), float(np.radians(above))),
        surface=Surface(
            _coefficients((1.7, 0.0, 0.0), 4.7 * loose, rng),
            _coefficients((0.0, -4.5, 0.0), 4.7 * loose, rng),
        ),
        repeat=_spread((2.6, 1.4), 0.3, rng),
        stretched=stretched,
        wrist=_pair((0.0, 0.0), (4.0, 4.0), side, rng),
        wrist_repeat=float(np.radians(1.5)),
        roll=-side * roll,
        upper_roll=-side * upper_roll,
        roll_repeat=float(np.radians(6.0)),
    )


def _draw_trunk(side: float, posture: Posture, rng: np.random.Generator) -> Trunk:
    """What shoulder and head do.

    In the study the pointing shoulder lay only 9 cm beside the middle of the eyes where a tape finds 18:
    unasked, people turn that side forward, draw the shoulder in and lean the head over the arm. Head and
    shoulder moved by 1.0 and 0.6 cm to the left for every 10 deg of azimuth, up by 0.9 and 0.5 of elevation.
    """
    free = posture == "natural"
    mean, sd = (34.0, 8.0) if free else (6.0, 5.0)
    forward, inward, up = rng.normal((0.02, 0.05, 0.0) if free else (0.01, 0.005, 0.0), 0.01)
    return Trunk(
        turn=-side * float(np.radians(rng.normal(mean, sd))),
        turn_gain=0.26 if free else 0.15,
        shift=(float(forward), -side * float(inward), float(up)),
        shift_repeat=(0.010, 0.004, 0.006) if free else (0.008, 0.004, 0.005),
        rise=0.028,
        head_gain=(float(rng.uniform(0.4, 0.9)), float(rng.uniform(0.4, 0.7))),
    )


def _draw_setup(rng: np.random.Generator) -> SetUp:
    level, heading, hang = np.radians((3.0, 4.0, 3.0)).tolist()
    return SetUp(level, heading, hang, hang_bend=float(np.radians(rng.normal(4.0, 3.0))))


def _draw_feedback(rng: np.random.Generator) -> Feedback:
    # The floor leaves what users of a laser were left with, 0.65 to 0.9 deg (ICRA 2019 feedback study).
    return Feedback(
        lag=float(rng.uniform(0.1, 0.2)),
        gain=float(rng.uniform(0.6, 0.9)),
        noise=0.1,
        floor=float(np.radians(0.2)),
        tolerance=float(np.radians(0.4)),
    )


def _draw_steadiness(seated: bool, rng: np.random.Generator) -> Steadiness:
    # Held aims of 5 s: medians 0.45 deg sideways and 0.16 deg up; standing heads: 1.6, 1.4, 0.6 cm.
    forward, left, up = np.array((0.017, 0.014, 0.006)) * (0.4 if seated else 1.0)
    sideways_deg, up_deg = rng.uniform(0.25, 0.45), rng.uniform(0.14, 0.28)
    return Steadiness(
        hold=(float(np.radians(sideways_deg)), float(np.radians(up_deg))),
        elbow=float(np.radians(0.2)),
        tremor=float(np.radians(0.005)),
        sway=(float(forward), float(left), float(up)),
    )
