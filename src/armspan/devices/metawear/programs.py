"""What a MetaWear board does on its own: data processors, timers, events, logging; and how it is cleaned.

The board answers each creation with a number: ``[module, 02, number]`` (MbientLab MetaWear-API,
docs/protocol-reference.md; MetaWear-SDK-Cpp 0.30.0, test/test_dataprocessor.py, test_event.py, test_logging.py).
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from armspan.devices.metawear.boards import EVENT, LOGGING, PROCESSOR, SETTINGS, TIMER, Board
from armspan.devices.metawear.quantities import counts
from armspan.devices.metawear.wire import stream_register
from armspan.errors import DeviceError

ANY: Final = 0xFF
"""The id of a source that has only one."""
TEAR_DOWN: Final = (b"\x09\x08", b"\x0a\x05", b"\x0b\x0a")
"""Remove processors, events, loggers."""
FACTORY_CLEAN: Final = tuple(
    bytes.fromhex(write) for write in ("0b0100", "0b09ffffffff", "0b0a", "0a05", "0908", "0f08", "fe05", "fe01")
)
START_LOGGING: Final = (b"\x0b\x0b\x01", b"\x0b\x01\x01")
STOP_LOGGING: Final = (b"\x0b\x01\x00",)
CLEAR_LOG: Final = (b"\x0b\x09\xff\xff\xff\xff",)
REMOVE_LOGGERS: Final = (b"\x0b\x0a",)
FLUSH_PAGE: Final = (b"\x0b\x10\x01",)
"""Before a download, on a MetaMotion S."""
ASK_LOG: Final = (b"\x0b\x08\x01", b"\x0b\x0d\x01", b"\x0b\x07\x01", b"\x0b\x85")
"""Let progress, pages and entries come, and ask how many there are."""
CONFIRM_PAGE: Final = b"\x0b\x0e"

_LIMITER, _BUFFER, _ACCOUNTER, _FUSER = 0x08, 0x0F, 0x11, 0x1B
_STREAM_BYTES: Final = {
    "acc": 6,
    "gyro": 6,
    "mag": 6,
    "switch": 1,
    "corrected_acc": 13,
    "corrected_gyro": 13,
    "corrected_mag": 13,
    "quaternion": 16,
    "euler": 16,
    "gravity": 12,
    "linear_acc": 12,
}


@dataclass(frozen=True, slots=True)
class Source:
    """Where data comes from: module, register, id, and its bytes."""

    module: int
    register: int
    number: int
    length: int
    offset: int = 0

    @property
    def header(self) -> bytes:
        """As a creation names it."""
        return bytes((self.module, self.register, self.number, (self.length - 1 << 5 | self.offset) & 0xFF))


def stream_source(board: Board, stream: str) -> Source:
    """A stream's data as a source.

    Raises:
        DeviceError: where the board does not have it, or nothing can be made of it.

    """
    module, register = stream_register(board, stream)
    if stream not in _STREAM_BYTES:
        raise DeviceError(f"nothing on the board can be made of {stream}; of {', '.join(_STREAM_BYTES)} it can")
    return Source(module, register, ANY, _STREAM_BYTES[stream])


def processor_source(number: int, length: int) -> Source:
    """A data processor's output as a source."""
    return Source(PROCESSOR, 0x03, _processor(number), counts("a length", length, 1, 16))


def _processor(number: int) -> int:
    return counts("a processor's number", number, 0, 0xFE)


def _create(source: Source, kind: int, settings: bytes) -> bytes:
    return bytes((PROCESSOR, 2)) + source.header + bytes((kind,)) + settings


def buffer(source: Source) -> bytes:
    """Create a processor that keeps the last value."""
    return _create(source, _BUFFER, bytes((source.length - 1,)))


def fuser(source: Source, buffers: Iterable[int]) -> bytes:
    """Create a processor that sends a value together with those of buffers (at most 12)."""
    numbers = bytes(counts("a buffer's number", number, 0, 0xFE) for number in buffers)
    if not 1 <= len(numbers) <= 12:
        raise DeviceError(f"{len(numbers)} buffers cannot be fused; expected 1 to 12")
    return _create(source, _FUSER, bytes((len(numbers),)) + numbers.ljust(12, b"\0"))


def accounter(source: Source, *, count: bool = False) -> bytes:
    """Create a processor that puts four bytes before each value: the clock, or how many there were."""
    return _create(source, _ACCOUNTER, bytes((0x30 if count else 0x31, 0x03)))


def rate_limiter(source: Source, period_ms: int) -> bytes:
    """Create a processor that lets at most one value pass per period."""
    period = counts("a period in ms", period_ms, 1, 0xFFFFFFFF)
    return _create(source, _LIMITER, bytes((0x10 | (source.length - 1 & 7),)) + struct.pack("<I", period))


def subscribe_processor(number: int) -> tuple[bytes, ...]:
    """Let a processor's output come."""
    return bytes((PROCESSOR, 7, _processor(number), 1)), bytes((PROCESSOR, 3, 1))


def unsubscribe_processor(number: int) -> tuple[bytes, ...]:
    """Let a processor's output come no more."""
    return (bytes((PROCESSOR, 7, _processor(number), 0)),)


def fused_raw(board: Board, buffer_number: int = 0, fuser_number: int = 1) -> tuple[bytes, bytes, bytes]:
    """Create, one after the other's reply: buffer of the gyro, fuser with the accelerometer, clock on both.

    The last one's output is `notifications.Fused`, 19 bytes with header.

    Raises:
        DeviceError: where the board's data processors are older than revision 3.

    """
    if not board.has(PROCESSOR, 3):
        raise DeviceError(
            f"the {board.name}'s firmware is too old for samples with a clock: that needs revision 3 of its data "
            "processors; update it with MbientLab's app, or use the fusion profile"
        )
    return (
        buffer(stream_source(board, "gyro")),
        fuser(stream_source(board, "acc"), (buffer_number,)),
        accounter(processor_source(fuser_number, 12)),
    )


def limited_chain(board: Board, period_ms: int = 20) -> tuple[bytes, ...]:
    """Fused samples at most once per period, counted, and with the clock, each from the same limiter."""
    keep, fuse, _ = fused_raw(board)
    limited = processor_source(2, 12)
    return (
        keep,
        fuse,
        rate_limiter(processor_source(1, 12), period_ms),
        accounter(limited, count=True),
        accounter(limited),
    )


def timer(period_ms: int, repeat: int = 0xFFFF, *, immediate: bool = True) -> bytes:
    """Create a timer that fires at once or after its first period; 65535 repetitions are forever."""
    period = counts("a period in ms", period_ms, 1, 0xFFFFFFFF)
    return struct.pack("<BBIHB", TIMER, 2, period, counts("repetitions", repeat, 0, 0xFFFF), immediate)


def start_timer(number: int) -> bytes:
    """Start a timer."""
    return bytes((TIMER, 3, counts("a timer's number", number, 0, 0xFE)))


def stop_timer(number: int) -> bytes:
    """Stop a timer."""
    return bytes((TIMER, 4, counts("a timer's number", number, 0, 0xFE)))


def remove_timer(number: int) -> bytes:
    """Remove a timer."""
    return bytes((TIMER, 5, counts("a timer's number", number, 0, 0xFE)))


def event(module: int, register: int, number: int, write: bytes) -> tuple[bytes, bytes]:
    """Let a write happen on the board whenever that source speaks."""
    if not 3 <= len(write) <= 20:
        raise DeviceError(f"an event's write has {len(write)} bytes; expected module, register and 1 to 18 more")
    head = (EVENT, 2, module, register, number, write[0], write[1], len(write) - 2)
    return bytes(head), bytes((EVENT, 3)) + write[2:]


def on_timer(number: int, write: bytes) -> tuple[bytes, bytes]:
    """Let a write happen at a timer's moments."""
    return event(TIMER, 0x06, counts("a timer's number", number, 0, 0xFE), write)


def on_disconnect(writes: Iterable[bytes]) -> tuple[bytes, ...]:
    """Let these writes happen on the board when it loses its host: the wearer shall notice."""
    return tuple(part for write in writes for part in event(SETTINGS, 0x0A, ANY, write))


def log(source: Source) -> tuple[bytes, ...]:
    """Create the loggers of a source, four bytes each."""
    parts = range(0, source.length, 4)
    pieces = (Source(source.module, source.register, source.number, min(4, source.length - at), at) for at in parts)
    return tuple(bytes((LOGGING, 2)) + piece.header for piece in pieces)


def download(entries: int, step: int = 20) -> bytes:
    """Ask for logged entries, with a word of progress every ``step``."""
    wanted = counts("log entries", entries, 0, 0xFFFFFFFF)
    return struct.pack("<BBII", LOGGING, 6, wanted, counts("a step", step, 0, 0xFFFFFFFF))
