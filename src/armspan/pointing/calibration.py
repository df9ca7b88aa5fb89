"""The user's place from pairs of rays and points: ``sheet_from_user`` with its uncertainty.

p_sheet = F Rz(yaw) p_user + xyz, with F = diag(1, -1, -1), or no flip for data whose frame has z up.
"""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from armspan.errors import CalibrationError, known_names
from armspan.frames import SHEET_FLIP, Array, Transform, sheet_from_user, yaw_rotation
from armspan.pointing.laser import LaserSettings
from armspan.pointing.least_squares import Problem, angles, linearise, robust_cost, solve
from armspan.pointing.misfits import leave_out_misfits
from armspan.pointing.nelder_mead import nelder_mead, nelder_mead_report
from armspan.pointing.pairs import Area, Pairs, area, check_layout
from armspan.pointing.parameters import Parameter, parameters
from armspan.pointing.priors import Priors, Refined, pitched, refine
from armspan.pointing.rays import arm_rays
from armspan.records import Body, Model

Method: TypeAlias = Literal["least-squares", "nelder-mead", "nelder-mead-report"]
METHODS: tuple[Method, ...] = ("least-squares", "nelder-mead", "nelder-mead-report")

NO_PRIORS = Priors()

ILL_CONDITIONED = 30.0
"""Condition number beyond which the place is open: four corners have 2 to 12, rays that all but coincide 20 to 1000."""

ABSURD = float(np.radians(25.0))
"""Residual [rad] of a fit that has nothing to do with its points: natural arms stay below 10 degrees."""


FARTHEST = 20.0
"""Distance [m] of a user from the points beyond which the numbers cannot be metres."""


@dataclass(frozen=True, slots=True)
class Noise:
    """Pointing noise per axis ``sigma`` [rad] assumed before any residual is seen, worth ``dof`` of them."""

    sigma: float
    dof: float


STRAIGHT = Noise(float(np.radians(2.0)), 4.0)
"""An arm whose elbow is straight or seen: natural pointing of six people with two bands (TorSalve data)."""

NATURAL = Noise(float(np.radians(3.5)), 2.0)
"""One band on a natural arm, which bends at an elbow that the band cannot see: the same people, one band."""

HIDDEN = Noise(float(np.radians(8.0)), 2.0)
"""A laser's ray from a wrist whose elbow bends unseen: the spot is on its target, but the beam begins a hand's breadth
beside where it is thought to begin, half a metre from there (simulated)."""


@dataclass(frozen=True, slots=True)
class StopResidual:
    """How far [rad] the ray of one stop passes by its point, how many samples it had, and whether it was used."""

    stop: str
    residual: float
    pairs: int
    used: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """``sheet_from_user``, how well it is known, and the arm it was found with.

    ``xyz`` (3,) [m] and ``yaw`` [rad]; ``covariance`` (4, 4) over (x, y, z, yaw); ``rms`` [rad] the residual
    angle; ``sigma`` [rad] the pointing noise per axis; ``condition`` the condition number of the problem with
    each parameter in its own unit; ``cost`` the robust cost [rad²]; ``area`` where the points of still pairs
    lay. ``body`` and ``pitch`` [rad] are as assumed, or as found under priors, with which ``parameters`` tell
    what the data determined. With a ``laser`` the rays are its beams.
    """

    body: Body
    model: Model
    method: Method
    z_up: bool
    xyz: Array
    yaw: float
    covariance: Array
    sigma: float
    rms: float
    stops: tuple[StopResidual, ...]
    condition: float
    cost: float
    area: Area | None = None
    pitch: float = 0.0
    laser: LaserSettings | None = None
    parameters: tuple[Parameter, ...] = ()

    def transform(self) -> Transform:
        """``sheet_from_user``."""
        return sheet_from_user(self.xyz, self.yaw, z_up=self.z_up)

    def rays(self, user_from_forearm: Array, user_from_upperarm: Array | None = None) -> tuple[Array, Array]:
        """Origins [m] and unit directions (..., 3) in ``user`` of the arm at other attitudes (..., 3, 3)."""
        forearm = pitched(user_from_forearm, self.pitch)
        return arm_rays(self.body, forearm, user_from_upperarm, self.model, self.laser)


def calibrate(
    body: Body,
    pairs: Pairs,
    model: Model,
    *,
    z_up: bool = False,
    method: Method = "least-squares",
    noise: Noise | None = None,
    priors: Priors = NO_PRIORS,
    laser: LaserSettings | None = None,
) -> Fit:
    """Place the user so that the rays meet the points.

    ``noise`` is `STRAIGHT` for two bands and else `NATURAL`, unless told. A ``laser`` goes with the forearm's model.

    Raises:
        CalibrationError: if the pairs do not determine the place, or the method or model does not exist.

    """
    if method not in METHODS:
        raise CalibrationError(known_names("method", method, METHODS))
    check_layout(pairs.points)
    flip = np.eye(3) if z_up else SHEET_FLIP
    centre = pairs.points.mean(axis=0)
    noise = noise or (STRAIGHT if model == "two-band" else NATURAL)
    rays = arm_rays(body, pairs.user_from_forearm, pairs.user_from_upperarm, model, laser)
    problem = Problem(*rays, (pairs.points - centre) @ flip, pairs.weights)
    problem, place = _solve(problem, SHEET_FLIP @ flip @ centre, method, pairs.stops is not None, noise)
    told = _information(problem, place, noise)
    if method == "least-squares":
        _check(told)
    found = Refined(place, np.asarray(told.sigma**2 * np.linalg.inv(told.curvature)), body, 0.0, problem)
    if priors:
        found = refine(found, pairs, model, told.sigma, priors, float((flip @ centre)[2]), laser)
    if method == "least-squares":
        _check_reach(found.place)
    turn = flip @ yaw_rotation(found.place[3])
    xyz = centre - turn @ found.place[:3]
    covariance = _of_transform(found.covariance, turn, found.place)
    fit = _fit(found, told, pairs, model=model, method=method, z_up=z_up, xyz=xyz, covariance=covariance)
    if priors:
        known = parameters(np.array([*xyz, fit.yaw]), covariance, body, found, priors, z_up=z_up)
        fit = replace(fit, parameters=known)
    return fit if laser is None else replace(fit, laser=laser)


def _fit(
    found: Refined,
    told: "_Information",
    pairs: Pairs,
    *,
    model: Model,
    method: Method,
    z_up: bool,
    xyz: Array,
    covariance: Array,
) -> Fit:
    """A place with what its residuals say."""
    residuals = angles(found.problem, found.place[None])[0]
    weights = found.problem.weights
    return Fit(
        body=found.body,
        model=model,
        method=method,
        z_up=z_up,
        xyz=xyz,
        yaw=float(np.arctan2(np.sin(found.place[3]), np.cos(found.place[3]))),
        covariance=covariance,
        sigma=told.sigma,
        rms=float(np.sqrt(weights @ residuals**2 / weights.sum())),
        stops=_stops(pairs, residuals, weights > 0.0),
        condition=told.condition,
        cost=float(robust_cost(found.problem, residuals)),
        area=area(pairs),
        pitch=found.pitch,
    )


def _solve(problem: Problem, centre: Array, method: Method, still: bool, noise: Noise) -> tuple[Problem, Array]:
    """The place (4,), and the problem without the stops that were left out."""
    if method == "nelder-mead":
        return problem, nelder_mead(problem, centre)
    if method == "nelder-mead-report":
        return problem, nelder_mead_report(problem, centre)
    try:
        place, cost = solve(problem)
    except np.linalg.LinAlgError:
        raise CalibrationError(_OPEN) from None
    return leave_out_misfits(problem, place, cost, noise.sigma) if still else (problem, place)


@dataclass(frozen=True, slots=True, eq=False)
class _Information:
    """What the pairs tell at a place: ``curvature`` (4, 4) for a noise of 1 rad, noise and residual [rad]."""

    curvature: Array
    condition: float
    sigma: float
    rms: float


def _information(problem: Problem, place: Array, noise: Noise) -> _Information:
    """Every pair counts as much as the loss leaves it; the noise is drawn towards the assumed one."""
    squares = angles(problem, place[None])[0] ** 2
    weights = problem.weights / np.sqrt(1.0 + squares / problem.loss_scale**2)
    curvature: Array = linearise(replace(problem, weights=weights, loss_scale=1e6), place[None]).curvature[0]
    total = float(weights.sum())
    dof = max(2.0 * total - 4.0, 0.0)
    variance = (noise.dof * noise.sigma**2 + float(weights @ squares)) / (noise.dof + dof)
    rms = float(np.sqrt(problem.weights @ squares / problem.weights.sum()))
    return _Information(curvature, _condition(curvature), float(np.sqrt(variance)), rms)


_OPEN = (
    "The rays hardly differ, which leaves the user's place open: point at places farther apart, and check that each "
    "row holds the arm's attitude of its own moment"
)


def _check(told: _Information) -> None:
    if told.rms > ABSURD:
        raise CalibrationError(
            f"The best place leaves the rays {np.degrees(told.rms):.0f} degrees from their points, where up to 10 are "
            "natural: check the quaternions (user_from_wrist, w first, x along the forearm) and which way z points"
        )
    if not told.condition < ILL_CONDITIONED:
        raise CalibrationError(_OPEN)


def _condition(curvature: Array) -> float:
    """The condition number of the least squares problem with each parameter in its own unit."""
    scale = np.sqrt(np.diagonal(curvature))
    if not scale.all():
        return float("inf")
    values = np.linalg.eigvalsh(curvature / (scale[:, None] * scale))
    return float(np.sqrt(values[-1] / values[0])) if values[0] > 0.0 else float("inf")


def _of_transform(covariance: Array, turn: Array, place: Array) -> Array:
    """A covariance (4, 4) over (centroid in user, yaw) as one over (x, y, z, yaw) of ``sheet_from_user``."""
    jacobian = np.eye(4)
    jacobian[:3, :3] = -turn
    jacobian[:3, 3] = -turn @ np.array([-place[1], place[0], 0.0])
    return np.asarray(jacobian @ covariance @ jacobian.T)


def _stops(pairs: Pairs, residuals: Array, used: NDArray[np.bool_]) -> tuple[StopResidual, ...]:
    if pairs.stops is None:
        return ()
    rows = zip(pairs.stops, residuals, pairs.counts, used, strict=True)
    return tuple(StopResidual(stop, float(angle), int(count), bool(kept)) for stop, angle, count, kept in rows)


def _check_reach(place: Array) -> None:
    """A user stands within `FARTHEST` of what is pointed at; (4,) is the points' centroid in ``user`` and the yaw."""
    reach = float(np.linalg.norm(place[:3]))
    if reach > FARTHEST:
        raise CalibrationError(
            f"The place found lies {reach:.0f} m from the points, where people stand within {FARTHEST:.0f}: are x_m, "
            "y_m and z_m in metres, and the heights as they are?"
        )


def quality(fit: Fit) -> str:
    """``good``, ``fair`` or ``poor``: people with straight or seen arms leave 1 to 2 degrees, unseen elbows 4."""
    degrees = float(np.degrees(fit.rms))
    return "good" if degrees < 2.0 else "fair" if degrees < 4.0 else "poor"
