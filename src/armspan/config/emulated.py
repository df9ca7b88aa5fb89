"""A virtual person and table behind emulated devices: real bytes on every wire, and the real drivers at their ends.

The person's bands feel what a virtual wrist feels and speak as MetaWear boards on an emulated radio; the robots run
Cellulo's firmware rules behind an emulated relay, or are toio cubes on the same radio. Everything runs in real time in
one event loop. The person and the bands are computed one tick ahead, so that a board meets each of its samples at the
moment when it is measured; robots live by the clock.
"""

import asyncio
import dataclasses
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import Literal, TypeAlias

import msgspec
import numpy as np

from armspan.conductor import BandSettings
from armspan.config.doors import Doors
from armspan.config.room_file import BandEntry, RoomFile
from armspan.config.virtual_entries import SimulatedRobot
from armspan.devices.cellulo.driver import CelluloRelay
from armspan.devices.cellulo.emulator import Emulator, addresses
from armspan.devices.cellulo.faults import Trouble
from armspan.devices.cellulo.firmware import Firmware
from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.board_models import Traits
from armspan.devices.metawear.driver import MetaWearBand
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.metawear.peripheral import MetaWearPeripheral
from armspan.frames import Array
from armspan.links.ble_emulated import Air, emulated_radio
from armspan.links.waves import LinkFaults
from armspan.records import Command, Event, ImuSample, RobotState
from armspan.simulation.bands import VirtualBand
from armspan.simulation.inertial import Wearer
from armspan.simulation.world import TICK, World

BandKind: TypeAlias = Literal["metawear"]
RobotKind: TypeAlias = Literal["cellulo"]

RADIO = LinkFaults(loss=0.01, run=1.5, burst_s=0.045)
"""The bands' radio links: a loss of one in a hundred, and Linux's own connection interval until the driver's wish for a
shorter one is granted."""


ANY_ADDRESS = "E8:C9:8F:52:7B:00"


class WornBoard:
    """A virtual band whose samples go into an emulated board instead of into the session."""

    def __init__(self, band: VirtualBand, board: MetaWearBoard) -> None:
        # What the radio and the clock do wrong is the emulated board's and the emulated air's affair.
        band.traits = dataclasses.replace(
            band.traits, loss=0.0, late=0.0, late_wander=0.0, missed=0.0, delay=0.0, burst=0.001
        )
        self.band, self.board, self.shift = band, board, 0.0

    def advance(self, t: float, person: Wearer) -> list[tuple[float, ImuSample]]:
        """Let the board feel what the band feels up to ``t`` [s]; nothing arrives by this way."""
        for _, sample in self.band.advance(t, person):
            self.board.sample(sample.t + self.shift, sample.acc, sample.gyr, sample.mag, sample.quat)
        return []


class TableRobots:
    """The firmware's robots as a virtual person sees them; what they tell and are told goes by wire."""

    def __init__(self, names: tuple[str, ...], firmware: Firmware, now: Callable[[], float]) -> None:
        self.names, self._firmware, self._now = names, firmware, now

    def command(self, t: float, command: Command) -> None:
        """A record is no byte: it is not heard."""

    def advance(self, t: float) -> list[tuple[float, RobotState]]:
        """Nothing: the emulator lets them live by the clock."""
        return []

    def truth(self) -> tuple[Array, Array, Array]:
        """Real xy (n, 2) [m], heading (n,) [rad], velocity (n, 2) [m/s] in ``sheet``."""
        xy, heading, velocity, _ = self._firmware.truth()
        return xy, heading, velocity

    def lights(self) -> Array:
        """The lights' colours (n, 6, 3) that a person sees now, 0 to 1."""
        return self._firmware.lights(self._now())


class Emulation:
    """What stands behind a house's wires; ``opened`` switches it on."""

    def __init__(
        self,
        world: World,
        room: RoomFile,
        bands: BandKind | None = None,
        robots: RobotKind | None = None,
        faults: LinkFaults = RADIO,
        troubles: Sequence[Trouble] = (),
        profile: Literal["fusion", "raw"] = "fusion",
    ) -> None:
        self.world, self.room, self.faults, self._robots = world, room, faults, robots
        self.troubles, self.profile = tuple(troubles), profile
        self.firmware: Firmware | None = None
        seed = room.simulation.seed
        self.worn: list[WornBoard] = (
            [WornBoard(band, _board(k, band, seed)) for k, band in enumerate(world.bands, 1)] if bands else []
        )
        if bands:
            world.bands[:] = self.worn  # type: ignore[assignment]
        self.air: Air | None = None

    def felt(self, band: BandSettings) -> BandSettings:
        """A band's settings as those of an emulated one."""
        return msgspec.structs.replace(band, stale_s=_entry(band, ANY_ADDRESS).stale_s) if self.worn else band

    @asynccontextmanager
    async def opened(self, now: Callable[[], float]) -> AsyncIterator[Doors]:
        """Switch the devices on and give the drivers that reach them; ``now`` is the session's clock [s]."""
        doors = Doors()
        async with AsyncExitStack() as stack:
            if self.worn:
                dice = np.random.default_rng([self.room.simulation.seed, 7])
                self.air = await stack.enter_async_context(emulated_radio(dice))
                await self._strap(self.air, now, doors)
            if self._robots:
                relay = await stack.enter_async_context(self._relay(now))
                doors.drivers.append(relay)
                doors.commanded |= dict.fromkeys(self.world.robots.names, relay)
            yield doors

    async def _strap(self, air: Air, now: Callable[[], float], doors: Doors) -> None:
        for worn, own in zip(self.worn, self.room.bands, strict=True):
            worn.shift = air.now() - now()
            await air.add(MetaWearPeripheral(worn.board), self.faults)
            band = MetaWearBand(_entry(own, worn.board.address, self.profile), now=now, radio=air.radio)
            doors.drivers.append(band)
            doors.commanded[own.name] = band

    @asynccontextmanager
    async def _relay(self, now: Callable[[], float]) -> AsyncIterator[CelluloRelay]:
        """Robots behind an emulated relay on a free port, and the driver that talks to it."""
        robots = [robot for robot in self.room.robots if isinstance(robot, SimulatedRobot)]
        names, sheet = tuple(robot.name for robot in robots), self.room.sheet
        xy = np.array([robot.start_m for robot in robots]) + np.array(sheet.origin_m)
        heading = np.radians([robot.heading_deg for robot in robots])
        firmware = Firmware(xy, heading, sheet, np.random.default_rng([self.room.simulation.seed, 5]))
        macs = dict(zip(names, addresses(len(names)), strict=True))
        emulator = Emulator(firmware, {mac: name for name, mac in macs.items()}, troubles=self.troubles, now=now)
        self.world.robots = TableRobots(names, firmware, now)  # type: ignore[assignment]
        self.firmware = firmware
        async with emulator.listening() as port:
            living = asyncio.create_task(emulator.live())
            try:
                yield CelluloRelay(macs, "127.0.0.1", port, origin_m=sheet.origin_m, now=now)
            finally:
                living.cancel()
                with suppress(asyncio.CancelledError):
                    await living

    async def source(self, now: Callable[[], float], seconds: float | None = None) -> AsyncGenerator[Event, None]:
        """The world's own events (ticks, presses), each at its time, until its script ends."""
        steps = 0
        while not self.world.ended and (seconds is None or steps * TICK < seconds - 1e-9):
            steps += 1
            events = self.world.advance(steps * TICK)
            for worn in self.worn:
                if self.air is not None:
                    self.air.wake(worn.board.address)
            await asyncio.sleep(max(0.0, steps * TICK - now()))
            for event in events:
                yield event


def _entry(band: BandEntry | BandSettings, address: str, profile: Literal["fusion", "raw"] = "fusion") -> MetaWearEntry:
    return MetaWearEntry(band.name, address, band.segment, band.arm, profile)


def _board(number: int, band: VirtualBand, seed: int) -> MetaWearBoard:
    address = f"E8:C9:8F:52:7B:{number:02X}"
    traits = Traits(acc_noise=0.0, gyr_noise=0.0, drift=band.traits.clock_rate)
    return MetaWearBoard("mmrl_current", traits, address=address, generator=np.random.default_rng([seed, 6, number]))
