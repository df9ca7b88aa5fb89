"""The data processors of an emulated board: buffer, fuser, accounter, rate limiter."""

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from armspan.devices.metawear.board_models import PROCESSOR

LIMITER, BUFFER, ACCOUNTER, FUSER = 0x08, 0x0F, 0x11, 0x1B
NEEDS = {ACCOUNTER: 3, FUSER: 3}
"""The revision of the module from which on a type exists."""
MOST = 17
"""Bytes that fit in a notification beside its three of header."""


@dataclass(slots=True)
class Processor:
    """A processor: where its data come from and what it has kept of them."""

    source: tuple[int, int, int]
    selection: int
    kind: int
    config: bytes
    kept: bytes | None = None
    count: int = 0
    passed_at: float = -1e9

    def selected(self, payload: bytes) -> bytes:
        """The bytes that it takes; the length is told modulo 8, and the longest that is there is meant."""
        offset, bits = self.selection & 0x1F, self.selection >> 5
        rest = payload[offset:]
        lengths = [length for length in range(len(rest), 0, -1) if (length - 1) & 0x07 == bits]
        return rest[: lengths[0]] if lengths else rest


class Processors:
    """All of a board's; ``tick`` says what the reference clock shows now."""

    def __init__(self, revision: int, most: int) -> None:
        self._revision, self._most = revision, most
        self.known: dict[int, Processor] = {}

    def create(self, data: bytes) -> int | None:
        """Make one of ``srcMod srcReg srcId selection type config…``; its number, or None where it cannot be made."""
        number = next((each for each in range(self._most) if each not in self.known), None)
        if len(data) < 5 or number is None or self._revision < NEEDS.get(data[4], 0):
            return None
        module, register, source, selection, kind = data[:5]
        self.known[number] = Processor((module, register & 0x3F, source), selection, kind, data[5:])
        return number

    def process(
        self, module: int, register: int, source: int, payload: bytes, at: float, tick: Callable[[], int]
    ) -> Iterator[tuple[int, bytes]]:
        """What comes out, (number, bytes), when a source gives ``payload`` at board time ``at`` [s]."""
        for number, each in sorted(self.known.items()):
            if each.source == (module, register, source):
                out = self._out(each, each.selected(payload), at, tick)
                if out is not None:
                    yield number, out
                    yield from self.process(PROCESSOR, 0x03, number, out, at, tick)

    def _out(self, each: Processor, taken: bytes, at: float, tick: Callable[[], int]) -> bytes | None:
        if each.kind == BUFFER:
            each.kept = taken
            return None
        if each.kind == FUSER:
            return self._fused(each, taken)
        if each.kind == ACCOUNTER:
            return _accounted(each, taken, tick)
        if each.kind == LIMITER:
            return _limited(each, taken, at)
        return None

    def _fused(self, each: Processor, taken: bytes) -> bytes | None:
        """With what the buffers named in the configuration keep, once all of them keep something."""
        numbers = each.config[1 : 1 + each.config[0]] if each.config else b""
        kept = [self.known[number].kept if number in self.known else None for number in numbers]
        if any(part is None for part in kept):
            return None
        return taken + b"".join(part for part in kept if part is not None)


def _accounted(each: Processor, taken: bytes, tick: Callable[[], int]) -> bytes:
    """Behind a count (mode 0) or a time (mode 1) of so many bytes."""
    mode, size = each.config[0] & 0x0F, (each.config[0] >> 4) + 1
    number = tick() if mode == 1 else each.count
    each.count += 1
    return (number % (1 << 8 * size)).to_bytes(size, "little") + taken


def _limited(each: Processor, taken: bytes, at: float) -> bytes | None:
    """At most one per period [ms]; half a millisecond early counts as in time."""
    (period_ms,) = struct.unpack("<I", each.config[1:5].ljust(4, b"\0"))
    if at - each.passed_at < period_ms / 1000.0 - 5e-4:
        return None
    each.passed_at = at
    return taken
