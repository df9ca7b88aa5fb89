"""The one loop: sources -> conductor -> swarm and sinks.

Async ends at ``Conductor.step``: above it everything may wait and nothing computes. Only the session calls
``swarm.send``. Robots are stopped on every way out: end of the sources, an exception anywhere, Ctrl-C.
"""

import asyncio
import time
from collections import deque
from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import AsyncExitStack, aclosing
from dataclasses import dataclass, field
from typing import Protocol

from armspan.conductor.conductor import STOP_TAPS
from armspan.errors import DeviceError
from armspan.ports import Sink, Source, Swarm
from armspan.records import (
    Command,
    Drive,
    Event,
    GoTo,
    Haptic,
    ImuSample,
    Light,
    Output,
    Press,
    Record,
    Stop,
    Tap,
    Tick,
    Touch,
    is_finite,
)

QUEUE = 2000
"""Events that may wait: ten seconds of two bands at 100 Hz."""

TOGETHER = 1.0
"""Seconds in which other devices may fail too, so that a person is told of all of them at once."""

TICK = 0.05
"""Seconds between two ticks in real time."""


@dataclass(slots=True)
class Counters:
    """What a session did: events by kind, samples dropped, microseconds of every step by kind of event."""

    dropped: int = 0
    not_finite: int = 0
    step_us: dict[str, list[float]] = field(default_factory=dict)


class Mind(Protocol):
    """What decides: the conductor, or a recorder of takes."""

    def step(self, event: Event) -> list[Output]:
        """Everything that follows from one event."""


class Session:
    """Runs a conductor between doors; ``run`` once."""

    def __init__(self, conductor: Mind, swarm: Swarm, sinks: Sequence[Sink] = ()) -> None:
        self.conductor, self.swarm, self.sinks = conductor, swarm, list(sinks)
        self.counters = Counters()
        self._waiting: deque[Event] = deque()
        self._news = asyncio.Event()
        self._idle = asyncio.Event()
        self._idle.set()
        self._t = 0.0
        self._failed: list[DeviceError] = []

    async def run(self, sources: Sequence[Source], lasting: Sequence[Source] = ()) -> None:
        """Let events in until every source has ended, then stop the robots.

        ``lasting`` are devices, which never end by themselves: they are closed when the others have ended. Raises
        whatever a source or the swarm raised, after the robots were told to stop.
        """
        try:
            # The pumps end before their sources are closed: a generator that still runs cannot be.
            async with AsyncExitStack() as stack, asyncio.TaskGroup() as doors:
                for source in (*sources, *lasting):
                    await stack.enter_async_context(aclosing(source))
                pumps = [doors.create_task(self._pump(source)) for source in sources]
                devices = [doors.create_task(self._pump(source)) for source in lasting]
                loop = doors.create_task(self._loop())
                await asyncio.gather(*(pumps or devices))
                await self.caught_up()
                for task in (*devices, loop):
                    task.cancel()
        except BaseExceptionGroup as failures:
            raise _first(failures) from None
        finally:
            await asyncio.shield(self._end())

    async def press(self, name: str, value: str = "") -> None:
        """Let a press in now; a stop is sent at once."""
        await self._admit(Press(self._t, name, value))

    async def caught_up(self) -> None:
        """Wait until everything let in so far has been decided and sent."""
        await self._idle.wait()

    def let_in(self, event: Event) -> None:
        """Queue an event: a full queue drops samples, counted, never anything else."""
        if not is_finite(event):
            self.counters.not_finite += 1
            return
        if isinstance(event, ImuSample) and len(self._waiting) >= QUEUE:
            self.counters.dropped += 1
            return
        self._waiting.append(event)
        self._idle.clear()
        self._news.set()

    async def _pump(self, source: Source) -> None:
        try:
            await self._pour(source)
        except DeviceError as failure:
            self._failed.append(failure)
            await self.swarm.send(Stop(self._t, None, "a device failed"))
            await asyncio.sleep(TOGETHER)
            raise _together(self._failed) from None

    async def _pour(self, source: Source) -> None:
        async for event in source:
            await self._admit(event)

    async def _admit(self, event: Event) -> None:
        if not is_stop(event):
            self.let_in(event)
            return
        await self.swarm.send(Stop(event.t, None, "stop"))  # at once, before anything that waits
        self._waiting.appendleft(event)
        self._idle.clear()
        self._news.set()

    async def _loop(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            while self._waiting:
                await self._decide(self._waiting.popleft())
            self._idle.set()

    async def _decide(self, event: Event) -> None:
        self._t = max(self._t, event.t)
        self._tell(event)
        began = time.perf_counter_ns()
        outputs = self.conductor.step(event)
        micros = (time.perf_counter_ns() - began) / 1000
        self.counters.step_us.setdefault(type(event).__name__, []).append(micros)
        for output in outputs:
            self._tell(output)
        for command in latest(outputs):
            await self.swarm.send(command)

    def _tell(self, record: Record) -> None:
        for sink in self.sinks:
            sink(record)

    async def _end(self) -> None:
        """Stop the robots first, whatever happened, then put it on record."""
        self._waiting.clear()
        try:
            await self.swarm.send(Stop(self._t, None, "quit"))
        finally:
            await self._decide(Press(self._t, "quit"))


def is_stop(event: Event) -> bool:
    """Whether an event stops all robots, whatever else goes on: a press, a long touch, a band's button."""
    match event:
        case Press(name="stop" | "quit") | Touch(kind="long"):
            return True
        case Tap(count=count):
            return count >= STOP_TAPS
        case _:
            return False


def latest(outputs: Sequence[Record]) -> list[Command]:
    """The commands to send, in order: of several motions for one robot only the last; a Stop for all leads."""
    commands: list[Command] = [o for o in outputs if isinstance(o, GoTo | Drive | Light | Haptic | Stop)]
    last: dict[tuple[object, ...], int] = {}
    for place, command in enumerate(commands):
        last[_slot(command, place)] = place
    kept = [commands[place] for place in sorted(last.values())]
    return sorted(kept, key=lambda command: not (isinstance(command, Stop) and command.robot is None))


def _slot(command: Command, place: int) -> tuple[object, ...]:
    return ("motion", command.robot) if isinstance(command, GoTo | Drive) else ("other", place)


def _first(failures: BaseExceptionGroup[BaseException]) -> BaseException:
    inner = failures.exceptions[0]
    return _first(inner) if isinstance(inner, BaseExceptionGroup) else inner


def _together(failures: Sequence[DeviceError]) -> DeviceError:
    """What several devices have to say to a person, as one error."""
    if len(failures) == 1:
        return failures[0]
    return DeviceError("; ".join(dict.fromkeys(str(failure) for failure in failures)))


class Stopwatch:
    """Session time of a live session [s], from when it is first asked for."""

    def __init__(self) -> None:
        self._start: float | None = None

    def __call__(self) -> float:
        """Seconds since the session began."""
        now = time.monotonic()
        if self._start is None:
            self._start = now
        return now - self._start


async def ticks(now: Callable[[], float], seconds: float | None = None) -> AsyncGenerator[Event, None]:
    """Twenty ticks a second in real time, until ``seconds`` [s] have passed; what fell behind is left out."""
    due = 0.0
    while seconds is None or due <= seconds:
        await asyncio.sleep(max(0.0, due - now()))
        yield Tick(now())
        due = max(due + TICK, now() - TICK)


class FastPace:
    """As fast as it goes, and still in order: the source that is least far waits for all decisions, then runs.

    Every source gets a pace of its own from ``door`` and gives it back with ``leave``.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._reached: dict[int, float] = {}
        self._turn = asyncio.Condition()

    def door(self) -> "Door":
        """A pace for one source, which starts at zero."""
        number = len(self._reached)
        self._reached[number] = 0.0
        return Door(self, number)

    async def wait(self, number: int, t: float) -> None:
        """Let source ``number`` go on to ``t`` [s] once no other is behind it and nothing waits."""
        async with self._turn:
            self._reached[number] = t
            self._turn.notify_all()
            await self._turn.wait_for(lambda: min((at, k) for k, at in self._reached.items())[1] == number)
        await self._session.caught_up()

    async def leave(self, number: int) -> None:
        """Source ``number`` has ended."""
        async with self._turn:
            self._reached.pop(number, None)
            self._turn.notify_all()


@dataclass(frozen=True, slots=True)
class Door:
    """One source's place in a `FastPace`."""

    pace: FastPace
    number: int

    async def __call__(self, t: float) -> None:
        """Wait for the turn to go on to ``t`` [s]."""
        await self.pace.wait(self.number, t)

    async def through(self, source: Source) -> AsyncGenerator[Event, None]:
        """The source's events; its place is given up when it ends."""
        try:
            async with aclosing(source):
                async for event in source:
                    yield event
        finally:
            await self.pace.leave(self.number)


class LivePace:
    """In time with the wall, or so many ``times`` faster: sleeps until ``t``; who falls behind goes on without."""

    def __init__(self, now: Callable[[], float] | None = None, *, times: float = 1.0) -> None:
        self._now, self._times = now, times

    async def __call__(self, t: float) -> None:
        """Sleep until ``t`` [s]."""
        if self._now is None:
            self._now = Stopwatch()
        await asyncio.sleep(max(0.0, t / self._times - self._now()))
