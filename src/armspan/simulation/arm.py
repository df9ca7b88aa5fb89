"""The arm's geometry: shoulder, elbow, wrist, fingertip, and the line of sight that the fingertip is held on.

Vectors are component first, (3, m), in one common frame with z up; angles are (2, m) [rad]: to the left, up.
"""

from dataclasses import dataclass

import numpy as np

from armspan.frames import Array

_TINY = 1e-30  # an angle of nothing has no direction, and needs none

STRETCH_LIMIT = 0.85
"""The greatest bend, as a share of the angle at which forearm and upper arm can no longer span the chord."""


@dataclass(frozen=True, slots=True)
class Arm:
    """Lengths [m] of the upper arm, of the forearm (elbow to wrist) and of the hand (wrist to fingertip)."""

    upper: float
    forearm: float
    hand: float

    @property
    def widest_bend(self) -> float:
        """The greatest angle [rad] between elbow-fingertip and shoulder-fingertip that a person is given."""
        return STRETCH_LIMIT * float(np.arcsin(min(1.0, self.upper / (self.forearm + self.hand))))


def unit(vectors: Array) -> Array:
    """Vectors (..., 3, m) of length one."""
    return np.asarray(vectors / np.sqrt(np.einsum("...im,...im->...m", vectors, vectors))[..., None, :])


def tangents(directions: Array) -> tuple[Array, Array]:
    """Unit vectors (3, m) to the left of and above unit ``directions`` (3, m); nothing where these are vertical."""
    x, y, z = directions
    level = np.sqrt(x * x + y * y + _TINY)
    x, y = x / level, y / level
    return np.array([-y, x, 0.0 * x]), np.array([-z * x, -z * y, level])


def turned(directions: Array, basis: tuple[Array, Array], angles: Array) -> Array:
    """Unit ``directions`` (3, m) turned along great circles by ``angles`` (2, ..., m) [rad]: (..., 3, m).

    ``basis`` are the directions' tangents.
    """
    left, up = angles
    angle = np.sqrt(left * left + up * up + _TINY)
    share = np.sin(angle) / angle
    aside = (share * left)[..., None, :] * basis[0] + (share * up)[..., None, :] * basis[1]
    return np.asarray(np.cos(angle)[..., None, :] * directions + aside)


def elbow_to_fingertip(arm: Arm, wrist: Array) -> Array:
    """Distances (m,) [m] with the hand turned by ``wrist`` (2, m) [rad] on the forearm (law of cosines)."""
    cosine = np.cos(np.sqrt((wrist * wrist).sum(axis=0)))
    return np.asarray(np.sqrt(arm.forearm**2 + arm.hand**2 + 2.0 * arm.forearm * arm.hand * cosine))


def chord(arm: Arm, bend: Array, lower: Array) -> Array:
    """Distances shoulder to fingertip (m,) [m] of a bent arm.

    ``bend`` (2, m) [rad] is the angle at the fingertip between the lines to the elbow, ``lower`` (m,) [m]
    away, and to the shoulder: c = L cos d + sqrt(U² - L² sin² d), the far side of the triangle.
    """
    angle = np.sqrt((bend * bend).sum(axis=0))
    return np.asarray(lower * np.cos(angle) + np.sqrt(arm.upper**2 - (lower * np.sin(angle)) ** 2))


def fingertip_on_sight(eye: Array, sight: Array, shoulder: Array, reach: Array) -> Array:
    """Points (3, m) on rays from ``eye`` along unit ``sight``, ``reach`` (m,) [m] from the shoulder.

    The eye is nearer to the shoulder than the fingertip is, so that there is exactly one ahead.
    """
    offset = eye - shoulder
    along, square = np.einsum("im,im->m", sight, offset), np.einsum("im,im->m", offset, offset)
    return np.asarray(eye + (np.sqrt(along * along - square + reach * reach) - along) * sight)


@dataclass(frozen=True, slots=True)
class Directions:
    """Unit vectors (3, m) along the upper arm, the forearm and the hand, away from the shoulder."""

    upper: Array
    forearm: Array
    hand: Array
    left: Array
    above: Array


def bent_arm(arm: Arm, to_fingertip: Array, bend: Array, wrist: Array, reach: Array, lower: Array) -> Directions:
    """The segments of an arm whose fingertip is ``reach`` [m] away along the unit ``to_fingertip`` (3, m).

    The elbow lies where the line to the fingertip is turned by ``bend``; the hand is turned by ``wrist``
    against the forearm and the forearm back by as much as keeps the fingertip in place (law of sines).
    ``left`` and ``above`` are the tangents at the elbow-fingertip line.
    """
    to_tip = turned(to_fingertip, tangents(to_fingertip), bend)
    upper = (reach * to_fingertip - lower * to_tip) / arm.upper
    basis = tangents(to_tip)
    angle = np.sqrt((wrist * wrist).sum(axis=0) + _TINY)
    back = wrist * (np.arcsin(arm.hand * np.sin(angle) / lower) / angle)
    forearm, hand = turned(to_tip, basis, np.array([-back, wrist - back]).swapaxes(0, 1))
    return Directions(upper, forearm, hand, basis[0], basis[1])
