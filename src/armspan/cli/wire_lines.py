"""What the lines of ``armspan wire`` share: keys that must be there, bytes in hexadecimal digits."""

from collections.abc import Mapping
from typing import Any

from armspan.errors import DeviceError


def required(line: Mapping[str, Any], key: str) -> str:
    """A text that a line must have.

    Raises:
        DeviceError: where it lacks it, or it is none.

    """
    value = line.get(key)
    if not isinstance(value, str):
        have = ", ".join(map(repr, line)) or "nothing"
        raise DeviceError(f"a line needs {key!r} as text; it has {have if value is None else f'{key} {value!r}'}")
    return value


def mapping(line: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """An object of a line by its key; empty where it lacks it.

    Raises:
        DeviceError: where it is none.

    """
    value = line.get(key)
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise DeviceError(f"a line's {key!r} is {str(value)[:40]!r}; expected an object with keys and values")
    return value


def hexadecimal(line: Mapping[str, Any], key: str, what: str) -> bytes:
    """Bytes from a line's hexadecimal digits, blanks between them or not.

    Raises:
        DeviceError: where they are none.

    """
    text = required(line, key)
    try:
        return bytes.fromhex(text.removeprefix("0x").replace(":", " "))
    except ValueError:
        raise DeviceError(f"{what}: {text[:40]!r} is not hexadecimal; expected pairs of digits, as 0150") from None


def text_of(value: Any) -> str:
    """A value for a person: numbers without what float arithmetic adds."""
    return f"{value:.9g}" if isinstance(value, float) else str(value)
