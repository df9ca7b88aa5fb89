"""How a number travels in a toio packet: little-endian, refused where it is not finite or out of range.

A field is one number or a few bytes on the wire and names the arguments it is made of: usually one, none for a
constant, two for an angle with its mode. Ranges are the toio core cube specification's (toio.github.io/toio-spec,
BLE protocol 2.0 to 2.5).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

Value: TypeAlias = int | float | str | bool | list[dict[str, int | float | str | bool]]
Raw: TypeAlias = int | float | bytes

FORWARD, BACKWARD = 1, 2
ANGLE_BITS = 13
MOST_DEG = (1 << ANGLE_BITS) - 1
ABSOLUTE = (0, 1, 2)
"""Modes of an angle that is a direction on the mat."""


@dataclass(frozen=True, slots=True)
class Field:
    """The arguments ``keys`` as ``code`` for `struct`, and both ways, which raise ValueError with what was expected."""

    keys: tuple[str, ...]
    code: str
    pack: Callable[..., Raw]
    unpack: Callable[[Any], tuple[int | float | str | bool, ...]]


def number(value: object, low: float, high: float) -> float:
    """A number from ``low`` to ``high``; ValueError for anything else, NaN too."""
    if not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(f"a number from {low:g} to {high:g}")
    return value


def constant(value: int, code: str = "B") -> Field:
    """A reserved number that is always the same."""

    def unpack(raw: int) -> tuple[()]:
        if raw != value:
            raise ValueError(f"{value} in a reserved place")
        return ()

    return Field((), code, lambda: value, unpack)


def whole(key: str, low: int = 0, high: int = 255, code: str = "B") -> Field:
    """A whole number from ``low`` to ``high``; a fraction is cut off."""
    return Field((key,), code, lambda value: int(number(value, low, high)), lambda raw: (int(number(raw, low, high)),))


def one_of(key: str, *allowed: int, code: str = "B") -> Field:
    """A whole number of a few."""

    def checked(value: object) -> int:
        if not isinstance(value, int | float) or value not in allowed:
            raise ValueError(f"one of {', '.join(map(str, allowed))}")
        return int(value)

    return Field((key,), code, checked, lambda raw: (checked(raw),))


def flag(key: str, on: int = 1) -> Field:
    """Yes or no, as ``on`` and 0."""

    def unpack(raw: int) -> tuple[bool]:
        if raw not in (0, on):
            raise ValueError(f"0 or {on}")
        return (raw == on,)

    return Field((key,), "B", lambda value: on if number(value, 0, 1) else 0, unpack)


def steps(key: str, step: int, low: int = 0) -> Field:
    """A time in steps of ``step`` [ms]; a little is one step, since none at all often means for ever."""

    def pack(value: object) -> int:
        ms = number(value, low * step, 255 * step)
        return max(1, int(ms // step)) if ms > 0 else 0

    return Field((key,), "B", pack, lambda raw: (step * int(number(raw, low, 255)),))


def wheel(key: str, motor: int) -> Field:
    """A wheel's speed from -255 to 255, as its motor's number, a direction and a size."""

    def pack(value: object) -> bytes:
        speed = int(number(value, -255, 255))
        return bytes((motor, FORWARD if speed >= 0 else BACKWARD, abs(speed)))

    def unpack(raw: bytes) -> tuple[int]:
        if raw[0] != motor or raw[1] not in (FORWARD, BACKWARD):
            raise ValueError(f"motor {motor}, direction {FORWARD} or {BACKWARD}, and a speed")
        return (raw[2] if raw[1] == FORWARD else -raw[2],)

    return Field((key,), "3s", pack, unpack)


def target_angle() -> Field:
    """A target's ``angle_deg`` and how it is meant, ``angle_mode``, in one number of 16 bits.

    Where it is a direction on the mat (modes 0 to 2) it is brought into the circle; a turn may be longer than one.
    """

    def pack(angle: object, mode: object) -> int:
        how = int(number(mode, 0, 6))
        absolute = how in ABSOLUTE
        degrees = number(angle, -MOST_DEG, MOST_DEG) % 360.0 if absolute else number(angle, 0, MOST_DEG)
        return how << ANGLE_BITS | int(degrees)

    def unpack(raw: int) -> tuple[int, int]:
        mode = int(number(raw >> ANGLE_BITS, 0, 6))
        return raw & ((1 << ANGLE_BITS) - 1), mode

    return Field(("angle_deg", "angle_mode"), "H", pack, unpack)


def real(key: str, most: float) -> Field:
    """A real number of at most ``most`` either way."""
    return Field(
        (key,), "f", lambda value: float(number(value, -most, most)), lambda raw: (float(number(raw, -most, most)),)
    )


def text(key: str, length: int) -> Field:
    """Printable ASCII of a fixed length."""

    def pack(value: object) -> bytes:
        if not (isinstance(value, str) and value.isascii() and value.isprintable() and len(value) == length):
            raise ValueError(f"{length} printable ASCII characters")
        return value.encode()

    def unpack(raw: bytes) -> tuple[str]:
        word = raw.decode("ascii", "replace")
        pack(word)
        return (word,)

    return Field((key,), f"{length}s", pack, unpack)


def octets(key: str, length: int) -> Field:
    """Bytes that are not taken apart, as hexadecimal digits."""

    def pack(value: object) -> bytes:
        try:
            raw = bytes.fromhex(value) if isinstance(value, str) else b""
        except ValueError:
            raw = b""
        if len(raw) != length:
            raise ValueError(f"{2 * length} hexadecimal digits")
        return raw

    return Field((key,), f"{length}s", pack, lambda raw: (raw.hex(),))


def keys_of(fields: Sequence[Field]) -> tuple[str, ...]:
    """The arguments that fields are made of, in order."""
    return tuple(key for field in fields for key in field.keys)
