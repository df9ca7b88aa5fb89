"""What a laser on the virtual wrist brings about: a dot for the person to see, light for the receptors."""

from collections.abc import Callable

import numpy as np

from armspan.frames import Array
from armspan.records import Hit
from armspan.simulation.dot import Dot
from armspan.simulation.laser import VirtualLaser
from armspan.simulation.person import VirtualPerson
from armspan.simulation.receptors import SAMPLE_S, VirtualReceptors


class Beam:
    """A laser with those who notice it; without ``receptors`` that is the person alone."""

    def __init__(self, laser: VirtualLaser, receptors: VirtualReceptors | None = None) -> None:
        self.laser, self.receptors, self.dot = laser, receptors, Dot()
        self._looks = 0

    def advance(self, t: float, person: VirtualPerson, place_of: Callable[[str], Array]) -> list[tuple[float, Hit]]:
        """What the receptors tell up to ``t`` [s], as (arrival, hit), while they are where ``place_of`` says."""
        upto = int(np.floor(t / SAMPLE_S + 1e-6)) + 1
        times: Array = SAMPLE_S * np.arange(self._looks, upto, dtype=float)
        self._looks = upto
        if not len(times):
            return []
        rays = self.laser.rays(person.pose(times))
        self.dot.look(float(times[-1]), rays[0][-1], rays[1][-1])
        if self.receptors is None or not self.receptors.robots:
            return []
        places = np.array([place_of(robot) for robot in self.receptors.robots])
        return self.receptors.advance(times, self.laser, rays, places)
