"""Which of a Cellulo's six corners has which number: three of EPFL's own programs disagree, so it is a setting.

Armspan counts a robot's lights and keys clockwise as seen from above, light 0 being the first corner at or clockwise
after straight ahead. The robot's own number 0 is somewhere else, and its count may go the other way round.
"""

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

from armspan.errors import ConfigError

CORNERS = 6
STEP_DEG = 360.0 / CORNERS

Turn: TypeAlias = Literal["clockwise", "counterclockwise"]


@dataclass(frozen=True, slots=True)
class Ring:
    """The robot's number 0 sits at ``zero_deg``, clockwise from straight ahead; its count goes round by ``turn``.

    Raises:
        ConfigError: for an angle that is none.

    """

    zero_deg: float = 0.0
    turn: Turn = "clockwise"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.zero_deg) and abs(self.zero_deg) <= 360.0):
            raise ConfigError(f"led_zero_deg is {self.zero_deg}; expected degrees from -360 to 360")

    @property
    def first_deg(self) -> float:
        """Where Armspan's light 0 sits, clockwise from straight ahead [degrees]: 0 to less than 60."""
        return self.zero_deg % STEP_DEG

    def robots_own(self, number: int) -> int:
        """The robot's number of the corner that Armspan calls ``number``."""
        return self._other(number)

    def armspans(self, number: int) -> int:
        """Armspan's number of the corner that the robot calls ``number``."""
        return (number + self._start) % CORNERS if self.turn == "clockwise" else self._other(number)

    @property
    def _start(self) -> int:
        return math.floor(self.zero_deg / STEP_DEG)

    def _other(self, number: int) -> int:
        """The other count's number; a count that goes the other way round is its own reverse."""
        return (number - self._start if self.turn == "clockwise" else self._start - number) % CORNERS
