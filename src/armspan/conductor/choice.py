"""Point to choose, gesture to command: the robots and the zone chosen last."""

import math
from dataclasses import dataclass, field


@dataclass(slots=True)
class Choice:
    """Robots that the next gesture is for, and the zone that it is about; each stays chosen for ``seconds``."""

    seconds: float
    _chosen: dict[str, float] = field(default_factory=dict)
    _zone: tuple[str, float] = ("", -math.inf)

    def add(self, t: float, robot: str) -> None:
        """A robot was chosen at ``t`` [s]."""
        self._chosen[robot] = t

    def add_zone(self, t: float, zone: str) -> None:
        """A zone was chosen at ``t`` [s], in the place of the one before."""
        self._zone = (zone, t)

    def take(self, t: float) -> tuple[list[str], str]:
        """The robots that are chosen at ``t`` [s], in the order of choice, and the zone; a choice counts once."""
        chosen = [robot for robot, since in self._chosen.items() if t - since <= self.seconds]
        zone, since = self._zone
        self._chosen.clear()
        self._zone = ("", -math.inf)
        return chosen, zone if t - since <= self.seconds else ""
