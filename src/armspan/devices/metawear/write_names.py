"""The name of a write that a host sent to a MetaWear board, found again by encoding the names that could be it."""

import struct
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Final, TypeAlias

from armspan.devices.metawear import quantities as q
from armspan.devices.metawear.commands import PLAIN
from armspan.devices.metawear.names import encode
from armspan.devices.metawear.signals import LED_COLOURS, LED_PRESETS
from armspan.devices.metawear.wire import MAG_PRESETS
from armspan.errors import DeviceError

_Guess: TypeAlias = tuple[str, dict[str, Any]]
_PARTS: Final[Mapping[bytes, str]] = {
    b"\x19\x01\x01": "fusion on",
    b"\x19\x01\x00": "fusion off",
    b"\x19\x03\x00\x7f": "fusion outputs: none",
}


def name_of_write(write: bytes, board: str) -> str | None:
    """What a write to a named board is, in the words of `names`; None where no name gives it."""
    if write in _PARTS:
        return _PARTS[write]
    if write[:2] == b"\x19\x03" and len(write) == 4 and 0 < write[2] < 0x80 and not write[3]:
        return f"fusion outputs: {', '.join(output for bit, output in enumerate(q.OUTPUTS) if write[2] >> bit & 1)}"
    return _table(board).get(write) or _guessed(write, board)


def _guessed(write: bytes, board: str) -> str | None:
    try:
        name, args = _GUESSES[write[:2]](write[2:])
        writes = [one for _, several in encode(name, board, args) for one in several]
    except (DeviceError, struct.error, UnicodeDecodeError, LookupError):
        return None
    if write not in writes:
        return None
    beside = "".join(f" {key}={value}" for key, value in args.items())
    return name + beside + (", a part of it" if len(writes) > 1 else "")


@cache
def _table(board: str) -> dict[bytes, str]:
    """The writes that stand alone and have few numbers; the shortest name of each."""
    table: dict[bytes, str] = {}
    acc = [f"acc.config.{hz:g}Hz.{g}g" for hz in q.ACC_RATES_HZ for g in q.ACC_RANGES_G]
    gyro = [f"gyro.config.{hz:g}Hz.{dps}dps" for hz in q.GYRO_RATES_HZ for dps in q.GYRO_RANGES_DPS]
    for name in sorted((*PLAIN, *acc, *gyro), key=len):
        try:
            writes = [one for _, several in encode(name, board) for one in several]
        except DeviceError:  # a board without it
            continue
        if len(writes) == 1:
            table.setdefault(writes[0], name)
    return table


def _fusion(rest: bytes) -> _Guess:
    mode, g, dps = list(q.MODES)[rest[0]], q.ACC_RANGES_G[rest[1] & 15], q.GYRO_RANGES_DPS[(rest[1] >> 4) - 1]
    return f"fusion.config.{mode}.{g}g.{dps}dps", {}


def _repetitions(rest: bytes) -> _Guess:
    told = (rest[0] * 2 + 1, rest[1] + 1)
    (name, *_) = [name for name, (xy, z, _) in MAG_PRESETS.items() if (xy, z) == told] or [""]
    return f"mag.preset.{name}", {}


def _led(rest: bytes) -> _Guess:
    colour, _, *levels = rest[:4]
    *times, delay, repeat = struct.unpack("<5HB", rest[4:])
    (preset, *_) = [name for name, told in LED_PRESETS.items() if [*levels, *times] == list(told)] or [""]
    return f"led.pattern.{preset}.{list(LED_COLOURS)[colour]}", {"delay_ms": delay, "repeat": repeat}


def _haptic(rest: bytes) -> _Guess:
    strength, duration, kind = struct.unpack("<BHB", rest)
    return f"haptic.buzzer.{duration}ms" if kind else f"haptic.motor.{-(-strength * 100 // 248)}pct.{duration}ms", {}


def _connection(rest: bytes) -> _Guess:
    least, most, latency, timeout = struct.unpack("<4H", rest)
    return f"settings.conn_params.{least * 1.25:g}_{most * 1.25:g}_{latency}_{timeout * 10}", {}


_GUESSES: Final[Mapping[bytes, Callable[[bytes], _Guess]]] = {
    b"\x19\x02": _fusion,
    b"\x15\x04": _repetitions,
    b"\x02\x03": _led,
    b"\x08\x01": _haptic,
    b"\x11\x09": _connection,
    b"\x11\x01": lambda rest: (f"settings.name.{rest.decode('ascii')}", {}),
    b"\x11\x03": lambda rest: (f"settings.tx_power.{struct.unpack('b', rest)[0]}", {}),
}
