"""The six coloured lights of a Cellulo robot: effects 0 to 9, faded 100 times a second, 12 bits a colour.

Recorded from EPFL's firmware (chili-epfl/CelluloV2, led.c) run in an emulator; the responses to touch and hold are from
its source. Which corner is light 0, and which way they count, is unknown.
"""

from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Colours: TypeAlias = NDArray[np.int64]

LEDS = 6
TICKS_PER_SECOND = 100
TOP = 4095
BOOT = 0x600
TOUCHED = 0x800
HELD = (0, 128 * TOP // 255, 0)
FADE, SLOW_FADE = 10, 25
FLASH_TICKS = 30
BLINK_TICKS_PER_VALUE = 2
BREATHE_TICKS = {False: 200, True: 40}  # dim, bright
STEP_TICKS = 14


class Effect(IntEnum):
    """The visual effects by the firmware's numbers."""

    CONST_ALL = 0
    CONST_SINGLE = 1
    ALERT_ALL = 2
    ALERT_SINGLE = 3
    PROGRESS = 4
    WAITING = 5
    DIRECTION = 6
    BLINK = 7
    BREATHE = 8
    PULSE = 9


MOVING = (Effect.WAITING, Effect.BLINK, Effect.BREATHE, Effect.PULSE)


class Lights:
    """The lights of one robot: ``now`` (6, 3) is what is seen, 0 to 4095."""

    def __init__(self, boot: int = BOOT) -> None:
        self.now: Colours = np.full((LEDS, 3), boot)
        self._goal = self.now.copy()
        self._other = self.now.copy()  # the colours to go back to, of an effect that alternates
        self._effect = Effect.CONST_ALL
        self._colour: Colours = self.now[0].copy()
        self._ticks = self._count = self._limit = 0
        self._lit = False
        self._steady = True
        self._alert: Alert | None = None

    def show(self, effect: Effect, colour: Sequence[int], value: int = 0) -> None:
        """Start an effect in a colour (3,) of 0 to 255; an alert while another one runs is ignored."""
        shade = np.asarray(colour) * TOP // 255
        if effect in (Effect.ALERT_ALL, Effect.ALERT_SINGLE):
            self._alert = self._alert or Alert(effect, shade, value, self.now)
            self.now = self._alert.now
            return
        if self._alert is not None:
            self.now, self._alert = self._alert.before, None
        if self._effect in MOVING:
            self._goal = self.now.copy()
        self._effect, self._colour, self._steady = effect, shade, False
        self._count, self._lit = 0, effect is not Effect.BREATHE
        self._begin(value)

    def seen(self, touched: Iterable[int] = (), held: bool = False) -> Colours:
        """The colours (6, 3) with the response to a hand: brighter where touched, green while held."""
        if held:
            return np.broadcast_to(np.array(HELD), (LEDS, 3)).copy()
        colours = self.now.copy()
        for led in touched:
            colours[led] = np.minimum(colours[led] + TOUCHED, TOP)
        return colours

    def advance(self, tick: int) -> None:
        """Run to the given tick, a hundredth of a second each."""
        while self._ticks < tick and not (self._steady and self._alert is None):
            self._ticks += 1
            self._tick()
        self._ticks = max(self._ticks, tick)

    def _begin(self, value: int) -> None:
        match self._effect:
            case Effect.CONST_ALL:
                self._goal[:] = self._colour
            case Effect.CONST_SINGLE if value < LEDS:  # beyond, the robot writes somewhere else in its memory
                self._goal[value] = self._colour
            case Effect.PROGRESS:
                share = np.clip(LEDS * value / 255 - np.arange(LEDS), 0.0, 1.0)
                self._goal = np.floor(share[:, None] * self._colour).astype(np.int64)
            case Effect.DIRECTION:
                self._point(value)
            case Effect.BLINK:
                self._limit = BLINK_TICKS_PER_VALUE * (value or 15)
                self.now[:] = self._colour
            case Effect.PULSE:
                self._other = self.now.copy()
                self._goal[:] = self._colour

    def _point(self, value: int) -> None:
        """Towards ``value``/256 of a turn, with the firmware's fault: one light, the next one untouched."""
        led, rest = divmod(LEDS * value, 256)
        keep = self._goal[(led + 1) % LEDS].copy()
        self._goal[:] = 0
        self._goal[(led + 1) % LEDS] = keep
        self._goal[led] = self._colour * rest // 256

    def _tick(self) -> None:
        if self._alert is not None:
            if self._alert.tick():
                return
            self.now, self._alert = self._alert.before, None
        match self._effect:
            case Effect.BLINK:
                self._toggle(self._limit)
                self.now[:] = self._colour if self._lit else 0
            case Effect.WAITING:
                self._walk()
                self._fade(FADE)
            case Effect.BREATHE:
                self._breathe()
            case Effect.PULSE:
                self._pulse()
            case _:
                self._steady = not self._fade(FADE)

    def _fade(self, inertia: int) -> bool:
        """Go a tick nearer to the goal, rounding down; False once nothing changes."""
        before = self.now
        self.now = (inertia * before + self._goal) // (inertia + 1)
        return not np.array_equal(before, self.now)

    def _toggle(self, limit: int) -> None:
        self._count += 1
        if self._count > limit:
            self._count, self._lit = 0, not self._lit

    def _walk(self) -> None:
        """A spot that walks over the ring: cross-faded from one light to the next."""
        led, rest = divmod(self._count, STEP_TICKS)
        on = self._colour * rest // (STEP_TICKS - 1)
        self._goal[:] = 0
        self._goal[led % LEDS], self._goal[(led + 1) % LEDS] = self._colour - on, on
        if led % LEDS == LEDS - 1:  # the firmware fades light 0 twice here, first as a dark one
            self.now[0] = FADE * self.now[0] // (FADE + 1)
        self._count += 1

    def _breathe(self) -> None:
        self._toggle(BREATHE_TICKS[self._lit])
        self._goal[:] = self._colour if self._lit else self._colour // 4
        self._fade(FADE)

    def _pulse(self) -> None:
        if not self._fade(SLOW_FADE):
            self._goal, self._other = self._other, self._goal


class Alert:
    """Flashes over whatever else is shown: 300 ms the colour, 300 ms what was there ``before``."""

    def __init__(self, effect: Effect, colour: Colours, value: int, before: Colours) -> None:
        single = effect is Effect.ALERT_SINGLE
        self.before = before.copy()
        self.now = before
        self._left = value >> 4 if single else value
        self._led = slice(value & 15, (value & 15) + 1) if single else slice(None)
        self._colour, self._count, self._lit = colour, 0, True
        self.now[self._led] = colour

    def tick(self) -> bool:
        """Go on by a tick; False when it is over."""
        self._count += 1
        if self._count > FLASH_TICKS:
            self._count, self._lit = 0, not self._lit
            self._left -= self._lit
        self.now[self._led] = self._colour if self._lit else self.before[self._led]
        return self._left > 0
