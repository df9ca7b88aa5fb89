"""The prior is the regression on the survey, plus what the survey does not hold."""

import csv
import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.body.ansur import ANSUR, SIZES, Population, Size
from armspan.body.anthropometry import Prior, prior
from armspan.body.told import Told
from armspan.frames import Array

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "ansur2_subset.csv"
EXACT = 0.0

# Ordinary least squares on the survey, fitted by another program: mm, rows (eye height, acromion height, half
# the biacromial breadth less half the pupils' distance, pupils' distance, acromion to middle fingertip).
REGRESSIONS: dict[tuple[Size, ...], tuple[list[list[float]], list[list[float]]]] = {
    ("stature",): (
        [
            [-45.277586, 0.960969],
            [-70.461545, 0.861303],
            [-43.007205, 0.123063],
            [40.280361, 0.013404],
            [-42.29281, 0.477218],
        ],
        [
            [68.883, 24.634, -0.027, 0.567, 27.168],
            [24.634, 244.42, -27.769, 3.382, 80.801],
            [-0.027, -27.769, 88.044, 1.115, 27.024],
            [0.567, 3.382, 1.115, 11.873, 20.882],
            [27.168, 80.801, 27.024, 20.882, 463.759],
        ],
    ),
    ("stature", "man"): (
        [
            [-43.869746, 0.960043, 0.266685],
            [-112.029449, 0.888639, -7.87414],
            [35.621134, 0.071355, 14.894438],
            [45.930579, 0.009688, 1.070312],
            [-24.90882, 0.465786, 3.293021],
        ],
        [
            [68.874, 24.891, -0.513, 0.532, 27.061],
            [24.891, 236.822, -13.396, 4.415, 83.979],
            [-0.513, -13.396, 60.856, -0.839, 21.013],
            [0.532, 4.415, -0.839, 11.733, 20.45],
            [27.061, 83.979, 21.013, 20.45, 462.43],
        ],
    ),
    ("stature", "man", "span"): (
        [
            [-43.29193, 0.921034, -0.58393, 0.037914],
            [-111.578877, 0.85822, -8.537438, 0.029565],
            [36.450463, 0.015366, 13.673563, 0.054417],
            [46.231639, -0.010637, 0.627114, 0.019754],
            [-19.301286, 0.087213, -4.961962, 0.367942],
        ],
        [
            [65.573, 22.317, -5.252, -1.188, -4.977],
            [22.317, 234.815, -17.091, 3.074, 58.997],
            [-5.252, -17.091, 54.055, -3.308, -24.97],
            [-1.188, 3.074, -3.308, 10.837, 3.757],
            [-4.977, 58.997, -24.97, 3.757, 151.513],
        ],
    ),
    ("stature", "man", "span", "acromion height"): (
        [
            [-32.687292, 0.839467, 0.227482, 0.035104, 0.095042],
            [0.0, 0.0, 0.0, 0.0, 1.0],
            [28.329314, 0.07783, 13.052174, 0.056569, -0.072784],
            [47.692371, -0.021872, 0.738882, 0.019367, 0.013091],
            [8.732626, -0.128413, -2.816952, 0.360514, 0.251247],
        ],
        [
            [63.451, 0.0, -3.627, -1.481, -10.584],
            [0.0, 0.0, 0.0, 0.0, 0.0],
            [-3.627, 0.0, 52.812, -3.084, -20.676],
            [-1.481, 0.0, -3.084, 10.796, 2.985],
            [-10.584, 0.0, -20.676, 2.985, 136.69],
        ],
    ),
}
TARGETS: tuple[dict[str, float], ...] = (
    {"eye height": 1.0},
    {"acromion height": 1.0},
    {"half breadth": 1.0, "half pupils": -1.0},
    {"half pupils": 2.0},
    {"upper arm": 1.0, "forearm": 1.0, "hand": 1.0},
)
SUMS = np.array([[target.get(size, 0.0) for size in SIZES] for target in TARGETS])
PEOPLE_MM = ([1600.0, 0.0, 1590.0, 1300.0], [1750.0, 1.0, 1830.0, 1430.0], [1900.0, 1.0, 1850.0, 1590.0])


def in_metres(size: Size, value: float) -> float:
    return value if size == "man" else value / 1000.0


@pytest.mark.parametrize("sizes", REGRESSIONS, ids="+".join)
@pytest.mark.parametrize("typed_mm", PEOPLE_MM)
def test_what_is_known_exactly_regresses_as_least_squares(sizes: tuple[Size, ...], typed_mm: list[float]) -> None:
    coefficients, residual = (np.array(part) for part in REGRESSIONS[sizes])
    known = {size: (in_metres(size, value), EXACT) for size, value in zip(sizes, typed_mm, strict=False)}
    person = ANSUR.given(known)
    expected_mm = coefficients @ np.array([1.0, *typed_mm[: len(sizes)]])
    assert 1000.0 * SUMS @ person.mean == pytest.approx(expected_mm, abs=0.02)
    assert 1e6 * SUMS @ person.covariance @ SUMS.T == pytest.approx(residual, abs=0.02)


def sd_mm(person: Prior) -> Array:
    return 1000.0 * np.sqrt(np.diag(person.covariance))


def test_a_man_of_1_75_m_worked_out_by_hand() -> None:
    person = prior(Told(height_m=1.75, sex="man"))
    # eye 1636.5, acromion 1435.2, sideways 175.4, arm 793.5 mm; then pivot 15 lower, index 7 shorter
    assert 1000.0 * person.mean == pytest.approx([1636.5, 117.25, 175.4, 201.2 + 15.0, 793.5 - 15.0 - 7.0], abs=0.15)
    # residuals, the tape's 5 mm through the slopes 0.960, 0.067, 0.071, 0.071 and 0.466, and the doubts
    assert sd_mm(person) == pytest.approx(
        [
            np.hypot(8.3, 4.8),
            np.hypot(22.0, 0.3),
            np.hypot(7.8, 0.4),
            np.sqrt(255.9 + 17.0**2 + 0.1),
            np.sqrt(462.4 + 17.0**2 + 8.0**2 + 5.4),
        ],
        abs=0.05,
    )
    assert person.upper_arm + person.elbow_to_fingertip == pytest.approx(person.mean[4], abs=1e-12)
    assert person.stature == pytest.approx(1.75, abs=1e-3)
    assert 1000.0 * person.hand == pytest.approx(189.0 - 7.0, abs=7.0)


def test_the_pivots_doubt_is_in_up_and_arm_length_at_once() -> None:
    person = prior(Told(height_m=1.75, sex="man"))
    # cov(eye - acromion, arm) = 27.061 - 83.979, the tape adds 0.071 * 0.466 * 25, the pivot takes 17 * 17
    assert 1e6 * person.covariance[3, 4] == pytest.approx(27.061 - 83.979 + 0.83 - 289.0, abs=0.1)


def test_soles_raise_the_eyes_alone() -> None:
    barefoot, shod = prior(Told(height_m=1.75)), prior(Told(height_m=1.75, sole_m=0.03))
    assert shod.mean - barefoot.mean == pytest.approx([0.03, 0.0, 0.0, 0.0, 0.0], abs=1e-12)
    assert shod.covariance == pytest.approx(barefoot.covariance)
    assert shod.stature == barefoot.stature


def test_a_seat_carries_the_eyes_and_nothing_else() -> None:
    standing = prior(Told(height_m=1.75, sex="man", sole_m=0.03))
    seated = prior(Told(height_m=1.75, sex="man", sole_m=0.03, seat_height_m=0.45))
    # sitting eye height given stature and sex, fitted separately: 802.3 mm, SD 21.2; a slope of 0.37 on the tape
    assert 1000.0 * seated.mean[0] == pytest.approx(450.0 + 802.3, abs=0.3)
    assert sd_mm(seated)[0] == pytest.approx(np.sqrt(21.2**2 + 25.0**2 + (0.37 * 5.0) ** 2), abs=0.1)
    assert seated.mean[1:] == pytest.approx(standing.mean[1:])
    assert seated.covariance[1:, 1:] == pytest.approx(standing.covariance[1:, 1:])


def test_a_higher_seat_carries_the_eyes_higher() -> None:
    low, high = (prior(Told(height_m=1.75, seat_height_m=seat)) for seat in (0.45, 0.60))
    assert high.mean - low.mean == pytest.approx([0.15, 0.0, 0.0, 0.0, 0.0], abs=1e-12)


def test_a_reported_height_is_taken_down_and_towards_the_mean() -> None:
    person = prior(Told(height_m=1.75, sex="man", self_reported=True))
    # men: mean 1756.2 mm, variance within sex 4509.5 mm²; 1750 - 19 keeps 4509.5 / (4509.5 + 27²) of its distance
    kept = 4509.5 / (4509.5 + 27.0**2)
    assert 1000.0 * person.stature == pytest.approx(1756.2 + kept * (1731.0 - 1756.2), abs=0.1)
    assert sd_mm(person)[0] == pytest.approx(np.sqrt(68.9 + 0.96**2 * kept * 27.0**2), abs=0.1)


@pytest.mark.parametrize(
    ("arm", "eye", "left_mm"),
    [("right", "right", 175.4), ("right", "left", 238.9), ("left", "left", -175.4), ("left", "right", -238.9)],
)
def test_the_eye_lies_inward_of_the_shoulder(arm: Any, eye: Any, left_mm: float) -> None:
    # the other eye is further by the pupils' distance, 45.93 + 0.009688 * 1750 + 1.07 = 63.95 mm
    person = prior(Told(height_m=1.75, sex="man", arm=arm, eye=eye))
    assert 1000.0 * person.mean[2] == pytest.approx(left_mm, abs=0.6)


@pytest.mark.parametrize("arm", ["right", "left"])
def test_either_eye_is_the_arms_own_with_a_wide_doubt(arm: Any) -> None:
    unsure, sure = prior(Told(height_m=1.75, arm=arm, eye="both")), prior(Told(height_m=1.75, arm=arm, eye=arm))
    assert unsure.mean == pytest.approx(sure.mean)
    assert sd_mm(unsure)[2] == pytest.approx(35.0)
    assert np.delete(sd_mm(unsure), 2) == pytest.approx(np.delete(sd_mm(sure), 2))


def test_a_span_that_was_seen_counts_as_one_that_was_typed() -> None:
    typed = prior(Told(height_m=1.75, sex="man", span_m=1.84))
    seen = prior(Told(height_m=1.75, sex="man"), {"span": (1.84, 0.010)})
    assert seen.mean == pytest.approx(typed.mean)
    assert seen.covariance == pytest.approx(typed.covariance)


def test_a_span_seen_badly_moves_the_arm_less() -> None:
    # the span's own variance v given stature and sex follows from the arm's two residuals: 462.4 - 151.5 = 0.368² v
    span = 1.84
    plain, sharp, dull = (
        prior(Told(height_m=1.75, sex="man"), seen) for seen in (None, {"span": (span, 1e-6)}, {"span": (span, 0.040)})
    )
    variance = (462.43 - 151.51) / 0.367942**2
    share = (dull.mean[4] - plain.mean[4]) / (sharp.mean[4] - plain.mean[4])
    assert share == pytest.approx(variance / (variance + 40.0**2), abs=0.01)


MIRROR = np.diag([1.0, 1.0, -1.0, 1.0, 1.0])
OPTIONAL: dict[str, object] = {
    "sex": "woman",
    "span_m": 1.70,
    "shoulder_height_m": 1.36,
    "forearm_hand_m": 0.45,
    "seat_height_m": 0.5,
    "self_reported": True,
}


def subsets() -> Iterator[dict[str, object]]:
    for count in range(len(OPTIONAL) + 1):
        for names in itertools.combinations(OPTIONAL, count):
            yield {name: OPTIONAL[name] for name in names}


@pytest.mark.parametrize(("eye", "other"), [("right", "left"), ("left", "right"), ("both", "both")])
def test_a_left_armed_person_is_the_mirror(eye: Any, other: Any) -> None:
    for typed in subsets():
        told: Any = {"height_m": 1.68} | typed
        right, left = prior(Told(arm="right", eye=eye, **told)), prior(Told(arm="left", eye=other, **told))
        assert left.mean == pytest.approx(MIRROR @ right.mean, abs=1e-12)
        assert left.covariance == pytest.approx(MIRROR @ right.covariance @ MIRROR, abs=1e-15)


@pytest.mark.parametrize("eye", ["right", "left", "both"])
def test_the_covariance_is_positive_definite_whatever_was_typed(eye: Any) -> None:
    for typed in subsets():
        told: Any = {"height_m": 1.68, "eye": eye} | typed
        covariance = prior(Told(**told)).covariance
        assert np.array_equal(covariance, covariance.T)
        assert np.linalg.eigvalsh(covariance).min() > 1e-5  # 3 mm, squared: nothing is known better


def test_more_knowledge_never_raises_a_variance() -> None:
    posture = {"seat_height_m", "self_reported"}
    for typed in subsets():
        for name in set(OPTIONAL) - set(typed) - posture:
            less: Any = {"height_m": 1.68} | typed
            before, after = (prior(Told(**told)).covariance for told in (less, less | {name: OPTIONAL[name]}))
            # in every direction, not only along the five
            assert np.linalg.eigvalsh(before - after).min() > -1e-12


@settings(derandomize=True, deadline=None, max_examples=60)
@given(st.floats(1.2, 2.29), st.sampled_from(["man", "woman", None]))
def test_a_taller_person_is_greater_in_every_measure(height: float, sex: Any) -> None:
    small, tall = prior(Told(height_m=height, sex=sex)), prior(Told(height_m=height + 0.01, sex=sex))
    assert np.all(tall.mean > small.mean)
    assert np.all(small.mean > 0.0)


def test_nothing_known_leaves_the_population() -> None:
    assert ANSUR.given({}) is ANSUR


# --- against the survey's own table -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def people_mm() -> Array:
    """Everybody's sizes (n, 12) [mm] in the order of `SIZES`."""
    if not DATA.exists():
        pytest.skip(f"the survey's table {DATA.name} is not beside the repository")
    with DATA.open(encoding="latin-1", newline="") as file:
        rows = list(csv.DictReader(file))

    def column(*names: str) -> Array:
        return sum((np.array([float(row[name]) for row in rows]) for name in names), np.zeros(len(rows)))

    return np.column_stack(
        [
            column("stature"),
            [row["gender"] == "Male" for row in rows],
            column("stature", "eyeheightsitting") - column("sittingheight"),
            column("eyeheightsitting"),
            column("acromialheight"),
            column("biacromialbreadth") / 2.0,
            column("interpupillarybreadth") / 2.0,
            column("acromionradialelength"),
            column("radialestylionlength"),
            column("handlength"),
            column("forearmhandlength"),
            column("span"),
        ]
    )


UNIT = np.array([1.0 if size == "man" else 1000.0 for size in SIZES])


def test_the_moments_are_the_tables(people_mm: Array) -> None:
    assert len(people_mm) == 4082 + 1986
    assert pytest.approx(people_mm.mean(axis=0), rel=1e-6) == UNIT * ANSUR.mean
    assert pytest.approx(np.cov(people_mm.T), rel=1e-6) == ANSUR.covariance * np.outer(UNIT, UNIT)


@pytest.mark.parametrize("sizes", [*REGRESSIONS, ("man",), ("stature", "forearm and hand"), ("span", "hand")], ids=str)
def test_conditioning_is_least_squares_on_the_table(people_mm: Array, sizes: tuple[Size, ...]) -> None:
    places = [SIZES.index(size) for size in sizes]
    design = np.column_stack([np.ones(len(people_mm)), people_mm[:, places]])
    fitted, *_ = np.linalg.lstsq(design, people_mm, rcond=None)
    someone = people_mm[17]
    person = ANSUR.given({size: (someone[i] / UNIT[i], EXACT) for size, i in zip(sizes, places, strict=True)})
    assert person.mean * UNIT == pytest.approx(design[17] @ fitted, abs=0.01)


CROSS_VALIDATED: dict[tuple[Size, ...], tuple[float | None, ...]] = {
    # RMSE [mm] not to be exceeded: eye height, up, sideways of the same eye, of the other eye, arm
    ("stature", "man"): (8.3, 16.0, 7.8, 8.4, 21.5),
    ("stature", "man", "span"): (8.1, 16.0, 7.4, 7.6, 12.3),
    ("stature", "man", "forearm and hand"): (8.2, 15.9, 7.7, 8.1, 11.5),
    ("stature", "man", "acromion height"): (8.1, 8.1, 7.8, 8.4, 20.8),
    ("stature", "man", "span", "acromion height"): (8.0, 8.0, 7.3, 7.6, 11.7),
}
MEASURED: tuple[dict[str, float], ...] = (
    {"eye height": 1.0},
    {"eye height": 1.0, "acromion height": -1.0},
    {"half breadth": 1.0, "half pupils": -1.0},
    {"half breadth": 1.0, "half pupils": 1.0},
    {"upper arm": 1.0, "forearm": 1.0, "hand": 1.0},
)


@pytest.mark.parametrize("sizes", CROSS_VALIDATED, ids="+".join)
def test_people_who_were_left_out_are_met_as_well_as_promised(people_mm: Array, sizes: tuple[Size, ...]) -> None:
    weights = np.array([[measure.get(size, 0.0) for size in SIZES] for measure in MEASURED])
    places = [SIZES.index(size) for size in sizes]
    errors = []
    for part in np.array_split(np.random.default_rng(6).permutation(len(people_mm)), 10):
        learnt = np.delete(people_mm, part, axis=0) / UNIT
        survey = Population(learnt.mean(axis=0), np.cov(learnt.T))
        for someone in people_mm[part[::4]]:  # a quarter of them, for the time it takes
            known = {size: (float(someone[i] / UNIT[i]), EXACT) for size, i in zip(sizes, places, strict=True)}
            errors.append(weights @ (survey.given(known).mean * UNIT - someone))
    rmse = np.sqrt(np.mean(np.square(errors), axis=0))
    assert np.all(rmse < np.array(CROSS_VALIDATED[sizes]) * 1.03 + 0.05)  # a quarter of 6068: 1.8 % SD
