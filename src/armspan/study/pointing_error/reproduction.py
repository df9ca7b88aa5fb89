"""The whole reproduction of the report's section 1.3, and what it did not have, as plain numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armspan.study.pointing_error.published import Map, Published, compare, maps, wrong_by
from armspan.study.pointing_error.readings import (
    ANGLES,
    Curve,
    angle_curves,
    body_curves,
    errors_mm,
    refitted,
)
from armspan.study.pointing_error.scene import (
    Scene,
    floor_workplace,
    front_sector,
    ideal_circle,
    published_circle,
    table_workplace,
)
from armspan.study.pointing_error.unabsorbed import Unabsorbed, unabsorbed

SEED = 133
FIGURE_SIZES = tuple(range(-10, 11))
TABLE_SIZES = (1, 2, 5, 10)


@dataclass(frozen=True, slots=True)
class Optimised:
    """Median errors [mm] after the report's own optimiser: Nelder-Mead in millimetres from (0, 0, 800, 0).

    ``careful_mm`` is the same cost minimised in metres from a simplex of half metres.
    """

    scene: str
    error: str
    unit: str
    sizes: tuple[float, ...]
    report_mm: tuple[float, ...]
    careful_mm: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Section 1.3 of the report in numbers [mm]; every field holds tuples, texts and numbers only.

    ``figures`` are the curves on the published circle at sizes from -10 to 10, ``curves`` those of the ideal user on
    his circle and in the front sector at some sizes; ``optimised`` the same by the report's optimiser; ``published``
    its points beside the reading that lands on them; ``maps`` the places of 1.3.2; ``unabsorbed`` the errors that begin
    after the calibration.
    """

    figures: tuple[Curve, ...]
    curves: tuple[Curve, ...]
    optimised: tuple[Optimised, ...]
    published: tuple[Published, ...]
    maps: tuple[Map, Map]
    unabsorbed: tuple[Unabsorbed, ...]


def reproduction(dice: np.random.Generator | None = None) -> Reproduction:
    """Everything, in about ten seconds; ``dice`` draws the random axes, from a fixed seed unless told."""
    dice = np.random.default_rng(SEED) if dice is None else dice
    circle = published_circle()
    ideal = (ideal_circle(), front_sector())
    curves = [curve for scene in ideal for curve in (*angle_curves(scene, TABLE_SIZES, dice), *_body(scene))]
    return Reproduction(
        (*angle_curves(circle, FIGURE_SIZES, dice), *body_curves(circle, FIGURE_SIZES)),
        tuple(curves),
        tuple(each for scene in ideal for each in optimised(scene, TABLE_SIZES)),
        compare(circle),
        maps(circle),
        (*unabsorbed(table_workplace()), *unabsorbed(floor_workplace())),
    )


def optimised(scene: Scene, sizes: Sequence[int]) -> tuple[Optimised, ...]:
    """Errors by an angle in each meaning (but the roll, which turns no ray) and of all measures, by its optimiser."""
    named = [
        (name, "deg", [make(scene, np.radians(d)) for d in sizes])
        for name, make in ANGLES.items()
        if name != "IMU roll"
    ]
    named.append(("all measures", "%", [wrong_by(scene, "%", size) for size in sizes]))
    return tuple(
        Optimised(
            scene.name,
            name,
            unit,
            tuple(map(float, sizes)),
            tuple(float(np.median(errors_mm(scene, refitted(scene, each, "nelder-mead-report")))) for each in wrongs),
            tuple(float(np.median(errors_mm(scene, refitted(scene, each, "nelder-mead")))) for each in wrongs),
        )
        for name, unit, wrongs in named
    )


def _body(scene: Scene) -> tuple[Curve, ...]:
    return body_curves(scene, TABLE_SIZES)
