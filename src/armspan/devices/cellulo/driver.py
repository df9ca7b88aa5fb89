"""Cellulo robots through EPFL's relay: a source of what they tell, a swarm that takes commands at once.

The session never waits for the radio: a command goes into its robot's outbox, where the latest motion wins, and
a stop is written at once. On every way out all robots are told to stop, three times. What a killed process
cannot do, its goals do: they lie a short way ahead, and the robots rest there.
"""

import asyncio
import math
import socket
import time
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import suppress

from armspan.devices.cellulo import relay
from armspan.devices.cellulo.quantities import mac_octets
from armspan.devices.cellulo.robot import CLEAR, STOPS, Placement, Robot
from armspan.devices.cellulo.wire import EVENTS
from armspan.errors import ConfigError, DeviceError, DeviceNotFound, known_names
from armspan.records import Command, Event, Stop, Vec2

CONNECT_S = 5.0
RETRY_S = 2.0
PACE_S = 0.005
"""Between two bursts to a robot, which reads its 256 bytes once in ten milliseconds."""
WATCH_S = 0.25
CLOSE_S = 0.5
KERNEL_BYTES = 4096
"""What the system may hold back of ours: old goals must not wait in a stuck link."""


class CelluloRelay:
    """Robots by name, each with its address, behind a relay at ``host`` and ``port``.

    ``origin_m`` is where the sheet's corner lies in the robots' own coordinates, ``scale`` what a metre of
    theirs is on the sheet, ``now`` the session's clock [s].

    Raises:
        ConfigError: for an address that is not one, or one that two robots have.

    """

    def __init__(
        self,
        robots: Mapping[str, str],
        host: str = "127.0.0.1",
        port: int = relay.PORT,
        *,
        origin_m: Vec2 = (0.0, 0.0),
        scale: float = 1.0,
        now: Callable[[], float] | None = None,
        retry_s: float = RETRY_S,
    ) -> None:
        self._macs = _checked_addresses(robots)
        if not (math.isfinite(scale) and scale > 0):
            raise ConfigError(f"scale is {scale}; expected a number above zero, 1 where the pattern was printed true")
        placement = Placement(origin_m, scale)
        self._robots = {name: Robot(name, placement) for name in robots}
        self._by_mac = {mac: self._robots[name] for name, mac in self._macs.items()}
        self._host, self._port, self._retry = host, port, retry_s
        began = time.monotonic()
        self._now = now or (lambda: time.monotonic() - began)
        self._events: asyncio.Queue[Event | None] = asyncio.Queue()
        self._news = asyncio.Event()
        self._line: _Line | None = None
        self._closed = False

    @property
    def refused(self) -> int:
        """Poses that could not be believed."""
        return sum(robot.track.refused for robot in self._robots.values())

    async def source(self) -> AsyncGenerator[Event, None]:
        """What the robots tell; a link that breaks is told, and tried again. Closing it stops the robots."""
        keeper = asyncio.create_task(self._keep())
        keeper.add_done_callback(lambda _: self._events.put_nowait(None))
        try:
            while (event := await self._events.get()) is not None:
                yield event
            await keeper
        finally:
            await self._close(keeper)

    async def send(self, command: Command) -> None:
        """Take a command and return at once.

        Raises:
            DeviceNotFound: for a robot that does not exist.
            DeviceError: for a velocity, or a number that must not reach the wire.

        """
        if self._closed:
            return  # the robots were told to stop already
        now = self._now()
        for robot in self._addressed(command.robot):
            robot.take(command, now)
        if isinstance(command, Stop):
            self._write(now)
        self._news.set()

    def _addressed(self, name: str | None) -> list[Robot]:
        if name is None:
            return list(self._robots.values())
        if name not in self._robots:
            raise DeviceNotFound(known_names("robot", name, self._robots))
        return [self._robots[name]]

    # --- the link --------------------------------------------------------------------------------------

    async def _keep(self) -> None:
        """Connect, talk until the link breaks, and again."""
        while True:
            with suppress(OSError, TimeoutError):
                async with asyncio.timeout(CONNECT_S):
                    reader, writer = await asyncio.open_connection(self._host, self._port)
                await self._talk(reader, _Line(writer, self._now()))
            self._tell_lost()
            await asyncio.sleep(self._retry)

    async def _talk(self, reader: asyncio.StreamReader, line: "_Line") -> None:
        self._line = line
        for mac in self._by_mac:
            line.write(line.stream.pack(mac, CLEAR))
            line.write(line.stream.status(mac, relay.CONNECTED))
        pen = asyncio.create_task(self._write_on(line))
        try:
            while data := await reader.read(4096):
                self._read(line, data)
        finally:
            pen.cancel()
            self._line = None
            line.writer.close()

    def _read(self, line: "_Line", data: bytes) -> None:
        now = self._now()
        for mac, packet in line.stream.feed(data, now):
            robot = self._by_mac.get(mac)
            if robot is None:
                continue
            if packet[1] == relay.STATUS:
                self._tell(robot.linked(now, packet[2] == relay.CONNECTED))
            else:
                with suppress(DeviceError):  # an impossible number: bytes were lost, the next packet comes
                    self._tell(robot.hear(EVENTS.decode(packet), now))
        self._news.set()

    async def _write_on(self, line: "_Line") -> None:
        """Write what is due, as fast as the link takes it, and no faster than robots read."""
        while True:
            self._write(self._now())
            with suppress(ConnectionError):  # the reading side notices
                await line.writer.drain()
            await asyncio.sleep(PACE_S)
            wake = min((robot.outbox.wake() for robot in self._robots.values()), default=math.inf)
            pause = min(max(wake - self._now(), 0.0), WATCH_S)
            with suppress(TimeoutError):
                async with asyncio.timeout(pause):
                    await self._news.wait()
            self._news.clear()
            for robot in self._robots.values():
                self._tell(robot.watch(self._now()))

    def _write(self, now: float) -> None:
        line = self._line
        if line is None:
            return
        line.write(line.stream.beat(now))
        for name, mac in self._macs.items():
            for packet in self._robots[name].outbox.due(now):
                line.write(line.stream.pack(mac, packet))
        if line.stream.silent(now):
            line.writer.transport.abort()

    def _tell(self, events: list[Event]) -> None:
        for event in events:
            self._events.put_nowait(event)

    def _tell_lost(self) -> None:
        now = self._now()
        for robot in self._robots.values():
            self._tell(robot.linked(now, False))

    # --- the end ---------------------------------------------------------------------------------------

    async def _close(self, keeper: "asyncio.Task[None]") -> None:
        """Stop every robot, whether it is thought to be there or not; the first time before anything waits."""
        self._closed = True
        try:
            for before, after in zip(STOPS, (*STOPS[1:], STOPS[-1]), strict=True):
                line = self._line
                if line is None:
                    break
                for mac in self._by_mac:
                    line.write(line.stream.pack(mac, CLEAR))
                await asyncio.sleep(after - before)
            if self._line is not None:
                await self._line.flushed()
        finally:
            keeper.cancel()
            with suppress(asyncio.CancelledError, Exception):
                await keeper


class _Line:
    """A connection to the relay."""

    def __init__(self, writer: asyncio.StreamWriter, now: float) -> None:
        self.stream, self.writer = relay.client_side(now), writer
        writer.transport.set_write_buffer_limits(high=0)
        writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, KERNEL_BYTES)

    def write(self, data: bytes) -> None:
        """Write without waiting."""
        if data and not self.writer.transport.is_closing():
            self.writer.write(data)

    async def flushed(self) -> None:
        """Wait a little for what was written."""
        with suppress(OSError, TimeoutError):
            async with asyncio.timeout(CLOSE_S):
                await self.writer.drain()


def _checked_addresses(robots: Mapping[str, str]) -> dict[str, str]:
    macs: dict[str, str] = {}
    for name, text in robots.items():
        try:
            mac_octets(text)
        except ValueError as error:
            raise ConfigError(f"robot {name!r} has the address {text!r}; expected {error}") from None
        if text.upper() in macs.values():
            raise ConfigError(f"robot {name!r} has the address {text} of another one; each robot has its own")
        macs[name] = text.upper()
    return macs
