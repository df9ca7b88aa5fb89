import asyncio
import stat

import numpy as np
import pytest

import fast_time
from armspan.config import survey as surveying
from armspan.config.survey import Found, survey
from armspan.devices.cellulo import relay
from armspan.devices.cellulo.emulator import Emulator, addresses
from armspan.devices.cellulo.firmware import Firmware
from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.board_models import Traits
from armspan.devices.metawear.peripheral import MetaWearPeripheral
from armspan.errors import DeviceError
from armspan.links import ble
from armspan.links.ble_emulated import emulated_radio
from armspan.records import Sheet


@pytest.fixture(autouse=True)
def _nothing(monkeypatch, tmp_path):
    """Neither a radio nor a relay nor a port, wherever the tests run."""

    async def no_radio(seconds, radio=ble.OWN):
        raise DeviceError("no adapter; plug one in")

    def no_sockets():
        raise DeviceError("no Bluetooth sockets; use the system's Python")

    monkeypatch.setattr(surveying.ble, "scan", no_radio)
    monkeypatch.setattr(surveying.rfcomm, "open_socket", no_sockets)


def looked(tmp_path, port=1, **more):
    return asyncio.run(survey(0.1, port=port, dev=tmp_path, **more))


def test_each_door_says_why_nothing_is_heard(tmp_path):
    seen = looked(tmp_path)
    assert seen.found == ()
    told = {missing.door.split(" (")[0]: missing.why for missing in seen.missing}
    assert told == {
        "Bluetooth LE": "no adapter; plug one in",
        "Bluetooth Classic": "no Bluetooth sockets; use the system's Python",
        "Cellulo relay on 127.0.0.1:1": "nobody listens there; start EPFL's robot pool or `armspan emulate cellulo`",
        "serial ports": f"there are none in {tmp_path}; plug the cable in, or bind a robot with `rfcomm bind`",
    }


def test_ports_are_listed(tmp_path):
    (tmp_path / "rfcomm0").touch()
    (tmp_path / "tty1").touch()
    assert looked(tmp_path).found == (Found("serial port", str(tmp_path / "rfcomm0")),)


def test_robots_that_bluez_knows_are_listed(tmp_path, monkeypatch):
    program = tmp_path / "bluetoothctl"
    lines = "Device 00:06:66:E7:8A:D8 Cellulo-8AD8\\nDevice 11:22:33:44:55:66 Headphones\\n"
    program.write_text(f'#!/bin/sh\n[ "$1" = devices ] && printf "{lines}"\n')
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setattr(surveying.rfcomm, "open_socket", _Socket)
    assert looked(tmp_path).found == (Found("cellulo", "00:06:66:E7:8A:D8", "Cellulo-8AD8"),)


class _Socket:
    def close(self):
        pass


def test_a_relay_tells_its_robots(tmp_path):
    async def scene():
        sheet = Sheet(0.8, 0.6)
        firmware = Firmware(((0.2, 0.2), (0.4, 0.4)), np.zeros(2), sheet, np.random.default_rng(0))
        emulator = Emulator(firmware, dict(zip(addresses(2), ("a", "b"), strict=True)))
        port = asyncio.get_running_loop().create_future()
        serving = asyncio.create_task(emulator.serve(0, port.set_result))
        at = await port
        _, writer = await asyncio.open_connection("127.0.0.1", at)
        busy = await survey(0.1, port=at, dev=tmp_path)
        for mac in addresses(2):  # a client names the robots it wants; the next one is told of them
            writer.write(relay.client_side().status(mac, relay.CONNECTED))
        await asyncio.sleep(0.1)
        writer.close()
        await asyncio.sleep(0.1)
        free = await survey(0.1, port=at, dev=tmp_path)
        serving.cancel()
        await asyncio.gather(serving, return_exceptions=True)
        return busy, free

    busy, free = asyncio.run(scene())
    assert [(found.kind, found.address) for found in free.found] == [("cellulo", mac) for mac in addresses(2)]
    assert "it has a client already" in next(missing.why for missing in busy.missing if "relay" in missing.door)


def test_bands_on_the_air_are_asked_for_battery_and_firmware(tmp_path, monkeypatch):
    monkeypatch.undo()

    async def scene():
        async with emulated_radio() as air:
            await air.add(MetaWearPeripheral(MetaWearBoard("mmrl_current", Traits(battery=64))))
            await air.add(
                MetaWearPeripheral(MetaWearBoard("mms", Traits(bootloader=True), address="E8:C9:8F:52:7B:08"))
            )
            return await survey(2.0, air.radio, port=1, dev=tmp_path)

    well, ill = sorted(fast_time.run(scene, 60.0).found, key=lambda found: found.address)
    assert (well.kind, well.address, well.name, well.battery) == ("metawear", "E8:C9:8F:52:7B:07", "MetaWear", 0.64)
    assert well.firmware.count(".") == 2
    assert (ill.kind, ill.battery) == ("metawear", None)
    assert "in its bootloader" in ill.note
