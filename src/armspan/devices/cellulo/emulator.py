"""Emulated Cellulo robots behind doors: real bytes in and out, in real time or as somebody else's clock tells.

The robots go on when the host is gone, as real ones do: whether they come to rest is the host's affair. What
they really did goes to a truth log, lines of JSON: first ``monotonic`` [s], the system's clock at t = 0, then
every 20 ms ``t`` [s], ``heard`` [s] when a command last came in, whether a ``host`` is connected, and ``robots``:
name to [x, y, speed] [m, m, m/s].
"""

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import Protocol, TextIO

import msgspec
import numpy as np

from armspan.devices.cellulo.doors import PtyDoor, RelayDoor
from armspan.devices.cellulo.faults import ASIDE_S, LOAD_G, Trouble
from armspan.devices.cellulo.firmware import Firmware
from armspan.errors import ConfigError, DeviceError, known_names
from armspan.records import Sheet, Vec2

STEP = 0.010
"""Seconds between two looks at the clock."""
TRUTH_STEPS = 2
LEAST_SPACING = 0.1
OUTAGE = 3.0
ASIDE = ASIDE_S


class Door(Protocol):
    """Where hosts come in."""

    @property
    def host(self) -> bool:
        """Whether one is there."""

    def tell(self, robot: int, packet: bytes) -> None:
        """Bring a host what a robot told."""

    def linked(self, robot: int, up: bool) -> None:
        """A robot's radio link came or went."""

    def tend(self, now: float) -> None:
        """Do what is due."""


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
    """The robots of a `Firmware`, and the air between them and the doors.

    ``robots`` are their addresses and names in the firmware's order. ``outage_at`` [s] is when their radio
    links break, for three seconds; ``kidnap_at`` [s] when the first robot is lifted, for two; ``troubles`` are more.
    ``now`` is whose clock they live by [s], their own by default, which begins with `serve` or `listening`.

    Raises:
        ConfigError: for trouble of a robot that does not exist.

    """

    def __init__(
        self,
        firmware: Firmware,
        robots: Mapping[str, str],
        truth: TextIO | None = None,
        outage_at: float | None = None,
        kidnap_at: float | None = None,
        troubles: Sequence[Trouble] = (),
        now: Callable[[], float] | None = None,
    ) -> None:
        self.firmware, self.macs, self.names = firmware, tuple(robots), tuple(robots.values())
        self.doors: list[Door] = []
        self._truth = truth
        self._troubles = list(troubles)
        if outage_at is not None:
            self._troubles.append(Trouble("link-loss", outage_at, OUTAGE))
        if kidnap_at is not None:
            self._troubles.append(Trouble("kidnap", kidnap_at, ASIDE, self.names[0]))
        for trouble in self._troubles:
            if trouble.robot is not None and trouble.robot not in self.names:
                raise ConfigError(known_names("robot", trouble.robot, self.names))
        self._broken, self._hushed = ([False] * len(self.macs) for _ in range(2))
        self._up = [True] * len(self.macs)
        self._whose = now
        self._start, self._steps, self.heard = time.monotonic(), 0, 0.0

    @property
    def now(self) -> float:
        """Seconds since the robots were switched on."""
        return self._whose() if self._whose is not None else time.monotonic() - self._start

    # --- doors -----------------------------------------------------------------------------------------

    async def serve(self, port: int, told: Callable[[int], None], host: str = "127.0.0.1") -> None:
        """Listen as EPFL's relay, tell the port, and let the robots live until cancelled.

        Raises:
            DeviceError: where the port cannot be had.

        """
        async with self.listening(port, host) as at:
            told(at)
            await self.live()

    @asynccontextmanager
    async def listening(self, port: int = 0, host: str = "127.0.0.1") -> AsyncIterator[int]:
        """Listen as EPFL's relay; the port. Whoever opens it lets the robots live: `live`, `catch_up` or `advance`.

        Raises:
            DeviceError: where the port cannot be had.

        """
        door = RelayDoor(self)
        try:
            server = await asyncio.start_server(door.serve, host, port)
        except OSError as error:
            why = error.strerror or error
            raise DeviceError(f"port {port} cannot be listened on: {why}; try another --port, 0 for any") from None
        async with server:
            self.begin()
            self.doors.append(door)
            try:
                yield server.sockets[0].getsockname()[1]
            finally:
                self.doors.remove(door)
                await door.close()

    @asynccontextmanager
    async def on_ptys(self) -> AsyncIterator[tuple[str, ...]]:
        """Give each robot a pseudo-terminal, as a radio bound to a serial port; their paths.

        Raises:
            DeviceError: where the system has none.

        """
        door = PtyDoor(self, len(self.macs))
        self.begin()
        self.doors.append(door)
        try:
            yield door.paths
        finally:
            self.doors.remove(door)
            await door.close()

    def begin(self) -> None:
        """Start the robots' clock, unless they live already."""
        if self._steps == 0 and not self.doors:
            self._start = time.monotonic()
            self._log({"monotonic": self._start, "robots": self.names})

    # --- life ------------------------------------------------------------------------------------------

    async def live(self) -> None:
        """Let the robots live until cancelled."""
        while True:
            self.catch_up()
            await asyncio.sleep(STEP)

    def catch_up(self) -> None:
        """Bring the robots up to the clock."""
        self.advance(self.now)

    def advance(self, now: float) -> None:
        """Bring the robots up to a time [s]."""
        while (self._steps + 1) * STEP <= now + 1e-9:
            self._steps += 1
            self._step(self._steps * STEP)
        for door in self.doors:
            door.tend(now)

    def _step(self, t: float) -> None:
        for trouble in self._troubles:
            begins, ends = trouble.turns(t - STEP, t)
            for robot in self._meant(trouble.robot) if begins or ends else ():
                self._go_wrong(t, trouble, robot, begins)
        for robot, packet in self.firmware.advance(t):
            if self._up[robot] and not self._hushed[robot]:
                for door in self.doors:
                    door.tell(robot, packet)
        for robot in range(len(self.macs)):
            self._link(robot, not (self._broken[robot] or self.firmware.asleep(robot)))
        if self._steps % TRUTH_STEPS == 0:
            host = any(door.host for door in self.doors)
            self._log({"t": round(t, 3), "heard": round(self.heard, 4), "host": host, "robots": self._places()})

    def _meant(self, name: str | None) -> range | tuple[int]:
        return range(len(self.names)) if name is None else (self.names.index(name),)

    def _go_wrong(self, t: float, trouble: Trouble, robot: int, begins: bool) -> None:
        """Let a trouble begin, or end."""
        match trouble.kind:
            case "link-loss":
                self._broken[robot] = begins
            case "silence":
                self._hushed[robot] = begins
            case "load":
                self.firmware.load(t, robot, LOAD_G if begins else 0.0)
            case "blind" if begins:
                self.firmware.blind(t, robot, trouble.seconds)
            case "kidnap" if begins:
                x, y, heading = self.firmware.bodies.pose[:, robot].tolist()
                self.firmware.lift(t, robot)
                self.firmware.put_down(t + trouble.seconds, robot, (x, y), heading)

    # --- the air ---------------------------------------------------------------------------------------

    def up(self, robot: int) -> bool:
        """Whether a robot's radio link is there."""
        return self._up[robot]

    def hear(self, robot: int, data: bytes) -> None:
        """Bring a robot what a host sent, if its link is there."""
        if self._up[robot] and not self._hushed[robot]:
            self.heard = self.now
            self.firmware.feed(self.heard, robot, data)

    def _link(self, robot: int, up: bool) -> None:
        if up is self._up[robot]:
            return
        self._up[robot] = up
        if up:
            self.firmware.met(robot)
        for door in self.doors:
            door.linked(robot, up)

    # --- the truth -------------------------------------------------------------------------------------

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
