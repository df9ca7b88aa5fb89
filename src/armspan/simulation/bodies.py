"""The bodies of virtual Cellulo robots: how they answer to their motors, and to each other.

The plant's defaults follow EPFL's logs of real robots (chili-epfl/CelluloV2, Controller/Analysis, 2022).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armspan.frames import Array
from armspan.records import Vec2
from armspan.simulation.contacts import Discs, Mask

FASTEST = 0.33 * math.sqrt(2.0)
"""The fastest that a robot can be told to move [m/s]: the wire's limit on both axes."""


STALL, STALL_GRAMS, SLOWED = 0.051, 100.0, 0.25
"""A weight of 100 g: the told speed [m/s] up to which it stalls a robot, and the share of all speeds that it takes."""


@dataclass(frozen=True, slots=True)
class Plant:
    """What lies between a robot's firmware and the world: motors, camera and radio.

    ``lag`` [s] of the speed's first-order answer; ``gain`` the range from which each robot's own is drawn;
    ``dead_zone`` [m/s] below which a told speed does nothing; ``saturation`` [m/s] and ``turn_saturation``
    [rad/s] the fastest; ``position_noise`` [m] and ``heading_noise`` [rad] the camera's, standard deviations;
    ``frame`` [s] from one picture to the next; ``latency`` [s] the range of the radio's, each way;
    ``broadcast_period`` [s] of the pose; ``radius`` [m] of the body.
    """

    lag: float = 0.1
    gain: Vec2 = (0.6, 1.0)
    dead_zone: float = 0.015
    saturation: float = 0.160
    turn_saturation: float = 7.5
    position_noise: float = 0.03e-3
    heading_noise: float = math.radians(0.3)
    frame: float = 0.011
    latency: Vec2 = (0.005, 0.030)
    broadcast_period: float = 0.020
    radius: float = 0.043


class Bodies:
    """n robots on the table: ``pose`` and ``velocity`` (3, n) in ``sheet`` [m, m, rad] and [m/s, m/s, rad/s].

    ``lifted`` (n,) tells which are in somebody's hand; ``gain`` and ``dead_zone`` (n,) are each robot's own.
    """

    def __init__(self, xy: ArrayLike, heading: ArrayLike, plant: Plant, rng: np.random.Generator) -> None:
        self.pose: Array = np.vstack([np.asarray(xy, dtype=float).T, np.asarray(heading, dtype=float)])
        n = self.pose.shape[1]
        self.velocity: Array = np.zeros((3, n))
        self.lifted: Mask = np.zeros(n, dtype=bool)
        low, high = plant.gain
        self.gain: Array = rng.uniform(low, high, size=(n,))
        self._slowed: Array = np.ones(n)
        self.dead_zone: Array = np.full(n, plant.dead_zone)
        self.discs = Discs(plant.radius, min(plant.saturation, FASTEST) * plant.frame)
        self._plant = plant
        self._keep = math.exp(-plant.frame / plant.lag) if plant.lag > 0 else 0.0
        self._coast = plant.lag * (1.0 - self._keep)

    def move(self, told: Array) -> None:
        """Move for one frame with motors told a velocity (3, n) in ``sheet`` [m/s, rad/s]."""
        target = self._answer(told)
        lead = self.velocity - target
        self.pose += target * self._plant.frame + lead * self._coast
        self.velocity = target + lead * self._keep
        self.discs.part(self.pose[:2], self.velocity[:2], ~self.lifted)

    def _answer(self, told: Array) -> Array:
        """The velocity (3, n) that the motors settle at."""
        plant = self._plant
        speed = np.hypot(told[0], told[1])
        share = np.minimum(self.gain, plant.saturation / np.maximum(speed, 1e-9))
        target: Array = told * (share * (speed >= self.dead_zone))
        turn = told[2] * self.gain
        target[2] = np.minimum(np.maximum(turn, -plant.turn_saturation), plant.turn_saturation)
        target *= ~self.lifted
        return target

    def nudge(self, robot: int, extra: ArrayLike, seconds: float) -> None:
        """What a velocity ``extra`` (3,) [m/s, rad/s], told for part of a frame, adds to where a robot is."""
        target = np.asarray(extra, dtype=float) * (self.gain[robot] * (not self.lifted[robot]))
        lag = self._plant.lag
        keep = math.exp(-seconds / lag) if lag > 0 else 0.0
        self.pose[:, robot] += target * (seconds - lag * (1.0 - keep))
        self.velocity[:, robot] += target * (1.0 - keep)

    def load(self, robot: int, grams: float) -> None:
        """Lay a weight on a robot: 100 g and it no longer starts at 50 mm/s, as EPFL's logs tell; slower is a guess."""
        free, share = self._plant.dead_zone, grams / STALL_GRAMS
        slowed = max(1.0 - SLOWED * share, 0.01)
        self.dead_zone[robot] = free + (STALL - free) * share
        self.gain[robot] *= slowed / self._slowed[robot]
        self._slowed[robot] = slowed

    def lift(self, robot: int) -> None:
        """Take a robot off the table."""
        self.lifted[robot] = True
        self.velocity[:, robot] = 0.0

    def put_down(self, robot: int, xy: Vec2, heading: float) -> None:
        """Put a robot on the table, at rest."""
        self.lifted[robot] = False
        self.pose[:, robot] = *xy, heading
        self.velocity[:, robot] = 0.0
        self.discs.disturb()
