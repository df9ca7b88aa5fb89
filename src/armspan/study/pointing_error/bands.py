"""What a second band on the upper arm is worth: the same gestures read with one and with two."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armspan.records import Model
from armspan.study.pointing_error.monte_carlo import TABLE, stop_shares
from armspan.study.pointing_error.recordings import Gestures
from armspan.study.pointing_error.trials import CORNERS, EDGES, MIDDLE, Misses, many_draws
from armspan.study.pointing_error.virtual import nine_places, virtual_gestures

MODELS: tuple[tuple[str, Model], ...] = (("one band", "head-finger"), ("two bands", "two-band"))

REAL_PLACES = nine_places((2.85, 0.0), 1.0, 0.49)
"""About where the real people's low targets lie [m]: their eyes were 0.35 m behind the room's middle."""

DESK_PLACES = TABLE.places(stop_shares(9))


@dataclass(frozen=True, slots=True)
class BandRow:
    """Who pointed where, and the misses with one band and with two."""

    who: str
    simulated: bool
    one: Misses
    two: Misses

    def document(self) -> dict[str, object]:
        """For JSON."""
        one, two = self.one.document(), self.two.document()
        return {"who": self.who, "simulated": self.simulated, "one_band": one, "two_bands": two}


def compare(
    who: str, people: Sequence[Gestures], *, simulated: bool, rng: np.random.Generator, draws: int = 20
) -> BandRow:
    """Calibrate on a gesture at each corner, test on the five other places."""
    tests = (*EDGES, MIDDLE)
    one, two = (many_draws(people, lambda _: CORNERS, tests, model, rng, draws=draws) for _, model in MODELS)
    return BandRow(who, simulated, one, two)


def virtual_crowds(rng: np.random.Generator, people: int) -> dict[str, list[Gestures]]:
    """New people, by what they were asked for and where they pointed."""
    asked = {
        "natural arm, 1.5 to 3.5 m": ("natural", REAL_PLACES),
        "straight arm, 1.5 to 3.5 m": ("straight", REAL_PLACES),
        "natural arm, table at 1 m": ("natural", DESK_PLACES),
        "straight arm, table at 1 m": ("straight", DESK_PLACES),
    }
    return {
        name: [virtual_gestures(rng, "natural" if posture == "natural" else "straight", places) for _ in range(people)]
        for name, (posture, places) in asked.items()
    }
