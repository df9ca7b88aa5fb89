"""Takes as arrays for whole-take classifiers, and as clips on a grid for spotting."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from armspan.frames import Array
from armspan.gesture.channels import Channels
from armspan.gesture.grid import stretched
from armspan.gesture.takes import NULL, Take
from armspan.gesture.windows import Clip, clip, derived

GRID = 32.0
"""Rate [Hz] of the grid on which windows lie, where the samples are that fast: arms move below 10 Hz."""

HOP = 0.125
OWN_WEIGHT = 4
"""How often an own take counts beside those of others (4 and 12 do equally well, 1 a little worse)."""

LENGTHS = (16, 256)
WINDOWS = (1.0, 2.5)

_MARGIN = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Dataset:
    """Checked takes of one set of columns, gestures and null apart.

    Of the gestures the first ``own`` are those of the people the model is for; the others only help, and theirs count
    once where an own take counts `OWN_WEIGHT` times.
    """

    gestures: list[Take]
    nulls: list[Take]
    columns: tuple[str, ...]
    own: int

    @classmethod
    def of(cls, takes: Sequence[Take], others: Sequence[Take] = ()) -> "Dataset":
        """The data set of takes that `check_takes` let pass."""
        own = [take for take in takes if take.label != NULL]
        more = [replace(take, person=f"other {take.person}") for take in others if take.label != NULL]
        nulls = [take for take in (*takes, *others) if take.label == NULL]
        return cls([*own, *more], nulls, takes[0].columns, len(own))

    @property
    def weights(self) -> list[int]:
        """How often each gesture counts."""
        weight = OWN_WEIGHT if self.own < len(self.gestures) else 1
        return [weight] * self.own + [1] * (len(self.gestures) - self.own)

    @property
    def channels(self) -> Channels:
        """What models see of its columns."""
        return Channels(self.columns)

    @property
    def labels(self) -> tuple[str, ...]:
        """Its gestures."""
        return tuple(sorted({take.label for take in self.gestures}))

    @property
    def rate(self) -> float:
        """The takes' usual rate [Hz]."""
        return float(np.median([take.rate for take in (*self.gestures, *self.nulls)]))

    @property
    def null_seconds(self) -> float:
        """How much everyday motion there is."""
        return sum(take.seconds for take in self.nulls)

    def take_length(self) -> int:
        """How many points takes are brought to: the usual number of samples of a gesture."""
        usual = float(np.median([_part(take).seconds * take.rate + 1 for take in self.gestures]))
        return int(np.clip(round(usual), *LENGTHS))

    def window_seconds(self) -> float:
        """How long a window is: a usual gesture, within what can be waited for."""
        usual = float(np.median([take.span[1] - take.span[0] for take in self.gestures]))
        return float(np.clip(usual, *WINDOWS))


def take_array(takes: Sequence[Take], channels: Channels, length: int) -> Array:
    """Takes as (n, channels, length), each stretched over its gesture."""
    return np.stack([stretched(*derived(_part(take), channels), length).T for take in takes])


def clips(takes: Sequence[Take], channels: Channels, grid: float) -> list[Clip]:
    """Takes on the grid."""
    return [clip(take, channels, grid) for take in takes]


def _part(take: Take) -> Take:
    """The take round its gesture, where that is known."""
    if take.gesture is None:
        return take
    start, end = take.gesture
    part = take.between(start - _MARGIN, end + _MARGIN)
    return part if len(part.times) >= 8 else take
