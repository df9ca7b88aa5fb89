"""What calibration does not absorb: the errors that begin after it, in millimetres on a table and on the floor.

A person calibrates without noise on four corners and then points, again without noise, while one thing is no longer
as it was. The person is that of `armspan.simulation`, which holds the fingertip of a bent arm on the line of sight;
the answer is the calibrated pointing. Nothing is drawn: this is arithmetic of rays.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armspan.frames import Array, Transform, plane_hit, yaw_rotation
from armspan.pointing.calibration import calibrate
from armspan.pointing.rays import arm_rays
from armspan.records import Vec2, Vec3
from armspan.simulation import arm as limb
from armspan.study.pointing_error.scene import UPPER_ARM_SHARE, Workplace, about, attitudes, moving

STEPS = 20
"""Up to how many units an error's growth is followed."""

LINEAR = 0.10
"""An error grows in step as long as it is within this share of its size at one unit times the units."""

EYES_APART = 0.062

_CM = 0.01
_DEG = float(np.radians(1.0))


@dataclass(frozen=True, slots=True)
class Change:
    """What is not as it is believed: all zero is a person as the system believes him to be.

    ``heading`` [rad] of the band to the left; ``slip`` [rad] of the band on the wrist about its own x, y and z axis
    (rolled, raised, to the left); ``step`` [m] of the whole person, ``head`` [m] of the eye alone (ahead, left, up);
    ``trunk`` [rad] turned to the left about the vertical through the eye; ``elbow`` [rad] between the forearm and the
    line from the shoulder to the fingertip (to the left, up); ``lift`` [m] of what is pointed at above where it is
    believed; ``scale``, by which share the sheet's coordinates are too long from its near left corner.
    """

    heading: float = 0.0
    slip: Vec3 = (0.0, 0.0, 0.0)
    step: Vec3 = (0.0, 0.0, 0.0)
    head: Vec3 = (0.0, 0.0, 0.0)
    trunk: float = 0.0
    elbow: Vec2 = (0.0, 0.0)
    lift: float = 0.0
    scale: float = 0.0


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of error: its ``unit``, what ``change`` so many units are, and what is ``usual`` [units], and whence."""

    name: str
    unit: str
    change: Callable[[float], Change]
    usual: float
    basis: str


KINDS = (
    Kind("heading drifts", "deg", lambda n: Change(heading=n * _DEG), 2.0, "a minute: 0.9 to 3.4 deg/min (IROS 2018)"),
    Kind("band slips, pitch", "deg", lambda n: Change(slip=(0.0, n * _DEG, 0.0)), 2.0, "assumed"),
    Kind("band slips, yaw", "deg", lambda n: Change(slip=(0.0, 0.0, n * _DEG)), 2.0, "assumed"),
    Kind("band slips, roll", "deg", lambda n: Change(slip=(n * _DEG, 0.0, 0.0)), 10.0, "assumed"),
    Kind("elbow bends, level", "deg", lambda n: Change(elbow=(n * _DEG, 0.0)), 2.5, "gesture to gesture (TorSalve)"),
    Kind("elbow bends, upright", "deg", lambda n: Change(elbow=(0.0, n * _DEG)), 1.4, "gesture to gesture (TorSalve)"),
    Kind("user steps aside", "cm", lambda n: Change(step=(0.0, n * _CM, 0.0)), 5.0, "assumed"),
    Kind("user steps ahead", "cm", lambda n: Change(step=(n * _CM, 0.0, 0.0)), 5.0, "assumed"),
    Kind("user stands taller", "cm", lambda n: Change(step=(0.0, 0.0, n * _CM)), 2.0, "assumed: a straightened back"),
    Kind("trunk turns", "deg", lambda n: Change(trunk=n * _DEG), 10.0, "assumed"),
    Kind("head sways aside", "cm", lambda n: Change(head=(0.0, n * _CM, 0.0)), 2.0, "standing in VR (TorSalve)"),
    Kind("head sways ahead", "cm", lambda n: Change(head=(n * _CM, 0.0, 0.0)), 2.0, "standing in VR (TorSalve)"),
    Kind("head rises", "cm", lambda n: Change(head=(0.0, 0.0, n * _CM)), 1.0, "assumed"),
    Kind("other eye aims", "eyes", lambda n: Change(head=(0.0, n * EYES_APART, 0.0)), 1.0, "62 mm between the eyes"),
    Kind("light's height ignored", "cm", lambda n: Change(lift=n * _CM), 5.0, "the report's robot: light 50 mm high"),
    Kind("sheet's scale", "%", lambda n: Change(scale=n / 100.0), 1.0, "assumed: a print fitted to the page"),
)


@dataclass(frozen=True, slots=True)
class Unabsorbed:
    """How far [mm] the places of a ``workplace`` are missed by a ``kind`` of error.

    ``per_unit_mm`` and ``p90_per_unit_mm`` are the median and 90th percentile over the calibrated square of one unit to
    either side that begins after the calibration; ``linear_to`` [units] is how far the median grows in step.
    ``usual_mm`` is the median of the ``usual`` size, ``before_mm`` of the same size if it was there, unchanged,
    already during the calibration: what calibration leaves of it.
    """

    workplace: str
    kind: str
    unit: str
    per_unit_mm: float
    p90_per_unit_mm: float
    linear_to: float
    usual: float
    usual_mm: float
    before_mm: float
    basis: str


def unabsorbed(work: Workplace) -> tuple[Unabsorbed, ...]:
    """Every kind of error at one workplace."""
    place = calibrated(work, Change())
    return tuple(_row(work, place, kind) for kind in KINDS)


def calibrated(work: Workplace, change: Change) -> Transform:
    """``sheet_from_user`` by a calibration on the four corners while a ``change`` is there."""
    corners = work.corners()
    pairs = moving(told_attitudes(work, corners, change), _told_places(work, corners, change))
    return calibrate(work.body, pairs, "head-finger", z_up=True).transform()


def missed_mm(work: Workplace, place: Transform, change: Change) -> Array:
    """Distances (n,) [mm] by which the places of the square are missed from a calibrated ``place``."""
    targets = work.grid()
    origins, directions = arm_rays(work.body, told_attitudes(work, targets, change), None, "head-finger")
    hits = plane_hit(place.points(origins), place.directions(directions), work.plane)
    return np.asarray(1000.0 * np.linalg.norm(hits - _told_places(work, targets, change), axis=1))


def told_attitudes(work: Workplace, targets: Array, change: Change) -> Array:
    """What the band tells, (n, 3, 3) ``user_from_forearm``, while the person points at targets (n, 3) [m]."""
    believed_eye = np.array([0.0, 0.0, work.body.eye_height_m])
    moved = believed_eye + change.step
    shoulder = moved - yaw_rotation(change.trunk) @ work.body.shoulder_to_eye_m
    lifted = targets + np.array([0.0, 0.0, change.lift])
    x, y, z = _forearm(work, lifted, moved + change.head, shoulder, change.elbow)
    true = attitudes(np.arctan2(y, x), np.arcsin(z))
    roll, pitch, yaw = (about(axis, angle) for axis, angle in zip(np.eye(3), change.slip * _SIGNS, strict=True))
    return np.asarray(yaw_rotation(change.heading) @ true @ yaw @ pitch @ roll)


_SIGNS = np.array([1.0, -1.0, 1.0])  # a positive turn about y, to the left, lowers x


def _forearm(work: Workplace, targets: Array, eye: Array, shoulder: Array, elbow: Vec2) -> Array:
    """Directions (3, n) of the forearm of a person whose fingertip lies on the line from the eye to each target."""
    length, count = work.body.shoulder_to_fingertip_m, len(targets)
    segments = limb.Arm(UPPER_ARM_SHARE * length, (1.0 - UPPER_ARM_SHARE) * length, 0.0)
    bend, lower = np.tile(np.array(elbow)[:, None], count), np.full(count, segments.forearm)
    reach = limb.chord(segments, bend, lower)
    eyes, shoulders = (np.tile(point[:, None], count) for point in (eye, shoulder))
    fingertip = limb.fingertip_on_sight(eyes, limb.unit(targets.T - eyes), shoulders, reach)
    towards = limb.unit(fingertip - shoulders)
    return limb.bent_arm(segments, towards, bend, np.zeros((2, count)), reach, lower).forearm


def _told_places(work: Workplace, targets: Array, change: Change) -> Array:
    """Where the sheet says its places are, (n, 3) [m]."""
    origin = np.array([*work.origin(), work.plane])
    return np.asarray(origin + (1.0 + change.scale) * (targets - origin))


def _row(work: Workplace, place: Transform, kind: Kind) -> Unabsorbed:
    one = _both_ways(work, place, kind, 1.0)
    usual = _both_ways(work, place, kind, kind.usual)
    before = [kind.change(sign * kind.usual) for sign in (1.0, -1.0)]
    left = np.concatenate([missed_mm(work, calibrated(work, change), change) for change in before])
    return Unabsorbed(
        work.name,
        kind.name,
        kind.unit,
        float(np.median(one)),
        float(np.percentile(one, 90)),
        _linear_to(work, place, kind, float(np.median(one))),
        kind.usual,
        float(np.median(usual)),
        float(np.median(left)),
        kind.basis,
    )


def _both_ways(work: Workplace, place: Transform, kind: Kind, size: float) -> Array:
    return np.concatenate([missed_mm(work, place, kind.change(sign * size)) for sign in (1.0, -1.0)])


def _linear_to(work: Workplace, place: Transform, kind: Kind, slope: float) -> float:
    """The largest number of units up to which the median is the slope times the units, within `LINEAR`."""
    last = 1 if kind.unit == "eyes" else STEPS
    for size in range(2, last + 1):
        for sign in (1.0, -1.0):
            median = float(np.median(missed_mm(work, place, kind.change(sign * size))))
            if not abs(median - slope * size) <= LINEAR * slope * size + 1e-6:
                return float(size - 1)
    return float(last)
