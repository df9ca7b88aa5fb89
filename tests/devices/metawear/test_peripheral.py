"""The emulated board on the emulated air, as bleak sees it."""

import asyncio
import json
import struct
from itertools import pairwise
from pathlib import Path

import pytest

from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.board_models import Traits
from armspan.devices.metawear.peripheral import BATTERY, COMMAND, DFU, NOTIFY, SERVICE, MetaWearPeripheral
from armspan.links.ble import connected, scan
from armspan.links.ble_emulated import advertisement, emulated_radio
from armspan.links.waves import LinkFaults
from fast_time import now, run

VECTORS = Path(__file__).parents[3].parent / "shared" / "vectors" / "metawear.json"
IMU_PLUS = "19020213 0303280c 13032800 190701 03020100 13020100 030101 130101 19030800 190101"
FUSED = (
    "03032808 13032800 09021305ffa00f05 09020304ffa01b01000000000000000000000000 090209030160113103 "
    "09070201 090301 13020100 03020100 130101 030101"
)


def never():
    raise AssertionError("the link broke")


async def listened(client):
    got = []
    await client.start_notify(NOTIFY, lambda _, data: got.append((now(), bytes(data))))
    return got


async def told(client, text):
    for command in text.split():
        await client.write_gatt_char(COMMAND, bytes.fromhex(command), response=False)


def test_it_advertises_as_traced():
    if not VECTORS.exists():
        pytest.skip("the recorded vectors are not beside the repository")
    fields = json.loads(VECTORS.read_text())["real_device_trace"]["advertising"]["data_fields"]
    traced = b""
    for kind, text in fields:
        value = bytes.fromhex(text.replace(" ", ""))
        traced += bytes([1 + len(value), int(kind[:2], 16)]) + value
    peripheral = MetaWearPeripheral(MetaWearBoard())
    assert advertisement(peripheral.name, peripheral.services) == traced


def test_handles_properties_and_strings_are_those_of_the_trace():
    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard("mmr_fw150")
            await air.add(MetaWearPeripheral(board))
            async with connected(board.address, air.radio, gone=never) as client:
                values = client.services.characteristics
                assert {handle: value.uuid[4:8] for handle, value in values.items()} == {
                    0x03: "2a00", 0x05: "2a01", 0x07: "2a04", 0x09: "2aa6", 0x0C: "2a05", 0x10: "2a19",
                    0x14: "2a29", 0x16: "2a24", 0x18: "2a25", 0x1A: "2a27", 0x1C: "2a26", 0x1F: "9001", 0x21: "9006",
                }  # fmt: skip
                assert set(values[0x1F].properties) == {"read", "write-without-response", "write"}
                assert set(values[0x21].properties) == set(values[0x10].properties) == {"read", "notify"}
                assert [each.handle for each in values[0x21].descriptors] == [0x22]
                assert [each.handle for each in values[0x10].descriptors] == [0x11]
                assert client.mtu_size == 23
                for uuid, text in (
                    ("2a29", "MbientLab Inc"),
                    ("2a24", "5"),
                    ("2a25", "047D22"),
                    ("2a27", "0.4"),
                    ("2a26", "1.5.0"),
                ):
                    assert await client.read_gatt_char(uuid) == text.encode()
                assert await client.read_gatt_char(BATTERY) == bytes([board.traits.battery])

    run(scene)


def test_a_handshake_and_a_stream_of_quaternions():
    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard()
            await air.add(MetaWearPeripheral(board))
            async with connected(board.address, air.radio, gone=never) as client:
                got = await listened(client)
                for module in board.model.modules:
                    await told(client, f"{module:02x}80")
                await asyncio.sleep(0.05)
                assert [data[:2] for _, data in got] == [bytes([module, 0x80]) for module in board.model.modules]
                got.clear()
                await told(client, IMU_PLUS)
                await asyncio.sleep(3.0)
                assert 298 <= len(got) <= 301
                gaps = [b[0] - a[0] for a, b in pairwise(got)]
                assert max(gaps) < 0.011
                assert sum(each * each for each in struct.unpack("<4f", got[-1][1][2:])) == pytest.approx(1.0, abs=1e-5)

    run(scene)


def test_two_boards_at_once_stream_their_own():
    async def scene():
        async with emulated_radio() as air:
            boards = [
                MetaWearBoard(address=f"E8:C9:8F:52:7B:0{i}", traits=Traits(drift=d))
                for i, d in ((1, 2e-3), (2, -2e-3))
            ]
            for board in boards:
                await air.add(MetaWearPeripheral(board))

            async def worn(board):
                async with connected(board.address, air.radio, gone=never) as client:
                    got = await listened(client)
                    await told(client, FUSED)
                    await asyncio.sleep(5.0)
                    ticks = [(t, struct.unpack("<I", data[3:7])[0]) for t, data in got if data[:3] == b"\x09\x03\x02"]
                    (t0, k0), (t1, k1) = ticks[0], ticks[-1]
                    return (k1 - k0) * 48 / 32768 / (t1 - t0) - 1.0

            fast, slow = await asyncio.gather(*(worn(board) for board in boards))
            assert fast == pytest.approx(2e-3, abs=4e-4)
            assert slow == pytest.approx(-2e-3, abs=4e-4)

    run(scene)


def test_the_connection_parameters_that_it_asks_for_are_granted():
    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard()
            await air.add(MetaWearPeripheral(board), LinkFaults(burst_s=0.04875))
            async with connected(board.address, air.radio, gone=never) as client:
                got = await listened(client)
                await told(client, IMU_PLUS)
                await asyncio.sleep(1.0)
                slow = len({round(t, 4) for t, _ in got})
                await told(client, "11090600060000005802")
                await asyncio.sleep(0.2)
                got.clear()
                await asyncio.sleep(1.0)
                assert slow < 25
                assert len({round(t, 4) for t, _ in got}) > 95
                cut = now()
                air.cut(board.address)
                while client.is_connected:
                    await asyncio.sleep(0.01)
                assert now() - cut == pytest.approx(6.0, abs=0.05)  # the time-out that it asked for

    run(scene)


def test_a_lost_link_runs_the_program_and_the_stream_outlives_it():
    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard()
            await air.add(MetaWearPeripheral(board), LinkFaults(away_s=1.0))
            gone = []
            async with connected(board.address, air.radio, gone=lambda: gone.append(now())) as client:
                await listened(client)
                await told(client, IMU_PLUS + " 0a02110aff080104 0a03f8b80b00")
                await asyncio.sleep(0.2)
                air.cut(board.address)
                await asyncio.sleep(1.2)
                assert len(gone) == 1
                assert len(board.haptics) == 1
            async with connected(board.address, air.radio, gone=never) as client:
                got = await listened(client)
                await asyncio.sleep(1.0)
                assert 98 <= len(got) <= 101

    run(scene)


@pytest.mark.parametrize(("command", "quiet"), [("fe06", 0.0), ("fe01", 2.0)])
def test_it_ends_the_link_and_comes_back(command, quiet):
    async def scene():
        gone = []
        async with emulated_radio() as air:
            board = MetaWearBoard()
            await air.add(MetaWearPeripheral(board))
            async with connected(board.address, air.radio, gone=lambda: gone.append(now())) as client:
                await told(client, command)
                await asyncio.sleep(0.1)
                assert len(gone) == 1
            async with connected(board.address, air.radio, gone=never):
                assert quiet < now() - gone[0] < quiet + 1.5

    run(scene)


def test_commands_before_a_disconnection_arrive():
    """As over a real link: what was sent before the link is ended goes first."""

    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard()
            await air.add(MetaWearPeripheral(board), LinkFaults(burst_s=0.05, latency_s=0.01))
            async with connected(board.address, air.radio, gone=never) as client:
                await told(client, "020302021f00000032000000f40100000a 020101")
            await asyncio.sleep(0.2)
            assert board.lamp.playing

    run(scene)


def test_the_button_is_heard_when_the_air_is_told():
    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard()
            await air.add(MetaWearPeripheral(board))
            async with connected(board.address, air.radio, gone=never) as client:
                got = await listened(client)
                await told(client, "010101")
                await asyncio.sleep(0.05)
                board.press()
                air.wake(board.address)
                await asyncio.sleep(0.05)
                assert [data for _, data in got] == [b"\x01\x01\x01"]

    run(scene)


def test_in_bootloader_mode_only_the_update_service_is_there():
    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard(traits=Traits(bootloader=True))
            await air.add(MetaWearPeripheral(board))
            (heard,) = await scan(1.0, air.radio)
            assert (heard.name, heard.services) == ("MetaBoot", {DFU})
            async with connected(board.address, air.radio, gone=never) as client:
                uuids = [service.uuid for service in client.services]
                assert DFU in uuids
                assert SERVICE not in uuids

    run(scene)


def test_jumping_to_the_bootloader_changes_what_it_is():
    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard()
            await air.add(MetaWearPeripheral(board))
            async with connected(board.address, air.radio, gone=lambda: None) as client:
                await told(client, "fe02")
                await asyncio.sleep(0.1)
                assert not client.is_connected
            await asyncio.sleep(2.0)
            (heard,) = await scan(1.0, air.radio)
            assert (heard.name, heard.services) == ("MetaBoot", {DFU})

    run(scene)
