"""What one arm is asked for, one posture after the other, blended into one movement."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from armspan.frames import Array
from armspan.simulation.arm import unit
from armspan.simulation.figure import FOREARM
from armspan.simulation.fluctuation import Fluctuation
from armspan.simulation.movement import minimum_jerk

_REACH = (0.6, 1.0)
_FAR = np.pi / 3.0


class Posture(Protocol):
    """An arm's posture as a function of time."""

    def at(self, times: Array, waver: Array) -> Array:
        """The posture (20, m), its rows named in `figure`, at ``times`` (m,) [s]."""


@dataclass(frozen=True, slots=True)
class _Stage:
    """A posture that the arm is taken to from ``start`` [s] on, in ``duration`` [s].

    ``forearm`` (3,) is where the forearm then points, to tell how far the next movement goes.
    """

    posture: Posture
    forearm: Array
    start: float
    duration: float

    @property
    def end(self) -> float:
        return self.start + self.duration


class Staging:
    """The postures of one arm, which wavers by ``waver``; the first one is held from ``start`` [s] on."""

    def __init__(self, posture: Posture, waver: Fluctuation, start: float) -> None:
        self._waver = waver
        self._stages = [_Stage(posture, self._forearm(posture, start), start, 0.0)]

    @property
    def posture(self) -> Posture:
        """The posture asked for last."""
        return self._stages[-1].posture

    @property
    def start(self) -> float:
        """When the arm sets out for it [s]."""
        return self._stages[-1].start

    @property
    def end(self) -> float:
        """When the arm has reached it [s]."""
        return self._stages[-1].end

    def begin(self, t: float, posture: Posture, start: float) -> None:
        """Told at ``t`` [s], take the arm to ``posture`` from ``start`` [s] on, but not before it set out last."""
        start = max(start, self._stages[-1].start)
        forearm = self._forearm(posture, t)
        angle = float(np.arccos(np.clip(forearm @ self._stages[-1].forearm, -1.0, 1.0)))
        duration = _REACH[0] + min(1.0, angle / _FAR) * (_REACH[1] - _REACH[0])
        self._stages.append(_Stage(posture, forearm, start, duration))

    def at(self, times: Array, waver: Array) -> Array:
        """The posture (20, m) at ``times`` (m,) [s]."""
        # Each stage adds its share of the way from the one before, so that an early change of mind blends.
        first, last = times.min(), times.max()
        done = max(i for i, stage in enumerate(self._stages) if i == 0 or stage.end <= first)
        posture = before = self._stages[done].posture.at(times, waver)
        for stage in self._stages[done + 1 :]:
            if stage.start >= last:
                break
            after = stage.posture.at(times, waver)
            posture = posture + minimum_jerk((times - stage.start) / stage.duration) * (after - before)
            before = after
        return posture

    def forget(self, before: float) -> list[Posture]:
        """Forget what was over ``before`` [s]; the postures that are left."""
        while len(self._stages) > 1 and self._stages[1].end <= before:
            del self._stages[0]
        return [stage.posture for stage in self._stages]

    def _forearm(self, posture: Posture, t: float) -> Array:
        now = np.array([t])
        return np.asarray(unit(posture.at(now, self._waver.at(now))[FOREARM])[:, 0])
