"""Spots: where a ray meets a plane of the sheet, with its ellipse, or why there is no answer.

Calibration error and the noise of this gesture are first written as a 2 × 2 covariance of the ray's angle at
the spot (that step is linear and the angles are small), then carried to the plane on a grid of rays about it
(that step is not: near the horizon a degree up takes the spot much farther than a degree down brings it back).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from armspan.frames import Array, Transform
from armspan.pointing.pairs import Area

HORIZON = float(np.radians(5.0))
"""A ray within this angle [rad] of the plane has no spot: a degree there moves it by a fifth of its distance."""

AREA_FREEDOM = 4.0
"""Degrees of freedom of the t distribution that is the prior over the area: it pulls little from far outside."""

AREA_HEIGHT_M = 0.1
"""A plane farther [m] from the calibrated points than this is another place, where their area tells nothing."""

_STEPS = np.linspace(-3.0, 3.0, 9)
_GRID = np.stack(np.meshgrid(_STEPS, _STEPS, indexing="ij"), axis=-1).reshape(-1, 2)
_GRID_WEIGHTS = np.exp(-0.5 * (_GRID**2).sum(axis=1)) / np.exp(-0.5 * (_GRID**2).sum(axis=1)).sum()


@dataclass(frozen=True, slots=True, eq=False)
class Spot:
    """Where a ray meets the plane: ``xy`` (2,) [m] and ``covariance`` (2, 2) [m²] in ``sheet``.

    Where there is no answer both are None and ``refused`` is a sentence that says why.
    """

    xy: Array | None
    covariance: Array | None
    refused: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Ray:
    """A ray in ``sheet`` (3,), (3,) that meets the plane ``height`` [m] away along z at ``hit`` (3,).

    ``up`` is the user's z along that of the points' frame: -1 for a sheet, 1 for data with z up.
    """

    origin: Array
    direction: Array
    height: float
    hit: Array
    up: float


class Placed(Protocol):
    """What a spot needs of ``sheet_from_user``; a `Fit` is one."""

    @property
    def xyz(self) -> Array:
        """(3,) [m]."""

    @property
    def covariance(self) -> Array:
        """(4, 4) over (x, y, z, yaw)."""

    @property
    def sigma(self) -> float:
        """Pointing noise per axis [rad]."""

    def transform(self) -> Transform:
        """``sheet_from_user``."""


def spot(place: Placed, origin_user: Array, direction_user: Array, z: float, *, area: Area | None = None) -> Spot:
    """Where a ray (3,) [m], (3,) in ``user`` meets the plane of height ``z`` [m] in the points' frame.

    With ``area``, people are taken to point at what lies about where they calibrated: the spot is then the mean
    of what the ray says times a t prior with the centre and the scatter of the calibrated points. It moves a spot
    by as much as the ray is uncertain against that area, little in the middle and most for shallow rays.
    """
    ray = _meet(place.transform(), origin_user, direction_user, z)
    if isinstance(ray, str):
        return Spot(None, None, ray)
    if area is not None and abs(z - area.centre[2]) > AREA_HEIGHT_M:
        area = None
    return _spot(ray, place, area)


def _meet(place: Transform, origin_user: Array, direction_user: Array, z: float) -> _Ray | str:
    origin, direction = place.points(origin_user), place.directions(direction_user)
    height, rise = float(z - origin[2]), float(direction[2])
    angle, limit = np.degrees(np.arcsin(min(1.0, abs(rise)))), np.degrees(HORIZON)
    if height * rise <= 0.0:
        return f"the ray points {angle:.1f} degrees away from the plane z = {z:g} m: point at the plane"
    if angle < limit:
        return f"the ray is {angle:.1f} degrees from the horizon of the plane, and {limit:.0f} are needed: point lower"
    return _Ray(origin, direction, height, origin + height / rise * direction, float(place.rotation[2, 2]))


def _spot(ray: _Ray, place: Placed, area: Area | None) -> Spot:
    """The spot with the second moment of the grid's spots about it."""
    across = _axes_across(ray.direction)
    angles = _angle_covariance(ray, across, place) + place.sigma**2 * np.eye(2)
    spots = _spots_near(ray, _GRID @ (across @ np.linalg.cholesky(angles)).T)
    weights, xy = _GRID_WEIGHTS, ray.hit[:2]
    if area is not None:
        weights = weights * _area_prior(spots, area)
        weights = weights / weights.sum()
        xy = weights @ spots
    offsets = spots - xy
    return Spot(xy, (weights[:, None] * offsets).T @ offsets)


def _angle_covariance(ray: _Ray, across: Array, place: Placed) -> Array:
    """How the calibration's doubt turns the ray at its spot, (2, 2) [rad²] about ``across``."""
    right, down, _ = ray.hit - place.xyz
    up = ray.up  # the yaw turns about the user's z, which is against the sheet's
    moved = np.array([[1.0, 0.0, 0.0, -up * down], [0.0, 1.0, 0.0, up * right], [0.0, 0.0, 1.0, 0.0]])
    # A shift turns the ray to its spot by the part of it that lies across, over the distance.
    angle_of = ray.direction[2] / ray.height * (across.T @ moved)
    return np.asarray(angle_of @ place.covariance @ angle_of.T)


def _axes_across(direction: Array) -> Array:
    """(3, 2): two unit axes across a direction, the second one level with the plane."""
    x, y, z = direction
    length = float(np.hypot(x, y))
    level_x, level_y = (-y / length, x / length) if length > 1e-9 else (0.0, 1.0)
    return np.array([[-level_y * z, level_x], [level_x * z, level_y], [level_y * x - level_x * y, 0.0]])


def _spots_near(ray: _Ray, turns: Array) -> Array:
    """Spots (n, 2) [m] of rays turned by small vectors (n, 3); those past the horizon are held at half of it."""
    rays = ray.direction + turns
    towards = np.sign(ray.height)
    rises = towards * np.maximum(towards * rays[:, 2], np.sin(HORIZON / 2.0))
    return np.asarray(ray.origin[:2] + (ray.height / rises)[:, None] * rays[:, :2])


def _area_prior(spots: Array, area: Area) -> Array:
    offsets = spots - area.centre[:2]
    distances = (offsets @ np.linalg.inv(area.scatter) * offsets).sum(axis=1)
    return np.asarray((1.0 + distances / AREA_FREEDOM) ** (-(AREA_FREEDOM + 2.0) / 2.0))
