"""A MetaWear band as a source of events, with its light and its motor."""

import asyncio
from collections.abc import AsyncGenerator, Callable
from contextlib import AbstractAsyncContextManager, suppress
from pathlib import Path

from armspan.devices.metawear.calibration import Shelf
from armspan.devices.metawear.carriers import by_cable, by_radio
from armspan.devices.metawear.connection import Connection, Memory
from armspan.devices.metawear.core import Band
from armspan.devices.metawear.counters import Report
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.metawear.handshake import Identity, check_services
from armspan.devices.metawear.talk import Carrier, Talk
from armspan.errors import DeviceLost, DeviceNotFound
from armspan.links.ble import OWN, Radio
from armspan.records import Command, Event

RETRY_S = 1.0
AT_ONCE_S = 0.1
"""Before the first try to mend a link that broke."""


class MetaWearBand:
    """One band.

    ``now`` is the session's clock [s] (the running loop's where it is not told), ``radio`` what reaches the band,
    ``calibration`` a folder where what the fusion learns of a board is kept for its next connection.
    """

    def __init__(
        self,
        entry: MetaWearEntry,
        *,
        now: Callable[[], float] | None = None,
        radio: Radio = OWN,
        calibration: Path | None = None,
        retry_s: float = RETRY_S,
    ) -> None:
        self.entry = entry
        self._radio, self._retry = radio, retry_s
        self._now = now or _loop_seconds()
        self._shelf, self._memory = Shelf(calibration), Memory()
        self._band = Band(entry)
        self._events: asyncio.Queue[Event | None] = asyncio.Queue()
        self._talk: Talk | None = None

    def report(self) -> Report:
        """What the band went through so far."""
        return self._band.report

    @property
    def battery(self) -> float | None:
        """Its charge, a share of 1, asked for once a minute."""
        return self._band.report.battery

    async def source(self) -> AsyncGenerator[Event, None]:
        """What the band tells; a link that breaks is told, and mended. Closing it leaves the board clean.

        Raises:
            ArmspanError: for what a person must mend.

        """
        self._now()  # its time begins here
        keeper = asyncio.create_task(self._keep())
        keeper.add_done_callback(lambda _: self._events.put_nowait(None))
        try:
            while (event := await self._events.get()) is not None:
                yield event
            await keeper
        finally:
            keeper.cancel()
            with suppress(asyncio.CancelledError, Exception):
                await keeper

    async def send(self, command: Command) -> None:
        """Take a light or a vibration for this band, and return at once.

        Raises:
            DeviceNotFound: for another name.
            DeviceError: for a command that a band does not know, or a number that is not finite.

        """
        self._band.take(command)
        if self._talk is not None:
            self._talk.wake()

    # --- the link --------------------------------------------------------------------------------------

    async def _keep(self) -> None:
        """Connect, live until the link breaks, and again."""
        while True:
            connections = self._band.report.connections
            try:
                await self._connect()
            except (DeviceNotFound, DeviceLost, OSError) as error:
                self._tell(self._band.lost(self._now(), str(error) or type(error).__name__))
            broke = self._band.report.connections > connections
            await asyncio.sleep(min(self._retry, AT_ONCE_S) if broke else self._retry)

    async def _connect(self) -> None:
        talk: Talk | None = None

        def gone() -> None:
            if talk is not None:
                talk.hang_up()
            self._tell(self._band.lost(self._now(), f"the link to {self.entry.name} broke"))

        async with self._open(gone) as (carrier, identity):
            talk = self._talk = Talk(carrier, self.entry.name, self._hear)
            connection = Connection(self._band, talk, self._memory, self._shelf, self._now, self._tell, identity)
            check_services(carrier, self.entry)
            try:
                await carrier.listen(talk.hear)
                await connection.live()
            except asyncio.CancelledError:  # the source is closed, and nobody comes back
                await connection.leave()
                raise
            finally:
                self._talk = None

    def _open(self, gone: Callable[[], None]) -> AbstractAsyncContextManager[tuple[Carrier, Identity | None]]:
        if self.entry.port is not None:
            return by_cable(self.entry.port, gone)
        return by_radio(self.entry.address, self._radio, gone)

    def _hear(self, data: bytes) -> None:
        self._tell(self._band.hear(data, self._now()))
        if self._talk is not None and self._band.button.pending:
            self._talk.wake()

    def _tell(self, events: list[Event]) -> None:
        for event in events:
            self._events.put_nowait(event)


def _loop_seconds() -> Callable[[], float]:
    """The running loop's time since it was first asked for [s]."""
    began: float | None = None

    def now() -> float:
        nonlocal began
        loop = asyncio.get_running_loop().time()
        began = loop if began is None else began
        return loop - began

    return now
