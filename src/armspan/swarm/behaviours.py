"""What a swarm does when it is told by name: gather and walk at random, one robot at a time.

The simplest safe form: while one robot drives, all others stand, so that ways round them hold. A robot that has not
arrived after `PATIENCE` gives its turn to the next.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from armspan.frames import Array
from armspan.records import RobotState, Sheet, Vec2
from armspan.swarm.errands import Errands
from armspan.swarm.limits import Limits

STOP, GATHER, RANDOM_WALK = "stop", "gather", "random walk"
BEHAVIOURS = (STOP, GATHER, RANDOM_WALK)

DICTIONARY: dict[str, str] = {"stop": STOP, "mixing": RANDOM_WALK, "raise_both": GATHER}
"""Gesture -> behaviour, where a room does not say otherwise."""

PATIENCE = 6.0
_SPARE = 0.015
_TRIES = 100
_LEG = 0.08


@dataclass(slots=True)
class Behaviours:
    """Goes on with the behaviour that was begun last, by sending one robot after the other on errands."""

    limits: Limits
    sheet: Sheet
    errands: Errands
    rng: np.random.Generator
    current: str | None = None
    _left: list[tuple[str, Vec2]] = field(default_factory=list)
    _mover: str | None = None
    _since: float = 0.0
    _turn: int = 0

    def begin(self, name: str, t: float, states: Mapping[str, RobotState]) -> None:
        """Begin a behaviour in the place of the one that goes on; ``stop`` ends it."""
        self.cancel()
        self.current = None if name == STOP else name
        self._since = t
        if name == GATHER:
            self._left = self._slots(_able(states))

    def cancel(self) -> None:
        """End the behaviour, and the errand that it gave."""
        if self._mover is not None:
            self.errands.goals.pop(self._mover, None)
        self.current, self._mover, self._left = None, None, []

    def step(self, t: float, states: Mapping[str, RobotState]) -> None:
        """Send the next robot once the last one has arrived or given up."""
        if self.current is None or self._busy(t):
            return
        able = _able(states)
        following = self._next_slot(able) if self.current == GATHER else self._next_leg(able)
        if following is None:
            if self.current == GATHER:
                self.current = None
            return
        self._mover, self._since = following[0], t
        self.errands.send(*following)

    def _busy(self, t: float) -> bool:
        if self._mover is None:
            return False
        if self._mover in self.errands.goals and t - self._since < PATIENCE:
            return True
        self.errands.goals.pop(self._mover, None)
        self._mover = None
        return False

    def _next_slot(self, able: Mapping[str, RobotState]) -> tuple[str, Vec2] | None:
        while self._left:
            robot, xy = self._left.pop(0)
            if robot in able:
                return robot, xy
        return None

    def _next_leg(self, able: Mapping[str, RobotState]) -> tuple[str, Vec2] | None:
        names = sorted(able)
        if not names:
            return None
        self._turn += 1
        robot = names[self._turn % len(names)]
        place = self._free_place(robot, able)
        return None if place is None else (robot, place)

    @property
    def _clear(self) -> float:
        return 2 * self.limits.body_radius_m + self.limits.gap_m + _SPARE

    def _free_place(self, robot: str, able: Mapping[str, RobotState]) -> Vec2 | None:
        """A random place [m] on the sheet, clear of the other robots and some way off."""
        here = np.array(able[robot].xy)
        others = np.array([state.xy for name, state in able.items() if name != robot]).reshape(-1, 2)
        low, high = self._bounds()
        for place in self.rng.uniform(low, high, size=(_TRIES, 2)):
            free = len(others) == 0 or np.linalg.norm(others - place, axis=1).min() >= self._clear
            if free and np.linalg.norm(place - here) >= _LEG:
                return float(place[0]), float(place[1])
        return None

    def _bounds(self) -> tuple[Array, Array]:
        margin = self.limits.body_radius_m + self.limits.gap_m
        size = np.array([self.sheet.width_m, self.sheet.height_m])
        return np.minimum(margin, size / 2), np.maximum(size - margin, size / 2)

    def _slots(self, able: Mapping[str, RobotState]) -> list[tuple[str, Vec2]]:
        """A place for each robot on a ring round their middle, the least way in all (Kuhn 1955), nearest first."""
        names = sorted(able)
        if len(names) < 2:
            return []
        at = np.array([able[name].xy for name in names])
        radius = self._clear / 2 / np.sin(np.pi / len(names))
        low, high = self._bounds()
        middle = np.clip(at.mean(axis=0), np.minimum(low + radius, high), np.maximum(high - radius, low))
        first = np.arctan2(*(at[0] - middle)[::-1])
        angles = first + 2 * np.pi * np.arange(len(names)) / len(names)
        ring = np.clip(middle + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1), low, high)
        away = np.linalg.norm(at[:, None] - ring, axis=2)
        rows, columns = linear_sum_assignment(away)
        order = sorted(zip(rows.tolist(), columns.tolist(), strict=True), key=lambda pair: away[pair])
        return [(names[row], (float(ring[column, 0]), float(ring[column, 1]))) for row, column in order]


def _able(states: Mapping[str, RobotState]) -> dict[str, RobotState]:
    """The robots that stand on the sheet."""
    return {name: state for name, state in states.items() if not state.held}
