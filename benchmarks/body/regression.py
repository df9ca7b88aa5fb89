"""How well a person's sizes follow from typed ones: ten-fold cross-validation on ANSUR II (6068 adults).

Prints three Markdown tables: the error (RMSE) by what was typed, beside the numbers the project set out from;
how many errors lie within one and two of the standard deviations that the regression itself claims; and what
the package says of a person of 1.75 m. The sizes are conditioned by the package's own code, on moments of nine
tenths of the people. Needs ansur2_subset.csv beside the repository. Run: python benchmarks/body/regression.py
"""

import argparse
import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from armspan.body.ansur import SIZES, Population, Size
from armspan.body.anthropometry import REPORTED_BIAS, REPORTED_SD, TAPE_SD, prior
from armspan.body.told import Told
from armspan.frames import Array

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "ansur2_subset.csv"
FOLDS = 10
SAME, OTHER = {"half breadth": 1.0, "half pupils": -1.0}, {"half breadth": 1.0, "half pupils": 1.0}
TARGETS: dict[str, Mapping[str, float]] = {
    "eye height": {"eye height": 1.0},
    "acromion height": {"acromion height": 1.0},
    "up": {"eye height": 1.0, "acromion height": -1.0},
    "sideways, same side": SAME,
    "sideways, other eye": OTHER,
    "arm": {"upper arm": 1.0, "forearm": 1.0, "hand": 1.0},
    "eye over seat": {"eye over seat": 1.0},
}
Typed = Mapping[Size, tuple[Array, float]]
"""What was typed: values (n,) [m] of the people and the standard deviation of the typing [m]."""

FACTS: dict[str, tuple[float | None, ...]] = {
    "Drillis-Contini shares": (8.9, 16.5, 17.5, 25.0, 23.9, 30.6),
    "stature": (None, None, None, None, None, None),
    "stature, sex": (8.3, 15.4, 16.0, 7.8, 8.4, 21.5),
    "+ span": (8.1, 15.3, 16.0, 7.4, 7.6, 12.3),
    "+ forearm and hand": (8.2, 15.2, 15.9, 7.7, 8.1, 11.5),
    "+ shoulder height": (8.1, None, 8.1, 7.8, 8.4, 20.8),
    "+ span, shoulder height": (8.0, None, 8.0, 7.3, 7.6, 11.7),
    "self-reported stature, sex": (33.0, 33.0, 16.2, 8.1, 8.8, 25.9),
    "stature wrong by SD 10 mm, sex": (12.7, 17.6, 16.0, None, None, 22.0),
}
"""RMSE [mm] of the same in the project's facts, where told."""


def survey(path: Path) -> tuple[Array, Array]:
    """Sizes (n, 12) [m] of everybody in the order of `SIZES`, and the stature they report (n,) [m]."""
    with path.open(encoding="latin-1", newline="") as file:
        rows = list(csv.DictReader(file))

    def column(name: str) -> Array:
        return np.array([float(row[name]) for row in rows]) / 1000.0

    stature = column("stature")
    sizes: dict[Size, Array] = {
        "stature": stature,
        "man": np.array([float(row["gender"] == "Male") for row in rows]),
        "eye height": stature - column("sittingheight") + column("eyeheightsitting"),
        "eye over seat": column("eyeheightsitting"),
        "acromion height": column("acromialheight"),
        "half breadth": column("biacromialbreadth") / 2.0,
        "half pupils": column("interpupillarybreadth") / 2.0,
        "upper arm": column("acromionradialelength"),
        "forearm": column("radialestylionlength"),
        "hand": column("handlength"),
        "forearm and hand": column("forearmhandlength"),
        "span": column("span"),
    }
    return np.column_stack([sizes[name] for name in SIZES]), column("self_h")


def weights() -> Array:
    return np.array([[combination.get(name, 0.0) for name in SIZES] for combination in TARGETS.values()])


def typed_sets(people: Array, reported: Array, rng: np.random.Generator) -> dict[str, Typed]:
    """What is typed in every row of the tables, by its name."""

    def exact(*names: Size) -> Typed:
        return {name: (people[:, SIZES.index(name)], 0.0) for name in names}

    def taped(*names: Size) -> Typed:
        sizes = {name: (people[:, SIZES.index(name)], TAPE_SD[name]) for name in names}
        return {name: (value + sd * rng.standard_normal(len(value)), sd) for name, (value, sd) in sizes.items()}

    rough = people[:, 0] + 0.010 * rng.standard_normal(len(people))
    return {
        "stature": exact("stature"),
        "stature, sex": exact("stature", "man"),
        "+ span": exact("stature", "man", "span"),
        "+ forearm and hand": exact("stature", "man", "forearm and hand"),
        "+ shoulder height": exact("stature", "man", "acromion height"),
        "+ span, shoulder height": exact("stature", "man", "span", "acromion height"),
        "self-reported stature, sex": {**exact("man"), "stature": (reported - REPORTED_BIAS, REPORTED_SD)},
        "stature wrong by SD 10 mm, sex": {**exact("man"), "stature": (rough, 0.010)},
        "by tape: stature, sex": {**exact("man"), **taped("stature")},
        "by tape: all": {**exact("man"), **taped("stature", "span", "acromion height", "forearm and hand")},
    }


def folds(count: int, rng: np.random.Generator) -> list[Array]:
    return np.array_split(rng.permutation(count), FOLDS)


def cross_validated(people: Array, typed: Typed, parts: list[Array]) -> tuple[Array, Array]:
    """Errors (n, targets) [m] and the standard deviations [m] claimed for them."""
    errors = np.empty((len(people), len(TARGETS)))
    claimed = np.empty_like(errors)
    for part in parts:
        learnt = np.delete(people, part, axis=0)
        population = Population(learnt.mean(axis=0), np.cov(learnt.T))
        for i in part:
            person = population.given({name: (float(value[i]), sd) for name, (value, sd) in typed.items()})
            errors[i] = weights() @ (person.mean - people[i])
        spread = weights() @ person.covariance @ weights().T  # the same whatever the values
        claimed[part] = np.sqrt(np.maximum(np.diag(spread), 0.0))
    return errors, claimed


def drillis_contini(people: Array) -> Array:
    """Errors (n, targets) [m] of the classical shares of the stature, the pupils 63 mm apart."""
    eye, shoulder, half, arm = 0.936, 0.818, 0.129, 0.186 + 0.146 + 0.108
    stature = people[:, 0]
    guess = np.column_stack(
        [
            eye * stature,
            shoulder * stature,
            (eye - shoulder) * stature,
            half * stature - 0.0315,
            half * stature + 0.0315,
            arm * stature,
            np.full(len(stature), np.nan),
        ]
    )
    return guess - people @ weights().T


def rmse_mm(errors: Array) -> Array:
    return 1000.0 * np.sqrt(np.mean(errors**2, axis=0))


def print_table(header: list[str], rows: list[list[str]]) -> None:
    print("| " + " | ".join(header) + " |\n|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print()


def beside(value: float, fact: float | None) -> str:
    text = "-" if np.isnan(value) else "typed" if value < 0.01 else f"{value:.1f}"
    return text if fact is None else f"{text} ({fact:g})"


def error_rows(errors: Mapping[str, Array]) -> list[list[str]]:
    none: tuple[float | None, ...] = (None,) * len(TARGETS)
    rows = []
    for name, of_people in errors.items():
        facts = (*FACTS.get(name, none), None)[: len(TARGETS)]
        rows.append([name, *(beside(v, f) for v, f in zip(rmse_mm(of_people), facts, strict=True))])
    return rows


def calibration_rows(results: Mapping[str, tuple[Array, Array]]) -> list[list[str]]:
    rows = []
    for name, (errors, claimed) in results.items():
        known = claimed[0] > 1e-5
        one, two = (100.0 * np.mean(np.abs(errors) < k * claimed, axis=0) for k in (1.0, 2.0))
        cells = [f"{a:.0f}, {b:.0f}" if k else "typed" for a, b, k in zip(one, two, known, strict=True)]
        rows.append([name, *cells])
    return rows


def package_rows() -> list[list[str]]:
    """Mean and standard deviation of the five measures [mm] of people of 1.75 m."""
    known = {
        "height": {},
        "height, man": {"sex": "man"},
        "height, woman": {"sex": "woman"},
        "height, man, span 1.80, shoulder height 1.44": {"sex": "man", "span_m": 1.80, "shoulder_height_m": 1.44},
        "the same and forearm to fingertip 0.48": {
            "sex": "man",
            "span_m": 1.80,
            "shoulder_height_m": 1.44,
            "forearm_hand_m": 0.48,
        },
        "height, man, self-reported": {"sex": "man", "self_reported": True},
        "height, man, on a seat of 0.45": {"sex": "man", "seat_height_m": 0.45},
        "height, man, either eye": {"sex": "man", "eye": "both"},
    }
    rows = []
    for name, more in known.items():
        person = prior(Told(height_m=1.75, **more))  # type: ignore[arg-type]
        means, sds = 1000.0 * person.mean, 1000.0 * np.sqrt(np.diag(person.covariance))
        rows.append([name, *(f"{mean:.0f} ± {sd:.0f}" for mean, sd in zip(means, sds, strict=True))])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=DATA, help="ansur2_subset.csv")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    people, reported = survey(arguments.data)
    parts = folds(len(people), rng)
    results = {name: cross_validated(people, typed, parts) for name, typed in typed_sets(people, reported, rng).items()}
    print(f"RMSE [mm] of {len(people)} adults, {FOLDS}-fold cross-validated; in brackets the facts' numbers\n")
    errors = {"Drillis-Contini shares": drillis_contini(people)} | {name: e for name, (e, _) in results.items()}
    print_table(["typed", *TARGETS], error_rows(errors))
    print("Share of people [%] within one and within two of the claimed standard deviations (Gauss: 68, 95)\n")
    print_table(["typed", *TARGETS], calibration_rows(results))
    print("What the package expects of people of 1.75 m, right arm and eye, barefoot [mm ± SD]\n")
    print_table(["typed", "eye height", "forward", "left", "up", "arm length"], package_rows())


if __name__ == "__main__":
    main()
