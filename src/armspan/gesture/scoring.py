"""How good a classifier and a spotter are: confusion, macro F1, events, false triggers per hour with their bound."""

from collections.abc import Sequence

import msgspec
import numpy as np
from scipy.stats import chi2

from armspan.frames import Array
from armspan.gesture.decision import Spotted
from armspan.gesture.takes import NULL

LATE = 0.5
"""How long [s] after a gesture's end its event still counts as right."""


class Truth(msgspec.Struct, frozen=True):
    """What was truly made, from ``start`` to ``end`` [s]."""

    start: float
    end: float
    label: str


class EventScore(msgspec.Struct, frozen=True):
    """Events against truth.

    ``hits`` are right events; ``deletions`` gestures without one; ``substitutions`` wrong labels during a gesture;
    ``duplicates`` further events during a gesture that had its right one; ``insertions`` events during none.
    ``latency_s`` are median and 95th percentile from a gesture's onset to its event. ``null_hours`` is the time
    outside gestures, and the insertions per hour are of that time.
    """

    gestures: int
    hits: int
    deletions: int
    substitutions: int
    duplicates: int
    insertions: int
    f1: float
    latency_s: tuple[float, float] | None
    null_hours: float
    per_hour: float | None
    bound_per_hour: float | None


def score_events(events: Sequence[Spotted], truth: Sequence[Truth], seconds: float) -> EventScore:
    """Match events to ``truth`` one to one over ``seconds`` of stream; F1 = 2 hits / (gestures + events)."""
    wanted = [entry for entry in truth if entry.label != NULL]
    latest: dict[int, float] = {}
    counts = {"substitutions": 0, "duplicates": 0, "insertions": 0}
    for event in sorted(events, key=lambda event: event.t):
        during = [k for k, entry in enumerate(wanted) if entry.start <= event.t <= entry.end + LATE]
        right = [k for k in during if wanted[k].label == event.label]
        free = [k for k in right if k not in latest]
        if free:
            latest[free[0]] = event.t - wanted[free[0]].start
        elif right:
            counts["duplicates"] += 1
        else:
            counts["substitutions" if during else "insertions"] += 1
    delays = list(latest.values())
    median, late = (float(v) for v in np.percentile(delays, [50, 95])) if delays else (np.nan, np.nan)
    hours = max(0.0, seconds - sum(entry.end - entry.start for entry in wanted)) / 3600
    total = len(wanted) + len(events)
    return EventScore(
        gestures=len(wanted),
        hits=len(delays),
        deletions=len(wanted) - len(delays),
        **counts,
        f1=2 * len(delays) / total if total else 1.0,
        latency_s=(median, late) if delays else None,
        null_hours=hours,
        per_hour=counts["insertions"] / hours if hours else None,
        bound_per_hour=rate_bound(counts["insertions"], hours),
    )


def rate_bound(count: int, hours: float, confidence: float = 0.95) -> float | None:
    """Upper bound of a Poisson rate [1/h] with ``count`` events in ``hours``: 3.0 / hours where there was none."""
    return float(chi2.ppf(confidence, 2 * (count + 1)) / 2 / hours) if hours > 0 else None


def confusion(truth: Sequence[str], found: Sequence[str], labels: Sequence[str]) -> Array:
    """How often each of ``labels`` (rows) was taken for each (columns)."""
    table = np.zeros((len(labels), len(labels)), dtype=int)
    places = {label: k for k, label in enumerate(labels)}
    for one, other in zip(truth, found, strict=True):
        table[places[one], places[other]] += 1
    return table


def accuracy(table: Array) -> float:
    """Share of a confusion matrix on its diagonal."""
    return float(np.trace(table) / table.sum()) if table.sum() else float("nan")


def macro_f1(table: Array) -> float:
    """Mean over the labels that occur of F1 = 2 tp / (2 tp + fp + fn)."""
    hits, sums = np.diag(table), table.sum(0) + table.sum(1)
    there = table.sum(1) > 0
    return float(np.mean(2 * hits[there] / sums[there])) if there.any() else float("nan")


def confused_pairs(table: Array, labels: Sequence[str]) -> list[tuple[str, str, int, int]]:
    """Pairs of labels taken for each other: (one, other, times, out of), the most confused first."""
    both = table + table.T
    pairs = [
        (labels[i], labels[j], int(both[i, j]), int(table[i].sum() + table[j].sum()))
        for i in range(len(labels))
        for j in range(i)
        if both[i, j]
    ]
    return sorted(pairs, key=lambda pair: -pair[2] / pair[3])
