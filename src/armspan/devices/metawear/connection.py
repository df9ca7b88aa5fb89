"""One connection to a band, from the first question to its end.

The band goes on while its link is away, so one that comes back and still is as it was set up is only listened to again:
its heading holds. One that falls silent while its link holds is nudged, then set up again, then reset.
"""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

from armspan.devices.metawear import setup, wire
from armspan.devices.metawear.boards import FUSION, SETTINGS
from armspan.devices.metawear.calibration import Calibration, Shelf, accuracy, is_good, take
from armspan.devices.metawear.core import Band
from armspan.devices.metawear.decoding import decode
from armspan.devices.metawear.handshake import Identity, Met, meet, reference
from armspan.devices.metawear.notifications import Battery
from armspan.devices.metawear.settings import connection_parameters
from armspan.devices.metawear.talk import Talk
from armspan.errors import DeviceError, DeviceLost
from armspan.records import Event

PARAMETERS = (7.5, 7.5, 0, 2000.0)
"""Interval from and to [ms], events to skip, and the silence that ends a link [ms]: a lost one must be noticed soon."""
SETTLE_S = 1.0
"""After asking for other connection parameters (MbientLab advises 1 to 1.5 s)."""
SILENT_S = 1.0
WATCH_S = 0.25
BATTERY_S = 60.0
CALIBRATION_S = 2.0
LEAVE_S = 1.0


@dataclass(slots=True)
class Memory:
    """What is remembered of a board between two connections; ``reset`` where it must be set up anew."""

    uid: int | None = None
    reset: bool = False
    kept: bool = False


@dataclass(slots=True)
class Connection:
    """A band at the other end of ``talk``; ``tell`` takes events, ``now`` is session time [s]."""

    band: Band
    talk: Talk
    memory: Memory
    shelf: Shelf
    now: Callable[[], float]
    tell: Callable[[list[Event]], None]
    identity: Identity | None = None
    _since: float = 0.0
    _steps: int = 0
    _chores: "asyncio.Task[None] | None" = field(default=None, repr=False)

    async def live(self) -> None:
        """Find the band as it was left or set it up, then attend to it until the link breaks.

        Raises:
            DeviceLost: when it does.
            DeviceError: for a board that cannot do what is wanted.

        """
        self.band.linked()
        if await self._resume():
            await self._quicken()
        else:
            await self._quicken()
            await self.talk.wait(SETTLE_S)
            await self._begin()
        chores = asyncio.create_task(self._look_after())
        try:
            await self._attend()
        finally:
            chores.cancel()
            await asyncio.wait({chores})
            with suppress(asyncio.CancelledError):
                chores.exception()

    async def leave(self) -> None:
        """Stop and clean the board, and let it disconnect; where it does not hear it, so be it."""
        met = self.band.met
        if met is None:
            return
        with suppress(DeviceError, OSError, TimeoutError):
            async with asyncio.timeout(LEAVE_S):
                await self.talk.tell(setup.leave(self.band.entry, met.board))
                await self.talk.wait(LEAVE_S)

    # --- the beginning ---------------------------------------------------------------------------------

    async def _resume(self) -> bool:
        """Listen again to a band that went on meanwhile."""
        met, done, entry = self.band.met, self.band.done, self.band.entry
        if met is None or done is None or self.memory.reset:
            return False
        clock = await reference(self.talk)
        if clock.reset_uid != self.memory.uid or not await setup.is_as_set_up(self.talk, entry, met.board):
            return False
        self.band.resume()
        await self.talk.tell(wire.subscribe(met.board, "switch"), setup.listening(entry, met.board, done))
        self._since = self.now()
        return True

    async def _begin(self) -> None:
        """Ask the board what it is, and set it up."""
        self.band.done = None
        if self.band.met is None:
            self.band.meet(await meet(self.talk, self.band.entry, self.identity))
        await self._set_up()

    async def _set_up(self) -> None:
        entry, met = self.band.entry, self.band.met
        if met is None:
            return
        self.band.done = None
        self.memory.uid = (await reference(self.talk)).reset_uid
        given = self.shelf.writes(_key(met, self.band), entry.mode) if self._calibrates(met) else ()
        done = await setup.set_up(self.talk, entry, met.board, given)
        clock = await reference(self.talk)
        self.band.begin(done, clock, self.now())
        self.memory.reset, self.memory.kept = False, False
        self.band.report.calibration = "given back" if given else self.band.report.calibration
        self._since = self.now()

    async def _quicken(self) -> None:
        """Ask for the shortest connection interval: once only, more of it drops links on Linux."""
        if self.band.entry.port is None:
            await self.talk.tell(connection_parameters(*PARAMETERS))

    # --- while it lasts --------------------------------------------------------------------------------

    async def _attend(self) -> None:
        """Show signs, tell taps, and mend a band that falls silent."""
        while True:
            await self.talk.pause(min(WATCH_S, self.band.wake() - self.now() + 1e-3))
            await self.talk.tell(self.band.signs())
            self.tell(self.band.due(self.now()))
            heard = self.band.stream.heard
            if heard > self._since:
                self._steps = 0
            if self.now() - max(heard, self._since) >= SILENT_S:
                await self._mend()

    async def _mend(self) -> None:
        """Take the next step with a band of which nothing is heard."""
        band, entry, met, done = self.band, self.band.entry, self.band.met, self.band.done
        if met is None or done is None:
            return
        self.tell(band.silent(self.now(), f"{entry.name} is linked but sends nothing"))
        self._steps += 1
        if self._steps == 1:
            await self.talk.tell(setup.listening(entry, met.board, done), setup.nudge(entry))
        elif await self.talk.ask(wire.read("log_time"), tries=1) is None:
            raise DeviceLost(f"{entry.name} neither sends nor answers")
        elif self._steps == 2:
            band.report.restarts += 1
            await self._set_up()
        else:
            band.report.resets += 1
            self.memory.reset = True
            await self.talk.tell(wire.RESET)
            await self.talk.wait(SETTLE_S)
            raise DeviceLost(f"{entry.name} was reset, since it sent nothing")
        self._since = self.now()

    async def _look_after(self) -> None:
        """Ask for the battery and the calibration from time to time."""
        asked = -BATTERY_S
        while True:
            if self.now() - asked >= BATTERY_S:
                asked = self.now()
                await self._ask_battery()
                await self._hold_button()
            await self._keep_calibration()
            await asyncio.sleep(CALIBRATION_S)

    async def _ask_battery(self) -> None:
        met = self.band.met
        if met is None or not met.board.has(SETTINGS, 3):
            return
        answer = await self.talk.ask(wire.read("battery"), tries=2)
        with suppress(DeviceError):
            battery = decode(answer or b"", met.board)
            if isinstance(battery, Battery):
                self.band.report.battery = min(battery.percent, 100) / 100

    async def _hold_button(self) -> None:
        """Subscribe to the button once more: it stops the robots, and no write is acknowledged."""
        if self.band.met is not None:
            await self.talk.tell(wire.subscribe(self.band.met.board, "switch"))

    async def _keep_calibration(self) -> None:
        met, entry, report = self.band.met, self.band.entry, self.band.report
        if met is None or self.memory.kept or not self._calibrates(met):
            return
        state = await accuracy(self.talk, met.board)
        if state is None:
            return
        report.accuracy = (state.acc, state.gyro, state.mag)
        chips = await take(self.talk, met.board, entry.mode) if is_good(state, entry.mode) else None
        if chips is None:
            return
        self.memory.kept = True
        try:
            self.shelf.save(Calibration(_key(met, self.band), met.identity.firmware, chips))
            report.calibration = "kept" if self.shelf.folder is not None else "good"
        except DeviceError as error:
            report.notes.append(str(error))

    def _calibrates(self, met: Met) -> bool:
        return self.band.entry.profile == "fusion" and met.board.has(FUSION, 2)


def _key(met: Met, band: Band) -> str:
    """A board's address; on macOS the system tells another one than the board does."""
    return met.identity.mac or band.entry.address
