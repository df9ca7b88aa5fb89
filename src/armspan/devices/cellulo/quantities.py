"""How a number travels in a Cellulo packet: big-endian, in hundredths, truncated as EPFL's client does.

The original client computes in float32 and truncates toward zero; so 2.54 mm are 499 counts, not 500. What it
does not do is done here: what is not finite, a negative position, limit or strength is refused, angles are
brought into the circle (layout from chili-epfl/CelluloV2, CelluloBluetoothSharedDefs.h).
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

Value: TypeAlias = int | float | str | bytes | None

COUNTS_PER_MM = float(np.float32(100.0) / np.float32(0.508))
MM_PER_COUNT = 0.00508
COUNTS_PER_TURN = 36000
MAC_OCTETS = 6
HUGE = 1e300  # beyond it, NaN too: not a number to compute with
_MAC = re.compile(r"[0-9A-Fa-f]{2}(:[0-9A-Fa-f]{2}){5}")


@dataclass(frozen=True, slots=True)
class Quantity:
    """A field's ``code`` for `struct`, and the two ways; both raise ValueError with what was expected."""

    code: str
    pack: Callable[[Value], int | float | bytes]
    unpack: Callable[[int | float | bytes], Value]


def mac_octets(mac: Value) -> bytes:
    """The six octets of an address as ``00:06:66:E7:8A:D8``; None is six zeros, any local adapter."""
    if mac is None:
        return bytes(MAC_OCTETS)
    if not isinstance(mac, str) or not _MAC.fullmatch(mac):
        raise ValueError("six pairs of hexadecimal digits as in 00:06:66:E7:8A:D8")
    return bytes.fromhex(mac.replace(":", ""))


def mac_text(octets: bytes) -> str | None:
    """The address that six octets are; None where all are zero."""
    return octets.hex(":").upper() if any(octets) else None


def whole(code: str, low: int, high: int, *, clamped: bool = False, floor: int | None = None) -> Quantity:
    """A whole number from ``low`` to ``high``; ``clamped`` to ``floor`` (or ``low``) and ``high``, or refused."""

    def pack(value: Value) -> int:
        number = int(_finite(value))
        if clamped:
            return min(max(number, low if floor is None else floor), high)
        return _between(number, low, high)

    return Quantity(code, pack, lambda raw: _between(_int(raw), low, high))


def hundredths(code: str, most: int, *, signed: bool = False) -> Quantity:
    """A number in hundredths, clamped to ``most`` counts; below zero refused unless ``signed``."""

    def pack(value: Value) -> int:
        number = _finite(value) if signed else _positive(value)
        return int(min(max(_times(number, 100.0), -most), most))

    return Quantity(code, pack, lambda raw: _int(raw) / 100)


def _pack_position(value: Value) -> int:
    return int(min(_times(_positive(value), COUNTS_PER_MM), 0x7FFFFFFF))


def _unpack_position(raw: int | float | bytes) -> float:
    counts = _int(raw)  # the robot takes it as a signed number
    return (counts - (1 << 32) if counts >= 1 << 31 else counts) * MM_PER_COUNT


def _pack_angle(value: Value) -> int:
    return int(_times(_finite(value) % 360.0, 100.0)) % COUNTS_PER_TURN


def _pack_exposure(value: Value) -> int:
    pixels = int(_positive(value))
    return min(max(pixels, 260), 0xFFFFFFFF) if pixels else 0


def _pack_real(value: Value) -> float:
    number = _finite(value)
    if abs(number) > 1e6:
        raise ValueError("at most a kilometre")
    return number


def _pack_octets(value: Value) -> bytes:
    if not isinstance(value, bytes):
        raise ValueError("bytes")
    return value


POSITION = Quantity("I", _pack_position, _unpack_position)
ANGLE = Quantity("H", _pack_angle, lambda raw: _int(raw) / 100)
EXPOSURE = Quantity("I", _pack_exposure, lambda raw: raw)
KNOT = Quantity("f", lambda value: _pack_real(_positive(value)), lambda raw: raw)
CONTROL = Quantity("f", _pack_real, lambda raw: raw)
MAC = Quantity("6s", mac_octets, lambda raw: mac_text(bytes(raw) if isinstance(raw, bytes) else b""))
PIXELS = Quantity("188s", _pack_octets, lambda raw: raw)

SPEED = hundredths("H", 0xFFFF)
"""A limit of speed or turn, or a strength: up to 655.35."""
VELOCITY = hundredths("h", 0x7FFF, signed=True)
"""A velocity or a coefficient with a sign: up to 327.67."""
PERIOD = whole("H", 0, 0xFFFF, clamped=True)
SHADE = whole("B", 0, 0xFF, clamped=True)
FLAG = whole("B", 0, 1)
PWM = whole("h", -4095, 4095, clamped=True)


def _finite(value: Value) -> float:
    if not isinstance(value, int | float) or not -HUGE < value < HUGE:
        raise ValueError("a finite number")
    return value


def _positive(value: Value) -> float:
    number = _finite(value)
    if number < 0:
        raise ValueError("zero or more")
    return number


def _between(number: int, low: int, high: int) -> int:
    if not low <= number <= high:
        raise ValueError(f"a whole number from {low} to {high}")
    return number


def _int(raw: int | float | bytes) -> int:
    return int(raw) if isinstance(raw, int | float) else 0


def _times(number: float, factor: float) -> float:
    """The product as float32 computes it, far beyond the clamps at most."""
    return float(np.float32(min(max(number, -1e9), 1e9)) * np.float32(factor))
