"""A finished take, cut out of what the bands told."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from armspan.conductor.recorder_motion import arm_rates, gesture_span
from armspan.conductor.recorder_plan import Ask
from armspan.conductor.recorder_trace import RATE, Trace
from armspan.conductor.wrist import WRIST
from armspan.frames import Array
from armspan.gesture.takes import INITIAL, NULL, Take

AROUND = 1.5
"""Seconds kept before and after the gesture."""

STANDING = 2.0
"""Seconds of a take of `initial`."""

REST = 2.0
"""Seconds before the cue that tell the arms' rest."""

SILENT, SILENT_EVERYDAY = 0.5, 5.0
"""Silence [s] of a band that spoils a take of a gesture, and one of everyday motion."""

_EARLY = 0.3
_CLICK = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class RecordedTake:
    """A finished take that began at ``start`` [s], and what is wrong with it (nothing, if ``note`` is empty)."""

    take: Take
    start: float
    note: str = ""


@dataclass(frozen=True, slots=True)
class Moment:
    """When a take happened: its cue, the second double click where there was one, and what was recorded last [s]."""

    cue: float
    end: float
    clicked: float | None = None


def cut(traces: Mapping[str, Trace], ask: Ask, moment: Moment, person: str, number: int) -> RecordedTake:
    """The take of ``ask`` from the traces by wrist; one that is spoilt counts as practice and says why."""
    span = _span(traces, ask.label, moment)
    start, end = _limits(ask.label, span, moment)
    grid = start + np.arange(round((end - start) * RATE) + 1) / RATE
    values = np.concatenate([trace.on(grid) for trace in traces.values()], axis=1)
    note = _silence(traces, ask.label, start, end)
    if not note and ask.label != NULL and span is None:
        note = "nothing moved"
    gesture = None if span is None else (round(span[0] - start, 2), round(span[1] - start, 2))
    columns = tuple(f"{side}_{name}" for side in traces for name in WRIST)
    practice = ask.practice or bool(note)
    take = Take(ask.label, person, number, columns, grid - start, values, practice, gesture)
    return RecordedTake(take, start, note)


def _span(traces: Mapping[str, Trace], label: str, moment: Moment) -> tuple[float, float] | None:
    """When the gesture was made [s]."""
    if label == NULL:
        return None
    if label == INITIAL:
        return moment.cue, moment.cue + STANDING
    start = moment.cue - REST
    times: Array = start + np.arange(round((moment.end - start) * RATE) + 1) / RATE
    rates = np.stack([arm_rates(trace.on(times)) for trace in traces.values()], axis=1)
    if moment.clicked is None:
        return gesture_span(times, rates, moment.cue, moment.cue - _EARLY)
    before_click = times <= moment.clicked - _CLICK  # the other hand's way to the button is no gesture
    return gesture_span(times[before_click], rates[before_click], moment.cue, moment.cue + _CLICK)


def _limits(label: str, span: tuple[float, float] | None, moment: Moment) -> tuple[float, float]:
    """Where the take starts and ends [s]."""
    if label == NULL:
        return moment.cue, moment.end
    first, last = span or (moment.cue, moment.end)
    around = 1.0 if label == INITIAL else AROUND
    return max(moment.cue - REST, first - around), min(moment.end, last + around)


def _silence(traces: Mapping[str, Trace], label: str, start: float, end: float) -> str:
    """Which band was silent for how long, if that spoils the take."""
    allowed = SILENT_EVERYDAY if label == NULL else SILENT
    for side, trace in traces.items():
        longest = trace.silence(start, end)
        if longest > allowed:
            return f"the band {side} was silent for {longest:.1f} s"
    return ""
