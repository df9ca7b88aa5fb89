"""Robots whose receptors see the laser: since when, what that is worth, and when it is a choice."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from armspan.frames import Array
from armspan.pointing.laser import LaserSettings
from armspan.pointing.selection import Candidate, Candidates
from armspan.records import Hit

FLICKER = 0.4
"""Darkness [s] that does not end a hold: an arm that is held still wavers by half a receptor."""


@dataclass(slots=True)
class Hits:
    """What the receptors say, robot by robot; robots that are not among ``laser.receptors`` are not listened to."""

    laser: LaserSettings
    _lit: dict[str, float] = field(default_factory=dict)
    _dark: dict[str, float] = field(default_factory=dict)
    _chosen: set[str] = field(default_factory=set)
    _released: set[str] = field(default_factory=set)

    def take(self, hit: Hit) -> None:
        """Light or darkness begins."""
        if hit.robot not in self.laser.receptors:
            return
        if hit.on:
            self._lit.setdefault(hit.robot, hit.t)
        elif self._lit.pop(hit.robot, None) is not None:
            self._dark[hit.robot] = hit.t

    def tick(self, t: float, *, leading: bool = False) -> None:
        """Release what was chosen by a hit and has been dark for long enough; what is hit while ``leading`` is spent.

        In the set-up the spot goes where it is led to.
        """
        if leading:
            self._chosen.update(self._lit)
        for robot in sorted(self._chosen):
            if robot not in self._lit and t - self._dark.get(robot, -math.inf) >= self.laser.release_s:
                self._chosen.discard(robot)
                self._released.add(robot)

    def heard(self, robot: str) -> bool:
        """Whether a robot's receptor has seen anything yet."""
        return robot in self._lit or robot in self._dark

    def sees(self, t: float, robot: str) -> bool:
        """Whether a robot is hit at ``t`` [s], but for a flicker."""
        return robot in self._lit or t - self._dark.get(robot, -math.inf) < FLICKER

    def odds(self, robots: Sequence[Candidate]) -> Array:
        """How much likelier (n,) what each robot's receptor says is if that robot is meant than if it is not."""
        known = self.laser.receptors
        return np.array(
            [self.laser.odds(robot.robot in self._lit) if robot.robot in known else 1.0 for robot in robots]
        )

    def best(self, candidates: Candidates, elsewhere: float) -> tuple[Candidate, float]:
        """The best candidate and its posterior by the receptors alone."""
        posterior = candidates.by_receptors(elsewhere, self.odds(candidates.robots))
        index = int(np.argmax(posterior))
        return candidates.name(index), float(posterior[index])

    def due(self, t: float, best: Candidate, *, already: bool) -> bool:
        """Whether the best candidate is chosen by a hit now; ``already`` it was chosen and has not been left since."""
        robot = best.robot
        if robot is None or robot not in self._lit or robot in self._chosen:
            return False
        if t - self._lit[robot] < self.laser.dwell_s - 1e-6 or (already and robot not in self._released):
            return False
        self._chosen.add(robot)
        self._released.discard(robot)
        return True
