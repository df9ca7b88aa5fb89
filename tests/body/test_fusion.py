"""Prior and observations become one body; mistakes are told, not taken."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.body.anthropometry import Prior, prior
from armspan.body.fusion import fuse
from armspan.body.observation import MEASURES, Observation
from armspan.body.told import Told
from armspan.errors import DataError
from armspan.frames import Array
from armspan.records import Body

SOMEBODY = Told(height_m=1.75, sex="man")


def person(mean: list[float], covariance: Array) -> Prior:
    return Prior(np.array(mean), covariance, 0.32, 0.44, 0.18, 1.75, SOMEBODY)


def covariance(body: Body) -> Array:
    assert body.covariance is not None
    return np.array(body.covariance).reshape(5, 5)


def numbers(body: Body) -> Array:
    return np.array([body.eye_height_m, *body.shoulder_to_eye_m, body.shoulder_to_fingertip_m])


def test_nothing_seen_leaves_what_was_expected() -> None:
    expected = prior(Told(height_m=1.68, sex="woman", arm="left", eye="left"))
    body = fuse(expected, []).body
    assert numbers(body) == pytest.approx(expected.mean)
    assert covariance(body) == pytest.approx(expected.covariance)
    assert (body.arm, body.upper_arm_m) == ("left", pytest.approx(expected.upper_arm))
    assert body.covariance is not None
    assert len(body.covariance) == 25


def test_one_measure_alone_is_the_weighted_mean() -> None:
    uncorrelated = person([1.64, 0.12, 0.17, 0.20, 0.76], np.diag([0.01, 0.02, 0.01, 0.03, 0.02]) ** 2)
    fused = fuse(uncorrelated, [Observation("up", 0.23, 0.04, "front.jpg")])
    # weights 1/9 and 1/16: 0.20 + 9/25 * 0.03; 3 and 4 give 12/5
    assert fused.body.shoulder_to_eye_m == pytest.approx((0.12, 0.17, 0.2108))
    assert math.sqrt(covariance(fused.body)[3, 3]) == pytest.approx(0.024)
    assert np.delete(numbers(fused.body), 3) == pytest.approx([1.64, 0.12, 0.17, 0.76])


def test_a_correlated_measure_follows() -> None:
    spread = np.diag([0.01, 0.02, 0.01, 0.02, 0.02]) ** 2
    spread[3, 4] = spread[4, 3] = -0.5 * 0.02 * 0.02
    fused = fuse(person([1.64, 0.12, 0.17, 0.20, 0.76], spread), [Observation("up", 0.22, 0.02, "side.jpg")])
    # gain of up 1/2, of the arm -1/4; the arm's variance falls by 1/4 * 1/2 of itself
    assert fused.body.shoulder_to_eye_m[2] == pytest.approx(0.21)
    assert fused.body.shoulder_to_fingertip_m == pytest.approx(0.755)
    assert covariance(fused.body)[4, 4] == pytest.approx(0.02**2 * (1.0 - 0.125))


def test_a_picture_gains_what_was_foretold() -> None:
    # residuals of the survey given stature and sex [mm²]; a picture's up to 10 and arm to 14 mm make 16 and 21.5
    # into 8.4 and 11.7 (worked out separately)
    spread = np.diag([68.9, 484.0, 60.9, 255.9, 462.4])
    spread[3, 4] = spread[4, 3] = 27.06 - 83.98
    views = [Observation("up", 0.20, 0.010, "front"), Observation("arm length", 0.76, 0.014, "front")]
    fused = fuse(person([1.64, 0.12, 0.17, 0.20, 0.76], spread * 1e-6), views)
    assert 1000.0 * np.sqrt(np.diag(covariance(fused.body))[3:]) == pytest.approx([8.4, 11.7], abs=0.1)


def test_the_limbs_grow_with_the_arm() -> None:
    expected = prior(SOMEBODY)
    body = fuse(expected, [Observation("arm length", float(expected.mean[4]) + 0.03, 0.005, "side.jpg")]).body
    assert body.upper_arm_m is not None
    assert body.elbow_to_fingertip_m is not None
    assert body.upper_arm_m > expected.upper_arm
    assert body.upper_arm_m + body.elbow_to_fingertip_m == pytest.approx(body.shoulder_to_fingertip_m)
    assert body.upper_arm_m / body.elbow_to_fingertip_m == pytest.approx(
        expected.upper_arm / expected.elbow_to_fingertip
    )


@pytest.mark.parametrize(("off", "is_taken"), [(0.149, True), (0.151, False), (-0.149, True), (-0.151, False)])
def test_a_value_beyond_three_deviations_is_a_mistake(off: float, is_taken: bool) -> None:
    # 0.03 and 0.04 together are 0.05
    expected = person([1.64, 0.12, 0.17, 0.20, 0.76], np.diag([0.01, 0.02, 0.01, 0.03, 0.02]) ** 2)
    seen = Observation("up", 0.20 + off, 0.04, "front.jpg")
    fused = fuse(expected, [seen])
    assert (seen in fused.taken) is is_taken
    if not is_taken:
        (rejected,) = fused.rejected
        assert rejected.observation is seen
        assert rejected.z == pytest.approx(off / 0.05)
        assert numbers(fused.body) == pytest.approx(expected.mean)


def test_a_mistake_does_not_spoil_the_others() -> None:
    expected = prior(SOMEBODY)
    good = Observation("arm length", float(expected.mean[4]) + 0.02, 0.01, "front.jpg")
    bad = Observation("up", 0.9, 0.01, "front.jpg")
    assert fuse(expected, [bad, good]).body == fuse(expected, [good]).body


@pytest.mark.parametrize(
    ("seen", "parts"),
    [
        (Observation("up", math.nan, 0.01, "front.jpg"), ["front.jpg", "up = nan"]),
        (Observation("up", 0.2, 0.0, "front.jpg"), ["front.jpg", "standard deviation 0 m", "leave this one out"]),
        (Observation("left", 0.2, -0.01, "side.jpg"), ["side.jpg", "-0.01 m"]),
        (Observation("left", 0.2, math.inf, "side.jpg"), ["side.jpg", "inf m"]),
        (Observation("arm", 0.7, 0.01, "side.jpg"), ["side.jpg", "'arm'", "arm length"]),  # type: ignore[arg-type]
    ],
)
def test_says_what_cannot_be_observed(seen: Observation, parts: list[str]) -> None:
    with pytest.raises(DataError) as caught:
        fuse(prior(SOMEBODY), [seen])
    assert [part for part in parts if part not in str(caught.value)] == []


views = st.builds(
    Observation,
    measure=st.sampled_from(MEASURES),
    value=st.floats(0.1, 1.7),
    sd=st.floats(0.002, 0.3),
    source=st.just("front.jpg"),
)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(st.lists(views, max_size=6))
def test_every_observation_is_accounted_for_and_sharpens(seen: list[Observation]) -> None:
    expected = prior(SOMEBODY)
    fused = fuse(expected, seen)
    assert sorted([*fused.taken, *(r.observation for r in fused.rejected)], key=repr) == sorted(seen, key=repr)
    after = covariance(fused.body)
    assert np.array_equal(after, after.T)
    assert np.linalg.eigvalsh(after).min() > 0.0
    assert np.linalg.eigvalsh(expected.covariance - after).min() > -1e-12


@settings(derandomize=True, deadline=None, max_examples=40)
@given(st.lists(views, min_size=2, max_size=4))
def test_the_order_does_not_matter(seen: list[Observation]) -> None:
    expected = prior(SOMEBODY)
    first = numbers(fuse(expected, seen).body)
    for order in itertools.permutations(seen):
        assert numbers(fuse(expected, list(order)).body) == pytest.approx(first, abs=1e-9)


def test_true_people_are_met_as_often_as_claimed() -> None:
    # 400 people drawn from the prior, seen with the claimed errors: 90 % lie in the claimed 90 % region (chi² of 5)
    rng = np.random.default_rng(11)
    expected = prior(SOMEBODY)
    root = np.linalg.cholesky(expected.covariance)
    inside = 0
    for _ in range(400):
        truth = expected.mean + root @ rng.standard_normal(5)
        seen = [
            Observation(measure, float(truth[i] + sd * rng.standard_normal()), sd, "front.jpg")
            for measure, i, sd in (("up", 3, 0.010), ("arm length", 4, 0.014), ("forward", 1, 0.012))
        ]
        body = fuse(expected, seen).body
        off = numbers(body) - truth
        inside += off @ np.linalg.solve(covariance(body), off) < 9.236
    assert inside / 400 == pytest.approx(0.90, abs=0.045)
