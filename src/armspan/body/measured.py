"""From what a person typed, and what pictures of them tell, to the five measures."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import TypeAlias

from armspan.body.anthropometry import Prior, prior
from armspan.body.fusion import Fused, fuse
from armspan.body.observation import Observation
from armspan.body.told import Told
from armspan.body.views import Seen
from armspan.errors import ConfigError

ALIKE = 0.7
"""Correlation of the errors of two pictures of one person (24 rendered bodies: up 0.74, arm length 0.6)."""

Look: TypeAlias = Callable[[Prior], Seen]
"""One view of the person, measured with what is expected of them."""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What was expected of the person before any view, what each view told, and what came out."""

    prior: Prior
    seen: tuple[Seen, ...]
    fused: Fused

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be known of how it was seen, each note once."""
        return tuple(dict.fromkeys(note for one in self.seen for note in one.notes))


def measure(told: Told, looks: Sequence[Look] = ()) -> Measured:
    """The five measures of the person who typed ``told`` and was looked at.

    Where no height was typed, the eye height that the views tell (with a marker sheet they can) stands in for it.

    Raises:
        ConfigError: where neither the height was typed nor a view tells of it.
        DataError: if a view cannot be measured.

    """
    known = prior(told)
    seen = [look(known) for look in looks]
    if told.height_m is None:
        known = _by_eye_height(told, _observations(seen))
        seen = [look(known) for look in looks]
    used = [one for one in _observations(seen) if told.height_m is not None or one.measure != "eye height"]
    return Measured(known, tuple(seen), fuse(known, _shared(used)))


def _observations(seen: Sequence[Seen]) -> list[Observation]:
    return [observation for one in seen for observation in one.observations]


def _shared(observations: Sequence[Observation]) -> list[Observation]:
    """The same, each so much less sure that those of one measure, taken as independent, are worth what they are."""
    count = Counter(observation.measure for observation in observations)
    return [replace(one, sd=one.sd * sqrt(1.0 + ALIKE * (count[one.measure] - 1))) for one in observations]


def _by_eye_height(told: Told, observations: Sequence[Observation]) -> Prior:
    heights = [observation for observation in observations if observation.measure == "eye height"]
    if not heights:
        raise ConfigError(
            "The height is missing: give the standing height without shoes in metres, such as 1.72, or a picture of "
            "the standing person with the marker sheet on the floor"
        )
    weights = [observation.sd**-2 for observation in heights]
    mean = sum(w * observation.value for w, observation in zip(weights, heights, strict=True)) / sum(weights)
    # Pictures of one sheet by one camera share their scale's error: two are not surer than the better one.
    return prior(told, {"eye height": (mean - told.sole_m, min(observation.sd for observation in heights))})
