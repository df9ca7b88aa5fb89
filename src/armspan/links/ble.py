"""Bluetooth LE through bleak: hear what is there, hold one connection.

bleak is imported only when a radio is used. Where there is none, the error says what is missing and what to do. What
is worth another try is told apart from it: `DeviceNotFound` (not heard) and `DeviceLost` (heard, but the connection
failed or broke; or the radio is busy). Every other `DeviceError` is for a person to mend.
"""

import asyncio
import os
import re
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from armspan.errors import ConfigError, DeviceError, DeviceLost, DeviceNotFound, MissingExtra

if TYPE_CHECKING:
    from bleak import BleakClient, BleakScanner
    from bleak.backends.device import BLEDevice
    from bleak.backends.scanner import AdvertisementData

ADDRESS = re.compile(r"[0-9A-F]{2}(:[0-9A-F]{2}){5}|[0-9A-F]{8}(-[0-9A-F]{4}){3}-[0-9A-F]{12}")
SLICE_S = 2.0
"""The longest that one search keeps the adapter while others wait for theirs [s]."""
LEAVE_S = 5.0
"""The longest wait for a clean disconnection [s]."""


@dataclass(frozen=True)
class Radio:
    """A radio: bleak backends of its own, or the machine's (None) with the ``adapter`` named, such as hci1."""

    scanner: type[Any] | None = None
    client: type[Any] | None = None
    adapter: str | None = None


OWN = Radio()
"""The machine's own radio."""


@dataclass(frozen=True, slots=True)
class Heard:
    """A device that advertises: the service UUIDs are of 128 bits and in lower case, ``rssi`` is in dBm."""

    address: str
    name: str | None
    services: frozenset[str]
    rssi: int | None


def checked_address(address: str) -> str:
    """An address in upper case; a ConfigError where it is none (on macOS an address is a UUID)."""
    tidy = address.strip().upper().replace("-", ":") if len(address.strip()) == 17 else address.strip().upper()
    if ADDRESS.fullmatch(tidy):
        return tidy
    raise ConfigError(
        f"{address!r} is not a Bluetooth address: six pairs of hexadecimal digits were expected, such as "
        "E8:C9:8F:52:7B:07 (on macOS a UUID); `armspan check --scan` lists those that are heard"
    )


async def scan(seconds: float, radio: Radio = OWN) -> list[Heard]:
    """Listen for ``seconds`` and list who advertises, the strongest first."""
    heard: _Notes = {}
    async with _held(radio):
        await _listen(heard, radio, seconds)
    return sorted((_heard(*note) for note in heard.values()), key=lambda device: -(device.rssi or -999))


async def trouble(radio: Radio = OWN) -> str | None:
    """Why Bluetooth LE cannot be used here and what to do, in words; None where it can."""
    try:
        async with _held(radio):
            await _listen({}, radio, 0.0)
    except DeviceError as error:
        return str(error)
    return None


@asynccontextmanager
async def connected(
    address: str, radio: Radio = OWN, *, gone: Callable[[], None], seconds: float = 10.0
) -> AsyncIterator["BleakClient"]:
    """A connection to ``address``, given up after ``seconds``; ``gone`` is called once if it breaks from outside.

    One attempt at a time is made per radio, and no scan runs during it. DeviceNotFound: not heard. DeviceLost: heard,
    but not to be connected; also what a bleak error that leaves the body becomes.
    """
    bleak = _bleak()
    live = False

    def broke(_: "BleakClient") -> None:
        if live:
            gone()

    client = await _opened(checked_address(address), radio, broke, seconds)
    live = True
    try:
        yield client
    except (bleak.BleakError, EOFError) as error:
        raise DeviceLost(f"The connection to {address} broke: {error or type(error).__name__}.") from error
    finally:
        live = False
        await _leave(client)


# --- one connection -------------------------------------------------------------------------------------


async def _opened(address: str, radio: Radio, broke: Callable[["BleakClient"], None], seconds: float) -> "BleakClient":
    """Search and connect, sharing the radio with others that search: nobody keeps it for longer than a slice."""
    loop = asyncio.get_running_loop()
    end = loop.time() + seconds
    heard: _Notes = {}
    while True:
        async with _held(radio):
            device = await _listen(heard, radio, min(SLICE_S, max(0.0, end - loop.time())), address)
            if device is None and loop.time() >= end:
                device = await _still_connected(address, radio)
            if device is not None:
                return await _connect(device, radio, broke, seconds)
        if loop.time() >= end:
            raise DeviceNotFound(_not_heard(address, heard, seconds))


async def _connect(
    device: "BLEDevice", radio: Radio, broke: Callable[["BleakClient"], None], seconds: float
) -> "BleakClient":
    bleak = _bleak()
    client: BleakClient = bleak.BleakClient(device, broke, timeout=seconds, backend=radio.client, bluez=_bluez(radio))
    try:
        async with asyncio.timeout(seconds):
            await client.connect()
    except (bleak.BleakError, OSError, EOFError) as error:
        await _leave(client)
        raise DeviceLost(
            f"{device.address} was heard but did not take the connection ({error or type(error).__name__}): "
            "it may be too far away, its battery low, or another program or phone may hold it."
        ) from error
    except BaseException:
        await _leave(client)
        raise
    return client


async def _leave(client: "BleakClient") -> None:
    with suppress(_bleak().BleakError, OSError, EOFError):
        async with asyncio.timeout(LEAVE_S):
            await client.disconnect()


async def _still_connected(address: str, radio: Radio) -> "BLEDevice | None":
    """A device that the machine holds already, for instance since a crash, does not advertise."""
    bleak = _bleak()
    if radio.client is not None:
        return None
    with suppress(bleak.BleakError, OSError, NotImplementedError):
        adapter = await bleak.BleakAdapter.get(bluez=_bluez(radio))
        for device in await adapter.get_connected_devices():
            if device.address.upper() == address:
                return device  # type: ignore[no-any-return]
    return None


# --- listening ------------------------------------------------------------------------------------------

_Notes = dict[str, tuple["BLEDevice", "AdvertisementData"]]
_turns: WeakKeyDictionary[asyncio.AbstractEventLoop, dict[Radio, asyncio.Lock]] = WeakKeyDictionary()


def _held(radio: Radio) -> asyncio.Lock:
    """The turn at a radio: first come, first served."""
    turns = _turns.setdefault(asyncio.get_running_loop(), {})
    return turns.setdefault(radio, asyncio.Lock())


async def _listen(heard: _Notes, radio: Radio, seconds: float, wanted: str = "") -> "BLEDevice | None":
    """Note who advertises until ``wanted`` does or ``seconds`` have passed."""
    found = asyncio.Event()

    def note(device: "BLEDevice", advertisement: "AdvertisementData") -> None:
        heard[device.address.upper()] = (device, advertisement)
        if device.address.upper() == wanted:
            found.set()

    bleak = _bleak()
    try:
        async with _scanner(note, radio):
            with suppress(TimeoutError):
                async with asyncio.timeout(seconds):
                    await found.wait()
    except (bleak.BleakError, OSError, EOFError) as error:
        kind = DeviceLost if _last_word(error) in PASSING else DeviceError
        raise kind(_why_no_radio(error, radio)) from error
    return heard[wanted][0] if found.is_set() else None


def _scanner(note: "Callable[[BLEDevice, AdvertisementData], None]", radio: Radio) -> "BleakScanner":
    scanner: BleakScanner = _bleak().BleakScanner(note, backend=radio.scanner, bluez=_bluez(radio))
    return scanner


def _heard(device: "BLEDevice", advertisement: "AdvertisementData") -> Heard:
    services = frozenset(uuid.lower() for uuid in advertisement.service_uuids)
    rssi = advertisement.rssi if advertisement.rssi > -127 else None  # -127 means unknown
    return Heard(device.address, advertisement.local_name or device.name, services, rssi)


def _bluez(radio: Radio) -> dict[str, str]:
    return {} if radio.adapter is None else {"adapter": radio.adapter}


def _bleak() -> Any:
    try:
        import bleak
    except ImportError:
        raise MissingExtra("bleak", "ble") from None
    return bleak


# --- words ----------------------------------------------------------------------------------------------


def _not_heard(address: str, heard: _Notes, seconds: float) -> str:
    near = get_close_matches(address, heard, n=4, cutoff=0.0)
    there = ", ".join(f"{name} ({heard[name][1].local_name or 'no name'})" for name in near) or "nobody"
    return (
        f"{address} was not heard within {seconds:g} s; heard instead: {there}. Is it switched on, charged, near, and "
        "free of other programs and phones (a device that is connected elsewhere does not advertise)?"
    )


REASONS = {
    "NO_BLUETOOTH": "this machine has no Bluetooth adapter that is ready: plug one in, or power it: "
    "`bluetoothctl power on`",
    "NO_BLE_CENTRAL_ROLE": "the Bluetooth adapter speaks classic Bluetooth only: plug in one of Bluetooth 4.0 or later",
    "POWERED_OFF": "the Bluetooth adapter is switched off: `bluetoothctl power on` (and `rfkill unblock bluetooth`)",
    "DENIED_BY_USER": "the permission to use Bluetooth was denied: allow it for this terminal in the system's settings",
    "DENIED_BY_SYSTEM": "the system forbids this program to use Bluetooth: ask its administrator",
    "DENIED_BY_UNKNOWN": "the permission to use Bluetooth was denied: allow it in the system's settings",
}
ABSENT = (
    "the Bluetooth service (bluetoothd) does not run: `sudo apt install bluez` and `sudo systemctl start bluetooth`"
)
FORBIDDEN = "this user may not use Bluetooth: `sudo usermod -aG bluetooth $USER` and log in again"
DBUS = {
    "ServiceUnknown": ABSENT,
    "NameHasNoOwner": ABSENT,
    "AccessDenied": FORBIDDEN,
    "NotAuthorized": FORBIDDEN,
    "NotPermitted": FORBIDDEN,
    "NotReady": REASONS["POWERED_OFF"],
    "InProgress": "another program keeps the Bluetooth adapter busy: close it, or wait a moment",
}
PASSING = ("InProgress", "NoReply")
"""What is worth another try."""


def _last_word(error: Exception) -> str:
    """The name of a D-Bus error, without where it comes from."""
    return str(getattr(error, "dbus_error", "")).rsplit(".", 1)[-1]


def _why_no_radio(error: Exception, radio: Radio) -> str:
    """One sentence: what is missing, and what to do about it."""
    adapter = f" ({radio.adapter})" if radio.adapter else ""
    return f"No Bluetooth LE{adapter}: {_cause(error)}."


def _cause(error: Exception) -> str:
    reason = getattr(getattr(error, "reason", None), "name", "")
    if reason in REASONS:
        return f"{REASONS[reason]} ({error.args[0]})"
    if _last_word(error) in DBUS:
        return DBUS[_last_word(error)]
    if isinstance(error, OSError):
        bus = os.environ.get("DBUS_SYSTEM_BUS_ADDRESS", "/run/dbus/system_bus_socket")
        return (
            f"the system's message bus (D-Bus) does not answer at {bus}: start it with `sudo systemctl start dbus "
            f"bluetooth`; inside a container, mount its socket ({error.strerror or type(error).__name__})"
        )
    return str(error) or type(error).__name__
