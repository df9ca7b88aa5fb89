"""Which of a robot's poses can be believed: packets carry no checksum, so one that jumps counts only with another."""

import math
from dataclasses import dataclass

from armspan.records import Vec2

JUMP_M, FASTEST_M_S, CLOCK_S = 0.05, 1.5, 2.0
TICKS = 1 << 32


@dataclass(slots=True)
class Track:
    """Which poses can be: one that jumps is refused until another one agrees with it."""

    refused: int = 0
    _last: tuple[float, Vec2, int | None] | None = None
    _odd: tuple[float, Vec2, int | None] | None = None

    def forget(self) -> None:
        """The robot was lifted or started again: the next pose is where it is."""
        self._last = self._odd = None

    def takes(self, arrived: float, xy: Vec2, ticks: int | None) -> bool:
        """Whether a pose [m] with its time stamp [ms], arrived at [s], is believed."""
        pose = arrived, xy, ticks
        if self._last is None or _agree(self._last, pose) or (self._odd is not None and _agree(self._odd, pose)):
            self._last, self._odd = pose, None
            return True
        self._odd = pose
        self.refused += 1
        return False

    def clock_jumped(self, arrived: float, ticks: int) -> bool:
        """Whether the robot's clock is another one than at the last pose."""
        return self._last is not None and not _clocks_agree(self._last, (arrived, (0.0, 0.0), ticks))


def _agree(before: tuple[float, Vec2, int | None], after: tuple[float, Vec2, int | None]) -> bool:
    seconds = after[0] - before[0]
    if before[2] is not None and after[2] is not None:
        seconds = max(seconds, (after[2] - before[2]) / 1000)  # packets that were held up come in one burst
    near = math.dist(before[1], after[1]) <= JUMP_M + FASTEST_M_S * max(seconds, 0.0)
    return near and _clocks_agree(before, after)


def _clocks_agree(before: tuple[float, Vec2, int | None], after: tuple[float, Vec2, int | None]) -> bool:
    if before[2] is None or after[2] is None:
        return True
    ticked = ((after[2] - before[2] + TICKS // 2) % TICKS - TICKS // 2) / 1000
    return abs(ticked - (after[0] - before[0])) <= CLOCK_S
