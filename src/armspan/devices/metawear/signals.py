"""What a wearer sees and feels of a MetaWear board: its LED and its motor or buzzer.

Sources: MbientLab MetaWear-API, docs/protocol-reference.md; MetaWear-SDK-Cpp 0.30.0, test/test_led.py, test_haptic.py.
"""

import math
import struct
from collections.abc import Mapping
from typing import Final

from armspan.devices.metawear.boards import HAPTIC, LED, Board
from armspan.devices.metawear.quantities import counts, named, within

LED_COLOURS: Final[Mapping[str, int]] = {"green": 0, "red": 1, "blue": 2}
LED_PRESETS: Final[Mapping[str, tuple[int, int, int, int, int, int]]] = {
    "blink": (31, 0, 0, 50, 0, 500),
    "pulse": (31, 0, 725, 500, 725, 2000),
    "solid": (31, 31, 0, 500, 0, 1000),
}
"""High and low intensity (0 to 31); rise, high, fall time and period [ms]."""
LED_PLAYS: Final[Mapping[str, bytes]] = {
    "play": b"\x02\x01\x01",
    "autoplay": b"\x02\x01\x02",
    "pause": b"\x02\x01\x00",
    "stop": b"\x02\x02\x00",
    "stop_and_clear": b"\x02\x02\x01",
}
FOREVER: Final = 0xFF


def led_pattern(
    board: Board,
    colour: str,
    levels: tuple[int, int],
    times_ms: tuple[int, int, int, int],
    *,
    delay_ms: int = 0,
    repeat: int = FOREVER,
) -> bytes:
    """A colour's pattern: high and low level (0 to 31); rise, high, fall, period [ms]; then delay and repetitions.

    A LED of revision 0 knows no delay. Clear before a new pattern; colours add up.
    """
    which = LED_COLOURS[named("the LED colour", colour, LED_COLOURS)]
    high, low = (counts("a LED level", level, 0, 31) for level in levels)
    times = [counts("a LED time in ms", time, 0, 0xFFFF) for time in (*times_ms, delay_ms)]
    times[-1] *= board.revision(LED) >= 1
    often = counts("LED repetitions (255: forever)", repeat, 0, 0xFF)
    return bytes((LED, 3, which, 2, high, low)) + struct.pack("<5HB", *times, often)


def led_preset(board: Board, preset: str, colour: str, *, delay_ms: int = 0, repeat: int = FOREVER) -> bytes:
    """One of LED_PRESETS in a colour."""
    high, low, *times = LED_PRESETS[named("the LED preset", preset, LED_PRESETS)]
    rise, top, fall, period = times
    return led_pattern(board, colour, (high, low), (rise, top, fall, period), delay_ms=delay_ms, repeat=repeat)


def play(what: str) -> bytes:
    """One of LED_PLAYS."""
    return LED_PLAYS[named("the LED order", what, LED_PLAYS)]


def motor(percent: float, duration_ms: int) -> bytes:
    """Let the haptic motor run at a share of its strength."""
    strength = math.floor(round(within("a haptic strength in %", percent, 0, 100) * 2.48, 9))
    return struct.pack("<BBBHB", HAPTIC, 1, strength, counts("a duration in ms", duration_ms, 0, 0xFFFF), 0)


def buzzer(duration_ms: int) -> bytes:
    """Let the buzzer sound."""
    return struct.pack("<BBBHB", HAPTIC, 1, 0x7F, counts("a duration in ms", duration_ms, 0, 0xFFFF), 1)
