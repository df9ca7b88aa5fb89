"""Coverage by deploying, the lab's own way: robots that push each other and are pushed by the sheet's edge."""

import math
from collections.abc import Mapping

import numpy as np

from armspan.frames import Array
from armspan.records import Drive, GoTo, RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage

STRENGTH = 5e-4
"""k [N m²]: the 500000 kg mm³/s² of the lab's launch file. Its text has a tenth, which moves nothing beyond 0.16 m."""

SIGHT = 0.2
"""What is farther [m] than this does not push."""

MASS = 0.2
"""m [kg], a Cellulo's own."""

FRICTION = 1.0
"""mu [kg/s]: a force F ends in a speed of F / mu."""

NEAREST = 0.01
"""A distance below this [m] pushes like this one: the field has no end at zero."""

AT_REST, REST_S = 0.002, 1.0
"""All robots slower [m/s] than this for so long [s] are deployed."""

CREEP = 0.025
"""The slowest [m/s] that robots are told to drive: real ones stand still below 0.015 (EPFL's logs)."""

LONGEST = 0.2
"""A pause between two steps counts as this long [s] at most."""


class Potential:
    """Deploy over the sheet by a potential field, as in the swarm practical of EPFL CHILI (Howard et al. 2002).

    U = sum of k / r over the other robots and the nearest points of the sheet's four edges within `SIGHT`, and
    m dv/dt = -grad U - mu v with a speed cap. ``strength`` is k [N m²]. One thing is our own: the push is less by what
    it is at the end of sight, so that it ends there without a step; at a step
    sixteen robots on a square metre dither for ever. And robots that are to move are told to creep at least.
    """

    def __init__(self, stage: Stage, states: Mapping[str, RobotState], *, strength: float = STRENGTH) -> None:
        self._stage = stage
        self._strength = strength
        self._velocities: dict[str, Array] = {name: np.zeros(2) for name in states}
        self._last: float | None = None
        self._rest_since: float | None = None
        self._done = False

    @property
    def done(self) -> bool:
        """Whether all robots have been at rest for a while."""
        return self._done

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[GoTo | Drive]:
        """Drive each as the field pushes it."""
        names = sorted(states)
        places = np.array([states[name].xy for name in names], dtype=float).reshape(-1, 2)
        before = np.array([self._velocities.get(name, np.zeros(2)) for name in names]).reshape(-1, 2)
        passed = 0.0 if self._last is None else min(max(t - self._last, 0.0), LONGEST)
        limits = self._stage.limits
        after = capped(slowed(before, self._forces(places), passed), limits.speed_m_s)
        self._velocities = dict(zip(names, after, strict=True))
        self._judge(t, after)
        self._last = t
        told = capped(after * creep(np.linalg.norm(after, axis=1))[:, None], limits.speed_m_s)
        return [
            Drive(t, name, (float(x), float(y)), 0.0, t + limits.lease_s)
            for name, (x, y) in zip(names, told, strict=True)
        ]

    def _forces(self, places: Array) -> Array:
        sheet = self._stage.sheet
        forces = robot_forces(places, self._strength)
        return forces + edge_forces(places, np.array([sheet.width_m, sheet.height_m]), self._strength)

    def _judge(self, t: float, velocities: Array) -> None:
        moved = self._last is not None and len(velocities) > 0
        if not moved or float(np.linalg.norm(velocities, axis=1).max()) >= AT_REST:
            self._rest_since, self._done = None, False
            return
        self._rest_since = t if self._rest_since is None else self._rest_since
        self._done = t - self._rest_since >= REST_S


def push(away: Array, strength: float) -> Array:
    """The push [N] from distances [m]: k / r² less its value at the end of sight, nothing beyond."""
    return np.asarray(strength * (1.0 / np.clip(away, NEAREST, SIGHT) ** 2 - 1.0 / SIGHT**2))


def robot_forces(places: Array, strength: float) -> Array:
    """The push (n, 2) [N] of all robots at ``places`` (n, 2) [m] on each, away from every one in sight."""
    apart = places[:, None] - places
    away = np.linalg.norm(apart, axis=2)
    same = (away < 1e-9) & ~np.eye(len(places), dtype=bool)
    apart[same] = _aside(len(places))[same]
    ways = np.maximum(np.linalg.norm(apart, axis=2), 1e-12)
    return np.asarray(((push(away, strength) / ways)[..., None] * apart).sum(axis=1))


def _aside(count: int) -> Array:
    """Directions (n, n, 2) in which robots in one place part: opposite ones for the two of a pair."""
    first, second = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    angle = np.minimum(first, second) + 2.4 * np.maximum(first, second)
    sign = np.where(first < second, 1.0, -1.0)
    return np.stack([sign * np.cos(angle), sign * np.sin(angle)], axis=2)


def edge_forces(places: Array, size: Array, strength: float) -> Array:
    """The push (n, 2) [N] of the four edges of a sheet of ``size`` (2,) [m] on robots, inward."""
    return push(places, strength) - push(size - places, strength)


def slowed(velocities: Array, forces: Array, passed: float) -> Array:
    """The velocities (n, 2) [m/s] under forces [N] and friction after ``passed`` [s]: the exact solution."""
    kept = math.exp(-FRICTION / MASS * passed)
    return np.asarray(velocities * kept + forces / FRICTION * (1.0 - kept))


def creep(speeds: Array) -> Array:
    """By how much (n,) speeds [m/s] are raised for robots to move at all; those at rest stay at rest."""
    return np.where(speeds < AT_REST, 1.0, np.maximum(1.0, CREEP / np.maximum(speeds, AT_REST)))


def capped(velocities: Array, most: float) -> Array:
    """Velocities (n, 2) [m/s] no faster than ``most``."""
    speeds = np.linalg.norm(velocities, axis=1, keepdims=True)
    return np.asarray(velocities * np.minimum(1.0, most / np.maximum(speeds, 1e-12)))
