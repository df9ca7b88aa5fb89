"""A model on takes that it has not seen."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from armspan.errors import DataError, ModelError
from armspan.frames import Array
from armspan.gesture.channels import same_columns
from armspan.gesture.dataset import take_array
from armspan.gesture.model import GestureModel
from armspan.gesture.scoring import accuracy, confusion, macro_f1, rate_bound
from armspan.gesture.stream import signals_of, spot
from armspan.gesture.takes import NULL, Take, check_clock, check_values


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """The confusion matrix of takes (rows: truth), and false triggers in everyday motion."""

    labels: tuple[str, ...]
    table: Array
    null_hours: float
    false_triggers: int

    @property
    def count(self) -> int:
        """How many takes were tried."""
        return int(self.table.sum())

    def document(self) -> dict[str, Any]:
        """As plain values."""
        rows = self.table.sum(axis=1)
        recall = {label: float(self.table[k, k] / rows[k]) for k, label in enumerate(self.labels) if rows[k]}
        null = (
            {
                "hours": self.null_hours,
                "false_triggers": self.false_triggers,
                "per_hour": self.false_triggers / self.null_hours,
                "below_per_hour": rate_bound(self.false_triggers, self.null_hours),
            }
            if self.null_hours
            else None
        )
        some = self.count > 0
        return {
            "count": self.count,
            "accuracy": accuracy(self.table) if some else None,
            "macro_f1": macro_f1(self.table) if some else None,
            "labels": list(self.labels),
            "confusion": self.table.tolist(),
            "recall": recall,
            "null": null,
        }


def evaluate(model: GestureModel, takes: Sequence[Take]) -> Evaluation:
    """Try a model on takes; practice takes are left out.

    Raises:
        DataError: a take cannot be used, or has a label that the model does not know.
        ModelError: the takes lack columns that the model needs.

    """
    used = [take for take in takes if not take.practice]
    if not used:
        raise DataError("there is no take to try the model on (practice takes are not used)")
    for take in used:
        _check(model, take)
    used = [take.picked(model.facts.columns) for take in used]
    gestures = [take for take in used if take.label != NULL]
    labels, table = model.facts.labels, confusion([], [], model.facts.labels)
    if gestures:
        found = model.takes.predict(take_array(gestures, model.channels, model.facts.take_length))
        table = confusion([take.label for take in gestures], found, labels)
    nulls = [take for take in used if take.label == NULL]
    false = sum(len(spot(model, signals_of(take, model))) for take in nulls)
    return Evaluation(labels, table, sum(take.seconds for take in nulls) / 3600, false)


def _check(model: GestureModel, take: Take) -> None:
    if take.label != NULL and take.label not in model.facts.labels:
        raise DataError(
            f"{take.name} is labelled {take.label!r}, which the model does not know; it knows "
            f"{', '.join(model.facts.labels)}: relabel the take, leave it out, or train with it"
        )
    lacking = same_columns(model.facts.columns, take.columns)
    if lacking:
        raise ModelError(
            f"{take.name} lacks {', '.join(lacking[:4])}{' and more' if len(lacking) > 4 else ''}, which the model was "
            "trained on: record with the same bands, or train on the bands that there are"
        )
    check_clock(take)
    check_values(take.picked(model.facts.columns))
