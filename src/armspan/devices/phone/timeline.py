"""A phone's clock, of any epoch, as session time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from armspan.clock import DeviceClock

_TICK = 1e-9
STEP_NS = 500_000_000
"""How far a clock must jump [ns] to be taken for one that was set anew."""


@dataclass(slots=True)
class Timeline:
    """Session seconds from a device's nanoseconds, which rise within a batch.

    The sample that was on its way for the shortest time sets the offset, which in a batch is the newest. A clock that
    was set goes back, or its samples seem to arrive before they were taken: the map then begins anew, counted in
    ``steps``; so does one whose first batch had been delayed.
    """

    steps: int = 0
    _clock: DeviceClock = field(default_factory=lambda: DeviceClock(_TICK))
    _newest: int | None = None
    _delay: float = math.inf

    def seconds(self, taken: Sequence[int], arrived: float) -> list[float]:
        """Session times [s] of a batch whose samples were taken at these times [ns]."""
        if not taken:
            return []
        if self._stepped(taken[-1], arrived):
            self.steps += 1
            self._clock, self._newest, self._delay = DeviceClock(_TICK), None, math.inf
        if self._newest is None:
            self._clock.seconds(taken[-1], arrived)
        self._newest = taken[-1]
        self._delay = min(self._delay, arrived - taken[-1] * _TICK)
        return [self._clock.seconds(ticks, arrived) for ticks in taken]

    def _stepped(self, newest: int, arrived: float) -> bool:
        if self._newest is None:
            return False
        early = self._delay - (arrived - newest * _TICK)
        return newest < self._newest - STEP_NS or early > STEP_NS * _TICK
