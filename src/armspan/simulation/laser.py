"""A virtual laser on the wrist: where its beam truly goes, which is not quite where it was mounted to go."""

from dataclasses import dataclass

import numpy as np

from armspan.frames import Array
from armspan.records import Vec2, Vec3
from armspan.simulation.figure import Pose

_OFF_DEG, _OFF_M = 2.0, 0.004


@dataclass(frozen=True, slots=True)
class LaserTraits:
    """How a laser truly sits: ``position`` [m] in ``wrist``, ``aim`` [rad] to the left and up of the forearm.

    ``spot`` [m] is the beam's radius (1/e²) at the wrist, ``divergence`` [rad] by how much it widens on its way.
    """

    position: Vec3 = (0.0, 0.0, 0.0)
    aim: Vec2 = (0.0, 0.0)
    spot: float = 0.002
    divergence: float = 0.0006


def draw_laser(rng: np.random.Generator, position: Vec3, aim: Vec2) -> LaserTraits:
    """A laser strapped on with care: 2 degrees and 4 mm off (standard deviations per axis) where it should be."""
    off = np.radians(_OFF_DEG) * rng.standard_normal(2)
    x, y, z = (np.array(position) + _OFF_M * rng.standard_normal(3)).tolist()
    left, up = (np.array(aim) + off).tolist()
    return LaserTraits((x, y, z), (left, up))


class VirtualLaser:
    """A laser that shines all the time, on the wrist of the arm that points."""

    def __init__(self, traits: LaserTraits) -> None:
        self.traits = traits
        left, up = traits.aim
        self._position: Array = np.array(traits.position)
        self._direction: Array = np.array([np.cos(up) * np.cos(left), np.cos(up) * np.sin(left), np.sin(up)])

    def rays(self, pose: Pose) -> tuple[Array, Array]:
        """Origins (m, 3) [m] and unit directions (m, 3) of the beam in ``room``."""
        return pose.wrist + pose.room_from_forearm @ self._position, pose.room_from_forearm @ self._direction

    def width(self, distance: Array) -> Array:
        """The beam's radius [m] at distances [m] from the laser."""
        return np.asarray(self.traits.spot + self.traits.divergence * distance)
