"""The doors of emulated Cellulo robots: EPFL's relay for all of them, or a pseudo-terminal for each."""

import asyncio
import os
from contextlib import suppress
from typing import Protocol

from armspan.devices.cellulo import relay
from armspan.errors import DeviceError
from armspan.links.line import Line

BACKLOG = 1 << 16
"""Bytes that may wait for a host that does not read; what comes then is lost, as on a radio."""
UNREAD = 1024


class Air(Protocol):
    """What lies between the robots and a door."""

    @property
    def macs(self) -> tuple[str, ...]:
        """The robots' addresses."""

    @property
    def now(self) -> float:
        """Seconds since they were switched on."""

    def up(self, robot: int) -> bool:
        """Whether a robot's radio link is there."""

    def hear(self, robot: int, data: bytes) -> None:
        """Bring a robot what a host sent."""


class RelayDoor:
    """EPFL's relay: all robots over one stream, one client at a time."""

    def __init__(self, air: Air) -> None:
        self._air = air
        self._number = {mac: k for k, mac in enumerate(air.macs)}
        self._known: set[int] = set()
        self._client: _Client | None = None

    @property
    def host(self) -> bool:
        """Whether a client is there."""
        return self._client is not None

    def tell(self, robot: int, packet: bytes) -> None:
        """Bring the client what a robot told, if it wanted that robot."""
        if robot in self._known and self._client is not None:
            self._client.send(self._client.stream.pack(self._air.macs[robot], packet))

    def linked(self, robot: int, up: bool) -> None:
        """Announce a robot's link."""
        if self._client is not None and robot in self._known:
            status = relay.CONNECTED if up else relay.CONNECTING
            self._client.send(self._client.stream.status(self._air.macs[robot], status))

    def tend(self, now: float) -> None:
        """Beat, and give up a client that does not."""
        client = self._client
        if client is not None:
            client.send(client.stream.beat(now))
            if client.stream.silent(now):
                client.writer.transport.abort()

    async def close(self) -> None:
        """Break the connection, and wait until nobody listens to it any more."""
        client = self._client
        if client is not None:
            client.writer.transport.abort()
            await client.gone.wait()
            await asyncio.sleep(0)

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Talk with a client until it goes; its robots go on."""
        if self._client is not None:  # one client only, as EPFL's
            writer.close()
            return
        client = self._client = _Client(relay.server_side(self._air.now), writer)
        for robot in sorted(self._known):
            self.linked(robot, self._air.up(robot))
        try:
            while data := await reader.read(4096):
                for mac, packet in client.stream.feed(data, self._air.now):
                    self._take(client, mac, packet)
        except ConnectionError:
            pass  # a host that was killed
        finally:
            self._client = None
            client.gone.set()
            writer.close()

    def _take(self, client: "_Client", mac: str, packet: bytes) -> None:
        """A robot's packet, or a wish about its connection; an address that no robot has is never found."""
        robot = self._number.get(mac)
        if robot is None:
            if packet[1] == relay.STATUS:
                client.send(client.stream.status(mac, relay.CONNECTING))
            return
        if packet[1] == relay.STATUS:
            if packet[2] == relay.DISCONNECTED:
                self._known.discard(robot)
                client.send(client.stream.status(mac, relay.DISCONNECTED))
            else:
                self._known.add(robot)
                self.linked(robot, self._air.up(robot))
            return
        self._known.add(robot)
        self._air.hear(robot, packet)


class _Client:
    """The host on the other end."""

    def __init__(self, stream: relay.Stream, writer: asyncio.StreamWriter) -> None:
        self.stream, self.writer = stream, writer
        self.gone = asyncio.Event()

    def send(self, data: bytes) -> None:
        """Send if it is not too far behind."""
        if data and self.writer.transport.get_write_buffer_size() < BACKLOG:
            self.writer.write(data)


class LineDoor:
    """Robots each behind a line of its own, by number; a line that ends is forgotten, a new one may be given."""

    def __init__(self, air: Air) -> None:
        self._air = air
        self._lines: dict[int, tuple[Line, asyncio.Task[None]]] = {}

    @property
    def host(self) -> bool:
        """Whether anybody may be there."""
        return bool(self._lines)

    def give(self, robot: int, line: Line) -> None:
        """Let a robot be reached over a line, until that ends."""
        self._lines[robot] = line, asyncio.create_task(self._listen(robot, line))

    def tell(self, robot: int, packet: bytes) -> None:
        """Bring the host what a robot told; what it does not read in time is lost."""
        line, _ = self._lines.get(robot, (None, None))
        if line is not None and line.waiting <= UNREAD:
            line.write(packet)

    def linked(self, robot: int, up: bool) -> None:
        """A radio link that goes takes its line with it."""
        if not up and robot in self._lines:
            self._lines[robot][0].close()

    def tend(self, now: float) -> None:
        """Nothing is due."""

    async def close(self) -> None:
        """Close all lines."""
        tasks = [task for _, task in self._lines.values()]
        for line, _ in list(self._lines.values()):
            line.close()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _listen(self, robot: int, line: Line) -> None:
        try:
            while data := await line.read():
                self._air.hear(robot, data)
        finally:
            if self._lines.get(robot, (None, None))[0] is line:
                del self._lines[robot]
            line.close()


class PtyDoor(LineDoor):
    """A pseudo-terminal for each robot; it stays open when the radio link is lost, and nothing comes through."""

    def __init__(self, air: Air, n: int) -> None:
        super().__init__(air)
        self._held: list[int] = []
        paths = []
        for robot in range(n):
            line, path, held = _pty()
            self._held.append(held)
            paths.append(path)
            self.give(robot, line)
        self.paths = tuple(paths)

    def linked(self, robot: int, up: bool) -> None:
        """Nobody can tell."""

    async def close(self) -> None:
        """Close all."""
        await super().close()
        for held in self._held:
            with suppress(OSError):
                os.close(held)


def _pty() -> tuple[Line, str, int]:
    """A raw pseudo-terminal: our end, the path of the other, and that end held open for whoever comes and goes."""
    try:
        import pty
        import tty

        ours, theirs = pty.openpty()
    except (ImportError, OSError) as error:
        raise DeviceError(
            f"this system gives no pseudo-terminals ({error}); leave --pty out and use the relay"
        ) from None
    tty.setraw(theirs)
    return Line(ours, lambda: os.close(ours)), os.ttyname(theirs), theirs
