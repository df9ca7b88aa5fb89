"""Point to choose, gesture to command: the robots chosen last."""

from dataclasses import dataclass, field


@dataclass(slots=True)
class Choice:
    """Robots that the next gesture is for; each stays chosen for ``seconds``."""

    seconds: float
    _chosen: dict[str, float] = field(default_factory=dict)

    def add(self, t: float, robot: str) -> None:
        """A robot was chosen at ``t`` [s]."""
        self._chosen[robot] = t

    def take(self, t: float) -> list[str]:
        """The robots that are chosen at ``t`` [s], in the order of choice; a choice counts once."""
        chosen = [robot for robot, since in self._chosen.items() if t - since <= self.seconds]
        self._chosen.clear()
        return chosen
