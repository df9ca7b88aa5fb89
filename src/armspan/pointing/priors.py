"""What is known beside the pairs: the plane's height, the band's pitch on the wrist, the body's measures.

The most probable place under these priors (MAP) is found from the plain fit by scipy's least squares: an
optional path, so plain code matters more than its few milliseconds. The eye's height is never freed: it and the
sheet's height are one number to the rays (the scene may be lifted with the eye), so where the plane's height is
told, the doubt about the eye's height widens that prior instead.

Measures move along the axes of their covariance in which there is any doubt, so that one measured exactly stays
where it is.
"""

from dataclasses import dataclass, field, replace

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


_SURE_M = 1e-5
"""Doubt [m] of a measure that is as good as none: no tape shows it."""


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
    """A place (4,) with its covariance (4, 4), the body and the band's pitch [rad] it holds for, and its problem.

    ``doubt`` (5,) are the standard deviations of (forward, left, up, arm length) [m] and pitch [rad].
    """

    place: Array
    covariance: Array
    body: Body
    pitch: float
    problem: Problem
    doubt: Array = field(default_factory=lambda: np.zeros(5))


@dataclass(frozen=True, slots=True, eq=False)
class Freedom:
    """What may move: (forward, left, up, arm length, pitch) = ``spread`` (5, r) times r independent unit normals.

    The plane's height is known to ``plane_sd`` [m] once the eye's height is expected ``eye_by_measures`` (4,)
    times the change of the measures higher; it is infinite where no plane is told.
    """

    spread: Array
    plane_sd: float
    eye_by_measures: Array

    @property
    def prior_sd(self) -> Array:
        """Standard deviations (5,) of (forward, left, up, arm length) [m] and pitch [rad] before any pair."""
        return np.asarray(np.sqrt((self.spread**2).sum(axis=1)))


def freedom(body: Body, priors: Priors) -> Freedom:
    """What ``priors`` let move of a body.

    Raises:
        CalibrationError: if the measures are to be freed but their covariance is not known.

    """
    if priors.measures and body.covariance is None:
        raise CalibrationError(
            "The body's measures cannot be freed without their covariance: give covariance_m2, or leave them be"
        )
    covariance = np.zeros((5, 5)) if body.covariance is None else np.reshape(body.covariance, (5, 5))
    axes = _root(covariance[1:, 1:]) if priors.measures else np.zeros((4, 0))
    pitch = np.zeros((5, 0)) if priors.pitch_sd is None else priors.pitch_sd * np.eye(5)[:, 4:]
    spread = np.hstack([np.vstack([axes, np.zeros((1, axes.shape[1]))]), pitch])
    eye_by_measures = covariance[0, 1:] @ np.linalg.pinv(axes @ axes.T, rcond=1e-9, hermitian=True)
    eye_variance = max(0.0, float(covariance[0, 0] - eye_by_measures @ covariance[1:, 0]))
    plane_sd = np.inf if priors.plane_height is None else float(np.hypot(priors.plane_height[1], np.sqrt(eye_variance)))
    return Freedom(spread, plane_sd, eye_by_measures)


def _root(covariance: Array) -> Array:
    """(4, r) with root @ root.T the covariance, r its rank: directions without doubt are left out."""
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2.0)
    doubtful = values > _SURE_M**2
    return np.asarray(vectors[:, doubtful] * np.sqrt(values[doubtful]))


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
    free = freedom(plain.body, priors)
    height = floor + (0.0 if priors.plane_height is None else priors.plane_height[0])

    def moved(freed: Array) -> tuple[Body, float, Problem]:
        body, pitch = _changed(plain.body, freed[:4]), float(freed[4])
        forearm = pitched(pairs.user_from_forearm, pitch)
        origins, directions = arm_rays(body, forearm, pairs.user_from_upperarm, model, laser)
        return body, pitch, replace(plain.problem, origins=origins, directions=directions)

    def whitened(x: Array) -> Array:
        freed = free.spread @ x[4:]
        problem = moved(freed)[2]
        seen = _robust(miss(problem, x[:4]), problem) / sigma
        lifted = (x[2] + free.eye_by_measures @ freed[:4] - height) / free.plane_sd
        return np.array([*seen.ravel(), *x[4:], lifted])

    start = np.concatenate([plain.place, np.zeros(free.spread.shape[1])])
    found = least_squares(whitened, start, x_scale="jac")
    covariance = np.linalg.inv(found.jac.T @ found.jac)
    doubt = np.sqrt(np.maximum(np.diagonal(free.spread @ covariance[4:, 4:] @ free.spread.T), 0.0))
    return Refined(found.x[:4], covariance[:4, :4], *moved(free.spread @ found.x[4:]), doubt)


def _robust(misses: Array, problem: Problem) -> Array:
    """Residuals (n, 3) whose squares sum to twice the robust cost."""
    squares = (misses**2).sum(axis=1) / problem.loss_scale**2
    shrink = np.sqrt(2.0 / (1.0 + np.sqrt(1.0 + squares)))
    return np.asarray(misses * (np.sqrt(problem.weights) * shrink)[:, None])


def _changed(body: Body, freed: Array) -> Body:
    """The body with its shoulder and arm moved by the freed measures (4,) [m]."""
    if not freed.any():
        return body
    forward, left, up = (float(a + b) for a, b in zip(body.shoulder_to_eye_m, freed[:3], strict=True))
    arm = body.shoulder_to_fingertip_m + float(freed[3])
    ratio = arm / body.shoulder_to_fingertip_m
    return msgspec.structs.replace(
        body,
        shoulder_to_eye_m=(forward, left, up),
        shoulder_to_fingertip_m=arm,
        upper_arm_m=None if body.upper_arm_m is None else body.upper_arm_m * ratio,
        elbow_to_fingertip_m=None if body.elbow_to_fingertip_m is None else body.elbow_to_fingertip_m * ratio,
    )
