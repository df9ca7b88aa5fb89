"""Rotate: everybody goes round the formation's middle."""

import math
from collections.abc import Mapping

import numpy as np

from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import (
    ARRIVED,
    CRUISE,
    Pace,
    Wish,
    discs,
    farthest,
    least_distance,
    matched,
    pitch,
    places,
    ring,
    spaced,
    wishes,
)

_POINT = 1e-3  # a smaller formation [m] is a robot at its middle


class Rotate:
    """The robots' present formation turns round its centroid, as one, by ``angle`` [rad].

    ``turn`` is +1 for left, counter-clockwise as the user sees it from above, and -1 for right. The rim moves at
    `CRUISE` times the highest speed, and waits while a robot is farther behind than ``limits.lead_m``. A formation
    that sweeps over the sheet's edge is shifted, then drawn together, and where that brings robots too near to each
    other it closes up to a ring or a disc.

    Raises:
        ConfigError: for another ``turn`` or ``angle``, and where so many robots have no room to turn.

    """

    def __init__(
        self, stage: Stage, states: Mapping[str, RobotState], *, turn: int = 1, angle: float = math.pi / 2
    ) -> None:
        if turn not in (1, -1):
            raise ConfigError(f"turn is {turn}; expected 1 for left or -1 for right")
        if not (math.isfinite(angle) and angle > 0):
            raise ConfigError(f"angle is {angle} rad; expected more than 0 (to turn right, say turn -1)")
        _check_room(len(states), stage)
        self._stage, self._turn, self._left = stage, turn, angle
        self._pace = Pace()
        self._names: list[str] = []
        self._centre: Array = np.zeros(2)
        self._offsets: Array = np.empty((0, 2))
        self.done = False

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[Wish]:
        """The wish of each robot for its slot in the formation as far as it has turned."""
        elapsed = self._pace.elapsed(t)
        names, here = places(states)
        if names != self._names:
            self._names = names
            self._centre, self._offsets = turnable(spaced(here, self._stage), self._stage) if names else (here, here)
        behind = farthest(here, self._centre + self._offsets)
        if behind <= self._stage.limits.lead_m:
            self._advance(elapsed)
        self.done = bool(names) and self._left == 0 and farthest(here, self._centre + self._offsets) < ARRIVED
        return wishes(t, self._stage, names, np.clip(self._centre + self._offsets, *self._stage.bounds))

    def _advance(self, elapsed: float) -> None:
        rim = _rim(self._offsets)
        step = self._left if rim < _POINT else CRUISE * self._stage.limits.speed_m_s * elapsed / rim
        step = min(step, self._left)
        self._left -= step
        self._offsets = turned(self._offsets, self._turn * step)


def turned(offsets: Array, angle: float) -> Array:
    """Vectors (n, 2) in ``sheet`` turned by ``angle`` [rad], counter-clockwise seen from above.

    The sheet's y runs down as printed: from above, x turns to y clockwise.
    """
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(offsets @ np.array([[c, -s], [s, c]]))


def turnable(here: Array, stage: Stage) -> tuple[Array, Array]:
    """The centre (2,) and the offsets (n, 2) of a formation near ``here`` (n, 2) that can turn within the sheet."""
    low, high = stage.bounds
    centre, room = here.mean(axis=0), _room(stage)
    offsets = here - centre
    rim = _rim(offsets)
    if rim > room:
        offsets = offsets * (room / rim)
        if least_distance(offsets) < stage.spacing:
            offsets = matched(here, centre + _compact(len(here), stage)) - centre
        rim = _rim(offsets)
    return np.clip(centre, low + rim, high - rim), offsets


def _compact(n: int, stage: Stage) -> Array:
    """The ring or disc of least radius, which never grows where a robot leaves."""
    return min([ring(n, pitch(stage)), *discs(n, pitch(stage))], key=_rim)


def _rim(offsets: Array) -> float:
    return float(np.hypot(*offsets.T).max(initial=0.0))


def _room(stage: Stage) -> float:
    low, high = stage.bounds
    return float((high - low).min()) / 2


def _check_room(n: int, stage: Stage) -> None:
    if n == 0 or _rim(_compact(n, stage)) <= _room(stage):
        return
    most = max(m for m in range(1, n) if _rim(_compact(m, stage)) <= _room(stage))
    sheet = f"{stage.sheet.width_m:g} × {stage.sheet.height_m:g} m"
    raise ConfigError(
        f"{n} robots have no room to turn together on a sheet of {sheet}, at most {most} have: "
        "try fewer robots, a larger sheet or a smaller limits.gap_m"
    )
