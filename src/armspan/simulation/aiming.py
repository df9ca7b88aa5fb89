"""What a person means to do when pointing: the place aimed at, with all errors, and the posture."""

import numpy as np

from armspan.frames import Array
from armspan.simulation.arm import tangents, turned
from armspan.simulation.figure import Figure
from armspan.simulation.habits import Trunk


class Aiming:
    """One gesture at a target (3,) [m] in the person's own frame.

    Its errors are drawn once, and anew little by little while the target travels. ``intent`` (14,) has its
    rows named in `posture`.
    """

    def __init__(self, figure: Figure, target: Array, rng: np.random.Generator) -> None:
        self._figure, self._rng, person = figure, rng, figure.person
        elbow, trunk = person.elbow, person.trunk
        self._scatter = np.array([person.aim.repeat, elbow.repeat])
        self._errors = self._scatter * rng.standard_normal((2, 2))
        self._wrist = elbow.wrist + elbow.wrist_repeat * rng.standard_normal(2)
        self._rolls = [elbow.roll, elbow.upper_roll] + elbow.roll_repeat * rng.standard_normal(2)
        self._shift = np.asarray(trunk.shift) + trunk.shift_repeat * rng.standard_normal(3)
        self._errors[0] += self._slip()
        self._direction: Array | None = None
        self.intent = self._intent(target)

    def _slip(self) -> Array:
        """The error (2,) [rad] of a gesture that goes elsewhere altogether, mostly none."""
        aim = self._figure.person.aim
        chance, size, way = self._rng.uniform(size=3)
        angle = aim.slipped[0] + size * (aim.slipped[1] - aim.slipped[0]) if chance < aim.slip else 0.0
        return angle * np.array([np.cos(2 * np.pi * way), np.sin(2 * np.pi * way)])

    def follow(self, target: Array) -> Array:
        """The step (14,) to what is intended now that the target is at (3,) [m]."""
        before, self.intent = self.intent, self._intent(target)
        return np.asarray(self.intent - before)

    def _intent(self, target: Array) -> Array:
        figure, person = self._figure, self._figure.person
        azimuth, elevation, _ = _towards(target - figure.eye)
        look = np.array(person.trunk.head_gain) * [azimuth, elevation]
        eye = figure.dominant_eye(look[:, None])[:, 0]
        azimuth, elevation, distance = _towards(target - eye)
        self._travel((target - eye) / distance)
        habit = person.aim.surface.at(azimuth, elevation, distance)
        error = person.aim.bias + habit + self._errors[0]
        sight = ((target - eye) / distance)[:, None]
        aim = eye + distance * turned(sight, tangents(sight), error[:, None])[:, 0]
        bend = person.elbow.bend + person.elbow.surface.at(azimuth, elevation, distance) + self._errors[1]
        shift = self._shift + self._turned_shoulder(azimuth, elevation, person.trunk)
        return np.concatenate([aim, _within(bend, figure.arm.widest_bend), self._wrist, self._rolls, look, shift])

    def _travel(self, direction: Array) -> None:
        if self._direction is not None:
            way = float(np.linalg.norm(direction - self._direction))
            kept = np.exp(-way / self._figure.person.aim.travel)
            fresh = self._scatter * self._rng.standard_normal((2, 2))
            self._errors = kept * self._errors + np.sqrt(1.0 - kept * kept) * fresh
        self._direction = direction

    def _turned_shoulder(self, azimuth: float, elevation: float, trunk: Trunk) -> Array:
        turn = trunk.turn + trunk.turn_gain * azimuth
        offset = self._figure.person.shoulder_offset
        return np.array(
            [-offset * np.sin(turn), offset * (np.cos(turn) - 1.0), trunk.rise * elevation],
        )


def _towards(offset: Array) -> tuple[float, float, float]:
    x, y, z = offset.tolist()
    level = float(np.hypot(x, y))
    return float(np.arctan2(y, x)), float(np.arctan2(z, level)), float(np.hypot(level, z))


def _within(bend: Array, widest: float) -> Array:
    angle = float(np.hypot(*bend))
    return bend * min(1.0, widest / angle) if angle > 0.0 else bend
