"""What leads a session of real devices: the clock's ticks, what somebody presses, the set-up when all are heard."""

from collections import deque
from collections.abc import AsyncGenerator, Callable, Collection
from contextlib import aclosing

from armspan.ports import Source
from armspan.records import Event, ImuSample, Press, Record, Say, Tick
from armspan.session import ticks

PATIENCE = 15.0
"""Seconds after which the set-up is begun although a band was not heard: its first step then says which."""


class Lead:
    """Leads for ``seconds`` [s], or until ``quit`` is pressed or a recording is done.

    ``bands`` are the names that are waited for before the set-up; it hears the session's records as a sink. Where it
    ``waits``, somebody else begins the set-up.
    """

    def __init__(self, now: Callable[[], float], bands: Collection[str], seconds: float | None = None) -> None:
        self._now, self._missing, self._seconds = now, set(bands), seconds
        self._pressed: deque[tuple[str, str]] = deque()
        self._begun = self._done = self.waits = False

    def hear(self, record: Record) -> None:
        """Note who is there, and whether all is done."""
        if isinstance(record, ImuSample):
            self._missing.discard(record.source)
        elif isinstance(record, Say) and record.cue == "done":
            self._done = True
        elif isinstance(record, Press) and record.name == "setup":
            self._begun = True

    def press(self, name: str, value: str = "") -> None:
        """Press a button; it counts at the next tick, twenty of which come in a second."""
        self._pressed.append((name, value))

    async def source(self) -> AsyncGenerator[Event, None]:
        """Ticks, presses, and the set-up."""
        async for tick in ticks(self._now, self._seconds):
            while self._pressed:
                name, value = self._pressed.popleft()
                if name == "quit":
                    return
                yield Press(tick.t, name, value)
            if not self._begun and not self.waits and (not self._missing or tick.t >= PATIENCE):
                self._begun = True
                yield Press(tick.t, "setup")
            yield tick
            if self._done:
                return


async def led(source: Source) -> AsyncGenerator[Event, None]:
    """A simulated or replayed source beside real devices: its ticks and presses are left out, since those are led."""
    async with aclosing(source):
        async for event in source:
            if not isinstance(event, Tick | Press):
                yield event
