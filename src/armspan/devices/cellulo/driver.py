"""Cellulo robots through EPFL's relay: a source of what they tell, a swarm that takes commands at once.

A stop is written at once. On every way out all robots are told to stop, three times.
"""

import asyncio
import os
import socket
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import suppress

from armspan.devices.cellulo import relay
from armspan.devices.cellulo.flock import PACE_S, Flock, Traits, stop_repeatedly
from armspan.devices.cellulo.quantities import mac_octets
from armspan.devices.cellulo.robot import CLEAR
from armspan.devices.cellulo.wire import EVENTS
from armspan.errors import ConfigError, DeviceError, DeviceNotFound
from armspan.records import Command, Event, Stop, Vec2

CONNECT_S = 5.0
RETRY_S = 2.0
KERNEL_BYTES = 4096
"""What the system may hold back of ours: old goals must not wait in a stuck link."""


class CelluloRelay:
    """Robots by name, each with its address, behind a relay at ``host`` and ``port``.

    ``origin_m`` is where the sheet's corner lies in the robots' own coordinates, ``scale`` what a metre of
    theirs is on the sheet where ``traits`` tell nothing of a robot, ``now`` the session's clock [s]. A relay that is
    not there at the start is waited for no longer than ``patience_s``; one that was there and goes, for ever.

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
        traits: Mapping[str, Traits] | None = None,
        now: Callable[[], float] | None = None,
        retry_s: float = RETRY_S,
        patience_s: float = 0.0,
    ) -> None:
        self._macs = checked_addresses(robots)
        self._traits = {name: (traits or {}).get(name, Traits(scale)) for name in robots}
        self._flock = Flock(self._traits, origin_m, now)
        self._by_mac = {mac: self._flock.robots[name] for name, mac in self._macs.items()}
        self._host, self._port, self._retry, self._patience = host, port, retry_s, patience_s
        self._line: _Line | None = None

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
            DeviceNotFound: where there is no relay at the start.
            DeviceError: for a robot that is connected and never answers.

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
            self._write(self._flock.now())
        self._flock.news.set()

    # --- the link --------------------------------------------------------------------------------------

    async def _keep(self) -> None:
        """Connect, talk until the link breaks, and again."""
        given_up = self._flock.now() + self._patience
        met = False
        while True:
            try:
                reader, writer = await self._connect()
            except OSError as error:
                if not met and self._flock.now() >= given_up:
                    raise self._absent(error) from None
            else:
                met = True
                with suppress(OSError):
                    await self._talk(reader, _Line(writer, self._flock.now()))
            self._tell_lost()
            await asyncio.sleep(self._retry)

    async def _connect(self) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        async with asyncio.timeout(CONNECT_S):
            return await asyncio.open_connection(self._host, self._port)

    def _absent(self, error: OSError) -> DeviceNotFound:
        number = error.errno or 0
        why = os.strerror(number).lower() if number > 0 else str(error) or f"no answer within {CONNECT_S:g} s"
        return DeviceNotFound(
            f"the relay at {self._host}:{self._port} was not heard ({why}); start EPFL's cellulo-robot-pool or "
            "cellulorobothubd there, or 'armspan emulate cellulo', and end other programs that use it: it serves one"
        )

    async def _talk(self, reader: asyncio.StreamReader, line: "_Line") -> None:
        self._line = line
        for name, mac in self._macs.items():
            line.write(line.stream.pack(mac, CLEAR))
            line.write(line.stream.status(mac, relay.CONNECTED, self._traits[name].adapter))
        reading = asyncio.create_task(self._read_on(reader, line))
        pen = asyncio.create_task(self._write_on(line))
        try:
            await asyncio.wait((reading, pen), return_when=asyncio.FIRST_COMPLETED)
            for task in (reading, pen):
                if task.done():
                    await task
        finally:
            for task in (reading, pen):
                task.cancel()
            await asyncio.gather(reading, pen, return_exceptions=True)
            self._line = None
            line.writer.close()

    async def _read_on(self, reader: asyncio.StreamReader, line: "_Line") -> None:
        while data := await reader.read(4096):
            self._read(line, data)

    def _read(self, line: "_Line", data: bytes) -> None:
        now, flock = self._flock.now(), self._flock
        for mac, packet in line.stream.feed(data, now):
            robot = self._by_mac.get(mac)
            if robot is None:
                continue
            if packet[1] == relay.STATUS:
                flock.tell(robot.linked(now, packet[2] == relay.CONNECTED))
            else:
                with suppress(DeviceError):  # an impossible number: bytes were lost, the next packet comes
                    flock.tell(robot.hear(EVENTS.decode(packet), now))
        flock.news.set()

    async def _write_on(self, line: "_Line") -> None:
        """Write what is due, as fast as the link takes it, and no faster than robots read."""
        while True:
            self._write(self._flock.now())
            with suppress(ConnectionError):  # the reading side notices
                await line.writer.drain()
            await asyncio.sleep(PACE_S)
            await self._flock.pause(min(robot.outbox.wake() for robot in self._flock))
            for robot in self._flock:
                self._flock.watch(robot)

    def _write(self, now: float) -> None:
        line = self._line
        if line is None:
            return
        line.write(line.stream.beat(now))
        for name, mac in self._macs.items():
            for packet in self._flock.robots[name].outbox.due(now):
                line.write(line.stream.pack(mac, packet))
        if line.stream.silent(now):
            line.writer.transport.abort()

    def _tell_lost(self) -> None:
        now = self._flock.now()
        for robot in self._flock:
            self._flock.tell(robot.linked(now, False))

    # --- the end ---------------------------------------------------------------------------------------

    async def _close(self) -> None:
        """Stop every robot, whether it is thought to be there or not; the first time before anything waits."""
        await stop_repeatedly(self._stop, self._flush)

    def _stop(self) -> bool:
        line = self._line
        if line is None:
            return False
        for mac in self._by_mac:
            line.write(line.stream.pack(mac, CLEAR))
        return True

    async def _flush(self) -> None:
        if self._line is not None:
            await self._line.writer.drain()


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


def checked_addresses(robots: Mapping[str, str]) -> dict[str, str]:
    """The addresses in capitals, by name; ConfigError for one that is none, or that two robots have."""
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
