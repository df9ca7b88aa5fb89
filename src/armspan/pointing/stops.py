"""Collecting calibration pairs: one stop of the robot, one hold of the arm.

A pair is taken only while robot and arm are both still. The first half second of a hold is dropped: the arm
lags the eye by 0.1 to 0.2 s, and a reach ends with corrections. Samples of one stop share one bias, so a stop
counts once.
"""

from dataclasses import dataclass, field

import numpy as np

from armspan.frames import Array
from armspan.records import Vec2

_HIGHEST = np.radians(40)
_LOWEST = np.radians(-84)
_EDGE = 1e-6
_SAME_DIRECTION = np.radians(2.5)


@dataclass(slots=True)
class StopPairs:
    """The attitudes of the pointing arm while the robot rests at one stop.

    ``before`` is the forearm's direction (3,) in ``user`` in which the arm was when the person was asked to
    point, or at the last stop: as long as the arm is still there, it has not answered yet.
    """

    before: Array
    settle: float = 0.5
    needed: float = 1.2
    still_since: float | None = None
    forearms: list[Array] = field(default_factory=list)
    upperarms: list[Array] = field(default_factory=list)
    points: list[Vec2] = field(default_factory=list)

    def add(self, t: float, forearm_user: Array, upperarm_user: Array | None, robot_xy: Vec2, still: bool) -> bool:
        """Take attitudes (3, 3) ``user_from_forearm`` at ``t`` [s]; True when the stop is complete."""
        direction = forearm_user[:, 0]
        elevation = float(np.arcsin(np.clip(direction[2], -1.0, 1.0)))
        answered = float(np.arccos(np.clip(direction @ self.before, -1.0, 1.0))) > _SAME_DIRECTION
        if not (still and answered and _LOWEST < elevation < _HIGHEST):
            self.still_since = None
            for taken in (self.forearms, self.upperarms, self.points):
                taken.clear()
            return False
        if self.still_since is None:
            self.still_since = t
        if t - self.still_since >= self.settle - _EDGE:
            self.forearms.append(forearm_user)
            self.points.append(robot_xy)
            if upperarm_user is not None:
                self.upperarms.append(upperarm_user)
        return t - self.still_since >= self.settle + self.needed - _EDGE

    @property
    def direction(self) -> Array:
        """Mean direction (3,) of the forearm in ``user`` over the hold."""
        mean = np.mean([forearm[:, 0] for forearm in self.forearms], axis=0)
        return np.asarray(mean / np.linalg.norm(mean))
