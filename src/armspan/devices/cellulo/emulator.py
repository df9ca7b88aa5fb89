"""Emulated Cellulo robots behind EPFL's relay on a TCP port: real bytes in and out, in real time.

The robots go on when the host is gone, as real ones do: whether they come to rest is the host's affair. What
they really did goes to a truth log, lines of JSON: first ``monotonic`` [s], the system's clock at t = 0, then
every 20 ms ``t`` [s], ``heard`` [s] when a command last came in, whether a ``host`` is connected, and ``robots``:
name to [x, y, speed] [m, m, m/s].
"""

import asyncio
import time
from collections.abc import Callable, Mapping
from typing import TextIO

import msgspec
import numpy as np

from armspan.devices.cellulo import relay
from armspan.devices.cellulo.firmware import Firmware
from armspan.errors import ConfigError, DeviceError
from armspan.records import Sheet, Vec2

STEP = 0.010
"""Seconds between two looks at the clock."""
TRUTH_STEPS = 2
LEAST_SPACING = 0.1
BACKLOG = 1 << 16
"""Bytes that may wait for a host that does not read; what comes then is lost, as on a radio."""
OUTAGE = 3.0
ASIDE = 2.0


def addresses(n: int) -> tuple[str, ...]:
    """Addresses of ``n`` emulated robots, with the prefix of the lab's radios."""
    return tuple(f"00:06:66:E7:{(k >> 8) & 0xFF:02X}:{k & 0xFF:02X}" for k in range(1, n + 1))


def places(n: int, sheet: Sheet) -> tuple[Vec2, ...]:
    """Where ``n`` robots stand, in rows over the sheet; in the pattern's own coordinates [m].

    Raises:
        ConfigError: where they would stand closer than 0.1 m.

    """
    columns = max(1, round((n * sheet.width_m / sheet.height_m) ** 0.5))
    rows = -(-n // columns)
    dx, dy = sheet.width_m / columns, sheet.height_m / rows
    if min(dx, dy) < LEAST_SPACING:
        size = f"{sheet.width_m:g} x {sheet.height_m:g} m"
        raise ConfigError(f"{n} robots do not fit on a sheet of {size}; expected fewer, or a larger one")
    x0, y0 = sheet.origin_m
    return tuple((x0 + (k % columns + 0.5) * dx, y0 + (k // columns + 0.5) * dy) for k in range(n))


class Emulator:
    """A relay for the robots of a `Firmware`, one client at a time.

    ``robots`` are their addresses and names in the firmware's order. ``outage_at`` [s] is when their radio
    links break, for three seconds; ``kidnap_at`` [s] when the first robot is lifted, for two.
    """

    def __init__(
        self,
        firmware: Firmware,
        robots: Mapping[str, str],
        truth: TextIO | None = None,
        outage_at: float | None = None,
        kidnap_at: float | None = None,
    ) -> None:
        self.firmware, self.macs, self.names = firmware, tuple(robots), tuple(robots.values())
        self._number = {mac: k for k, mac in enumerate(self.macs)}
        self._truth, self._outage_at, self._kidnap_at = truth, outage_at, kidnap_at
        self._client: _Client | None = None
        self._up = [True] * len(self.macs)
        self._known: set[int] = set()
        self._start, self._steps, self._heard = time.monotonic(), 0, 0.0

    @property
    def now(self) -> float:
        """Seconds since the robots were switched on."""
        return time.monotonic() - self._start

    async def serve(self, port: int, told: Callable[[int], None], host: str = "127.0.0.1") -> None:
        """Listen, tell the port, and let the robots live until cancelled.

        Raises:
            DeviceError: where the port cannot be had.

        """
        try:
            server = await asyncio.start_server(self._serve_client, host, port)
        except OSError as error:
            why = error.strerror or error
            raise DeviceError(f"port {port} cannot be listened on: {why}; try another --port, 0 for any") from None
        async with server:
            self._start = time.monotonic()
            self._log({"monotonic": self._start, "robots": self.names})
            told(server.sockets[0].getsockname()[1])
            try:
                while True:
                    self.catch_up()
                    await asyncio.sleep(STEP)
            finally:
                if self._client is not None:
                    await self._client.drop()

    def catch_up(self) -> None:
        """Bring the robots up to the clock."""
        now = self.now
        while (self._steps + 1) * STEP <= now:
            self._steps += 1
            self._step(self._steps * STEP)
        client = self._client
        if client is not None:
            client.send(client.stream.beat(now))
            if client.stream.silent(now):
                client.writer.transport.abort()

    def _step(self, t: float) -> None:
        self._go_wrong(t)
        for robot, packet in self.firmware.advance(t):
            if self._up[robot] and robot in self._known and self._client is not None:
                self._client.send(self._client.stream.pack(self.macs[robot], packet))
        for robot in range(len(self.macs)):
            if self._up[robot] and self.firmware.asleep(robot):
                self._link(robot, False)
        if self._steps % TRUTH_STEPS == 0:
            host = self._client is not None
            self._log({"t": round(t, 3), "heard": round(self._heard, 4), "host": host, "robots": self._places()})

    def _go_wrong(self, t: float) -> None:
        if self._outage_at is not None and abs(t - self._outage_at) <= STEP / 2:
            self._link_all(False)
        if self._outage_at is not None and abs(t - self._outage_at - OUTAGE) <= STEP / 2:
            self._link_all(True)
        if self._kidnap_at is not None and abs(t - self._kidnap_at) <= STEP / 2:
            x, y, heading = self.firmware.bodies.pose[:, 0].tolist()
            self.firmware.lift(t, 0)
            self.firmware.put_down(t + ASIDE, 0, (x, y), heading)

    def _link_all(self, up: bool) -> None:
        for robot in range(len(self.macs)):
            self._link(robot, up and not self.firmware.asleep(robot))

    def _link(self, robot: int, up: bool) -> None:
        self._up[robot] = up
        if self._client is not None and robot in self._known:
            self._announce(self._client, robot)

    def _announce(self, client: "_Client", robot: int) -> None:
        status = relay.CONNECTED if self._up[robot] else relay.CONNECTING
        client.send(client.stream.status(self.macs[robot], status))

    def _places(self) -> dict[str, tuple[float, float, float]]:
        bodies = self.firmware.bodies
        speed = np.hypot(*bodies.velocity[:2]).tolist()
        xy = bodies.pose[:2].T.tolist()
        return {
            name: (round(x, 6), round(y, 6), round(v, 6)) for name, (x, y), v in zip(self.names, xy, speed, strict=True)
        }

    def _log(self, line: object) -> None:
        if self._truth is not None:
            self._truth.write(msgspec.json.encode(line).decode() + "\n")
            self._truth.flush()

    # --- the client ------------------------------------------------------------------------------------

    async def _serve_client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._client is not None:  # one client only, as EPFL's
            writer.close()
            return
        client = self._client = _Client(relay.server_side(self.now), writer)
        for robot in sorted(self._known):
            self._announce(client, robot)
        try:
            while data := await reader.read(4096):
                for mac, packet in client.stream.feed(data, self.now):
                    self._take(client, mac, packet)
        except ConnectionError:
            pass  # a host that was killed: its robots go on
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
                self._announce(client, robot)
            return
        self._known.add(robot)
        if self._up[robot]:
            self._heard = self.now
            self.firmware.feed(self._heard, robot, packet)


class _Client:
    """The host on the other end."""

    def __init__(self, stream: relay.Stream, writer: asyncio.StreamWriter) -> None:
        self.stream, self.writer = stream, writer
        self.gone = asyncio.Event()

    def send(self, data: bytes) -> None:
        """Send if it is not too far behind."""
        if data and self.writer.transport.get_write_buffer_size() < BACKLOG:
            self.writer.write(data)

    async def drop(self) -> None:
        """Break the connection, and wait until nobody listens to it any more."""
        self.writer.transport.abort()
        await self.gone.wait()
        await asyncio.sleep(0)
