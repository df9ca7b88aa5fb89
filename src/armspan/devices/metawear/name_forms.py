"""How a name of a MetaWear board's command tells its arguments: forms with braces, and what a word becomes."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

from armspan.devices.metawear.sessions import Steps
from armspan.errors import DeviceError, known_names

Writes: TypeAlias = bytes | tuple[bytes, ...] | Steps

_NUMBER: Final = r"-?\d+(?:\.\d+)?"
_WORDS: Final = {"mode": r"\w+", "preset": r"\w+?", "colour": r"[a-z]+", "stream": r"\w+?", "feature": r"\w+"}
_TEXTS: Final = {"name": ".+", "outputs": r"[a-z_+]+", "payload": r"[0-9A-Fa-f]*"} | _WORDS
_HEX: Final = ("acc", "gyro", "mag", "payload")
_ABBREVIATED: Final = {
    "quat": "quaternion",
    "linacc": "linear_acc",
    "gyro": "corrected_gyro",
    "acc": "corrected_acc",
    "mag": "corrected_mag",
    "quaternion": "quaternion",
}


@dataclass(frozen=True, slots=True)
class Rule:
    """Names of one form; ``optional`` arguments have these values where they are not told."""

    form: str
    encode: Callable[..., Writes]
    optional: Mapping[str, Any] = field(default_factory=dict)

    @property
    def arguments(self) -> list[str]:
        """In the order of the form."""
        return re.findall(r"\{(\w+)\}", self.form)

    @property
    def short(self) -> str:
        """The name without its arguments."""
        words = (part for part in re.split(r"[.+](?![^{]*\})", self.form) if "{" not in part)
        return ".".join(words)

    @property
    def pattern(self) -> str:
        """What its names match."""
        literal = re.escape(self.form).replace(r"\{", "{").replace(r"\}", "}")
        return re.sub(r"\{(\w+)\}", lambda m: f"(?P<{m[1]}>{_TEXTS.get(m[1], _NUMBER)})", literal)


def checked(rule: Rule, told: Mapping[str, Any]) -> dict[str, Any]:
    """A rule's arguments as its encoder takes them; DeviceError for one that is missing, unknown or no number."""
    known = {*rule.arguments, *rule.optional}
    missing = [key for key in rule.arguments if key not in told]
    if missing:
        raise DeviceError(f"{rule.short} needs {', '.join(missing)}; its name in full is {rule.form}")
    for key in told:
        if key not in known:
            raise DeviceError(known_names(f"{rule.short}'s argument", key, known))
    return {key: _value(key, value) for key, value in told.items()}


def _value(key: str, value: Any) -> Any:
    """An argument as its encoder takes it."""
    if key in _HEX:
        return octets(key, value)
    if key == "outputs":
        return [_ABBREVIATED.get(word, word) for word in str(value).split("+")]
    if key in _TEXTS:
        return str(value)
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise DeviceError(f"{key} is {value!r}; expected a number") from None
    return int(number) if number.is_integer() else number


def octets(what: str, text: Any) -> bytes:
    """Bytes from hexadecimal digits, with or without blanks between them.

    Raises:
        DeviceError: where they are none.

    """
    try:
        return bytes.fromhex(str(text).replace(":", " "))
    except ValueError:
        raise DeviceError(f"{what} is {str(text)[:40]!r}; expected pairs of hexadecimal digits") from None
