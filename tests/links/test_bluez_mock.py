"""bleak's unmodified BlueZ backend, against a mock BlueZ on a private bus."""

import asyncio

import pytest

from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.peripheral import BATTERY, COMMAND, NOTIFY, SERVICE
from armspan.errors import DeviceNotFound
from armspan.links.ble import Radio, connected, scan, trouble
from links.mock_bluez import THEIRS, dropped, missing, mock_bluez, private_bus, served

pytestmark = pytest.mark.skipif(missing() is not None, reason=str(missing()))


@pytest.fixture
def bus(monkeypatch):
    with private_bus() as address:
        monkeypatch.setenv("DBUS_SYSTEM_BUS_ADDRESS", address)
        yield address


def play(scene):
    asyncio.run(asyncio.wait_for(scene(), 30.0))


def test_a_bus_without_bluetoothd_says_so(bus):
    assert "bluetoothd" in asyncio.run(trouble())


def test_adapters_that_are_off_or_not_there_say_so(bus):
    async def scene():
        for _ in range(100):  # until the mock is up
            told = await trouble()
            if "bluetoothd" not in told:
                break
            await asyncio.sleep(0.05)
        assert "bluetoothctl power on" in told
        assert "No Bluetooth LE (hci7): " in await trouble(Radio(adapter="hci7"))

    with mock_bluez(bus):
        play(scene)


def test_a_board_is_heard(bus):
    async def scene():
        async with served(MetaWearBoard("mmrl_current", address=THEIRS), bus):
            heard = await scan(1.5, Radio(adapter="hci0"))
            assert [(each.address, each.name) for each in heard] == [(THEIRS, "MetaWear")]
            assert SERVICE in heard[0].services

    with mock_bluez(bus, "--auto-enable"):
        play(scene)


def test_a_board_is_connected_and_streams(bus):
    """The mock reports each device only once, so that nobody may listen before."""

    async def scene():
        board = MetaWearBoard("mmrl_current", address=THEIRS)
        radio, gone, got = Radio(adapter="hci0"), [], []
        async with served(board, bus):
            async with connected(THEIRS, radio, gone=lambda: gone.append(True)) as client:
                assert await client.read_gatt_char(BATTERY) == bytes([board.traits.battery])
                await client.start_notify(NOTIFY, lambda _, data: got.append(bytes(data)))
                await client.write_gatt_char(COMMAND, bytes.fromhex("0980"), response=False)
                await asyncio.sleep(0.2)
                assert got == [bytes.fromhex("098000031c")]
                for text in START:
                    await client.write_gatt_char(COMMAND, bytes.fromhex(text), response=False)
                await asyncio.sleep(1.5)
                quaternions = [data for data in got if data[:2] == b"\x19\x07"]
                assert len(quaternions) > 120
            assert gone == []

    with mock_bluez(bus, "--auto-enable"):
        play(scene)


def test_a_board_that_goes_is_noticed(bus):
    async def scene():
        gone = []
        async with served(MetaWearBoard("mmrl_current", address=THEIRS), bus):
            async with connected(THEIRS, Radio(adapter="hci0"), gone=lambda: gone.append(True)) as client:
                await dropped(bus, "hci0", THEIRS)  # as bluetoothd tells it
                await asyncio.sleep(0.3)
                assert not client.is_connected
            assert gone == [True]

    with mock_bluez(bus, "--auto-enable"):
        play(scene)


def test_who_is_not_there_is_not_heard(bus):
    async def scene():
        async with served(MetaWearBoard("mmrl_current", address=THEIRS), bus):
            with pytest.raises(DeviceNotFound, match=f"heard instead: {THEIRS} .MetaWear."):
                async with connected("E8:C9:8F:52:7B:99", Radio(adapter="hci0"), gone=lambda: None, seconds=1.0):
                    pass

    with mock_bluez(bus, "--auto-enable"):
        play(scene)


START = ["19020213", "0303280c", "13032800", "190701", "03020100", "13020100", "030101", "130101", "19030800", "190101"]
