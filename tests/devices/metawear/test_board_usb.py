"""The emulated MetaMotion S on a pseudo-terminal, spoken to with pyserial."""

import asyncio
import json
from pathlib import Path

import pytest

from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.board_usb import IDENTIFY, UsbFraming, framed, serve_usb
from armspan.errors import ConfigError

VECTORS = Path(__file__).parents[3].parent / "shared" / "vectors" / "metawear.json"
STREAM = "19020213 0303a803 13032800 190701 03020100 13020100 030101 130101 19030800 190101"


def test_recorded_frames():
    if not VECTORS.exists():
        pytest.skip("the recorded vectors are not beside the repository")
    for told in json.loads(VECTORS.read_text())["usb"]["examples"]:
        assert framed(bytes.fromhex(told["payload"])).hex() == told["frame"]
        assert UsbFraming().feed(bytes.fromhex(told["frame"])) == [bytes.fromhex(told["payload"])]


def test_frames_are_found_between_garbage_and_in_pieces():
    line = b"\x00\xff" + framed(b"\xfe\x06") + b"?x" + IDENTIFY + b"\x1f\x02\xfe\x06\x0b" + framed(b"\x01\x80\x0a\x1f")
    framing = UsbFraming()
    found = [payload for byte in line for payload in framing.feed(bytes([byte]))]
    assert found == [b"\xfe\x06", IDENTIFY, b"\x01\x80\x0a\x1f"]


def test_a_board_without_usb_says_so():
    async def scene():
        async with serve_usb(MetaWearBoard("mmrl_current")):
            pass

    with pytest.raises(ConfigError, match="only the MetaMotion S"):
        asyncio.run(scene())


def test_pyserial_identifies_asks_and_streams():
    serial = pytest.importorskip("serial")

    async def scene():
        board = MetaWearBoard("mms")
        async with serve_usb(board) as path:
            with serial.Serial(path, 1_000_000, timeout=0) as port:
                port.write(b"?\n")
                await asyncio.sleep(0.05)
                assert port.read(200) == b"MbientLab Inc MetaMotionS 8 0.1 1.5.0 047D22\n"
                port.write(framed(b"\x19\x80"))
                await asyncio.sleep(0.05)
                assert port.read(200) == framed(bytes.fromhex("198000030300060002000100"))
                for text in STREAM.split():
                    port.write(framed(bytes.fromhex(text)))
                await asyncio.sleep(1.0)
                packets = UsbFraming().feed(port.read(10000))
                assert 90 <= len(packets) <= 101
                assert all(packet[:2] == b"\x19\x07" and len(packet) == 18 for packet in packets)
                port.write(framed(b"\xfe\x06"))
                await asyncio.sleep(0.05)
                port.read(10000)
                await asyncio.sleep(0.1)
                assert port.read(10000) == b""
                port.write(framed(b"\x01\x80"))  # the stream lives on, as it does over the air
                await asyncio.sleep(0.2)
                assert len(UsbFraming().feed(port.read(10000))) > 10

    asyncio.run(scene())
