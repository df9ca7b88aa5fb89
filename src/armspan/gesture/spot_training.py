"""Learning to spot: windows with a null class, and a rule chosen on what was held out.

Every threshold comes from cross-validation inside the training data: held-out takes tell how many gestures would be
noticed, held-out everyday motion how often one would be noticed that was not made.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from armspan.frames import Array
from armspan.gesture.dataset import GRID, HOP, Dataset, clips
from armspan.gesture.decision import Rule
from armspan.gesture.folds import take_folds
from armspan.gesture.model import ordered
from armspan.gesture.pipeline import Pipeline
from armspan.gesture.rules import Heard, choose_rule
from armspan.gesture.takes import NULL
from armspan.gesture.windows import SEEN, Clip, gesture_windows, null_windows, windows

MOST_GESTURE, MOST_NULL = 1600, 1200
"""Windows that are learnt from at most."""

_TRIED = 300
_FOLDS = 4
_DTW_MOST = 120
_ALWAYS = -1


@dataclass(frozen=True, slots=True, eq=False)
class Spotting:
    """A trained spotter: its pipeline, its grid and rule, and an account of how the rule was chosen."""

    pipeline: Pipeline
    window: int
    grid: float
    hop: int
    temperature: float
    rule: Rule
    lead: dict[str, float]
    document: dict[str, Any]


@dataclass(slots=True, eq=False)
class _Examples:
    """Windows with their labels and the fold that each belongs to."""

    X: Array
    y: Array
    fold: Array
    together: Array
    """What must be left out together when a penalty is chosen: a person, or with one person a take."""


def train_spotting(
    data: Dataset,
    fresh: Callable[[], Pipeline],
    rate_per_hour: float,
    seed: int,
    window_s: float | None,
    progress: Callable[[str, float], None],
) -> Spotting:
    """A spotter for the takes and null recordings of ``data``."""
    grid = min(GRID, data.rate)
    length = max(8, round((window_s or data.window_seconds()) * grid))
    hop = max(1, round(HOP * grid))
    made, nulls = clips(data.gestures, data.channels, grid), [c.values for c in clips(data.nulls, data.channels, grid)]
    small = fresh().kind == "dtw"
    examples = _examples(made, data.weights, data.own, nulls, length, hop, seed, _DTW_MOST if small else None)
    progress("cross-validation of spotting", 0.0)
    heard, oof = _held_out(made[: data.own], nulls, examples, fresh, data.labels, length, hop, seed, progress)
    temperature = _temperature(*oof) if oof[0].size else 1.0
    lead = {label: SEEN * _usual(made, label) / grid for label in data.labels}
    rule, document = choose_rule(heard, data.labels, lead, temperature, rate_per_hour, hop / grid)
    progress("learning to spot", 0.9)
    pipeline = fresh().fit(examples.X, examples.y.tolist(), examples.together.tolist())
    document |= {"windows": len(examples.y), "null_windows": int((examples.y == NULL).sum()), "window_s": length / grid}
    return Spotting(pipeline, length, grid, hop, temperature, rule, lead, document)


def _examples(
    made: Sequence[Clip],
    weights: Sequence[int],
    own: int,
    nulls: Sequence[Array],
    length: int,
    hop: int,
    seed: int,
    most: int | None,
) -> _Examples:
    rng = np.random.default_rng([seed, 7])
    folds = np.full(len(made), _ALWAYS)
    folds[:own] = _folds(made[:own])
    per_take = max(1, (most or MOST_GESTURE) // max(1, len(made)))
    parts: list[tuple[Array, list[str], int, str]] = []
    persons = sorted({part.take.person for part in made})
    for number, part in enumerate(made):
        X, y = gesture_windows(part, length, hop, nulls, rng)
        kept = _spread(len(y), per_take)
        group = part.take.person if len(persons) > 2 else f"take {number}"
        kept = np.repeat(kept, weights[number])
        parts.append((X[kept], [y[k] for k in kept], int(folds[number]), group))
    total = sum(max(0, len(values) - length) for values in nulls)
    step = max(2 * hop, int(np.ceil(total / (most or MOST_NULL))))
    for number, values in enumerate(nulls):
        X = null_windows(values, length, step)
        # Neighbouring windows share samples: a fold is one stretch of everyday motion.
        for fold, stretch in enumerate(np.array_split(np.arange(len(X)), _FOLDS)):
            # Everyday motion is shared out among the persons: were it one of them, leaving it out would leave no null.
            group = persons[fold % len(persons)] if len(persons) > 2 else f"null {number} {fold}"
            parts.append((X[stretch], [NULL] * len(stretch), fold, group))
    return _Examples(
        np.concatenate([X for X, _, _, _ in parts]),
        np.array([label for _, y, _, _ in parts for label in y]),
        np.array([fold for _, y, fold, _ in parts for _ in y]),
        np.array([group for _, y, _, group in parts for _ in y]),
    )


def _folds(made: Sequence[Clip]) -> NDArray[np.intp]:
    folds = np.zeros(len(made), dtype=int)
    for number, held in enumerate(take_folds([part.take for part in made], _FOLDS)):
        folds[held] = number
    return folds


def _spread(count: int, most: int) -> NDArray[np.intp]:
    """Up to ``most`` of ``count`` places, evenly spread."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(int))


def _held_out(
    made: Sequence[Clip],
    nulls: Sequence[Array],
    examples: _Examples,
    fresh: Callable[[], Pipeline],
    labels: tuple[str, ...],
    length: int,
    hop: int,
    seed: int,
    progress: Callable[[str, float], None],
) -> tuple[Heard, tuple[Array, Array]]:
    """What a spotter that has not seen them says of takes and of everyday motion."""
    heard, scores, truth = Heard(), [], []
    folds, rng = _folds(made), np.random.default_rng([seed, 8])
    tried = set(_spread(len(made), _TRIED).tolist())
    used = int(folds.max()) + 1 if len(made) else 0
    for fold in range(used):
        progress("cross-validation of spotting", fold / max(used, 1))
        rest, held = examples.fold != fold, examples.fold == fold
        if len(set(examples.y[rest])) < 2:
            continue
        pipeline = fresh().fit(examples.X[rest], examples.y[rest].tolist(), examples.together[rest].tolist())
        if held.any():
            scores.append(ordered(pipeline, examples.X[held], labels))
            truth.append(examples.y[held])
        for k in np.flatnonzero(folds == fold).tolist():
            if k in tried:
                _hear_take(heard, made[k], pipeline, labels, length, hop, nulls, rng)
        for values in nulls:
            _hear_null(heard, values, fold, pipeline, labels, length, hop)
    if not scores:
        return heard, (np.empty((0, len(labels) + 1)), np.empty(0, dtype=int))
    places = {label: k for k, label in enumerate((*labels, NULL))}
    return heard, (np.concatenate(scores), np.array([places[y] for y in np.concatenate(truth).tolist()]))


def _hear_take(
    heard: Heard,
    part: Clip,
    pipeline: Pipeline,
    labels: tuple[str, ...],
    length: int,
    hop: int,
    nulls: Sequence[Array],
    rng: np.random.Generator,
) -> None:
    past = [values for values in nulls if len(values) >= length]
    before = np.repeat(part.values[:1], length, axis=0)
    if past:
        chosen = past[int(rng.integers(len(past)))]
        at = int(rng.integers(len(chosen) - length + 1))
        before = chosen[at : at + length]
    values = np.concatenate([before, part.values])
    ends = np.arange(length + int(part.start), len(values), hop)
    cut = windows(values, length, ends)
    whole = np.isfinite(cut).all(axis=(1, 2))
    if whole.any():
        heard.takes.append((part.label, ordered(pipeline, cut[whole], labels)))


def _hear_null(
    heard: Heard, values: Array, fold: int, pipeline: Pipeline, labels: tuple[str, ...], length: int, hop: int
) -> None:
    ends = np.array_split(np.arange(length - 1, len(values), hop), _FOLDS)[fold]
    if not len(ends):
        return
    cut = windows(values, length, ends)
    whole = np.isfinite(cut).all(axis=(1, 2))
    if whole.any():
        heard.nulls.append(ordered(pipeline, cut[whole], labels))


def _temperature(scores: Array, truth: Array) -> float:
    """The temperature at which held-out probabilities are worth most (Guo et al. 2017, ICML, section 4.2)."""
    finite = np.where(np.isfinite(scores), scores, -1e3)
    rows = np.arange(len(truth))

    def loss(log_temperature: float) -> float:
        scaled = finite / np.exp(log_temperature)
        top = scaled.max(axis=1)
        return float(np.mean(top + np.log(np.exp(scaled - top[:, None]).sum(axis=1)) - scaled[rows, truth]))

    return float(np.exp(minimize_scalar(loss, bounds=(-5.0, 4.0), method="bounded").x))


def _usual(made: Sequence[Clip], label: str) -> float:
    return float(np.median([part.end - part.start for part in made if part.label == label]))
