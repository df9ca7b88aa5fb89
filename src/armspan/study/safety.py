"""Whether robots were ever told, or seen, to do what they must not: counted from records, apart from the filter."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from armspan.records import Drive, GoTo, Press, Record, RobotState, Sheet, Stop
from armspan.swarm.limits import Limits

BODY = 0.0433
"""Half of Cellulo's width across its corners [m]: nearer than two of these, two robots touch."""

_EASE = 1e-9


@dataclass(slots=True)
class SafetyWatch:
    """Counts violations by kind while it reads a session."""

    limits: Limits
    sheet: Sheet
    violations: dict[str, int] = field(default_factory=dict)
    least_gap: float = np.inf
    _states: dict[str, RobotState] = field(default_factory=dict)
    _latched: bool = False

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
            and np.hypot(x - state.xy[0], y - state.xy[1]) > self.limits.lead_m + 0.02,
        }
        for what, broken in checks.items():
            if broken:
                self._count(what)

    def _state(self, state: RobotState) -> None:
        before = self._states.get(state.robot)
        self._states[state.robot] = state
        if state.held:
            return
        x, y = state.xy
        if not (0 <= x <= self.sheet.width_m and 0 <= y <= self.sheet.height_m):
            self._count("robot off the sheet")
        if before is not None and not before.held and state.t > before.t:
            speed = np.hypot(x - before.xy[0], y - before.xy[1]) / (state.t - before.t)
            if speed > 1.25 * self.limits.speed_m_s:
                self._count("robot too fast")
        others = [s for s in self._states.values() if s.robot != state.robot and not s.held]
        gaps = [float(np.hypot(x - s.xy[0], y - s.xy[1])) - 2 * BODY for s in others]
        self.least_gap = min([self.least_gap, *gaps])
        if gaps and min(gaps) < 0:
            self._count("robots touch")


def watch(records: Iterable[Record], limits: Limits, sheet: Sheet) -> SafetyWatch:
    """Read a whole session."""
    safety = SafetyWatch(limits, sheet)
    for record in records:
        safety.take(record)
    return safety
