"""Spotting in a stream: sample by sample while it goes on, or all at once; both say the same."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from armspan.errors import DataError, ModelError
from armspan.frames import Array
from armspan.gesture.channels import Band, same_columns
from armspan.gesture.decision import Decision, Spotted
from armspan.gesture.grid import bridge, cells, on_grid
from armspan.gesture.model import GestureModel
from armspan.gesture.takes import RATE_TOLERANCE, Take
from armspan.gesture.windows import windows

Signals: TypeAlias = Mapping[str, tuple[Array, Array]]
"""By prefix: times (n,) [s], rising, and the band's columns (n, c) in the model's order, all finite."""

_BLOCK = 64


@dataclass(slots=True, eq=False)
class _Feed:
    """What one band has sent: rows not yet looked at, and channels not yet on the grid."""

    band: Band
    times: list[float] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)
    known_times: Array = field(default_factory=lambda: np.empty(0))
    known: Array | None = None
    last: float = -np.inf

    def push(self, t: float, row: tuple[float, ...]) -> None:
        if t <= self.last:  # late or doubled packets; a clock that was set back
            return
        self.last = t
        self.times.append(t)
        self.rows.append(row)

    def cells(self, rate: float, first: int, last: int) -> Array:
        """Grid points ``first`` .. ``last`` of its channels; samples that no later cell needs are dropped."""
        fresh = self.band.channels(np.array(self.rows).reshape(-1, len(self.band.columns)))
        self.known = fresh if self.known is None else np.concatenate([self.known, fresh])
        self.known_times = np.concatenate([self.known_times, self.times])
        self.times, self.rows = [], []
        found = on_grid(self.known_times, self.known, rate, first, last)
        kept = max(0, int(np.searchsorted(self.known_times, (last - 1) / rate, side="right")) - 1)
        self.known, self.known_times = self.known[kept:], self.known_times[kept:]
        return found


class Spotter:
    """Spots gestures while samples come in: `push` each, then `advance` whenever an answer is wanted."""

    def __init__(self, model: GestureModel) -> None:
        facts = model.facts
        self.model, self.rate, self.hop = model, facts.grid_hz, facts.hop
        self.decision = Decision(facts.labels, facts.rule, facts.lead_s)
        self.probabilities: Array | None = None
        """Smoothed probabilities (labels + 1,) of the last hop, null last; None while there is no whole window."""
        self._feeds = {band.prefix: _Feed(band) for band in model.channels.bands}
        self._history = np.empty((0, model.channels.count))
        self._next: int | None = None

    @property
    def prefixes(self) -> tuple[str, ...]:
        """Who must deliver."""
        return tuple(self._feeds)

    def push(self, prefix: str, t: float, row: tuple[float, ...]) -> None:
        """One sample: the band's columns in the model's order, at ``t`` [s]."""
        self._feeds[prefix].push(t, row)

    def advance(self) -> list[Spotted]:
        """What has been spotted since the last time."""
        if self._next is None:
            starts = [feed.times[0] if feed.times else np.inf for feed in self._feeds.values()]
            if not np.isfinite(max(starts)):
                return []
            self._next = cells(self.rate, max(starts), max(starts))[0]
        last = int(np.floor(min(feed.last for feed in self._feeds.values()) * self.rate + 1e-6)) + 1
        if last <= self._next:
            return []
        parts = [feed.cells(self.rate, self._next, last) for feed in self._feeds.values()]
        first, self._next = self._next, last
        fresh = np.concatenate(parts, axis=1)
        values = np.concatenate([self._history, fresh])
        self._history = values[-self.model.window :]
        found = []
        for k in range(first, last):
            if k % self.hop == 0:
                end = len(values) - (last - k) + 1
                event = self._hop(k / self.rate, values[max(0, end - self.model.window) : end])
                found += [event] if event else []
        return found

    def _hop(self, t: float, window: Array) -> Spotted | None:
        if len(window) < self.model.window or not np.isfinite(window).all():
            self.decision.interrupt(t)
            self.probabilities = None
            return None
        event = self.decision.step(t, self.model.probabilities(window.T[None])[0])
        self.probabilities = self.decision.smooth
        return event


def spot(model: GestureModel, signals: Signals) -> list[Spotted]:
    """All gestures in a recorded stream, computed at once."""
    facts, bands = model.facts, model.channels.bands
    start = max(signals[band.prefix][0][0] for band in bands)
    end = min(signals[band.prefix][0][-1] for band in bands)
    first, last = cells(facts.grid_hz, start, end)
    parts = [
        on_grid(signals[band.prefix][0], band.channels(signals[band.prefix][1]), facts.grid_hz, first, last)
        for band in bands
    ]
    values = np.concatenate(parts, axis=1)
    ends = [k - first for k in range(first, last) if k % facts.hop == 0]
    decision = Decision(facts.labels, facts.rule, facts.lead_s)
    ready = [e for e in ends if e + 1 >= model.window]
    for block in range(0, len(ready), _BLOCK):
        _spot_block(model, decision, values, ready[block : block + _BLOCK], first)
    return decision.finish((first + len(values) - 1) / facts.grid_hz)


def _spot_block(model: GestureModel, decision: Decision, values: Array, ends: list[int], first: int) -> None:
    cut = windows(values, model.window, ends)
    whole = np.isfinite(cut).all(axis=(1, 2))
    found = iter(model.probabilities(cut[whole])) if whole.any() else iter(())
    for e, usable in zip(ends, np.atleast_1d(whole), strict=True):
        t = (e + first) / model.facts.grid_hz
        if usable:
            decision.step(t, next(found))
        else:
            decision.interrupt(t)


def signals_of(take: Take, model: GestureModel) -> dict[str, tuple[Array, Array]]:
    """A recorded stream, band by band, as the model needs it.

    Raises:
        ModelError: columns that the model needs are not there.
        DataError: a band never sent, or the samples come too slowly.

    """
    lacking = same_columns(model.facts.columns, take.columns)
    if lacking:
        raise ModelError(
            f"{take.name} lacks {', '.join(lacking[:4])}{' and more' if len(lacking) > 4 else ''}; the model was "
            f"trained on {', '.join(_briefly(model))}: give it those, or train on what there is"
        )
    if take.rate < (1 - RATE_TOLERANCE) * min(model.facts.grid_hz, model.facts.rate_hz):
        raise DataError(
            f"{take.name} comes at {take.rate:.3g} Hz; the model needs {model.facts.grid_hz:.3g} Hz at least: record "
            "it faster, or train on recordings of this rate"
        )
    values = bridge(take.times, take.picked(model.facts.columns).values)
    found = {}
    for band in model.channels.bands:
        part = values[:, list(band.places)]
        whole = np.isfinite(part).all(axis=1)
        if whole.sum() < 2:
            raise DataError(f"{take.name} holds no sample of {band.prefix}: did the band send?")
        found[band.prefix] = (take.times[whole], part[whole])
    return found


def _briefly(model: GestureModel) -> list[str]:
    """The model's columns, band by band."""
    return [
        f"{band.prefix} ({' '.join(name.partition('_')[2] or name for name in band.columns)})"
        for band in model.channels.bands
    ]
