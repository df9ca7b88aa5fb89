"""Virtual receptors: photodiodes on the robots' tops that notice a laser's spot, late, and now and then wrongly."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from armspan.frames import Array
from armspan.records import Hit, Vec2
from armspan.simulation.laser import VirtualLaser

SAMPLE_S = 0.01
"""How often [s] a receptor looks."""


@dataclass(frozen=True, slots=True)
class ReceptorTraits:
    """How receptors are built.

    ``radius`` [m] is that of the level disc that gathers light; of the beam it takes the share that falls on it times
    the sine of the beam's elevation, and notices ``threshold`` of it. It answers after ``response`` [s, from and to],
    drawn for each receptor, to light and to darkness alike; the message is on its way for ``late`` [s]. A share
    ``missed`` of its looks sees nothing; stray light is noticed ``stray`` times a second for ``stray_s`` [s].
    """

    radius: float = 0.02
    threshold: float = 0.15
    response: Vec2 = (0.02, 0.05)
    late: Vec2 = (0.003, 0.015)
    missed: float = 0.02
    stray: float = 1 / 120
    stray_s: Vec2 = (0.05, 0.3)


class VirtualReceptors:
    """Receptors on the robots named; ``advance`` tells what they noticed."""

    def __init__(self, robots: Sequence[str], traits: ReceptorTraits, rng: np.random.Generator) -> None:
        self.robots, self.traits = tuple(robots), traits
        n = len(self.robots)
        self._rng = rng
        self._response: Array = rng.uniform(*traits.response, n)
        self._lit = np.zeros(n, dtype=bool)
        self._told = np.zeros(n, dtype=bool)
        self._changed: Array = np.full(n, -np.inf)
        self._stray_until: Array = np.full(n, -np.inf)

    def advance(
        self, times: Array, laser: VirtualLaser, rays: tuple[Array, Array], places: Array
    ) -> list[tuple[float, Hit]]:
        """What arrives, as (arrival, hit), of looks at ``times`` (m,) [s] along rays (m, 3), (m, 3) in ``room``.

        ``places`` (n, 3) [m] are the receptors' middles in ``room``.
        """
        lit = self._seen(laser, rays, places)
        told: list[tuple[float, Hit]] = []
        for t, beam in zip(times.tolist(), lit, strict=True):
            told.extend(self._look(t, beam))
        return told

    def _seen(self, laser: VirtualLaser, rays: tuple[Array, Array], places: Array) -> NDArray[np.bool_]:
        """Whether the beam is noticed, (m, n)."""
        origins, directions = rays
        sine = -directions[:, 2:]
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (origins[:, 2:] - places[:, 2]) / sine
        at = origins[:, None] + reach[..., None] * directions[:, None]
        beside = np.hypot(at[..., 0] - places[:, 0], at[..., 1] - places[:, 1])
        width = laser.width(np.abs(reach)) / 2.0  # 1/e² is at two standard deviations
        caught = ndtr((self.traits.radius - beside) / width) * sine
        return np.asarray((reach > 0.0) & (sine > 0.0) & (caught > self.traits.threshold))

    def _look(self, t: float, beam: NDArray[np.bool_]) -> list[tuple[float, Hit]]:
        n, traits = len(self.robots), self.traits
        missed, strays, lasts = self._rng.uniform(size=(3, n))
        began = strays < traits.stray * SAMPLE_S
        low, high = traits.stray_s
        self._stray_until = np.where(began, t + low + lasts * (high - low), self._stray_until)
        lit = (beam & (missed >= traits.missed)) | (t < self._stray_until)
        self._changed = np.where(lit != self._lit, t, self._changed)
        self._lit = lit
        due = (lit != self._told) & (t - self._changed >= self._response)
        self._told = np.where(due, lit, self._told)
        return [self._message(t, int(number)) for number in np.flatnonzero(due)]

    def _message(self, t: float, number: int) -> tuple[float, Hit]:
        late = float(self._rng.uniform(*self.traits.late))
        return t + late, Hit(t, self.robots[number], bool(self._told[number]))
