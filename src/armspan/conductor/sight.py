"""What the conductor believes at one moment, for those who show it: it is asked for, and changes nothing."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from armspan.conductor.arm import Arm, Band
from armspan.conductor.pointer import Pointer
from armspan.conductor.setup import SetUp
from armspan.conductor.steering import Steering
from armspan.frames import Array
from armspan.pointing.calibration import Fit, quality
from armspan.records import Body, Vec3

UPPER_SHARE = 0.42
"""The upper arm's share of shoulder to fingertip where neither part was measured."""


@dataclass(frozen=True, slots=True)
class Limb:
    """One arm as its bands feel it: shoulder, elbow, fingertip in ``user`` [m].

    Without a band on the upper arm the elbow is drawn straight, because nothing sees it.
    """

    side: str
    points: tuple[Vec3, Vec3, Vec3]


@dataclass(frozen=True, slots=True)
class StopSeen:
    """One stop of the set-up: how far [rad] its ray passed by, and whether it was used."""

    number: int
    residual: float
    used: bool


@dataclass(frozen=True, slots=True)
class Sight:
    """The arms and the ray in ``user`` [m], the set-up's step, its stops, and what the robots are at.

    ``place`` is ``sheet_from_user`` as (x, y, z, yaw) in metres and radians, None before a calibration; ``ray`` is
    origin and direction. ``waiting`` tells why a robot stands until something new is asked of it.
    """

    step: str
    stop: int
    stops: int
    seen: tuple[StopSeen, ...]
    quality: str
    limbs: tuple[Limb, ...]
    place: tuple[float, float, float, float] | None
    ray: tuple[Vec3, Vec3] | None
    stopped: bool
    waiting: Mapping[str, str]
    running: tuple[tuple[str, tuple[str, ...]], ...]
    silent: tuple[str, ...]


def look(
    arm: Arm, body: Body, setup: SetUp, pointer: Pointer | None, steering: Steering, silent: Iterable[str]
) -> Sight:
    """What the parts of a conductor believe now."""
    seen, word = _stops_seen(setup.draft)
    number, count = setup.progress
    place, ray = None, None
    if pointer is not None:
        x, y, z, yaw = pointer.place.state[:4].tolist()
        place, ray = (x, y, z, yaw), pointer.ray
    return Sight(
        setup.step.value,
        number,
        count,
        seen,
        word,
        limbs(arm, body),
        place,
        (_vec3(ray[0]), _vec3(ray[1])) if ray is not None else None,
        steering.filter.stopped,
        dict(steering.filter.waiting),
        tuple((running.order, tuple(sorted(running.robots))) for running in steering.director.running),
        tuple(sorted(silent)),
    )


def limbs(arm: Arm, body: Body) -> tuple[Limb, ...]:
    """The arms whose bands are mounted; the other arm's shoulder is taken as mirrored at the eye."""
    seen = []
    for side, band in arm.wrists.items():
        upper = arm.upperarm if side == body.arm else None
        points = _points(band, upper, body, mirrored=side != body.arm)
        if points is not None:
            seen.append(Limb(side, points))
    return tuple(seen)


def _points(band: Band, upper: Band | None, body: Body, *, mirrored: bool) -> tuple[Vec3, Vec3, Vec3] | None:
    forearm, above = band.in_user(), upper.in_user() if upper else None
    if forearm is None:
        return None
    forward, left, up = body.shoulder_to_eye_m
    shoulder = np.array([-forward, left if mirrored else -left, body.eye_height_m - up])
    length = body.shoulder_to_fingertip_m
    first = body.upper_arm_m or UPPER_SHARE * length
    second = body.elbow_to_fingertip_m or length - first
    along = above[:, 0] if above is not None else forearm[:, 0]
    elbow = shoulder + first * along
    return _vec3(shoulder), _vec3(elbow), _vec3(elbow + second * forearm[:, 0])


def _stops_seen(fit: Fit | None) -> tuple[tuple[StopSeen, ...], str]:
    """The stops of a calibration, and its quality in a word."""
    if fit is None:
        return (), ""
    return tuple(StopSeen(int(stop.stop), float(stop.residual), stop.used) for stop in fit.stops), quality(fit)


def _vec3(values: Array) -> Vec3:
    """Three numbers of an array."""
    x, y, z = np.asarray(values, dtype=float).tolist()
    return x, y, z
