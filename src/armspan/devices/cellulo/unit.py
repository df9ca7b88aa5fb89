"""What one emulated Cellulo robot has beside its motion: receiver, lights, keys, battery, settings, power."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from armspan.devices.cellulo.keys import Keys
from armspan.devices.cellulo.wire import COMMANDS, Decoder
from armspan.frames import Array
from armspan.simulation.bezier import Chain
from armspan.simulation.lights import Colours, Effect, Lights

GREEN, YELLOW, RED = (0, 255, 0), (255, 255, 0), (255, 0, 0)
LOW = 1
ALERTS = {0: (YELLOW, 2), LOW: (RED, 10), 2: (GREEN, 2), 3: (GREEN, 4)}
"""The flashes of a battery's state."""
LAST_WORDS_S = 5.7
"""Seconds from a low battery to its last words."""
TOUCH_RESPONSE, NO_RESPONSE, HOLD_RESPONSE = 0, 1, 2


@dataclass(slots=True)
class Unit:
    """One robot; ``feels`` is whether it tells a hold, ``wheels`` (3,) [mm/s, rad/s] what raw PWM turned it to."""

    ears: Decoder = field(default_factory=lambda: Decoder(COMMANDS))
    lights: Lights = field(default_factory=Lights)
    keys: Keys = field(default_factory=Keys)
    chain: Chain = field(default_factory=Chain)
    battery: int = 0
    response: int = TOUCH_RESPONSE
    exposure: int = 0
    feels: bool = False
    held: bool = False
    sampling: bool = False
    wanted_picture: bool = False
    wheels: Array = field(default_factory=lambda: np.zeros(3))
    wheels_since: float = 0.0
    deaf: int = 0
    asleep: bool = False
    fading: bool = False

    def show(self, tick: int, effect: Effect, colour: Sequence[int], value: int = 0) -> None:
        """Start a visual effect."""
        self.lights.advance(tick)
        self.lights.show(effect, colour, value)

    def seen(self, tick: int) -> Colours:
        """What a person sees of its lights (6, 3), 0 to 4095."""
        self.lights.advance(tick)
        if self.asleep or self.fading:
            return self.lights.now
        touched = self.keys.touched if self.response == TOUCH_RESPONSE else ()
        return self.lights.seen(touched, self.response == HOLD_RESPONSE and self.held)

    def fade(self, tick: int) -> None:
        """Let the lights go out, and everything with them."""
        self.show(tick, Effect.CONST_ALL, (0, 0, 0))
        self.fading = True

    def dark(self, tick: int) -> bool:
        """Whether the lights are out now; it then sleeps."""
        self.lights.advance(tick)
        self.asleep = not self.lights.now.any()
        return self.asleep

    def start(self, deaf: int, cold: bool) -> None:
        """Have the settings of a boot; after a cold one, the lights too."""
        self.ears, self.chain, self.deaf = Decoder(COMMANDS), Chain(), deaf
        self.response, self.exposure = TOUCH_RESPONSE, 0
        self.feels = self.held = self.wanted_picture = self.asleep = self.fading = False
        if cold:
            self.lights = Lights()
