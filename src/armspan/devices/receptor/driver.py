"""Receptors as a source of hits: serial ports, datagrams, requests, one stream of events."""

import asyncio
import math
from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING

from armspan.devices.receptor.datagrams import listening
from armspan.devices.receptor.entry import HttpReceptor, ReceptorEntry, SerialReceptor, UdpReceptor, robots_of
from armspan.devices.receptor.lines import Line, Reader
from armspan.devices.receptor.steady import Steady
from armspan.errors import ConfigError, DeviceError, DeviceNotFound
from armspan.links import serial_port
from armspan.links.http import Guard, posting, serving
from armspan.records import Event, Link

if TYPE_CHECKING:
    from armspan.links.line import Line as SerialLine

RETRY_S = 2.0
LARGEST_BODY = 4096
LEAST_S = 0.001
"""A pause too short for a clock's digits would never end."""


class Receptors:
    """Doors for whatever notices the laser's spot on ``robots``; ``now`` is the session's clock [s].

    Raises:
        ConfigError: where a door names a robot that does not exist, or two doors are the same.

    """

    def __init__(
        self,
        entries: Sequence[ReceptorEntry],
        robots: Sequence[str],
        now: Callable[[], float] | None = None,
        *,
        retry_s: float = RETRY_S,
    ) -> None:
        _check_doors(entries)
        self._doors = [_Door(entry, Reader(robots_of(entry, tuple(robots))), self._take) for entry in entries]
        self._given, self._began, self._retry = now, 0.0, retry_s
        self._events: asyncio.Queue[Event | None] = asyncio.Queue()
        self._news = asyncio.Event()
        self.ports: dict[str, int] = {}

    async def source(self) -> AsyncGenerator[Event, None]:
        """What the receptors notice, until it is closed; a serial port that went away is told, and tried again.

        Raises:
            DeviceNotFound: where there is no port at the path.
            DeviceError: where a door cannot be opened.
            MissingExtra: where HTTP is wanted and its package is not installed.

        """
        self._began = asyncio.get_running_loop().time()
        async with AsyncExitStack() as stack:
            tasks: list[asyncio.Task[None]] = []
            stack.push_async_callback(_ended, tasks)
            tasks.append(asyncio.create_task(self._watch()))
            for door in self._doors:
                await self._open(door, stack, tasks)
            for task in tasks:
                task.add_done_callback(lambda _: self._events.put_nowait(None))
            while (event := await self._events.get()) is not None:
                yield event
            await asyncio.gather(*(task for task in tasks if task.done()))

    def report(self) -> dict[str, dict[str, int]]:
        """The counters of each door; ``refused`` are messages of strangers."""
        return {door.entry.name: door.report() for door in self._doors}

    def told(self) -> list[str]:
        """What was wrong with what was said, one sentence each: names that no robot has."""
        return [f"receptor {door.entry.name!r}: {sentence}" for door in self._doors for sentence in door.reader.told]

    # --- doors -----------------------------------------------------------------------------------------

    async def _open(self, door: "_Door", stack: AsyncExitStack, tasks: "list[asyncio.Task[None]]") -> None:
        match door.entry:
            case SerialReceptor(path=path, baud=baud):
                line = await serial_port.opened(path, baud)  # raises for what a person must mend
                tasks.append(asyncio.create_task(self._keep(door, path, baud, line)))
            case UdpReceptor():
                host, port = door.entry.address
                self.ports[door.entry.name] = await stack.enter_async_context(listening(host, port, door.datagram))
            case HttpReceptor():
                routes = [posting("/{path:.*}", door.posted)]
                host, port = door.entry.address
                opened = serving(routes, host, port, door.guard, largest=LARGEST_BODY)
                self.ports[door.entry.name] = await stack.enter_async_context(opened)

    async def _keep(self, door: "_Door", path: str, baud: int, line: "SerialLine | None") -> None:
        """Read a serial port until it breaks, and open it again."""
        try:
            while True:
                if line is not None:
                    self._link(door, True)
                    door.reader.begin()
                    while data := await line.read():
                        door.take(door.reader.feed(data))
                    line.close()
                    self._lose(door)
                await asyncio.sleep(self._retry)
                line = await _reopened(path, baud)
        finally:
            if line is not None:
                line.close()

    # --- what all share --------------------------------------------------------------------------------

    def _take(self, door: "_Door", lines: list[Line]) -> None:
        t = self._now()
        if lines:
            self._link(door, True)
        for line in lines:
            self._tell(door.steady.take(t, line.robot, line.on))
        self._news.set()

    def _link(self, door: "_Door", up: bool) -> None:
        if door.up is not up:
            door.up = up
            self._tell([Link(self._now(), door.entry.name, up)])

    def _lose(self, door: "_Door") -> None:
        self._tell(door.steady.clear(self._now()))
        self._link(door, False)

    async def _watch(self) -> None:
        """Tell what is over by itself, when it is."""
        while True:
            self._news.clear()
            t = self._now()
            for door in self._doors:
                self._tell(door.steady.advance(t))
            wait = min((door.steady.due() for door in self._doors), default=math.inf) - t
            try:
                async with asyncio.timeout(max(wait, LEAST_S) if math.isfinite(wait) else None):
                    await self._news.wait()
            except TimeoutError:
                continue

    def _tell(self, events: Sequence[Event]) -> None:
        for event in events:
            self._events.put_nowait(event)

    def _now(self) -> float:
        return self._given() if self._given is not None else asyncio.get_running_loop().time() - self._began


class _Door:
    """One door: who may come in, what was read, what is lit."""

    def __init__(self, entry: ReceptorEntry, reader: Reader, take: "Callable[[_Door, list[Line]], None]") -> None:
        self.entry, self.reader = entry, reader
        self.steady = Steady(entry.chatter_s, entry.expire_s)
        self.guard = Guard() if isinstance(entry, SerialReceptor) else entry.guard()
        self.up: bool | None = None
        self._take = take

    def take(self, lines: list[Line]) -> None:
        """Take lines of those who may come in."""
        self._take(self, lines)

    def datagram(self, data: bytes, address: str) -> None:
        """Take the lines of a datagram that bring the token along, or come from an address that is allowed."""
        if isinstance(self.entry, SerialReceptor):
            return
        host, _ = self.entry.address
        admitted = []
        for line in self.reader.whole(data):
            if self.guard.admits(address, line.token, host):
                admitted.append(line)
            else:
                self.guard.refused += 1
        self.take(admitted)

    def posted(self, data: bytes) -> None:
        """Take the lines of a request (DeviceError where one of them says nothing that can be used)."""
        counters = self.reader.counters
        unknown, malformed = counters.unknown, counters.malformed + counters.too_long
        self.take(self.reader.whole(data))
        if counters.unknown > unknown:
            names = ", ".join(self.reader.robots)
            raise DeviceError(f"a line names a robot that does not exist; there are: {names}")
        if counters.malformed + counters.too_long > malformed:
            raise DeviceError("a line is neither 'hit ROBOT' nor 'lost ROBOT'; expected one of them in each line")

    def report(self) -> dict[str, int]:
        """The counters."""
        c = self.reader.counters
        refused = self.guard.refused
        return {"lines": c.lines, "unknown": c.unknown, "malformed": c.malformed, "too_long": c.too_long} | {
            "refused": refused
        }


async def _reopened(path: str, baud: int) -> "SerialLine | None":
    try:
        return await serial_port.opened(path, baud)
    except DeviceNotFound:
        return None


async def _ended(tasks: "list[asyncio.Task[None]]") -> None:
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


def _check_doors(entries: Sequence[ReceptorEntry]) -> None:
    names: set[str] = set()
    places: dict[object, str] = {}
    for entry in entries:
        if entry.name in names:
            raise ConfigError(f"receptor {entry.name!r} is named twice; names tell receptors apart")
        names.add(entry.name)
        place: object = entry.path if isinstance(entry, SerialReceptor) else (type(entry), *entry.address)
        free = not isinstance(entry, SerialReceptor) and entry.address[1] == 0
        other = entry.name if free else places.setdefault(place, entry.name)
        if other != entry.name:
            raise ConfigError(
                f"receptors {other!r} and {entry.name!r} are the same door; one door serves many robots, or give the "
                "second one a path or a port of its own"
            )
