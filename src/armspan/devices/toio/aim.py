"""How an emulated cube drives to a target by itself (toio core cube specification, motor control with targets).

The way is made up: the specification draws it, and tells when a target counts as reached, and how it may end.
"""

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

from armspan.devices.toio.quantities import LEAST
from armspan.devices.toio.wire import Packet

NEAR, STRAIGHT_DEG = 15, 4
"""Position IDs on each axis, and degrees, within which a target is reached."""
KEEP = 0xFFFF
REACHED, TIME_OUT, OFF_THE_MAT = 0, 1, 2
DEFAULT_S = 10.0

Sight: TypeAlias = tuple[int, int, int]
Spot: TypeAlias = tuple[int, int, int, int]
"""x, y, an angle, and how it is meant."""


@dataclass(slots=True)
class Aim:
    """Targets to drive to in turn, told at ``begun`` [s] from ``start``."""

    reply: str
    number: int
    seconds: float
    movement: int
    top: int
    change: int
    spots: list[Spot]
    begun: float
    start: Sight
    many: bool
    _far: float = 0.0
    _from: float | None = None

    @classmethod
    def of(cls, packet: Packet, t: float, sight: Sight | None) -> "Aim | None":
        """What a packet asks for, None where it keeps place and angle as they are."""
        args = packet.args
        told = args.get("targets")
        rows: list[dict[str, Any]] = told if isinstance(told, list) else [dict(args)]
        spots = [tuple(int(row[key]) for key in ("x", "y", "angle_deg", "angle_mode")) for row in rows]
        start = sight or (0, 0, 0)
        filled = _filled(start, spots)
        if all(x == KEEP and y == KEEP and mode == 6 for x, y, _, mode in spots):
            return None
        number, timeout, movement, top, change = (
            int(str(args[key])) for key in ("id", "timeout_s", "movement", "max_speed", "change")
        )
        many = packet.name == "motorTargets"
        reply = "motorTargetsReply" if many else "motorReply"
        return cls(reply, number, timeout or DEFAULT_S, movement, top, change, filled, t, start, many)

    def drive(self, t: float, sight: Sight | None) -> tuple[tuple[int, int], int | None]:
        """Both speed values at ``t`` [s], and the result once it is over."""
        if sight is None:
            return (0, 0), OFF_THE_MAT
        if t - self.begun >= self.seconds:
            return (0, 0), TIME_OUT
        x, y, angle, mode = self.spots[0]
        dx, dy = x - sight[0], y - sight[1]
        if self._from is None and max(abs(dx), abs(dy)) > NEAR:
            return self._move(dx, dy, sight[2]), None
        if self._from is None:
            self._from = float(sight[2])
        left = self._turn_left(angle, mode, sight[2])
        if abs(left) > STRAIGHT_DEG:
            turn = _least(math.copysign(min(self.top / 2, abs(left) / 2), left))
            return (turn, -turn), None
        return self._reached(t)

    def _reached(self, t: float) -> tuple[tuple[int, int], int | None]:
        self.spots = self.spots[1:]
        self.begun, self._from, self._far = t, None, 0.0
        return (0, 0), None if self.spots else REACHED

    def _move(self, dx: float, dy: float, angle: float) -> tuple[int, int]:
        far = math.hypot(dx, dy)
        self._far = max(self._far, far)
        off, sign = _wrapped(math.degrees(math.atan2(dy, dx)) - angle), 1
        if self.movement == 0 and abs(off) > 90:
            off, sign = _wrapped(off + 180), -1
        allowed = 10 if self.movement == 2 else 60
        speed = 0.0 if abs(off) > allowed else self._speed(1 - far / self._far) * math.cos(math.radians(off))
        turn = max(-self.top / 2, min(off / 2, self.top / 2))
        return _least(sign * speed + turn), _least(sign * speed - turn)

    def _speed(self, done: float) -> float:
        """The speed after a share ``done`` of the way."""
        slow = {0: 0.0, 1: 1 - done, 2: done, 3: abs(2 * done - 1)}[self.change]
        return max(self.top * (1 - 0.8 * slow), LEAST)

    def _turn_left(self, angle: int, mode: int, now: int) -> float:
        """Degrees that are left to turn, clockwise above zero."""
        if mode == 5:
            return 0.0
        if mode in (3, 4):
            sign = 1 if mode == 3 else -1
            return _wrapped((self._from or 0.0) + sign * angle - now)  # of a relative angle, the shortest way is told
        left = _wrapped(angle - now)
        if mode == 1 and left < -STRAIGHT_DEG:
            return left + 360
        return left - 360 if mode == 2 and left > STRAIGHT_DEG else left


def _filled(start: Sight, spots: "list[tuple[int, ...]]") -> list[Spot]:
    """The spots with what they keep of the ones before filled in."""
    x, y, angle, mode = start[0], start[1], start[2], 0
    filled: list[Spot] = []
    for spot in spots:
        x, y = (x if spot[0] == KEEP else spot[0]), (y if spot[1] == KEEP else spot[1])
        angle, mode = (angle, 0) if spot[3] == 6 else (spot[2], spot[3])
        filled.append((x, y, angle, mode))
    return filled


def _wrapped(degrees: float) -> float:
    return (degrees + 180) % 360 - 180


def _least(value: float) -> int:
    """A speed value that turns the wheel."""
    size = round(abs(value))
    return 0 if size == 0 else int(math.copysign(max(size, LEAST), value))
