"""What the wearer of an emulated board sees and feels: LED and motor."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

LampColour: TypeAlias = Literal["green", "red", "blue"]
COLOURS: tuple[LampColour, ...] = ("green", "red", "blue")
PATTERN = 15
"""Bytes of a pattern, with its colour before it."""
FULL_MOTOR, FULL_BUZZER = 0xF8, 0x7F


@dataclass(frozen=True, slots=True)
class Buzz:
    """What the motor or the buzzer was told at ``t`` [s]: ``strength`` 0 to 1 for ``duration`` [s]."""

    t: float
    strength: float
    duration: float
    buzzer: bool


@dataclass(slots=True)
class Lamp:
    """The LED: the patterns by colour, as written behind the colour, and whether they play."""

    patterns: dict[LampColour, bytes] = field(default_factory=dict)
    playing: bool = False
    plays_at_once: bool = False

    def write(self, register: int, data: bytes) -> None:
        """A write to 01 (0 pause, 1 play, 2 play what is written), 02 (stop; 1 clears too) or 03 (a pattern)."""
        if register == 0x01 and data:
            self.playing = data[0] == 1 or (data[0] == 2 and bool(self.patterns))
            self.plays_at_once = data[0] == 2
        elif register == 0x02 and data:
            self.playing = False
            if data[0] == 1:
                self.patterns.clear()
        elif register == 0x03 and len(data) >= PATTERN and data[0] < len(COLOURS):
            self.patterns[COLOURS[data[0]]] = data[1:]
            self.playing = self.playing or self.plays_at_once


def buzzes(register: int, data: bytes, t: float) -> Iterator[Buzz]:
    """A write to 01 of the haptic module: strength, duration [ms], 0 for the motor and 1 for the buzzer."""
    if register == 0x01 and len(data) >= 4:
        strength, millis, kind = struct.unpack("<BHB", data[:4])
        full = FULL_BUZZER if kind == 1 else FULL_MOTOR
        yield Buzz(t, min(1.0, strength / full), millis / 1000.0, kind == 1)
