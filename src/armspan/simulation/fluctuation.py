"""Smooth random processes: the sway, the tremor and the slow drifts that nobody commands.

A process is a sum of sinusoids with drawn frequencies and phases, so that it is infinitely smooth, can be
evaluated at any time in any order, and depends on nothing but the generator it was drawn from.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armspan.frames import Array


@dataclass(frozen=True, slots=True)
class Band:
    """One process: ``sd`` (in its own unit) over ``tones`` sinusoids from ``low`` to ``high`` [Hz].

    The power is the same in every octave; several bands may share a ``row``, which then adds them up.
    """

    row: int
    sd: float
    low: float
    high: float
    tones: int


class Fluctuation:
    """Independent zero-mean processes, one a row, drawn once and then a function of time only."""

    def __init__(self, bands: Sequence[Band], rows: int, rng: np.random.Generator) -> None:
        rates: list[float] = []
        self._weights = np.zeros((rows, sum(band.tones for band in bands)))
        for band in bands:
            first = len(rates)
            rates.extend(_spread(band, rng))
            self._weights[band.row, first : len(rates)] = band.sd * np.sqrt(2.0 / band.tones)
        self._rates = 2.0 * np.pi * np.array(rates)[:, None]
        self._phases = rng.uniform(0.0, 2.0 * np.pi, (len(rates), 1))

    def at(self, times: Array) -> Array:
        """The processes (rows, m) at ``times`` (m,) [s]."""
        return np.asarray(self._weights @ np.sin(self._rates * times + self._phases))


def _spread(band: Band, rng: np.random.Generator) -> list[float]:
    # One tone somewhere in each equal share of the octaves: no two people, and no two axes, keep step.
    shares = (np.arange(band.tones) + rng.uniform(0.0, 1.0, band.tones)) / band.tones
    return [float(rate) for rate in band.low * (band.high / band.low) ** shares]
