"""Steady hits out of chattering ones: a spot at a receptor's rim comes and goes many times a second. Pure."""

import math
from dataclasses import dataclass, field

from armspan.records import Hit


@dataclass(slots=True)
class Steady:
    """Turns what receptors say into `Hit` records; ``chatter`` and ``expire`` [s] as in the room file.

    A hit is told at once. That it is over is told ``chatter`` later, with the time at which it was; not at all where
    there was a new hit by then. With ``expire`` above 0 a hit that is not repeated is over by itself.
    """

    chatter: float
    expire: float
    _on: dict[str, float] = field(default_factory=dict)
    _lost: dict[str, float] = field(default_factory=dict)

    def take(self, t: float, robot: str, on: bool) -> list[Hit]:
        """What a receptor says at ``t`` [s]."""
        told = self.advance(t)
        if not on:
            if robot in self._on:
                self._lost.setdefault(robot, t)
            return told
        fresh = robot not in self._on
        self._lost.pop(robot, None)
        self._on[robot] = t
        return [*told, Hit(t, robot, True)] if fresh else told

    def advance(self, t: float) -> list[Hit]:
        """What is over by ``t`` [s]."""
        return [self._end(robot, since) for due, since, robot in self._ends() if due <= t]

    def due(self) -> float:
        """When something will be over if nothing more is said [s]."""
        return min((due for due, _, _ in self._ends()), default=math.inf)

    def clear(self, t: float) -> list[Hit]:
        """All hits are over at ``t`` [s]: nobody is there to say so."""
        return [self._end(robot, t) for robot in sorted(self._on)]

    def _ends(self) -> list[tuple[float, float, str]]:
        """When each hit's end is to be told, when it was, and the robot; in order."""
        ends: list[tuple[float, float, str]] = []
        for robot, said in self._on.items():
            lost = self._lost.get(robot)
            if lost is not None:
                ends.append((lost + self.chatter, lost, robot))
            elif self.expire > 0.0:
                ends.append((said + self.expire, said + self.expire, robot))
        return sorted(ends)

    def _end(self, robot: str, t: float) -> Hit:
        self._on.pop(robot)
        self._lost.pop(robot, None)
        return Hit(t, robot, False)
