import asyncio
import os
import pty
import termios

import pytest

from armspan.errors import DeviceError, DeviceNotFound
from armspan.links import serial_port
from fast_time import run


def test_raw_bytes_both_ways_and_the_end():
    every = bytes(range(256))

    async def scene():
        ours, theirs = pty.openpty()
        path = os.ttyname(theirs)
        line = await serial_port.opened(path, 9600)
        assert termios.tcgetattr(theirs)[4] == termios.B9600
        os.close(theirs)
        os.write(ours, every)
        heard = b""
        while len(heard) < 256:
            heard += await line.read()
        assert heard == every
        assert line.room
        line.write(every)
        assert os.read(ours, 999) == every
        waiting = asyncio.ensure_future(line.read())
        await asyncio.sleep(0.01)
        os.close(ours)
        assert await waiting == b""
        line.write(b"too late")
        await line.flushed()
        line.close()

    run(scene)


def test_a_line_that_nobody_reads_keeps_what_it_cannot_send_and_says_so():
    async def scene():
        ours, theirs = pty.openpty()
        line = await serial_port.opened(os.ttyname(theirs))
        line.write(bytes(100_000))
        assert not line.room
        assert line.waiting > 10_000
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(line.flushed(), 0.05)
        os.set_blocking(ours, False)
        read = 0
        while read < 100_000:
            try:
                read += len(os.read(ours, 65536))
            except BlockingIOError:
                await asyncio.sleep(0.001)
        await line.flushed()
        assert line.waiting == 0
        line.close()
        assert await line.read() == b""
        os.close(theirs)
        os.close(ours)

    run(scene)


@pytest.mark.parametrize(
    ("path", "kind", "words"),
    [
        ("/dev/rfcomm77", DeviceNotFound, r"/dev/rfcomm77 cannot be opened: No such file.*; see how it is called"),
        ("/", DeviceError, r"/ cannot be opened: Is a directory; that is a folder"),
        ("/dev/null", DeviceError, "/dev/null is not a serial port"),
    ],
)
def test_what_is_no_port(path, kind, words):
    async def scene():
        with pytest.raises(DeviceError, match=words) as told:
            await serial_port.opened(path)
        assert type(told.value) is kind

    run(scene)


def test_a_rate_that_is_none_and_a_port_that_is_taken(monkeypatch):
    async def scene():
        ours, theirs = pty.openpty()
        with pytest.raises(DeviceError, match="cannot have 12345 baud; expected a usual rate"):
            await serial_port.opened(os.ttyname(theirs), 12345)

        def refuse(path, flags):
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr(serial_port.os, "open", refuse)
        with pytest.raises(DeviceError, match="Permission denied; this user may not: add it to the port's group"):
            await serial_port.opened("/dev/ttyUSB0")
        os.close(ours)
        os.close(theirs)

    run(scene)
