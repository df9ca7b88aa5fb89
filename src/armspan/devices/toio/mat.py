"""Emulated cubes on a mat: two wheels each, as they drive, slip and are late; who touches whom; what a camera reads."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armspan.devices.toio.cube import Cube, Note, Sight
from armspan.devices.toio.quantities import MATS, UNIT_M, WHEELS_APART_M, speed_of
from armspan.frames import Array
from armspan.records import Vec2
from armspan.simulation.contacts import Discs, Mask

FRAME_S = 0.01
FASTEST = 0.35
JUST = 1e-9


@dataclass(frozen=True, slots=True)
class Chassis:
    """What lies between the motors and the mat, and between the mat and the camera.

    ``lag`` [s] of the wheels' first-order answer; ``gain`` the range from which each cube's own is drawn, and
    ``mismatch`` the standard deviation of a wheel's; ``noise`` the camera's, in position IDs and in degrees;
    ``radius`` [m] round the corners of the body, a square of 31.8 mm.
    """

    lag: float = 0.1
    gain: Vec2 = (0.92, 1.02)
    mismatch: float = 0.02
    noise: Vec2 = (0.5, 1.0)
    radius: float = 0.0225


class Mat:
    """n cubes: places ``xy`` (n, 2) [m] from the mat's top left corner, headings (n,) [rad] clockwise from above.

    ``mat`` names one of Sony's. The cubes' cameras read no position IDs beyond it.
    """

    def __init__(
        self,
        xy: ArrayLike,
        heading: ArrayLike,
        rng: np.random.Generator,
        chassis: Chassis | None = None,
        mat: str = "ring",
    ) -> None:
        self.chassis = chassis or Chassis()
        self.pose: Array = np.vstack([np.asarray(xy, dtype=float).T, np.asarray(heading, dtype=float)])
        n = self.pose.shape[1]
        self.cubes = [Cube() for _ in range(n)]
        self.lifted: Mask = np.zeros(n, dtype=bool)
        gain, self._noise = rng.spawn(2)
        self.gain: Array = gain.uniform(*self.chassis.gain, n) * gain.normal(1.0, self.chassis.mismatch, (2, n))
        self.discs = Discs(self.chassis.radius, FASTEST * FRAME_S)
        self.velocity: Array = np.zeros((2, n))
        self._wheels: Array = np.zeros((2, n))
        self._keep = math.exp(-FRAME_S / self.chassis.lag) if self.chassis.lag > 0 else 0.0
        self._corner, self._end = (np.array(corner) for corner in MATS[mat])
        self._frames = 0

    @property
    def contacts(self) -> int:
        """How often two cubes came to touch."""
        return self.discs.contacts

    def advance(self, t: float) -> list[tuple[float, int, Note]]:
        """Run to ``t`` [s]: when, which cube, and what it notified, in order."""
        told: list[tuple[float, int, Note]] = []
        while self._frames * FRAME_S <= t + JUST:
            at = self._frames * FRAME_S
            if self._frames:
                self._move()
            sights = self._sights()
            for i, (cube, sight) in enumerate(zip(self.cubes, sights, strict=True)):
                told += [(at, i, note) for note in cube.frame(at, sight)]
            self._frames += 1
        return told

    def truth(self) -> tuple[Array, Array, Array]:
        """Real places (n, 2) [m], headings (n,) [rad] and velocities (n, 2) [m/s], from the mat's corner."""
        return self.pose[:2].T.copy(), self.pose[2] % (2.0 * math.pi), self.velocity.T.copy()

    def lift(self, cube: int) -> None:
        """Take a cube off the mat."""
        self.lifted[cube] = True
        self._wheels[:, cube] = self.velocity[:, cube] = 0.0

    def put_down(self, cube: int, xy: Vec2, heading: float) -> None:
        """Put a cube on the mat, at rest, at ``xy`` [m] and ``heading`` [rad]."""
        self.lifted[cube] = False
        self.pose[:, cube] = *xy, heading
        self.discs.disturb()

    def _move(self) -> None:
        """One frame: the wheels near what they were told, and carry the cubes along an arc."""
        told = np.array([[speed_of(value) for value in cube.wheels] for cube in self.cubes]).T.reshape(2, -1)
        target = told * self.gain * ~self.lifted
        before, self._wheels = self._wheels, target + (self._wheels - target) * self._keep
        left, right = (before + self._wheels) / 2
        speed, turn = (left + right) / 2, (left - right) / WHEELS_APART_M
        middle = self.pose[2] + turn * FRAME_S / 2
        self.velocity = speed * np.stack([np.cos(middle), np.sin(middle)])
        self.pose[:2] += self.velocity * FRAME_S
        self.pose[2] += turn * FRAME_S
        self.discs.part(self.pose[:2], self.velocity, ~self.lifted)

    def _sights(self) -> list[Sight | None]:
        n = len(self.cubes)
        place = self._corner[:, None] + self.pose[:2] / UNIT_M
        seen = ((place >= self._corner[:, None]) & (place <= self._end[:, None])).all(axis=0) & ~self.lifted
        noisy = np.rint(np.maximum(place + self._noise.normal(0.0, self.chassis.noise[0], (2, n)), 0.0))
        angle = np.rint(np.degrees(self.pose[2]) + self._noise.normal(0.0, self.chassis.noise[1], n)) % 360
        rows = np.vstack([noisy, angle]).astype(int).T.tolist()
        return [(x, y, turned) if ok else None for (x, y, turned), ok in zip(rows, seen.tolist(), strict=True)]
