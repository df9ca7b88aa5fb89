"""The USB side of an emulated MetaMotion S: a pseudo-terminal that speaks the board's frames."""

import asyncio
import os
import tty
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.peripheral import MAKER
from armspan.errors import ConfigError

START, END = 0x1F, 0x0A
IDENTIFY = b"?\n"
MODEL_NAME = "MetaMotionS"
WITH_USB = "8"
"""The model number that has a socket for data."""
ROOM = 4096


class UsbFraming:
    """Bytes of the line: commands out of frames, and the question who it is. What is neither is skipped."""

    def __init__(self) -> None:
        self._line = b""

    def feed(self, data: bytes) -> list[bytes]:
        """The payloads that are complete now; `IDENTIFY` stands for the question."""
        self._line += data
        found = []
        while self._line:
            taken, payload = self._first()
            if taken == 0:
                break
            self._line = self._line[taken:]
            if payload:
                found.append(payload)
        return found

    def _first(self) -> tuple[int, bytes]:
        """How many bytes are dealt with (0: more are needed), and what they hold."""
        line = self._line
        if line[0] == IDENTIFY[0]:
            return (len(IDENTIFY), IDENTIFY) if line[:2] == IDENTIFY else (0 if len(line) < 2 else 1, b"")
        if line[0] != START:
            return 1, b""
        if len(line) < 2 or len(line) < line[1] + 3:
            return 0, b""
        whole = line[line[1] + 2] == END
        return (line[1] + 3, line[2 : line[1] + 2]) if whole else (1, b"")


def framed(payload: bytes) -> bytes:
    """One frame."""
    return bytes([START, len(payload)]) + payload + bytes([END])


def identity(board: MetaWearBoard) -> bytes:
    """The line that answers the question."""
    model = board.model
    words = (MAKER, MODEL_NAME, model.number, model.hardware, model.firmware, board.traits.serial)
    return " ".join(words).encode() + b"\n"


@asynccontextmanager
async def serve_usb(board: MetaWearBoard) -> AsyncIterator[str]:
    """Serve a board on a pseudo-terminal, whose path is given; only the MetaMotion S has USB."""
    if board.model.number != WITH_USB:
        raise ConfigError(
            f"model {board.model.number} has no USB: only the MetaMotion S (model {WITH_USB}) does; emulate mms"
        )
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    os.set_blocking(ours, False)
    line = _Line(board, ours)
    try:
        yield os.ttyname(theirs)
    finally:
        line.close()
        os.close(ours)
        os.close(theirs)


class _Line:
    """The board at one end of the line, with its time."""

    def __init__(self, board: MetaWearBoard, descriptor: int) -> None:
        self._board, self._descriptor = board, descriptor
        self._framing = UsbFraming()
        self._timer: asyncio.TimerHandle | None = None
        asyncio.get_running_loop().add_reader(descriptor, self._read)

    def close(self) -> None:
        asyncio.get_running_loop().remove_reader(self._descriptor)
        if self._timer is not None:
            self._timer.cancel()

    def _read(self) -> None:
        with suppress(BlockingIOError, OSError):
            for payload in self._framing.feed(os.read(self._descriptor, ROOM)):
                if payload == IDENTIFY:
                    self._send(identity(self._board))
                    continue
                if not self._board.up:
                    self._board.linked(True)
                self._board.write(payload)
                self._tick()

    def _tick(self) -> None:
        """Let the board's time go on, now and again when something is due."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        loop = asyncio.get_running_loop()
        for packet in self._board.advance(loop.time()):
            self._send(framed(packet))
        if self._board.leaving is not None:
            self._board.linked(False)
            self._board.advance(loop.time())
        due = self._board.due()
        if due is not None:
            self._timer = loop.call_at(due, self._tick)

    def _send(self, data: bytes) -> None:
        """What a full line does not take is lost."""
        with suppress(BlockingIOError):
            os.write(self._descriptor, data)
