"""Addresses, and what is said where there is no Bluetooth."""

import asyncio
import subprocess
import sys

import pytest

from armspan.errors import ConfigError, DeviceError, DeviceLost, MissingExtra
from armspan.links import ble
from armspan.links.ble import Radio, checked_address, connected, scan, trouble


def test_addresses_are_tidied():
    assert checked_address("e8:c9:8f:52:7b:07") == "E8:C9:8F:52:7B:07"
    assert checked_address(" E8-C9-8F-52-7B-07 ") == "E8:C9:8F:52:7B:07"
    assert checked_address("4f2a1b00-0d3c-4b5e-9c6d-00112233aabb") == "4F2A1B00-0D3C-4B5E-9C6D-00112233AABB"


@pytest.mark.parametrize("wrong", ["", "E8:C9:8F:52:7B", "E8:C9:8F:52:7B:0G", "MetaWear", "E8:C9:8F:52:7B:07:01"])
def test_what_is_no_address_is_refused_with_an_example(wrong):
    with pytest.raises(ConfigError, match=r"is not a Bluetooth address: .* such as E8:C9:8F:52:7B:07"):
        checked_address(wrong)


def failing(error):
    """A radio whose scanner cannot start."""
    from bleak.backends.scanner import BaseBleakScanner

    class Failing(BaseBleakScanner):
        def __init__(self, detection_callback, service_uuids, scanning_mode, **_):
            super().__init__(detection_callback, service_uuids)

        async def start(self):
            raise error

        async def stop(self):
            pass

    return Radio(scanner=Failing)


def causes():
    from bleak.exc import BleakBluetoothNotAvailableError, BleakBluetoothNotAvailableReason, BleakDBusError, BleakError

    reasons = BleakBluetoothNotAvailableReason
    off = BleakBluetoothNotAvailableError("No powered Bluetooth adapters found.", reasons.POWERED_OFF)
    none = BleakBluetoothNotAvailableError("adapter 'hci7' not found", reasons.NO_BLUETOOTH)
    classic = BleakBluetoothNotAvailableError("no LE", reasons.NO_BLE_CENTRAL_ROLE)
    denied = BleakBluetoothNotAvailableError("denied", reasons.DENIED_BY_USER)
    unknown = BleakDBusError("org.freedesktop.DBus.Error.ServiceUnknown", ["The name org.bluez was not provided"])
    forbidden = BleakDBusError("org.freedesktop.DBus.Error.AccessDenied", ["Rejected send message"])
    unready = BleakDBusError("org.bluez.Error.NotReady", ["Resource Not Ready"])
    return [
        (off, "bluetoothctl power on"),
        (none, "no Bluetooth adapter"),
        (classic, "classic Bluetooth only"),
        (denied, "was denied"),
        (unknown, "systemctl start bluetooth"),
        (forbidden, "usermod -aG bluetooth"),
        (unready, "bluetoothctl power on"),
        (FileNotFoundError(2, "No such file or directory"), "message bus"),
        (ConnectionRefusedError(111, "Connection refused"), "message bus"),
        (BleakError("something new"), "something new"),
    ]


@pytest.mark.parametrize("number", range(10))
def test_every_cause_becomes_a_sentence_with_what_to_do(number):
    error, words = causes()[number]
    radio = failing(error)

    async def scene():
        told = await trouble(radio)
        assert told.startswith("No Bluetooth LE: ")
        assert words in told
        assert told.endswith(".")
        assert "\n" not in told
        for attempt in (scan(1.0, radio), enter(radio)):
            with pytest.raises(DeviceError) as raised:
                await attempt
            assert str(raised.value) == told
            assert type(raised.value) is DeviceError

    asyncio.run(scene())


async def enter(radio):
    async with connected("E8:C9:8F:52:7B:07", radio, gone=lambda: None, seconds=1.0):
        pass


def test_a_busy_radio_is_worth_another_try():
    from bleak.exc import BleakDBusError

    radio = failing(BleakDBusError("org.bluez.Error.InProgress", ["Operation already in progress"]))
    with pytest.raises(DeviceLost, match="another program keeps the Bluetooth adapter busy"):
        asyncio.run(scan(1.0, radio))


def test_this_machine_without_a_bus_says_so(monkeypatch, tmp_path):
    monkeypatch.setenv("DBUS_SYSTEM_BUS_ADDRESS", f"unix:path={tmp_path}/nothing")
    if sys.platform != "linux":
        pytest.skip("D-Bus is Linux's")
    told = asyncio.run(trouble())
    assert told.startswith("No Bluetooth LE: the system's message bus (D-Bus) does not answer at unix:path=")
    assert "sudo systemctl start dbus" in told


def test_without_bleak_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "bleak", None)
    with pytest.raises(MissingExtra, match=r"pip install 'armspan\[ble\]'"):
        asyncio.run(scan(1.0))
    assert "armspan[ble]" in asyncio.run(trouble())


def test_without_bumble_the_extra_is_named(monkeypatch):
    from armspan.links.ble_emulated import emulated_radio

    monkeypatch.setitem(sys.modules, "bumble", None)

    async def scene():
        async with emulated_radio():
            pass

    with pytest.raises(MissingExtra, match=r"bumble is not installed: pip install 'armspan\[ble\]'"):
        asyncio.run(scene())


def test_importing_loads_no_radio():
    code = (
        "import sys, armspan.links.ble, armspan.links.ble_emulated, armspan.links.ble_backend; "
        "sys.exit(any(name.split('.')[0] in ('bleak', 'bumble') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0


def test_turns_are_kept_apart_by_loop_and_radio():
    async def turn(radio):
        return ble._held(radio)

    async def scene():
        assert await turn(ble.OWN) is await turn(Radio())
        assert await turn(ble.OWN) is not await turn(Radio(adapter="hci1"))

    asyncio.run(scene())
    asyncio.run(scene())
