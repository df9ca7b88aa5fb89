"""Toio cubes over Bluetooth LE: a source of what they tell, a swarm that takes commands at once.

The session never waits for the radio: a command changes what its cube is to be told next, where the latest motion wins
and a stop comes first. On every way out all cubes are told to stand still, three times; what a killed process cannot
tell, its last pulses do, which end by themselves.
"""

import asyncio
from collections.abc import AsyncGenerator, Callable, Coroutine, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from armspan.devices.toio.entry import ToioEntry
from armspan.devices.toio.robot import SETTINGS, STANDSTILL, STOPS, Placement, Robot, Write
from armspan.devices.toio.wire import UUIDS, decode
from armspan.errors import ConfigError, DeviceError, DeviceLost, DeviceNotFound, known_names
from armspan.links.ble import OWN, Radio, checked_address, connected
from armspan.records import Command, Event, Vec2

if TYPE_CHECKING:
    from bleak import BleakClient

CONNECT_S, RETRY_S = 10.0, 1.0
WATCH_S = 0.25
CLOSE_S = 1.0
HEARD = ("configuration", "id", "motor", "button", "battery")
"""Characteristics that are listened to, in the order in which they are subscribed."""
CONFIRMED = frozenset({"light", "sound", "configuration"})
"""Characteristics whose writes the cube confirms; motors are written without."""


class ToioCubes:
    """Cubes by name, each with its address, on one mat.

    ``origin_m`` is where the sheet's corner lies, from the mat's; ``now`` the session's clock [s], the running
    loop's time since it was first asked where not told; ``radio`` the machine's own.

    Raises:
        ConfigError: for two cubes of one name or one address.

    """

    def __init__(
        self,
        cubes: Sequence[ToioEntry],
        *,
        origin_m: Vec2 = (0.0, 0.0),
        now: Callable[[], float] | None = None,
        radio: Radio = OWN,
        connect_s: float = CONNECT_S,
        retry_s: float = RETRY_S,
    ) -> None:
        _check_apart(cubes)
        self._now = now or _SinceStart()
        self._radio, self._connect_s, self._retry_s = radio, connect_s, retry_s
        self._events: asyncio.Queue[Event | None] = asyncio.Queue()
        self._cubes = {
            cube.name: _Line(cube.address, Robot(cube.name, Placement(cube.corner, origin_m))) for cube in cubes
        }
        self._closed = False

    async def source(self) -> AsyncGenerator[Event, None]:
        """What the cubes tell; a link that breaks is told, and tried again. Closing it stops the cubes.

        Raises:
            DeviceError: for what a person must mend: no radio, a cube whose system software is too old.

        """
        keepers = [asyncio.create_task(self._keep(line)) for line in self._cubes.values()]
        for keeper in keepers:
            keeper.add_done_callback(lambda _: self._events.put_nowait(None))
        try:
            while (event := await self._events.get()) is not None:
                yield event
            for keeper in keepers:
                if keeper.done():
                    await keeper
        finally:
            await self._close(keepers)

    async def send(self, command: Command) -> None:
        """Take a command and return at once.

        Raises:
            DeviceNotFound: for a cube that does not exist.
            DeviceError: for a velocity, or a number that must not reach the wire.

        """
        if self._closed:
            return  # the cubes were told to stop already
        for line in self._addressed(command.robot):
            line.robot.take(command, self._now())
            line.news.set()

    def _addressed(self, name: str | None) -> "list[_Line]":
        if name is None:
            return list(self._cubes.values())
        if name not in self._cubes:
            raise DeviceNotFound(known_names("robot", name, self._cubes))
        return [self._cubes[name]]

    # --- one cube --------------------------------------------------------------------------------------

    async def _keep(self, line: "_Line") -> None:
        """Connect, talk until the link breaks, and again."""
        while True:
            line.broken.clear()
            with suppress(DeviceNotFound, DeviceLost, OSError):  # a time-out is one of these
                async with connected(
                    line.address, self._radio, gone=line.broken.set, seconds=self._connect_s
                ) as client:
                    await self._talk(line, client)
            line.client = None
            self._tell(line.robot.linked(self._now(), False))
            await asyncio.sleep(self._retry_s)

    async def _talk(self, line: "_Line", client: "BleakClient") -> None:
        """Set a cube up and keep it company until the link breaks, it falls silent, or something is wrong with it."""
        async with asyncio.timeout(self._connect_s):
            await self._meet(line, client)
        await _first_of(self._drive(line, client), self._show(line, client), line.broken.wait())

    async def _meet(self, line: "_Line", client: "BleakClient") -> None:
        await _write(client, STANDSTILL)  # it may still obey somebody who is gone
        for characteristic in HEARD:
            await client.start_notify(UUIDS[characteristic], self._ear(line, characteristic))
        self._tell(line.robot.linked(self._now(), True))
        line.client = client
        for write in SETTINGS:
            await _write(client, write)
        self._hear(line, "battery", bytes(await client.read_gatt_char(UUIDS["battery"])))

    def _ear(self, line: "_Line", characteristic: str) -> Callable[[Any, bytearray], None]:
        return lambda _, data: self._hear(line, characteristic, bytes(data))

    def _hear(self, line: "_Line", characteristic: str, data: bytes) -> None:
        with suppress(DeviceError):  # what makes no sense is not for us; the next packet comes
            packet = decode(characteristic, data)
            try:
                self._tell(line.robot.hear(packet, self._now()))
            except DeviceError as error:
                line.wrong = error
            line.news.set()

    async def _drive(self, line: "_Line", client: "BleakClient") -> None:
        """Write motions when they are due; ends when the cube is lost."""
        robot = line.robot
        while robot.up:
            if line.wrong is not None:
                raise line.wrong
            for write in robot.motion(self._now()):
                await _write(client, write)
            line.signs.set()
            with suppress(TimeoutError):
                async with asyncio.timeout(min(max(robot.wake() - self._now(), 0.0), WATCH_S)):
                    await line.news.wait()
            line.news.clear()
            self._tell(robot.watch(self._now()))

    async def _show(self, line: "_Line", client: "BleakClient") -> None:
        """Write lights and sounds, whose confirmation must not hold a motion back."""
        while True:
            await line.signs.wait()
            line.signs.clear()
            for write in line.robot.signs():
                await _write(client, write)

    def _tell(self, events: list[Event]) -> None:
        for event in events:
            self._events.put_nowait(event)

    # --- the end ---------------------------------------------------------------------------------------

    async def _close(self, keepers: "list[asyncio.Task[None]]") -> None:
        """Stop every cube that is there, then let go of all."""
        self._closed = True
        try:
            for before, after in zip(STOPS, (*STOPS[1:], STOPS[-1]), strict=True):
                clients = [line.client for line in self._cubes.values() if line.client is not None]
                with suppress(TimeoutError):
                    async with asyncio.timeout(CLOSE_S):
                        await asyncio.gather(*(_write(each, STANDSTILL) for each in clients), return_exceptions=True)
                if clients:
                    await asyncio.sleep(after - before)
        finally:
            for keeper in keepers:
                keeper.cancel()
            await asyncio.gather(*keepers, return_exceptions=True)


class _Line:
    """A cube, and the connection to it while there is one."""

    def __init__(self, address: str, robot: Robot) -> None:
        self.address, self.robot = address, robot
        self.client: BleakClient | None = None
        self.news, self.signs, self.broken = asyncio.Event(), asyncio.Event(), asyncio.Event()
        self.wrong: DeviceError | None = None


class _SinceStart:
    """The running loop's time since it was first asked for [s]."""

    def __init__(self) -> None:
        self._began: float | None = None

    def __call__(self) -> float:
        t = asyncio.get_running_loop().time()
        self._began = t if self._began is None else self._began
        return t - self._began


async def _write(client: "BleakClient", write: Write) -> None:
    characteristic, data = write
    await client.write_gatt_char(UUIDS[characteristic], data, response=characteristic in CONFIRMED)


async def _first_of(*works: Coroutine[Any, Any, object]) -> None:
    """Do all of these until one of them ends, and raise what it raised."""
    tasks = [asyncio.ensure_future(work) for work in works]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        ended = await asyncio.gather(*tasks, return_exceptions=True)
    for outcome in ended:
        if isinstance(outcome, Exception):
            raise outcome


def _check_apart(cubes: Sequence[ToioEntry]) -> None:
    for what, values in (
        ("name", [cube.name for cube in cubes]),
        ("address", [checked_address(cube.address) for cube in cubes]),
    ):
        for k, value in enumerate(values):
            if value in values[:k]:
                raise ConfigError(f"two toio cubes have the {what} {value}; each has its own")
