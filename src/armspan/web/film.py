"""A log's frames, made beforehand, and the place in them that is shown."""

import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import msgspec

RATE_HZ = 20.0
"""Frames a second of a log."""

LONGEST = 3600
"""Seconds of a log that are kept in memory at most."""

SPEEDS = (1, 2, 4)


class Opening(msgspec.Struct, frozen=True):
    """What is told first of a log: how long it lasts [s], whether a virtual person was in it, what it lacks."""

    seconds: float
    simulated: bool
    note: str = ""


class Second(msgspec.Struct, frozen=True):
    """One second of a log: the room message, and frame messages."""

    room: dict[str, Any] | None
    frames: list[dict[str, Any]]


_READ = msgspec.json.Decoder(Second)


def packed(second: Second) -> bytes:
    """A second as bytes, a tenth as large as what is sent of it."""
    return zlib.compress(msgspec.json.encode(second), 1)


@dataclass(slots=True)
class Film:
    """Plays what is there of a log; ``base`` is added to its rooms' numbers, so that browsers know them as new ones.

    ``clock`` tells seconds that only rise.
    """

    opening: Opening
    base: int = 0
    clock: Callable[[], float] = time.monotonic
    position: float = 0.0
    playing: bool = False
    speed: int = 1
    whole: bool = False
    _seconds: list[bytes] = field(default_factory=list)
    _open: tuple[int, Second | None] = (-1, None)
    _asked: float = 0.0

    @property
    def ready(self) -> float:
        """Seconds that can be shown now."""
        return min(float(len(self._seconds)), self.opening.seconds) if self._seconds else 0.0

    def add(self, data: bytes) -> None:
        """Take the next second, `packed`."""
        self._seconds.append(data)

    def play(self, playing: bool) -> None:
        """Play or pause; at the end it plays from the beginning."""
        self._asked = self.clock()
        if playing and self.whole and self.position >= self.ready:
            self.position = 0.0
        self.playing = playing

    def seek(self, position: float) -> None:
        """Go to a place [s]; what is not made yet cannot be gone to."""
        self.position = min(max(0.0, position), self.ready)
        self._asked = self.clock()

    def move(self) -> bool:
        """Go on with the clock; is there another frame to show?"""
        now = self.clock()
        passed, self._asked = now - self._asked, now
        if not self.playing:
            return False
        self.position = min(self.position + passed * self.speed, self.ready)
        if self.whole and self.position >= self.ready:
            self.playing = False
        return True

    def room(self) -> dict[str, Any] | None:
        """The room message at the place."""
        second = self._second()
        if second is None or second.room is None:
            return None
        return second.room | {"number": self.base + second.room["number"]}

    def frame(self) -> dict[str, Any]:
        """The frame message at the place."""
        second = self._second()
        if second is None or second.room is None or not second.frames:
            return {"t": 0.0, "room": 0}
        place = int((self.position - self._open[0]) * RATE_HZ)
        frame = second.frames[min(max(0, place), len(second.frames) - 1)]
        return frame | {"room": self.base + second.room["number"]}

    def _second(self) -> Second | None:
        place = min(int(self.position), len(self._seconds) - 1)
        if place < 0:
            return None
        if self._open[0] != place:
            self._open = (place, _READ.decode(zlib.decompress(self._seconds[place])))
        return self._open[1]
