"""How briskly each robot answers, learnt from how it drives, and how far ahead its goals may therefore lie.

Cellulo's firmware drives at 2 mm/s for each 0.508 mm that are left to its goal (chili-epfl/CelluloV2, motion.c), as
far as its motors go along: real robots reach 0.6 to 1.0 of that (EPFL's logs). When goals stop coming, a sluggish one
takes longer to come to rest from the same distance. So its goals are nearer: the leads were found on the model of the
firmware, as what is below 25 mm/s within 0.5 s at any heading, with a tenth to spare.
"""

import numpy as np
from numpy.typing import NDArray

from armspan.frames import Array

TAPER = 2.0 / 0.508
"""Speed [1/s] for each metre that is left to the goal."""

SLUGGISH, SLUGGISH_LEAD, LEAD_PER_GAIN = 0.6, 0.032, 0.045
"""The least share of its told speed that a robot is taken to reach, its lead [m], and how the lead grows with it."""

_WINDOW = 0.2
_SETTLED = 0.3
_NEW = 0.3


class Answers:
    """The share of its told speed that each robot reaches; ``delay`` [s] is between a state and the goal made of it."""

    def __init__(self, lead: float, delay: float) -> None:
        self._most, self._delay = lead, delay
        self.gain: Array = np.zeros(0)
        self._free: Array = np.zeros(0)
        self._from: Array = np.zeros((0, 3))

    def know(self, n: int) -> None:
        """Make room for n robots."""
        more = n - len(self.gain)
        if more > 0:
            self.gain = np.append(self.gain, np.full(more, SLUGGISH))
            self._free = np.append(self._free, np.full(more, np.inf))
            self._from = np.vstack([self._from, np.full((more, 3), np.nan)])

    def lead(self, rows: NDArray[np.intp]) -> Array:
        """How far ahead (n,) [m] the goals of robots may lie."""
        lead = SLUGGISH_LEAD + LEAD_PER_GAIN * (self.gain[rows] - SLUGGISH)
        return np.minimum(np.maximum(lead, SLUGGISH_LEAD), self._most)

    def learn(self, rows: NDArray[np.intp], seen: Array, told: Array, free: NDArray[np.bool_]) -> None:
        """Learn from where robots are: ``seen`` (n, 3) as x, y [m] and t [s]; ``told`` (n,) [m/s] is their speed.

        ``free`` (n,) tells which were sent straight ahead by the whole lead.
        """
        t = seen[:, 2]
        since = np.where(free, np.minimum(self._free[rows], t), np.inf)
        self._free[rows] = since
        settled = free & (t >= since + _SETTLED)
        begun = ~np.isnan(self._from[rows, 2])
        span = t - np.where(begun, self._from[rows, 2], t)
        over = settled & begun & (span >= _WINDOW)
        moved = np.hypot(*(seen[:, :2] - self._from[rows, :2]).T)
        speed = np.where(over, moved, 0.0) / np.where(over, span, 1.0)
        left = np.maximum(self.lead(rows) - speed * self._delay, 0.001)
        gain = np.clip(speed / np.maximum(np.minimum(told, TAPER * left), 1e-6), 0.0, 1.5)
        self.gain[rows] = np.where(over, self.gain[rows] + _NEW * (gain - self.gain[rows]), self.gain[rows])
        start = over | (settled & ~begun)
        self._from[rows] = np.where(start[:, None], seen, np.where(settled[:, None], self._from[rows], np.nan))
