"""What one person misses by, as a field over the directions they point in.

People repeat a gesture to half a degree or so, but miss by more, and by the same again in the same direction:
the head turns with the arm, the elbow bends, the band sits askew. In natural pointing of 13 people (Dalsgaard's
open recordings) about 0.7 of the variance that a person's constant offset leaves belongs to the target, 0.3 to
the single gesture; for the forearm of a bent arm it is the same. A Gaussian process learns the part that
repeats from every confirmed choice, as far as the place has not taken it up already.
"""

from dataclasses import dataclass, field

import numpy as np

from armspan.frames import Array

REPEATED = 0.3
"""Share of the variance of misses that comes again in the same direction and that the place does not take up."""

REACH = float(np.radians(12.0))
"""Angle [rad] over which misses are alike."""

MEMORY = 40
"""Confirmed choices that are kept, the latest ones."""


@dataclass(slots=True)
class MissField:
    """Misses (2,) [rad, to the left and upward of the ray] as a function of the ray's direction in ``user``.

    Everything is told in units of the person's noise, so that the field keeps its shape when that is learnt.
    """

    directions: list[Array] = field(default_factory=list)
    misses: list[Array] = field(default_factory=list)
    doubts: list[float] = field(default_factory=list)
    _inverse: Array | None = None

    def at(self, direction: Array) -> tuple[Array, float]:
        """The miss (2,) [rad] to expect in a direction (3,), and the share of the variance that stays."""
        if self._inverse is None:
            return np.zeros(2), 1.0
        alike = REPEATED * _alike(np.array(self.directions), direction)
        pull = self._inverse @ alike
        return np.asarray(pull @ np.array(self.misses)), float(1.0 - alike @ pull)

    def learn(self, direction: Array, miss: Array, doubt: float) -> None:
        """Remember that a ray (3,) missed by (2,) [rad]; ``doubt`` is its own variance, 1 being all of a miss's."""
        self.directions = [*self.directions, direction][-MEMORY:]
        self.misses = [*self.misses, miss][-MEMORY:]
        self.doubts = [*self.doubts, doubt][-MEMORY:]
        known = np.array(self.directions)
        alike = REPEATED * np.stack([_alike(known, one) for one in known])
        own = np.diag(1.0 - REPEATED + np.array(self.doubts))
        self._inverse = np.asarray(np.linalg.inv(alike + own), dtype=float)


def _alike(directions: Array, direction: Array) -> Array:
    """How alike misses in directions (n, 3) are to those in one (3,): 1 for the same."""
    apart = np.sum((directions - direction) ** 2, axis=1)
    return np.asarray(np.exp(-0.5 * apart / REACH**2))
