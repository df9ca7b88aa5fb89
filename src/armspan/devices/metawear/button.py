"""A band's button: presses that follow each other within 0.4 s are one tap of several.

The board tells presses only. How many there are is known when no other follows, but the third is told at once: it
stops the robots, and that does not wait.
"""

import math
from dataclasses import dataclass

from armspan.records import Tap

WITHIN_S = 0.4
AT_ONCE = 3


@dataclass(slots=True)
class Button:
    """The button of one band."""

    source: str
    _count: int = 0
    _last: float = -math.inf
    _down: bool = False

    def hear(self, state: int, t: float) -> list[Tap]:
        """The button was pressed (1) or released (0) at session time ``t`` [s].

        Each word may get lost: a release without a press tells of one too.
        """
        pressed, self._down = bool(state) or not self._down, bool(state)
        if not pressed:
            return []
        taps = self.due(t)
        self._count, self._last = self._count + 1, t
        return [*taps, *self._tell()] if self._count >= AT_ONCE else taps

    @property
    def pending(self) -> bool:
        """Whether a tap waits for another press."""
        return self._count > 0

    def due(self, now: float) -> list[Tap]:
        """The tap that is complete by now."""
        return self._tell() if self._count and now - self._last > WITHIN_S else []

    def wake(self) -> float:
        """When something may be due [s]."""
        return self._last + WITHIN_S if self._count else math.inf

    def leave(self) -> list[Tap]:
        """The link is gone: no other press can be heard."""
        self._down = False
        return self._tell() if self._count else []

    def _tell(self) -> list[Tap]:
        count, self._count = self._count, 0
        return [Tap(self._last, self.source, count)]
