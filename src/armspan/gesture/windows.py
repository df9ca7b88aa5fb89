"""Windows that end now: cut from takes and from everyday motion, as live spotting will see them.

A gesture's windows end in its last 60 %, when enough of it has been seen; windows that end in its first quarter are
null still, and those between belong to neither. What came before a take is unknown and is taken from the null
recordings, else the first sample is held.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armspan.frames import Array
from armspan.gesture.channels import Channels
from armspan.gesture.grid import bridge, cells, on_grid
from armspan.gesture.takes import NULL, Take

SEEN, UNSEEN = 0.4, 0.25
"""Share of a gesture after which its label is expected, and up to which it is not."""

_AFTER = 0.6


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """A take on the grid: channels (k, d), NaN in gaps; ``start`` and ``end`` of the gesture in grid points."""

    take: Take
    values: Array
    start: float
    end: float

    @property
    def label(self) -> str:
        """The take's label."""
        return self.take.label


def clip(take: Take, channels: Channels, rate: float) -> Clip:
    """A take brought onto the grid of ``rate`` [Hz]."""
    times, values = derived(take, channels)
    first, last = cells(rate, times[0], times[-1])
    start, end = (moment * rate - first for moment in take.span)
    return Clip(take, on_grid(times, values, rate, first, last), max(start, 0.0), min(end, last - first - 1.0))


def derived(take: Take, channels: Channels) -> tuple[Array, Array]:
    """Times (n,) and channels (n, d) of a take, short gaps bridged and what is missing still left out."""
    values = bridge(take.times, take.values)
    whole = np.isfinite(values).all(axis=1)
    return take.times[whole], channels(values[whole])


def windows(values: Array, length: int, ends: Sequence[int] | NDArray[np.intp]) -> Array:
    """Windows (n, d, length) of ``values`` (k, d), each ending with grid point ``ends``."""
    if not len(ends):
        return np.empty((0, values.shape[1], length))
    view = np.lib.stride_tricks.sliding_window_view(values, length, axis=0)
    return np.ascontiguousarray(view[np.asarray(ends) - length + 1])


def gesture_windows(
    part: Clip, length: int, hop: int, before: Sequence[Array], rng: np.random.Generator
) -> tuple[Array, list[str]]:
    """Windows (n, d, length) that end within a gesture, and their labels: its own, or null at its beginning."""
    values, added = _with_past(part.values, length, before, rng)
    long = part.end - part.start
    ends = range(int(np.ceil(part.start)), len(part.values), hop)
    seen = [e for e in ends if part.start + SEEN * long <= e <= part.end + 1]
    if not seen:
        seen = [int(part.end)]
    unseen = [e for e in ends if e <= part.start + UNSEEN * long]
    late = [e for e in ends if e > part.end + _AFTER * length]
    cut = windows(values, length, [e + added for e in (*seen, *unseen, *late)])
    labels = [part.label] * len(seen) + [NULL] * (len(unseen) + len(late))
    return _finite(cut, labels)


def null_windows(values: Array, length: int, hop: int) -> Array:
    """Windows (n, d, length) of everyday motion, every ``hop`` grid points."""
    if len(values) < length:
        return np.empty((0, values.shape[1], length))
    return _finite(windows(values, length, range(length - 1, len(values), hop)), [])[0]


def _with_past(values: Array, length: int, before: Sequence[Array], rng: np.random.Generator) -> tuple[Array, int]:
    """``values`` with a window's length before them, and how many grid points that added."""
    usable = [past for past in before if len(past) >= length]
    if usable:
        past = usable[int(rng.integers(len(usable)))]
        at = int(rng.integers(len(past) - length + 1))
        past = past[at : at + length]
        if np.isfinite(past).all():
            return np.concatenate([past, values]), length
    return np.concatenate([np.repeat(values[:1], length, axis=0), values]), length


def _finite(cut: Array, labels: list[str]) -> tuple[Array, list[str]]:
    whole = np.isfinite(cut).all(axis=(1, 2))
    return cut[whole], [label for label, kept in zip(labels, np.atleast_1d(whole), strict=False) if kept]
