"""Bluetooth LE through a controller that is reached by HCI packets: over TCP to an emulator, or a dongle without BlueZ.

bumble is the host: what it needs of a controller comes over one of its transports. ``tcp-client:127.0.0.1:PORT`` is
the air of `armspan emulate metawear` or `armspan emulate toio` in another process; ``usb:0`` is a USB dongle that the
system's own Bluetooth does not hold (for machines without BlueZ; never tried with a real dongle here). bleak's own
scanner and client speak through it as through any other radio. bumble and bleak are imported when a radio is used.
"""

import asyncio
import re
from collections.abc import AsyncGenerator, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any
from weakref import WeakKeyDictionary

from armspan.errors import ConfigError, DeviceError, DeviceLost
from armspan.links.ble import OWN, Radio
from armspan.links.ble_backend import fields, radio_of, uuids
from armspan.links.hci_central import bumble_modules, line_central, line_host, reset

ADAPTER = re.compile(r"hci\d+")
BUMBLE = "bumble:"
OPEN_S = 10.0
"""The longest wait for a controller to answer [s]."""
LINGER_S = 2.0
"""A transport is closed when nobody has used it for so long [s]: who scans will most likely connect."""


def radio_named(text: str | None) -> Radio:
    """The radio that a room file or a command line names; the machine's own where it names none.

    Raises:
        ConfigError: for what names no radio.

    """
    if text is None:
        return OWN
    if ADAPTER.fullmatch(text):
        return Radio(adapter=text)
    if text.startswith(BUMBLE) and text[len(BUMBLE) :]:
        return hci_radio(text[len(BUMBLE) :])
    raise ConfigError(
        f"{text!r} names no radio; expected an adapter such as 'hci1', or 'bumble:' and a transport: "
        "'bumble:tcp-client:127.0.0.1:PORT', as `armspan emulate metawear` and `armspan emulate toio` print it, or "
        "'bumble:usb:0' for a dongle without BlueZ"
    )


@cache
def hci_radio(transport: str) -> Radio:
    """The radio behind one of bumble's transports, the same one whenever it is asked for.

    The transport is opened by the first scan or connection, shared by all of them, and closed a moment after the last.
    DeviceError: there is no such transport, or no controller behind it. DeviceLost: there was one before.
    """
    reach = _Reach(transport)
    own: Any = radio_of(reach)  # type: ignore[arg-type]
    return Radio(scanner=_scanner(own.scanner, reach), client=_client(own.client, reach))


class _Reach:
    """What stands for an emulated air in bleak's classes: the central of the loop that is running."""

    def __init__(self, transport: str) -> None:
        self.transport = transport
        self._lines: WeakKeyDictionary[asyncio.AbstractEventLoop, _Line] = WeakKeyDictionary()

    @property
    def line(self) -> "_Line":
        loop = asyncio.get_running_loop()
        if loop not in self._lines:
            self._lines[loop] = _Line(self.transport)
        return self._lines[loop]

    @property
    def central(self) -> Any:
        return self.line.device

    @property
    def tables(self) -> dict[str, Any]:
        return self.line.tables

    def answer_to_a_scan(self, address: str) -> str | None:
        """A controller tells the answers to a scan itself."""
        return None


class _Line:
    """A transport with its controller: ``device`` is bumble's central while there is one."""

    def __init__(self, transport: str) -> None:
        self.device: Any = None
        self.tables: dict[str, Any] = {}
        self.heard: dict[str, tuple[Any, list[str]]] = {}
        self._transport, self._users, self._known = transport, set[object](), False
        self._turn, self._opening = asyncio.Lock(), _none()
        self._timer: asyncio.TimerHandle | None = None
        self._closing: asyncio.Task[None] | None = None

    def note(self, address: str, advertiser: Any, services: list[str]) -> None:
        """A device advertises; one that offers other services than before may have another GATT table."""
        if services and self.heard.get(address, (None, services))[1] != services:
            self.tables.pop(address, None)
        if services or address not in self.heard:
            self.heard[address] = (advertiser, services)

    async def enter(self, user: object) -> None:
        """Somebody uses the controller from now on."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        async with self._turn:
            if self.device is None:
                await self._open()
            self._users.add(user)

    def leave(self, user: object) -> None:
        """Somebody needs it no more."""
        self._users.discard(user)
        if not self._users and self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(LINGER_S, self._idle)

    async def _open(self) -> None:
        await self._opening.aclose()
        opening = self._powered()
        try:
            async with asyncio.timeout(OPEN_S):
                self.device = await anext(opening)
        except (EOFError, TimeoutError) as error:
            raise self._absent(str(error) or f"no answer within {OPEN_S:g} s") from None
        self._opening, self._known = opening, True

    def _idle(self) -> None:
        self._timer = None
        self._closing = asyncio.get_running_loop().create_task(self._close())

    async def _close(self) -> None:
        async with self._turn:
            if not self._users:
                await self._opening.aclose()

    async def _powered(self) -> AsyncGenerator[Any, None]:
        """A central that is switched on; a loop that ends closes what is still open, and so this is a generator."""
        transport = await self._opened()
        try:
            host = line_host(transport, self._lost)
            device = line_central(host, self.heard)
            await device.power_on()
            yield device
            self.device = None
            if not host.gone:
                await reset(host)
        finally:
            self.device = None
            await transport.close()

    async def _opened(self) -> Any:
        bumble = bumble_modules()
        try:
            return await bumble.transport.open_transport(self._transport)
        except bumble.transport.TransportSpecError:
            raise DeviceError(
                f"{self._transport!r} is no transport that bumble knows; expected tcp-client:HOST:PORT, usb:0, or "
                "another one of https://google.github.io/bumble/transports"
            ) from None
        except Exception as error:  # each transport has errors of its own
            raise self._absent(str(error) or type(error).__name__) from error

    def _lost(self) -> None:
        self.device = None

    def _absent(self, why: str) -> DeviceError:
        """Nobody is there: worth another try where somebody was before."""
        tcp = self._transport.startswith("tcp-client")
        hint = (
            "start `armspan emulate metawear` or `armspan emulate toio` first, with one program at a time as its client"
            if tcp
            else "is it plugged in, may this user open it, and does no other program hold it?"
        )
        kind = DeviceLost if self._known else DeviceError
        return kind(f"No Bluetooth controller answers at {self._transport} ({why}): {hint}")


async def _none() -> AsyncGenerator[Any, None]:
    """Nothing is open."""
    return
    yield


def _scanner(own: Any, reach: _Reach) -> type[Any]:
    class HciScanner(own):  # type: ignore[misc]
        """The scanner of the emulated air, on a controller that is opened for it."""

        async def start(self) -> None:
            self._line = reach.line
            await self._line.enter(self)
            self._device = self._line.device
            try:
                with _lost_in_words(reach.transport):
                    await super().start()
            except BaseException:
                self._line.leave(self)
                raise

        async def stop(self) -> None:
            try:
                if self._line.device is self._device:
                    with suppress(EOFError, bumble_modules().core.BaseBumbleError):
                        await super().stop()
            finally:
                self._line.leave(self)

        def _heard(self, advertisement: Any) -> None:
            advertisement.data_bytes = bytes(advertisement.data)  # with the answer to the scan, where there is one
            services = sorted(uuids(fields(advertisement.data_bytes)))
            self._line.note(str(advertisement.address).split("/")[0], advertisement.address, services)
            super()._heard(advertisement)

    return HciScanner


def _client(own: Any, reach: _Reach) -> type[Any]:
    class HciClient(own):  # type: ignore[misc]
        """The client of the emulated air, on a controller that is opened for it."""

        async def connect(self, pair: bool, **settings: Any) -> None:
            line = reach.line
            await line.enter(self)
            try:
                with _as_bleak():
                    await super().connect(pair, **settings)
            except BaseException:
                line.leave(self)
                raise

        def _on_disconnection(self, reason: int) -> None:
            super()._on_disconnection(reason)
            reach.line.leave(self)

        async def disconnect(self) -> None:
            with _as_bleak():
                await super().disconnect()

        async def _asked(self, answer: Any) -> Any:
            with _as_bleak():
                return await super()._asked(answer)

    return HciClient


@contextmanager
def _as_bleak() -> Iterator[None]:
    """What bumble raises becomes bleak's error."""
    from bleak.exc import BleakError

    try:
        yield
    except bumble_modules().core.BaseBumbleError as error:
        raise BleakError(str(error) or type(error).__name__) from error


@contextmanager
def _lost_in_words(transport: str) -> Iterator[None]:
    """A controller that goes away, or is busy, is worth another try."""
    try:
        yield
    except (EOFError, bumble_modules().core.BaseBumbleError) as error:
        raise DeviceLost(f"The Bluetooth controller at {transport} does not listen: {error}.") from error
