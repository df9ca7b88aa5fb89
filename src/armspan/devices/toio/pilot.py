"""How a cube with two wheels is driven to a place: by short timed commands that end by themselves.

Each command is planned from where the cube would come to rest if nothing more was told: a pulse of speed v for T
seconds then adds just v T to the way, whatever the wheels' lag. So no command carries the cube past its goal, and
the last one ends there. Both ends of a cube may lead. Pure; places in ``sheet`` [m], headings [rad] clockwise from
above.
"""

import math
from dataclasses import dataclass

from armspan.devices.toio.quantities import LEAST, SPEED_M_S, WHEELS_APART_M, speed_of, value_of
from armspan.devices.toio.reckoning import REST, Pose, Pulse, wrapped
from armspan.records import Vec2

HOLD_S, HOLD_M = 0.2, 0.025
"""The longest and the farthest that a cube drives on what it was told once: three refreshes at 0.15 m/s."""
FASTEST_M_S = 0.2
"""No faster, whoever asks: with the wheels' lag, a cube that hears nothing more rests within 60 mm."""
TICK_S = 0.01
APPROACH, TURN = 8.0, 6.0
"""Speed for each metre, and turn rate for each radian, that is left from the place of rest."""
FASTEST_TURN = 10.0
ASIDE, BACK, SWINGS = math.radians(20), math.radians(100), math.radians(20)
"""Off by more, a cube turns on the spot; off by more, it drives the other end first; it waits until it swings less."""
THERE_M, AGAIN_M, TURNED = 0.0025, 0.004, math.radians(3)
"""A cube this near to its goal has arrived, and sets out again once farther off; a heading so near is taken."""


@dataclass(slots=True)
class Pilot:
    """Drives one cube: which end leads, and whether it is there, is remembered."""

    backward: bool = False
    arrived: bool = False

    def plan(self, here: Pose, rest: Pose, goal: Vec2, heading: float | None, speed: float) -> Pulse:
        """What to tell the wheels so that a cube gets to ``goal`` at most at ``speed`` [m/s].

        It is ``here`` when it hears that, and would come to ``rest`` without.
        """
        dx, dy = goal[0] - rest[0], goal[1] - rest[1]
        far = math.hypot(dx, dy)
        self.arrived = far < (AGAIN_M if self.arrived else THERE_M)
        if self.arrived:
            return REST if heading is None else _turned(wrapped(heading - rest[2]))
        off = wrapped(math.atan2(dy, dx) - rest[2])
        self.backward = abs(off) > (math.pi - BACK if self.backward else BACK)
        off = wrapped(off + math.pi) if self.backward else off
        swings = abs(wrapped(rest[2] - here[2])) > SWINGS
        if swings or abs(off) > max(ASIDE, math.asin(min(1.0, 0.5 * THERE_M / far))):
            return _turned(off)
        return _driven(far * math.cos(off), off, speed, -1 if self.backward else 1)


def _turned(off: float) -> Pulse:
    """A turn on the spot by an angle [rad], or as much of it as one pulse holds."""
    if abs(off) < TURNED:
        return REST
    slowest = 2 * LEAST * SPEED_M_S / WHEELS_APART_M
    rate = math.copysign(min(max(TURN * abs(off), slowest), FASTEST_TURN), off)
    value = value_of(rate * WHEELS_APART_M / 2)
    return Pulse(value, -value, _ticks(off / (2 * speed_of(value) / WHEELS_APART_M)))


def _driven(far: float, off: float, speed: float, sign: int) -> Pulse:
    """A stretch of the way of ``far`` [m], bent by ``off`` [rad]."""
    pace = max(min(speed, FASTEST_M_S, APPROACH * far), LEAST * SPEED_M_S)
    bend = TURN * off * WHEELS_APART_M / 2
    bend = math.copysign(min(abs(bend), pace - LEAST * SPEED_M_S), bend)  # both wheels turn the same way
    left, right = value_of(sign * pace + bend), value_of(sign * pace - bend)
    mean = (abs(speed_of(left)) + abs(speed_of(right))) / 2
    return Pulse(left, right, _ticks(min(far, HOLD_M) / mean))


def _ticks(seconds: float) -> float:
    """A duration that can be told: hundredths of a second, one at least."""
    return min(max(math.floor(seconds / TICK_S + 0.5), 1) * TICK_S, HOLD_S)
