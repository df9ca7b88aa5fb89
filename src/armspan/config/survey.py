"""What is in reach: bands and robots that answer, and for each kind of door why nothing can be heard there.

Every device that is recognised is asked for its battery and its firmware, one after the other.
"""

import asyncio
import shutil
import subprocess
from contextlib import suppress
from pathlib import Path

import msgspec

from armspan.devices.cellulo import relay
from armspan.errors import DeviceError
from armspan.links import ble, rfcomm

METAWEAR = "326a9000-85cb-9195-d9dd-464cfbbae75a"
BOOTLOADER = "00001530-1212-efde-1523-785feabcd123"
TOIO = "10b20100-5b3b-4571-9508-cf3efcd7bbae"
FIRMWARE, BATTERY = (f"0000{number}-0000-1000-8000-00805f9b34fb" for number in ("2a26", "2a19"))
TOIO_BATTERY = TOIO.replace("10b20100", "10b20108")
KINDS = {METAWEAR: "metawear", TOIO: "toio", BOOTLOADER: "metawear"}

ASK_S = 6.0
"""Seconds in which a device must let itself be asked."""
RELAY_S = 1.5
"""Seconds in which a relay tells the robots that it has."""
SERIAL = ("ttyACM*", "ttyUSB*", "rfcomm*")


class Found(msgspec.Struct, frozen=True):
    """A device: its address is what a room file names; ``battery`` is a share from 0 to 1, ``signal`` in dBm."""

    kind: str
    address: str
    name: str | None = None
    signal: int | None = None
    battery: float | None = None
    firmware: str | None = None
    note: str = ""


class Missing(msgspec.Struct, frozen=True):
    """A kind of door behind which nothing can be heard: why, and what to do."""

    door: str
    why: str


class Survey(msgspec.Struct, frozen=True):
    """What was found, and where nothing can be."""

    found: tuple[Found, ...]
    missing: tuple[Missing, ...]


async def survey(
    seconds: float, radio: ble.Radio = ble.OWN, port: int = relay.PORT, dev: Path = Path("/dev")
) -> Survey:
    """Look behind every door for ``seconds``; a ``radio``, relay ``port`` or device folder of its own serves tests."""
    found: list[Found] = []
    missing: list[Missing] = []
    for door, look in (
        ("Bluetooth LE (MetaWear bands, toio robots)", _by_radio(seconds, radio)),
        ("Bluetooth Classic (Cellulo robots)", _by_classic(seconds)),
        (f"Cellulo relay on 127.0.0.1:{port}", _by_relay(port)),
        ("serial ports (MetaMotion S, receptors, /dev/rfcommN)", _by_cable(dev)),
    ):
        try:
            found.extend(await look)
        except DeviceError as error:
            missing.append(Missing(door, str(error)))
    return Survey(tuple(found), tuple(missing))


async def _by_radio(seconds: float, radio: ble.Radio) -> list[Found]:
    heard = [device for device in await ble.scan(seconds, radio) if device.services & KINDS.keys()]
    return [await _asked(device, radio) for device in heard]


async def _asked(device: ble.Heard, radio: ble.Radio) -> Found:
    kind = next(KINDS[service] for service in sorted(device.services) if service in KINDS)
    found = Found(kind, device.address, device.name, device.rssi)
    if BOOTLOADER in device.services:
        return msgspec.structs.replace(found, note="in its bootloader: load its firmware anew with the maker's app")
    try:
        async with ble.connected(device.address, radio, gone=lambda: None, seconds=ASK_S) as client:
            battery = bytes(await client.read_gatt_char(TOIO_BATTERY if kind == "toio" else BATTERY))
            firmware = (
                None if kind == "toio" else bytes(await client.read_gatt_char(FIRMWARE)).decode("ascii", "replace")
            )
    except DeviceError as error:
        return msgspec.structs.replace(found, note=f"heard, but it could not be asked: {error}")
    share = battery[0] / 100 if battery else None
    return msgspec.structs.replace(found, battery=share, firmware=firmware)


async def _by_classic(seconds: float) -> list[Found]:
    """Robots that BlueZ knows or hears now; sockets alone cannot search."""
    rfcomm.open_socket().close()
    if shutil.which("bluetoothctl") is None:
        raise DeviceError(
            "robots are searched for with bluetoothctl, which is not installed; on Debian: apt install bluez"
        )
    await _bluetoothctl("--timeout", str(max(1, round(seconds))), "scan", "on")
    lines = (await _bluetoothctl("devices")).splitlines()
    known = [line.split(" ", 2)[1:] for line in lines if line.startswith("Device ") and line.count(" ") >= 2]
    return [Found("cellulo", mac, name) for mac, name in known if name.lower().startswith("cellulo")]


async def _bluetoothctl(*words: str) -> str:
    """What BlueZ's own program answers."""
    process = await asyncio.create_subprocess_exec(
        "bluetoothctl", *words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    try:
        async with asyncio.timeout(60):
            told, _ = await process.communicate()
    except TimeoutError:
        process.kill()
        raise DeviceError("bluetoothctl did not answer within a minute; see `systemctl status bluetooth`") from None
    return told.decode("utf-8", "replace")


async def _by_relay(port: int) -> list[Found]:
    """The robots that a relay announces to its client."""
    try:
        async with asyncio.timeout(RELAY_S):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
    except (OSError, TimeoutError):
        raise DeviceError("nobody listens there; start EPFL's robot pool or `armspan emulate cellulo`") from None
    try:
        robots = await _announced(reader)
    finally:
        writer.close()
        with suppress(OSError):
            await writer.wait_closed()
    words = {relay.DISCONNECTED: "not connected", relay.CONNECTING: "connecting", relay.CONNECTED: "connected"}
    return [Found("cellulo", mac, note=f"behind the relay, {words.get(status, '?')}") for mac, status in robots.items()]


async def _announced(reader: asyncio.StreamReader) -> dict[str, int]:
    """The robots of a relay by their addresses, with the state of their links."""
    stream, robots = relay.client_side(), {}
    with suppress(TimeoutError):
        async with asyncio.timeout(RELAY_S):
            while data := await reader.read(4096):
                for mac, packet in stream.feed(data, 0.0):
                    if packet[1] == relay.STATUS:
                        robots[mac] = packet[2]
            raise DeviceError("it has a client already, and takes one only: end that program first")
    if not robots:
        raise DeviceError("it answers, and has no robots yet: it connects those that a room file names")
    return robots


async def _by_cable(dev: Path) -> list[Found]:
    ports = sorted(path for pattern in SERIAL for path in dev.glob(pattern))
    if not ports:
        raise DeviceError(f"there are none in {dev}; plug the cable in, or bind a robot with `rfcomm bind`")
    return [Found("serial port", str(path)) for path in ports]
