"""The scenes in which errors are put in: the report's circle round an ideal user, a front sector, a table, a floor.

A `Scene` gives the arm's attitudes and takes where they point as the truth, as the report's simulation does; a
`Workplace` gives places and a person who points at them. Coordinates are those of the report's frame H, z up, with
its origin on the floor between the feet, called ``sheet`` here as everywhere; the eye is ``eye_left`` beside it.
"""

from dataclasses import dataclass

import numpy as np

from armspan.frames import Array, Transform, plane_hit, sheet_from_user
from armspan.pointing.pairs import Pairs
from armspan.pointing.rays import arm_rays
from armspan.records import Body, Vec2

RAYS = 30
"""Azimuths from -180 to 180 degrees, both ends among them, as the published figures show them."""

DOWN = float(np.radians(45.0))
EYE_LEFT = 0.03
CIRCLE_RADIUS, CIRCLE_Y = 1.0875, -0.540
"""The circle [m] of the report's figures 1.3.2a and b, read from their vector graphics."""

UPPER_ARM_SHARE = 0.43
"""The upper arm's share of the straight arm to the index fingertip."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A person whose arm has the attitudes ``user_from_forearm`` (n, 3, 3) and points at the plane z = ``plane`` [m].

    What the true rays hit are the points of the calibration, as in the report. ``eye_left`` [m] is the eye's place
    beside the middle of the feet.
    """

    name: str
    body: Body
    user_from_forearm: Array
    plane: float = 0.0
    eye_left: float = EYE_LEFT

    def points(self) -> Array:
        """What the true rays hit, (n, 3) [m] in ``sheet``."""
        return self.hits(self.place(), self.body, self.user_from_forearm)

    def place(self) -> Transform:
        """The true ``sheet_from_user``."""
        return place_beside(self.eye_left)

    def hits(self, place: Transform, body: Body, user_from_forearm: Array) -> Array:
        """Where the rays of a ``body`` at a ``place`` meet the plane, (n, 3) [m] in ``sheet``; NaN where they miss."""
        origins, directions = arm_rays(body, user_from_forearm, None, "head-finger")
        return plane_hit(place.points(origins), place.directions(directions), self.plane)


def place_beside(eye_left: float) -> Transform:
    """``sheet_from_user`` of a person who stands on the origin, with the eye ``eye_left`` [m] beside it."""
    return sheet_from_user((0.0, eye_left, 0.0), 0.0, z_up=True)


def moving(user_from_forearm: Array, points: Array) -> Pairs:
    """Pairs (n,) of the report's kind: every ray counts the same and none is left out as a misfit."""
    ones = np.ones(len(points))
    return Pairs(user_from_forearm, None, points, ones, ones)


def attitudes(azimuths: Array, elevations: Array) -> Array:
    """Attitudes (n, 3, 3) ``user_from_forearm`` of arms to the left by and above the level by angles (n,) [rad]."""
    ca, sa, ce, se = np.cos(azimuths), np.sin(azimuths), np.cos(elevations), np.sin(elevations)
    along = np.stack([ca * ce, sa * ce, se], axis=-1)
    left = np.stack([-sa, ca, np.zeros_like(sa)], axis=-1)
    return np.stack([along, left, np.cross(along, left)], axis=-1)


def about(axis: Array, angle: float) -> Array:
    """Rotations (..., 3, 3) by ``angle`` [rad] about unit axes (..., 3), by Rodrigues's formula."""
    cross = np.cross(axis[..., None, :], np.eye(3))  # rows are axis × e_k, the columns of the cross-product matrix
    cross = cross.swapaxes(-1, -2)
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross))


def ideal_body() -> Body:
    """The ideal user [m]: eye 1.65 high, shoulder 0.20 to the right of and 0.25 below it, arm 0.70."""
    return Body(eye_height_m=1.65, shoulder_to_eye_m=(0.0, 0.20, 0.25), shoulder_to_fingertip_m=0.70)


def ideal_circle() -> Scene:
    """The ideal user with the arm 45 degrees down, once round: the torso stays, only the arm turns."""
    return Scene("ideal user, circle", ideal_body(), _circle())


def published_circle() -> Scene:
    """The ideal user with the shoulder where the circle becomes the published one.

    The report does not state its measures together with its figures. With the eye 1.65 m high, 30 mm beside the feet
    and an arm of 0.70 m, the circle of radius 1087.5 mm about (0, -540) mm needs the shoulder 259 mm beside and 256 mm
    below the eye. Errors of the arm's yaw and of all measures together depend on the circle alone, not on this choice.
    """
    body = ideal_body()
    level = body.shoulder_to_fingertip_m * np.cos(DOWN)
    stretch = CIRCLE_RADIUS / level  # from eye-fingertip to eye-floor
    up = body.eye_height_m / stretch - body.shoulder_to_fingertip_m * np.sin(DOWN)
    left = (EYE_LEFT - CIRCLE_Y) / stretch
    shoulder_to_eye = (0.0, float(left), float(up))
    measured = Body(eye_height_m=body.eye_height_m, shoulder_to_eye_m=shoulder_to_eye, shoulder_to_fingertip_m=0.70)
    return Scene("published circle", measured, _circle())


def front_sector() -> Scene:
    """The ideal user pointing where people do: 60 degrees to both sides, 35 to 65 degrees down, 6 by 5 rays."""
    azimuths, downs = np.meshgrid(np.radians(np.linspace(-60, 60, 6)), np.radians(np.linspace(35, 65, 5)))
    return Scene("ideal user, front sector", ideal_body(), attitudes(azimuths.ravel(), -downs.ravel()))


def _circle() -> Array:
    return attitudes(np.linspace(-np.pi, np.pi, RAYS), np.full(RAYS, -DOWN))


@dataclass(frozen=True, slots=True, eq=False)
class Workplace:
    """A square of ``side`` [m] whose middle lies ``ahead`` [m] of the eye, at the height ``plane`` [m].

    The calibration takes its four corners. Coordinates are those of ``user`` at calibration, so that the true
    ``sheet_from_user`` is the identity.
    """

    name: str
    ahead: float
    side: float
    plane: float
    body: Body

    def corners(self) -> Array:
        """The four corners, (4, 3) [m]."""
        return self._at(np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]))

    def grid(self, count: int = 9) -> Array:
        """Places to point at, (count², 3) [m], evenly over the square with its edges."""
        across = np.linspace(-1.0, 1.0, count)
        return self._at(np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2))

    def origin(self) -> Vec2:
        """The corner [m] from which a sheet's coordinates are counted: near and left."""
        return self.ahead - self.side / 2, self.side / 2

    def _at(self, shares: Array) -> Array:
        xy = [self.ahead, 0.0] + self.side / 2 * shares
        return np.column_stack([xy, np.full(len(shares), self.plane)])


def table_workplace() -> Workplace:
    """The report's square of 0.4 m on a table 0.75 m high, its middle 1 m ahead."""
    return Workplace("table at 1 m", 1.0, 0.4, 0.75, ideal_body())


def floor_workplace() -> Workplace:
    """A square of 1 m on the floor, its middle 1.5 m ahead."""
    return Workplace("floor at 1.5 m", 1.5, 1.0, 0.0, ideal_body())
