"""Whether robots were ever told, or seen, to do what they must not: counted from records, apart from the filter."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import hypot, sqrt

import numpy as np

from armspan.frames import Array
from armspan.records import Drive, GoTo, Press, Record, RobotState, Sheet, Stop
from armspan.swarm.limits import Limits

BODY = 0.0433
"""Half of Cellulo's width across its corners [m]: nearer than two of these, two robots touch."""

_EASE = 1e-9


@dataclass(slots=True)
class SafetyWatch:
    """Counts violations by kind while it reads a session; ``body`` is a robot's radius [m]."""

    limits: Limits
    sheet: Sheet
    violations: dict[str, int] = field(default_factory=dict)
    least_gap: float = np.inf
    body: float = BODY
    _states: dict[str, RobotState] = field(default_factory=dict)
    _latched: bool = False
    _places: "Places" = field(default_factory=lambda: Places())

    def take(self, record: Record) -> None:
        """Take the next record."""
        match record:
            case GoTo():
                self._command(record)
            case Drive():
                self._count("open-ended velocity")
            case Stop(robot=None):
                self._latched = True
            case Press(name="resume"):
                self._latched = False
            case RobotState():
                self._state(record)
            case _:
                pass

    def _count(self, what: str) -> None:
        self.violations[what] = self.violations.get(what, 0) + 1

    def _command(self, command: GoTo) -> None:
        state = self._states.get(command.robot)
        margin = self.limits.body_radius_m - _EASE
        x, y = command.xy
        inside = margin <= x <= self.sheet.width_m - margin and margin <= y <= self.sheet.height_m - margin
        checks = {
            "speed above the cap": command.speed > self.limits.speed_m_s + _EASE,
            "lease too long": command.until - command.t > self.limits.lease_s + _EASE,
            "goal off the sheet": not inside,
            "motion after stop": self._latched,
            "motion of a held robot": state is not None and state.held,
            "goal too far ahead": state is not None
            and hypot(x - state.xy[0], y - state.xy[1]) > self.limits.lead_m + 0.02,
        }
        for what, broken in checks.items():
            if broken:
                self._count(what)

    def _state(self, state: RobotState) -> None:
        before = self._states.get(state.robot)
        self._states[state.robot] = state
        if state.held:
            self._places.forget(state.robot)
            return
        x, y = state.xy
        if not (0 <= x <= self.sheet.width_m and 0 <= y <= self.sheet.height_m):
            self._count("robot off the sheet")
        if before is not None and not before.held and state.t > before.t:
            speed = hypot(x - before.xy[0], y - before.xy[1]) / (state.t - before.t)
            if speed > 1.25 * self.limits.speed_m_s:
                self._count("robot too fast")
        gap = self._places.nearest(state.robot, x, y) - 2 * self.body
        self.least_gap = min(self.least_gap, gap)
        if gap < 0:
            self._count("robots touch")


class Places:
    """Where the robots on the sheet are, in arrays: asked of every state, with hundreds of robots."""

    def __init__(self) -> None:
        self._number: dict[str, int] = {}
        self._x: Array = np.full(8, np.inf)
        self._y: Array = np.full(8, np.inf)

    def nearest(self, robot: str, x: float, y: float) -> float:
        """Put a robot at its place [m]: how far the nearest other one is, infinite without one."""
        i = self._row(robot)
        self._x[i] = np.inf  # its own last place does not count
        dx, dy = self._x - x, self._y - y
        dx *= dx
        dy *= dy
        dx += dy
        self._x[i], self._y[i] = x, y
        return sqrt(float(dx.min()))

    def forget(self, robot: str) -> None:
        """Take a robot away."""
        self._x[self._row(robot)] = np.inf

    def _row(self, robot: str) -> int:
        i = self._number.setdefault(robot, len(self._number))
        if i == len(self._x):
            self._x, self._y = (np.append(places, np.full(i, np.inf)) for places in (self._x, self._y))
        return i


def watch(records: Iterable[Record], limits: Limits, sheet: Sheet) -> SafetyWatch:
    """Read a whole session."""
    safety = SafetyWatch(limits, sheet)
    for record in records:
        safety.take(record)
    return safety
