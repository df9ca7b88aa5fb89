"""From a take's columns to the channels that models see, heading-free where attitudes are known.

Where a band's four ``q`` columns are there, its vectors are written in its own wrist frame, and gravity's direction
joins them: what remains does not change when the person turns about the vertical, nor when a heading drifts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armspan.frames import Array, rotation_from_quaternion

_AXES = "xyz"


@dataclass(frozen=True, slots=True)
class Band:
    """The columns with one prefix (``right``, ``left``, ...), and where they lie among all columns."""

    prefix: str
    columns: tuple[str, ...]
    places: tuple[int, ...]

    @property
    def attitude(self) -> list[int] | None:
        """Places of qw, qx, qy, qz among the band's own columns, or None without attitude."""
        names = [f"{self.prefix}_q{axis}" for axis in "wxyz"]
        return [self.columns.index(name) for name in names] if set(names) <= set(self.columns) else None

    def vectors(self) -> list[tuple[str, list[int]]]:
        """The complete vectors among the band's columns: name and places."""
        stems = sorted({name[:-1] for name in self.columns if name[-1] in _AXES and not name[:-1].endswith("_q")})
        found = [(stem, [stem + axis for axis in _AXES]) for stem in stems]
        return [
            (stem, [self.columns.index(name) for name in names])
            for stem, names in found
            if set(names) <= set(self.columns)
        ]

    def channels(self, values: Array) -> Array:
        """Channels (n, d) of the band's columns ``values`` (n, c)."""
        attitude = self.attitude
        if attitude is None:
            return values
        wxyz = values[:, attitude]
        user_from_wrist = rotation_from_quaternion(wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True))
        parts = [user_from_wrist[:, 2, :]]  # earth's up, written in the wrist
        parts += [np.einsum("nji,nj->ni", user_from_wrist, values[:, places]) for _, places in self.vectors()]
        used = {*attitude, *(place for _, places in self.vectors() for place in places)}
        parts.append(values[:, [k for k in range(len(self.columns)) if k not in used]])
        return np.concatenate(parts, axis=1)

    def groups(self) -> list[str]:
        """The sensor that each channel belongs to: channels of one sensor share one scale."""
        if self.attitude is None:
            return [sensor_of(name) for name in self.columns]
        vectors = self.vectors()
        used = {name for _, places in vectors for name in (self.columns[k] for k in places)}
        left = [name for name in self.columns if name not in used and not name.startswith(f"{self.prefix}_q")]
        return [f"{self.prefix}_up"] * 3 + [stem for stem, _ in vectors for _ in _AXES] + [sensor_of(n) for n in left]


@dataclass(frozen=True, slots=True)
class Channels:
    """What a model sees of ``columns``: the bands' channels one after the other."""

    columns: tuple[str, ...]

    @property
    def bands(self) -> list[Band]:
        """The columns by prefix, in order of first appearance."""
        order: dict[str, list[int]] = {}
        for place, name in enumerate(self.columns):
            order.setdefault(prefix_of(name), []).append(place)
        return [Band(prefix, tuple(self.columns[k] for k in places), tuple(places)) for prefix, places in order.items()]

    @property
    def groups(self) -> tuple[int, ...]:
        """One number per channel; channels of one sensor share it."""
        names = [name for band in self.bands for name in band.groups()]
        numbers = {name: k for k, name in enumerate(sorted(set(names)))}
        return tuple(numbers[name] for name in names)

    @property
    def count(self) -> int:
        """How many channels there are."""
        return len(self.groups)

    def __call__(self, values: Array) -> Array:
        """Channels (n, d) of ``values`` (n, c)."""
        return np.concatenate([band.channels(values[:, list(band.places)]) for band in self.bands], axis=1)


def prefix_of(column: str) -> str:
    """Who delivers a column: what stands before its first underscore."""
    return column.partition("_")[0]


def sensor_of(column: str) -> str:
    """The sensor of a column: its name without the axis."""
    return column[:-1] if column[-1] in "xyzw" and len(column) > 1 else column


def same_columns(known: Sequence[str], given: Sequence[str]) -> list[str]:
    """Which of the ``known`` columns are not among those ``given``."""
    there = set(given)
    return [name for name in known if name not in there]
