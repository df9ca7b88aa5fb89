"""Dead reckoning of a cube: what its wheels do after what they were told, late and with their lag.

Pure; poses are (x, y, heading) in ``sheet`` [m, rad clockwise from above]; times are those at which a cube's places
arrive, so that ``DELAY_S`` is the radio's both ways.
"""

import math
from dataclasses import dataclass, field
from typing import TypeAlias

from armspan.devices.toio.quantities import WHEELS_APART_M, speed_of

LAG_S, DELAY_S, STEP_S, PAST_S = 0.1, 0.03, 0.01, 1.0
"""The wheels' first-order lag, the radio both ways, the longest step, and how far back wheels matter."""
KEPT_S = 0.5

Pose: TypeAlias = tuple[float, float, float]
Speeds: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Pulse:
    """What to tell the wheels: two speed values, and for how long [s]; zero is standstill."""

    left: int
    right: int
    seconds: float


REST = Pulse(0, 0, 0.0)


@dataclass(slots=True)
class Reckoning:
    """Knows what a cube's wheels were told, and how fast they turned when it was seen last."""

    _told: list[tuple[float, Pulse]] = field(default_factory=list)
    _speeds: Speeds = (0.0, 0.0)
    _seen: float = -math.inf

    def note(self, now: float, pulse: Pulse) -> None:
        """The wheels were told this at ``now`` [s], in place of what they were told before."""
        self._told = [(at, old) for at, old in self._told if at > now - KEPT_S]
        self._told.append((now, pulse))

    def carried(self, pose: Pose, t: float) -> Pose:
        """A pose when the cube was seen last, carried on to ``t`` [s], when it is seen again."""
        start, self._seen = max(self._seen, t - PAST_S), t
        pose, self._speeds = self._rolled(pose, self._speeds, start, t)
        return pose

    def forecast(self, pose: Pose, now: float) -> tuple[Pose, Pose]:
        """Where a cube is when it hears what it is told ``now``, and where it then comes to rest if that is nothing.

        It was seen at ``pose`` last.
        """
        here, speeds = self._rolled(pose, self._speeds, max(self._seen, now - PAST_S), now + DELAY_S)
        return here, rolled(here, speeds[0] * LAG_S, speeds[1] * LAG_S)

    def _rolled(self, pose: Pose, speeds: Speeds, start: float, end: float) -> tuple[Pose, Speeds]:
        count = max(math.ceil((end - start) / STEP_S - 1e-6), 0)
        step = (end - start) / max(count, 1)
        keep = math.exp(-step / LAG_S)
        coast = LAG_S * (1 - keep)
        left, right = speeds
        for k in range(count):
            to_left, to_right = self._at(start + (k + 0.5) * step - DELAY_S)
            left, right = left - to_left, right - to_right
            pose = rolled(pose, to_left * step + left * coast, to_right * step + right * coast)
            left, right = to_left + left * keep, to_right + right * keep
        return pose, (left, right)

    def _at(self, t: float) -> Speeds:
        """What the wheels were told at a time [m/s]."""
        for at, pulse in reversed(self._told):
            if at <= t:
                return (speed_of(pulse.left), speed_of(pulse.right)) if t < at + pulse.seconds else (0.0, 0.0)
        return 0.0, 0.0


def rolled(pose: Pose, left: float, right: float) -> Pose:
    """A pose after its wheels rolled ``left`` and ``right`` [m]."""
    x, y, heading = pose
    way, turn = (left + right) / 2, (left - right) / WHEELS_APART_M
    middle = heading + turn / 2
    return x + way * math.cos(middle), y + way * math.sin(middle), heading + turn


def wrapped(angle: float) -> float:
    """An angle [rad] within half a turn."""
    return math.remainder(angle, 2 * math.pi)
