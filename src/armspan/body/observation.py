"""What a view of a person tells of one measure."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

Measure: TypeAlias = Literal["eye height", "forward", "left", "up", "arm length"]
"""The five measures in the order of `Body.covariance`; the middle three run from the shoulder's pivot to the eye."""

MEASURES: tuple[Measure, ...] = get_args(Measure)


@dataclass(frozen=True, slots=True)
class Observation:
    """One ``measure`` as seen: ``value`` and standard deviation ``sd`` [m], and what it was seen in."""

    measure: Measure
    value: float
    sd: float
    source: str
