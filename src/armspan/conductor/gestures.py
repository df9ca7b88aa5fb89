"""Gestures in the conductor: the bands' samples go to the spotter, what it spots comes out as records."""

import math
from dataclasses import dataclass, replace

import msgspec

from armspan.conductor.arm import Band
from armspan.conductor.wrist import WRIST, wrist_row
from armspan.errors import ConfigError, ModelError
from armspan.gesture.model import GestureModel
from armspan.gesture.stream import Spotter
from armspan.gesture.takes import NULL
from armspan.records import Gesture, ImuSample, Output, Scores

SCORES_EVERY = 2
"""Ticks between two `Scores`: ten a second."""

LEAST_SURE, MOST_SURE = 0.1, 0.99
"""Thresholds that can be asked for."""


@dataclass(slots=True)
class _Side:
    """One wrist: its band, and which of its ten columns the model wants."""

    band: Band
    prefix: str
    places: tuple[int, ...]


class Gestures:
    """Follows the bands on the wrists; ``sides`` maps ``right`` and ``left`` to their bands.

    Raises:
        ModelError: the model needs what these bands do not deliver.

    """

    def __init__(self, model: GestureModel, sides: dict[str, Band]) -> None:
        self.labels = (*model.facts.labels, NULL)
        self.source = "+".join(
            sides[band.prefix].settings.name for band in model.channels.bands if band.prefix in sides
        )
        self._spotter = Spotter(model)
        self._sides: dict[str, _Side] = {}
        self._ticks = 0
        for wanted in model.channels.bands:
            _check(wanted.prefix, wanted.columns, sides)
            band = sides[wanted.prefix]
            places = tuple(WRIST.index(name.partition("_")[2]) for name in wanted.columns)
            self._sides[band.settings.name] = _Side(band, wanted.prefix, places)

    def obey(self, model: GestureModel) -> None:
        """Go on with the thresholds of ``model``, which is the same but for these."""
        self._spotter.decision.rule = model.facts.rule

    def feel(self, sample: ImuSample) -> None:
        """Take a sample of a band that has been set up."""
        side = self._sides.get(sample.source)
        if side is None:
            return
        row = wrist_row(side.band, sample)
        if row is not None:
            self._spotter.push(side.prefix, sample.t, tuple(row[k] for k in side.places))

    def tick(self, t: float) -> list[Output]:
        """What was spotted since the last tick, and ten times a second how probable each gesture is."""
        found: list[Output] = [
            Gesture(event.t, event.start, self.source, event.label, event.score) for event in self._spotter.advance()
        ]
        self._ticks += 1
        probabilities = self._spotter.probabilities
        if self._ticks % SCORES_EVERY == 0 and probabilities is not None:
            found.append(Scores(t, self.source, self.labels, tuple(round(float(p), 4) for p in probabilities)))
        return found


def with_threshold(model: GestureModel | None, text: str) -> GestureModel:
    """A model in which a gesture counts from another probability on.

    Raises:
        ConfigError: there is no model, or ``text`` is no such probability.

    """
    if model is None:
        raise ConfigError("this room has no gesture model, so there is no threshold: train one first")
    try:
        threshold = float(text)
    except ValueError:
        threshold = math.nan
    if not LEAST_SURE <= threshold <= MOST_SURE:
        raise ConfigError(f"threshold {text!r}: expected a probability from {LEAST_SURE:g} to {MOST_SURE:g}")
    return replace(model, facts=msgspec.structs.replace(model.facts, rule=model.facts.rule.at(threshold)))


def _check(prefix: str, columns: tuple[str, ...], sides: dict[str, Band]) -> None:
    strange = [name for name in columns if name.partition("_")[2] not in WRIST]
    if prefix not in ("right", "left") or strange:
        raise ModelError(
            f"the model was trained on {', '.join(strange or columns)}, which no wristband delivers: train it on takes "
            "recorded with `armspan record`"
        )
    if prefix not in sides:
        raise ModelError(
            f"the model needs a band on the {prefix} wrist, and the room has none there: add one (arm = {prefix!r}), "
            "or train with --bands " + ("left" if prefix == "right" else "right")
        )
