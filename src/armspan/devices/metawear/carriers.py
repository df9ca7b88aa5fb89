"""What carries a board's bytes: Bluetooth LE, or the USB cable of a MetaMotion S."""

import asyncio
import re
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING

from armspan.devices.metawear.handshake import Identity
from armspan.devices.metawear.talk import Carrier
from armspan.devices.metawear.usb_frames import IDENTIFY, UsbFramer, usb_frame
from armspan.devices.metawear.wire import COMMAND, NOTIFY
from armspan.errors import DeviceLost
from armspan.links import ble, serial_port

if TYPE_CHECKING:
    from bleak import BleakClient
    from bleak.backends.characteristic import BleakGATTCharacteristic

    from armspan.links.line import Line

USB_BAUD = 1_000_000 if sys.platform == "linux" else 115_200
"""The vendor's, where the system knows it; a USB device takes any."""
NAMED_S = 1.0
LEAVE_S = 0.3
_IDENTITY = re.compile(rb"([A-Z][ -~]*) (\d+) ([\d.]+) ([\d.]+) (\S+)\r?\n")


class Radioed:
    """A board on a Bluetooth LE connection."""

    def __init__(self, client: "BleakClient") -> None:
        self._client = client

    @property
    def services(self) -> frozenset[str] | None:
        """The GATT services."""
        return frozenset(service.uuid.lower() for service in self._client.services)

    async def write(self, data: bytes, response: bool = False) -> None:
        """Write to the command characteristic."""
        await self._client.write_gatt_char(COMMAND, data, response=response)

    async def read(self, uuid: str) -> bytes:
        """Read a characteristic's value."""
        return bytes(await self._client.read_gatt_char(uuid))

    async def listen(self, heard: Callable[[bytes], None]) -> None:
        """Let notifications come."""

        def notified(_: "BleakGATTCharacteristic", data: bytearray) -> None:
            heard(bytes(data))

        await self._client.start_notify(NOTIFY, notified)


class Wired:
    """A board on a cable: every packet in a frame, and a line of words that says what it is."""

    services: frozenset[str] | None = None

    def __init__(self, line: "Line", gone: Callable[[], None]) -> None:
        self._line, self._gone = line, gone
        self._heard: Callable[[bytes], None] | None = None
        self._framer = UsbFramer()

    async def identify(self) -> Identity:
        """Ask for the line of words; some of what came before it may still be in the cable.

        Raises:
            DeviceLost: where nothing like it comes.

        """
        self._line.write(IDENTIFY)
        text = b""
        try:
            async with asyncio.timeout(NAMED_S):
                while (identity := identity_of(text)) is None:
                    data = await self._line.read()
                    if not data:
                        break
                    text = (text + data)[-4096:]
        except TimeoutError:
            identity = None
        if identity is None:
            raise DeviceLost(f"nothing like a MetaMotion S answers on the cable: {text[-40:]!r}")
        return identity

    async def write(self, data: bytes, response: bool = False) -> None:
        """Write a packet."""
        self._line.write(usb_frame(data))

    async def read(self, uuid: str) -> bytes:
        """A cable has no characteristics."""
        return b""

    async def listen(self, heard: Callable[[bytes], None]) -> None:
        """Let packets come."""
        self._heard = heard

    async def pump(self) -> None:
        """Pass on what comes until the cable is pulled."""
        while data := await self._line.read():
            for payload in self._framer.feed(data):
                if self._heard is not None:
                    self._heard(payload)
        self._gone()


def identity_of(text: bytes) -> Identity | None:
    """What the last such line says: maker and model's name in words, then model, hardware, firmware, serial number.

    It is read from the right, since names contain spaces (MbientLab MetaWear-API, docs/usb-transport.md).
    """
    lines = _IDENTITY.findall(text)
    if not lines:
        return None
    names, *numbers = (part.decode("ascii") for part in lines[-1])
    model, hardware, firmware, serial = numbers
    return Identity(firmware, model, hardware, names.rsplit(" Meta", 1)[0], serial)


@asynccontextmanager
async def by_radio(
    address: str, radio: ble.Radio, gone: Callable[[], None]
) -> AsyncIterator[tuple[Carrier, Identity | None]]:
    """A connection by Bluetooth LE."""
    async with ble.connected(address, radio, gone=gone) as client:
        yield Radioed(client), None


@asynccontextmanager
async def by_cable(port: str, gone: Callable[[], None]) -> AsyncIterator[tuple[Carrier, Identity | None]]:
    """A connection by a cable, and what the board says it is."""
    line = await serial_port.opened(port, USB_BAUD)
    try:
        wired = Wired(line, gone)
        identity = await wired.identify()
        pump = asyncio.create_task(wired.pump())
        try:
            yield wired, identity
        finally:
            pump.cancel()
            await asyncio.wait({pump})
            with suppress(TimeoutError):
                async with asyncio.timeout(LEAVE_S):
                    await line.flushed()
    finally:
        line.close()
