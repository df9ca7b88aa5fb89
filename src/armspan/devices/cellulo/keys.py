"""The six touch keys of a Cellulo: touches, long touches, a hold, and the two ways to switch it off and on.

Times in milliseconds. From EPFL's source (chili-epfl/CelluloV1, touch.c and gesture.c). A key's raw offset tells how
much of a hand it feels; how much a finger gives is a guess, all else are the firmware's own numbers.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

KEYS = 6
SAMPLE_MS, LONG_MS, SWITCH_MS = 32, 2000, 3000
FINGER = 40.0
TOUCHED = 20.0
HOLD = 10.0
OFF = (frozenset((0, 2, 4)), frozenset((1, 3, 5)))
ON = 4


@dataclass(slots=True)
class Keys:
    """One robot's keys; ``touched`` is key to the time of its touch, ``held`` whether a hand is around the robot."""

    touched: dict[int, float] = field(default_factory=dict)
    held: bool = False
    _offsets: list[float] = field(default_factory=lambda: [0.0] * KEYS)
    _long: set[int] = field(default_factory=set)
    _off_since: float | None = None
    _on_since: float | None = None

    def feel(self, keys: Iterable[int] = (), grasp: float = 0.0) -> None:
        """A hand with fingers on ``keys``, and so much of it (the sum of the raw offsets) around the robot."""
        self._offsets = [grasp / KEYS] * KEYS
        for key in keys:
            self._offsets[key] += FINGER

    @property
    def busy(self) -> bool:
        """Whether there is anything to be sampled."""
        return any(self._offsets) or bool(self.touched) or self.held

    def sample(self, now: float) -> list[tuple[str, int]]:
        """What the chip tells: touchBegan, longTouch and touchReleased with their key, ``off`` and ``on``."""
        told = [event for key in range(KEYS) for event in self._sample_key(now, key)]
        self.held = sum(self._offsets) >= HOLD
        self._off_since, off = _lasting(now, self._off_since, frozenset(self.touched) in OFF)
        self._on_since, on = _lasting(now, self._on_since, len(self.touched) >= ON)
        return told + [("off", 0)] * off + [("on", 0)] * on

    def _sample_key(self, now: float, key: int) -> list[tuple[str, int]]:
        began = self.touched.get(key)
        if self._offsets[key] < TOUCHED:
            self._long.discard(key)
            return [] if self.touched.pop(key, None) is None else [("touchReleased", key)]
        if began is None:
            self.touched[key] = now
            return [("touchBegan", key)]
        if now - began >= LONG_MS and key not in self._long:
            self._long.add(key)
            return [("longTouch", key)]
        return []


def _lasting(now: float, since: float | None, so: bool) -> tuple[float | None, bool]:
    """Since when it is so, and whether that is three seconds now; told once."""
    if not so:
        return None, False
    if since is None:
        return now, False
    return (float("inf"), True) if now - since >= SWITCH_MS else (since, False)
