"""Cellulo robots each over a line of its own: a Bluetooth socket, or a serial port.

One attempt to connect at a time for each adapter, for a radio that pages somebody hears nobody else. What comes up is
told to forget its goal before anything else. Commands wait in the robot's outbox, not in a line that is stuck: what
is written late would be an old goal. On every way out all robots are told to stop, three times.
"""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from armspan.devices.cellulo.flock import PACE_S, Flock, Traits, stop_repeatedly
from armspan.devices.cellulo.robot import CLEAR, LOST_S, Robot
from armspan.devices.cellulo.wire import EVENTS, Decoder
from armspan.errors import DeviceError, DeviceNotFound
from armspan.records import Command, Event, Stop, Vec2

PAUSES = (0.5, 1.0, 2.0, 4.0)
"""Seconds from one attempt in vain to the next; the last for ever."""
STUCK_S, STUCK_PAUSE_S = 8.0, 0.02
"""Seconds of silence after which a line is opened anew, and between two looks at one that takes nothing."""


class Line(Protocol):
    """What a robot's bytes travel over."""

    async def read(self) -> bytes:
        """What arrived; nothing once the line is broken."""

    def write(self, data: bytes) -> None:
        """Write without waiting."""

    @property
    def room(self) -> bool:
        """Whether what was written before has left."""

    async def flushed(self) -> None:
        """Wait until all has left."""

    def close(self) -> None:
        """Close it."""


@dataclass(frozen=True, slots=True)
class Way:
    """How a robot is reached: ``connect`` makes one attempt, beside no other one of the same ``queue``.

    ``carrier`` tells that an open line means a robot at its other end, as a Bluetooth socket's; a serial port is open
    with nobody there. ``connect`` raises DeviceNotFound where another attempt may help, DeviceError where none will; at
    the start a serial port that is not there ends the session too.
    """

    connect: Callable[[], Awaitable[Line]]
    queue: str = ""
    carrier: bool = True


@dataclass(slots=True)
class _Tie:
    """A robot, the way to it, and the line while there is one."""

    robot: Robot
    way: Way
    line: Line | None = None
    opened: float = 0.0
    tries: int = 0
    ever: bool = False
    ears: Decoder = field(default_factory=lambda: Decoder(EVENTS))


class CelluloSockets:
    """Robots by name, each with its way; ``origin_m`` is where the sheet's corner lies in their own coordinates.

    ``now`` is the session's clock [s]; ``pauses`` [s] lie between attempts in vain.
    """

    def __init__(
        self,
        robots: Mapping[str, Way],
        *,
        origin_m: Vec2 = (0.0, 0.0),
        traits: Mapping[str, Traits] | None = None,
        now: Callable[[], float] | None = None,
        pauses: tuple[float, ...] = PAUSES,
    ) -> None:
        told = {name: (traits or {}).get(name, Traits()) for name in robots}
        self._flock = Flock(told, origin_m, now)
        self._ties = {name: _Tie(self._flock.robots[name], way) for name, way in robots.items()}
        self._turn = {way.queue: asyncio.Lock() for way in robots.values()}
        self._pauses = pauses

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names."""
        return tuple(self._flock.robots)

    @property
    def refused(self) -> int:
        """Poses that could not be believed."""
        return sum(robot.track.refused for robot in self._flock)

    def source(self) -> AsyncGenerator[Event, None]:
        """What the robots tell; a link that breaks is told, and tried again. Closing it stops the robots.

        Raises:
            DeviceError: for what a person must mend: no Bluetooth, no permission, a robot that never answers.

        """
        return self._flock.heard(self._keep, self._close)

    async def send(self, command: Command) -> None:
        """Take a command and return at once.

        Raises:
            DeviceNotFound: for a robot that does not exist.
            DeviceError: for a velocity, or a number that must not reach the wire.

        """
        if self._flock.closed:
            return  # the robots were told to stop already
        self._flock.take(command)
        if isinstance(command, Stop):
            for tie in self._ties.values():
                self._write(tie)
        self._flock.news.set()

    # --- the links -------------------------------------------------------------------------------------

    async def _keep(self) -> None:
        """Keep all links, and write what is due on them."""
        tasks = [asyncio.create_task(self._hold(tie)) for tie in self._ties.values()]
        tasks.append(asyncio.create_task(self._write_on()))
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_EXCEPTION)
            for task in done:
                await task
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _hold(self, tie: _Tie) -> None:
        """Connect, listen until the line breaks, and again."""
        while True:
            line = await self._open(tie)
            if line is not None:
                await self._listen(tie, line)
            self._flock.tell(tie.robot.linked(self._flock.now(), False))
            pause = self._pauses[min(tie.tries, len(self._pauses) - 1)]
            tie.tries += 1
            await asyncio.sleep(pause)

    async def _open(self, tie: _Tie) -> Line | None:
        """One attempt, when it is this robot's turn."""
        try:
            async with self._turn[tie.way.queue]:
                return await tie.way.connect()
        except DeviceError as error:
            passing = isinstance(error, DeviceNotFound) and tie.way.carrier  # a robot may be switched on
            if not (passing or tie.ever):  # an adapter or a port that was there may be plugged in again
                raise
            return None

    async def _listen(self, tie: _Tie, line: Line) -> None:
        line.write(CLEAR)
        now = self._flock.now()
        tie.line, tie.opened, tie.ever, tie.ears = line, now, True, Decoder(EVENTS)
        if tie.way.carrier:
            self._flock.tell(tie.robot.linked(now, True))
        else:
            tie.robot.knock(now)
        self._flock.news.set()
        try:
            while data := await line.read():
                self._hear(tie, data)
        finally:
            self._drop(tie)

    def _hear(self, tie: _Tie, data: bytes) -> None:
        for packet in tie.ears.feed(data):
            tie.tries = 0
            self._flock.tell(tie.robot.hear(packet, self._flock.now()))
        self._flock.news.set()

    def _drop(self, tie: _Tie) -> None:
        line, tie.line = tie.line, None
        if line is not None:
            line.close()

    async def _write_on(self) -> None:
        """Write what is due to each, and no faster than robots read."""
        while True:
            for tie in self._ties.values():
                self._write(tie)
            await asyncio.sleep(PACE_S)
            await self._flock.pause(min(self._wake(tie) for tie in self._ties.values()))
            for tie in self._ties.values():
                self._watch(tie)

    def _write(self, tie: _Tie) -> None:
        if tie.line is not None and tie.line.room:
            for packet in tie.robot.outbox.due(self._flock.now()):
                tie.line.write(packet)

    def _wake(self, tie: _Tie) -> float:
        """When to look after a robot again [s]; soon where its line was stuck."""
        if tie.line is not None and not tie.line.room:
            return self._flock.now() + STUCK_PAUSE_S
        return tie.robot.outbox.wake()

    def _watch(self, tie: _Tie) -> None:
        """Ask a silent robot whether it is there; after a while open its line anew."""
        if tie.line is None:
            return
        now = self._flock.now()
        if not tie.robot.up:
            tie.robot.knock(now)
        if tie.robot.up is None and now - tie.opened >= LOST_S:
            self._flock.tell(tie.robot.linked(now, False))  # a port is open, and nobody there
        self._flock.watch(tie.robot)
        if tie.way.carrier and now - max(tie.robot.heard, tie.opened) >= STUCK_S:
            self._drop(tie)

    # --- the end ---------------------------------------------------------------------------------------

    async def _close(self) -> None:
        """Stop every robot that there is a line to, whatever is thought of it; at once, before anything waits."""
        await stop_repeatedly(self._stop, self._flush)
        for tie in self._ties.values():
            self._drop(tie)

    def _stop(self) -> bool:
        lines = [tie.line for tie in self._ties.values() if tie.line is not None]
        for line in lines:
            line.write(CLEAR)
        return bool(lines)

    async def _flush(self) -> None:
        await asyncio.gather(*(tie.line.flushed() for tie in self._ties.values() if tie.line is not None))
