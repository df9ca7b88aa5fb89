"""Takes: one recorded gesture each, or a stretch of everyday motion, as named columns over one clock.

A take's columns are named by who delivers them: ``right_qx`` .. ``right_qw`` is the right band's attitude
``user_from_wrist`` as (x, y, z, w), ``right_ax`` .. its linear acceleration without gravity [m/s²],
``right_gx`` .. its rate [rad/s], both in ``user``; ``left_`` likewise. Any other columns are channels as they stand.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armspan.errors import DataError
from armspan.frames import Array

SEVEN = ("x_left_high", "x_right_high", "raise_both", "mixing", "stop", "arms_to_ground", "breaststroke")
INITIAL = "initial"
NULL = "null"
"""Everything that is no gesture."""

GAP = 0.5
"""Longest gap [s] in a gesture that is bridged by a straight line; a longer one may have hidden the gesture."""

RATE_TOLERANCE = 0.2
_JUMP = 2.0
_STILL = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class Take:
    """One recording: ``times`` (n,) [s], rising, and ``values`` (n, c), NaN where a sample is missing.

    ``gesture`` are start and end [s] of the gesture where they are known; ``source`` tells where the take comes from.
    """

    label: str
    person: str
    number: int
    columns: tuple[str, ...]
    times: Array
    values: Array
    practice: bool = False
    gesture: tuple[float, float] | None = None
    source: str = ""

    @property
    def name(self) -> str:
        """The take's name for messages."""
        return self.source or f"{self.label}/{self.person}_{self.number:02d}"

    @property
    def seconds(self) -> float:
        """How long it is."""
        return float(self.times[-1] - self.times[0]) if len(self.times) else 0.0

    @property
    def rate(self) -> float:
        """Samples a second: the median's, so that gaps do not count."""
        return float(1.0 / np.median(np.diff(self.times)))

    @property
    def span(self) -> tuple[float, float]:
        """Start and end [s] of the gesture: as known, or the whole take."""
        return self.gesture or (float(self.times[0]), float(self.times[-1]))

    def picked(self, columns: Sequence[str]) -> "Take":
        """The take with these columns only, in this order."""
        places = [self.columns.index(name) for name in columns]
        return replace(self, columns=tuple(columns), values=self.values[:, places])

    def between(self, start: float, end: float) -> "Take":
        """The part from ``start`` to ``end`` [s]."""
        kept = (self.times >= start) & (self.times <= end)
        return replace(self, times=self.times[kept], values=self.values[kept])


def check_takes(takes: Sequence[Take]) -> list[Take]:
    """Takes that can be learnt from, in one set of columns: practice takes left out.

    Raises:
        DataError: the first thing that is wrong with them, in one sentence.

    """
    used = [take for take in takes if not take.practice]
    if not used:
        raise DataError(
            "there is no take to learn from" + (" (practice takes are not used)" if takes else "") + ": record some "
            "with `armspan record`"
        )
    _check_labels(used)
    for take in used:
        check_clock(take)
    _check_columns(used)
    _check_rates(used)
    for take in used:
        check_values(take)
    _check_motion(used)
    return [take.picked(used[0].columns) for take in used]


def check_clock(take: Take) -> None:
    """Refuse a take that is too short, or whose clock runs back or leaps (DataError)."""
    if len(take.times) < 8:
        raise DataError(f"{take.name} has {len(take.times)} samples; a take needs 8 at least: record it again")
    steps = np.diff(take.times)
    if steps.min() <= 0:
        row = int(np.argmin(steps)) + 1
        raise DataError(
            f"{take.name}: the clock jumps back from {take.times[row - 1]:g} to {take.times[row]:g} s at sample "
            f"{row + 1}; times must rise: record the take again, or mend or delete it"
        )
    if take.label != NULL and steps.max() > max(_JUMP, 3 * float(np.median(steps))):
        row = int(np.argmax(steps)) + 1
        raise DataError(
            f"{take.name}: the clock jumps from {take.times[row - 1]:g} to {take.times[row]:g} s at sample {row + 1}; "
            "a take is one stretch of time: record it again, or trim or delete it"
        )


def check_values(take: Take) -> None:
    """Refuse a take in which a column is empty, or a gesture with a long gap (DataError)."""
    missing = ~np.isfinite(take.values)
    empty = [name for name, column in zip(take.columns, missing.T, strict=True) if column.all()]
    if empty:
        raise DataError(
            f"{take.name} holds no number in {_listed(empty)}: a band that did not send, or NaN throughout; record it "
            "again, or delete it"
        )
    if take.label == NULL:
        return
    for name, column in zip(take.columns, missing.T, strict=True):
        longest = longest_gap(take.times, column)
        if longest > GAP:
            raise DataError(
                f"{take.name}: {name} is missing for {longest:.2f} s; gaps of up to {GAP:g} s can be bridged: record "
                "the take again, or delete it"
            )


def longest_gap(times: Array, missing: NDArray[np.bool_]) -> float:
    """The longest stretch [s] between two samples that are there, in a column with ``missing`` (n,) ones."""
    there = times[~missing]
    edges = np.concatenate([times[:1], there, times[-1:]])
    return float(np.max(np.diff(edges), initial=0.0)) if missing.any() else 0.0


def labels_of(takes: Sequence[Take]) -> list[str]:
    """The gestures of some takes, sorted, without null."""
    return sorted({take.label for take in takes} - {NULL})


def _check_labels(takes: Sequence[Take]) -> None:
    labels = sorted({take.label for take in takes})
    by_lower: dict[str, str] = {}
    for label in labels:
        other = by_lower.setdefault(label.lower(), label)
        if other != label:
            raise DataError(f"labels {other!r} and {label!r} differ by case only: give both folders one name")


def _check_columns(takes: Sequence[Take]) -> None:
    whole = max(takes, key=lambda take: len(take.columns))
    for take in takes:
        lacking = [name for name in whole.columns if name not in take.columns]
        extra = [name for name in take.columns if name not in whole.columns]
        if lacking or extra:
            what = f"lacks {_listed(lacking)}, which {whole.name} has" if lacking else f"has {_listed(extra)} besides"
            raise DataError(
                f"{take.name} {what}: all takes need the same columns; record it again with all bands, delete it, or "
                "train on one band with --bands"
            )


def _check_rates(takes: Sequence[Take]) -> None:
    usual = float(np.median([take.rate for take in takes]))
    for take in takes:
        if abs(take.rate / usual - 1.0) > RATE_TOLERANCE:
            raise DataError(
                f"{take.name} was recorded at {take.rate:.3g} Hz, the others at {usual:.3g} Hz: takes of one set need "
                "one rate; record it again, or delete it"
            )


def _check_motion(takes: Sequence[Take]) -> None:
    moved = [float(np.nanmax(np.nanstd(take.values, axis=0))) for take in takes]
    by_label: dict[str, list[float]] = {}
    for take, amount in zip(takes, moved, strict=True):
        by_label.setdefault(take.label, []).append(amount)
    for take, amount in zip(takes, moved, strict=True):
        usual = float(np.median(by_label[take.label]))
        # A held pose is a gesture too, so still means still beside the other takes of the same label.
        if amount <= 1e-9 or (take.label not in (NULL, INITIAL) and amount < _STILL * usual):
            raise DataError(
                f"{take.name} shows no motion: was the band worn and sending? Record it again, or delete it"
            )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
