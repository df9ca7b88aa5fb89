"""From takes to a model, with an honest account of how good it is."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import msgspec
import numpy as np
from numpy.typing import NDArray

from armspan.errors import DataError
from armspan.frames import Array
from armspan.gesture.dataset import Dataset, take_array
from armspan.gesture.folds import person_folds, take_folds
from armspan.gesture.model import Facts, GestureModel
from armspan.gesture.pipeline import Pipeline
from armspan.gesture.scoring import accuracy, confused_pairs, confusion, macro_f1
from armspan.gesture.spot_training import Spotting, train_spotting
from armspan.gesture.takes import Take, check_takes

Progress: TypeAlias = Callable[[str, float], None]
"""Told what is being done, and which share of it is done."""


class Wanted(msgspec.Struct, frozen=True, kw_only=True):
    """What to train; ``rate_per_hour`` is how many false triggers are put up with."""

    kind: str = "kernels"
    recipe: str = "standard"
    rate_per_hour: float = 1.0
    seed: int = 0
    window_s: float | None = None
    folds: int = 5


@dataclass(frozen=True, slots=True)
class Validation:
    """Cross-validation of whole takes: ``by_take`` and, where there are two persons or more, ``by_person``."""

    labels: tuple[str, ...]
    by_take: Array | None
    by_person: Array | None

    def document(self) -> dict[str, Any]:
        """As plain values."""
        found: dict[str, Any] = {"labels": list(self.labels)}
        for name, table in (("by_take", self.by_take), ("by_person", self.by_person)):
            if table is None:
                found[name] = None
                continue
            found[name] = {
                "accuracy": round(accuracy(table), 4),
                "macro_f1": round(macro_f1(table), 4),
                "confusion": table.tolist(),
            }
        return found


def silent(what: str, share: float) -> None:
    """No progress is told."""


def train(
    takes: Sequence[Take], wanted: Wanted, progress: Progress = silent, others: Sequence[Take] = ()
) -> GestureModel:
    """A model of ``takes``; practice takes are left out.

    With ``others``, takes of other people, it is a general model refined by the own ones: these count more, and only
    they are held out when it is validated.

    Raises:
        DataError: what is wrong with the takes, in one sentence.

    """
    checked, own = check_takes([*takes, *others]), sum(not take.practice for take in takes)
    data = Dataset.of(checked[:own], checked[own:])
    _check_enough(data)
    length, channels = data.take_length(), data.channels
    X, y = take_array(data.gestures, channels, length), [take.label for take in data.gestures]
    persons, weights = [take.person for take in data.gestures], data.weights

    fresh = partial(Pipeline.fresh, wanted.kind, wanted.recipe, channels.groups, wanted.seed)

    validation = validate(X, y, data, fresh, wanted.folds, progress)
    progress("learning the takes", 0.0)
    whole = weighted(fresh(), X, y, persons, weights)
    spotting = train_spotting(
        data, partial(fresh, windows=True), wanted.rate_per_hour, wanted.seed, wanted.window_s, progress
    )
    facts = _facts(data, wanted, length, spotting, validation)
    progress("done", 1.0)
    return GestureModel(facts, whole, spotting.pipeline)


def validate(
    X: Array,
    y: Sequence[str],
    data: Dataset,
    fresh: Callable[[], Pipeline],
    folds: int,
    progress: Progress = silent,
) -> Validation:
    """Cross-validation of the own whole takes (n, c, t), grouped by take and by person."""
    takes = data.gestures[: data.own]
    labels = tuple(sorted(set(y)))

    def cross(what: str, split: list[NDArray[np.intp]]) -> Array | None:
        tell = partial(progress, f"cross-validation {what}")
        return _cross(X, y, data, fresh, labels, split, tell) if split else None

    by_take = cross("by take", take_folds(takes, folds))
    return Validation(labels, by_take, cross("by person", person_folds(takes, 2 * folds)))


def _cross(
    X: Array,
    y: Sequence[str],
    data: Dataset,
    fresh: Callable[[], Pipeline],
    labels: tuple[str, ...],
    split: list[NDArray[np.intp]],
    progress: Callable[[float], None],
) -> Array:
    found = np.empty(data.own, dtype=object)
    for done, held in enumerate(split):
        progress(done / len(split))
        rest = np.setdiff1d(np.arange(len(y)), held)
        persons, weights = [data.gestures[k].person for k in rest], [data.weights[k] for k in rest]
        found[held] = weighted(fresh(), X[rest], [y[k] for k in rest], persons, weights).predict(X[held])
    return confusion(y[: data.own], found.tolist(), labels)


def weighted(
    pipeline: Pipeline, X: Array, y: Sequence[str], persons: Sequence[str], weights: Sequence[int]
) -> Pipeline:
    """A pipeline that has learnt from takes each as often as its weight says."""
    chosen = np.repeat(np.arange(len(y)), weights)
    return pipeline.fit(X[chosen], [y[k] for k in chosen.tolist()], [persons[k] for k in chosen.tolist()])


def _facts(data: Dataset, wanted: Wanted, length: int, spotting: Spotting, validation: Validation) -> Facts:
    counts = {label: sum(take.label == label for take in data.gestures) for label in data.labels}
    return Facts(
        kind=wanted.kind,
        recipe=wanted.recipe,
        columns=data.columns,
        labels=data.labels,
        rate_hz=round(data.rate, 3),
        take_length=length,
        window_s=spotting.window / spotting.grid,
        grid_hz=spotting.grid,
        hop=spotting.hop,
        temperature=spotting.temperature,
        rule=spotting.rule,
        lead_s=spotting.lead,
        persons=tuple(sorted({take.person for take in data.gestures[: data.own]})),
        takes=counts,
        null_s=round(data.null_seconds, 2),
        seed=wanted.seed,
        scores={**validation.document(), "spotting": spotting.document},
    )


def _check_enough(data: Dataset) -> None:
    if not data.gestures:
        raise DataError("there are null recordings only: record takes of two gestures at least")
    if len(data.labels) < 2:
        raise DataError(
            f"all takes are of one gesture, {data.labels[0]!r}: a model tells gestures apart and needs two at least; "
            "record another one"
        )
    for label in data.labels:
        if sum(take.label == label for take in data.gestures) < 2:
            raise DataError(
                f"there is one take only of {label!r}: two are needed to learn from one and try the other, better "
                "five; record more, or leave the gesture out"
            )


def advice(facts: Facts) -> list[str]:
    """What a person should record more of, the most useful first."""
    found: list[str] = []
    table = np.array((facts.scores.get("by_take") or {"confusion": []})["confusion"])
    if table.size:
        for one, other, times, out_of in confused_pairs(table, facts.labels)[:3]:
            found.append(
                f"{one} and {other} are taken for each other in {times} of {out_of} takes: record more of both, or "
                "make them differ more"
            )
    if len(facts.persons) == 1:
        found.append("one person's takes say nothing of other people: a model serves whom it was trained on")
    few = [label for label, count in facts.takes.items() if count < 5]
    if few:
        found.append(f"fewer than five takes of {', '.join(few)}: three to five more would help")
    if facts.null_s < 300:
        found.append(
            f"{facts.null_s / 60:.1f} minutes of everyday motion: five to ten teach the model what is no gesture"
        )
    return found
