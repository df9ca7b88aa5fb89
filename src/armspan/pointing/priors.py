"""What is known beside the pairs: the plane's height, the band's pitch on the wrist, the body's measures.

The most probable place under these priors (MAP) is found from the plain fit by scipy's least squares: an
optional path, so plain code matters more than its few milliseconds. The eye's height is never freed: it and the
sheet's height are one number to the rays (the scene may be lifted with the eye), so where the plane's height is
told, the doubt about the eye's height widens that prior instead.
"""

from dataclasses import dataclass, replace

import msgspec
import numpy as np
from scipy.optimize import least_squares

from armspan.errors import CalibrationError
from armspan.frames import Array
from armspan.pointing.laser import LaserSettings
from armspan.pointing.least_squares import Problem, miss
from armspan.pointing.pairs import Pairs
from armspan.pointing.rays import arm_rays
from armspan.records import Body, Model

PITCH_SD = float(np.radians(3.0))
"""How far a band's pitch on the wrist is off after zeroing [rad]; a wrist is not a cylinder."""


TABLE_SD = 0.01
"""How well a table's height is measured with a tape [m], floor and sheet included."""


@dataclass(frozen=True, slots=True)
class Priors:
    """What to assume; None or False leaves a quantity as it is.

    ``plane_height`` is the height [m] of the sheet's z = 0 above the user's floor with its standard deviation
    [m]; ``pitch_sd`` [rad] frees the band's pitch on the wrist; ``measures`` frees the body's measures within
    `Body.covariance`.
    """

    plane_height: tuple[float, float] | None = None
    pitch_sd: float | None = None
    measures: bool = False

    def __bool__(self) -> bool:
        return self.plane_height is not None or self.pitch_sd is not None or self.measures


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """A place (4,) with its covariance (4, 4), the body and the band's pitch [rad] it holds for, and its problem."""

    place: Array
    covariance: Array
    body: Body
    pitch: float
    problem: Problem


def pitched(user_from_forearm: Array, pitch: float) -> Array:
    """Attitudes (..., 3, 3) of a forearm whose band sits turned by ``pitch`` [rad] about the wrist's y axis."""
    c, s = np.cos(pitch), np.sin(pitch)
    return np.asarray(user_from_forearm @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]))


def refine(
    plain: Refined,
    pairs: Pairs,
    model: Model,
    sigma: float,
    priors: Priors,
    floor: float,
    laser: LaserSettings | None = None,
) -> Refined:
    """The most probable place near the ``plain`` fit, for pointing noise ``sigma`` [rad].

    ``floor`` [m] is the height of the points' centroid above the sheet's z = 0.

    Raises:
        CalibrationError: if the measures are to be freed but their covariance is not known.

    """
    spread, doubt = _doubts(plain.body, priors)

    def moved(freed: Array) -> tuple[Body, float, Problem]:
        body, pitch = _changed(plain.body, freed, priors)
        forearm = pitched(pairs.user_from_forearm, pitch)
        origins, directions = arm_rays(body, forearm, pairs.user_from_upperarm, model, laser)
        return body, pitch, replace(plain.problem, origins=origins, directions=directions)

    def whitened(x: Array) -> Array:
        problem = moved(x[4:])[2]
        seen = _robust(miss(problem, x[:4]), problem) / sigma
        height = [] if priors.plane_height is None else [(x[2] - floor - priors.plane_height[0]) / doubt]
        return np.concatenate([seen.ravel(), np.linalg.solve(spread, x[4:]), height])

    found = least_squares(whitened, np.concatenate([plain.place, np.zeros(len(spread))]), x_scale="jac")
    covariance = np.linalg.inv(found.jac.T @ found.jac)[:4, :4]
    return Refined(found.x[:4], covariance, *moved(found.x[4:]))


def _robust(misses: Array, problem: Problem) -> Array:
    """Residuals (n, 3) whose squares sum to twice the robust cost."""
    squares = (misses**2).sum(axis=1) / problem.loss_scale**2
    shrink = np.sqrt(2.0 / (1.0 + np.sqrt(1.0 + squares)))
    return np.asarray(misses * (np.sqrt(problem.weights) * shrink)[:, None])


def _doubts(body: Body, priors: Priors) -> tuple[Array, float]:
    """The Cholesky factor of the freed quantities' covariance, and the plane's doubt [m]."""
    covariance = np.zeros((5, 5)) if body.covariance is None else np.reshape(body.covariance, (5, 5))
    doubts = float(np.hypot(priors.plane_height[1], np.sqrt(covariance[0, 0]))) if priors.plane_height else 0.0
    if priors.measures and body.covariance is None:
        raise CalibrationError(
            "The body's measures cannot be freed without their covariance: give covariance_m2, or leave them be"
        )
    free = 4 if priors.measures else 0
    spread = np.zeros((free + 1, free + 1)) if priors.pitch_sd is not None else np.zeros((free, free))
    if priors.measures:
        spread[:4, :4] = np.linalg.cholesky(covariance[1:, 1:])
    if priors.pitch_sd is not None:
        spread[-1, -1] = priors.pitch_sd
    return spread, doubts


def _changed(body: Body, freed: Array, priors: Priors) -> tuple[Body, float]:
    """The body with its shoulder and arm moved by the freed measures [m], and the pitch [rad]."""
    pitch = float(freed[-1]) if priors.pitch_sd is not None else 0.0
    if not priors.measures:
        return body, pitch
    forward, left, up = (float(a + b) for a, b in zip(body.shoulder_to_eye_m, freed[:3], strict=True))
    arm = body.shoulder_to_fingertip_m + float(freed[3])
    ratio = arm / body.shoulder_to_fingertip_m
    changed = msgspec.structs.replace(
        body,
        shoulder_to_eye_m=(forward, left, up),
        shoulder_to_fingertip_m=arm,
        upper_arm_m=None if body.upper_arm_m is None else body.upper_arm_m * ratio,
        elbow_to_fingertip_m=None if body.elbow_to_fingertip_m is None else body.elbow_to_fingertip_m * ratio,
    )
    return changed, pitch
