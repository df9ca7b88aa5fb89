"""Random convolution kernels and their ridge head, against sums written out and against plain refits."""

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.linear_model import Ridge as PlainRidge

from armspan.errors import ModelError
from armspan.gesture.kernel_features import KernelFeatures, spread_dilations, two_valued_kernels
from armspan.gesture.kernel_ridge import LONE, SOFTENING, Ridge, left_basis, left_out_residuals
from armspan.gesture.kernels import Kernels, retimed


def swings(n_each: int, seed: int, n_classes: int = 3, n_channels: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Noisy sines: the class is the frequency, the phase is chance."""
    rng = np.random.default_rng(seed)
    labels = np.repeat(np.arange(n_classes), n_each)
    phase = rng.uniform(0, 2 * np.pi, (len(labels), n_channels, 1))
    turns = 2.0 + 2.0 * labels[:, None, None]
    takes = np.sin(2 * np.pi * turns * np.linspace(0, 1, 64) + phase) + rng.normal(
        0, 0.3, (len(labels), n_channels, 64)
    )
    return takes, np.array(["circle", "push", "wave", "zigzag"])[labels]


def test_kernels_are_all_different_and_sum_to_zero() -> None:
    kernels = two_valued_kernels()
    assert len({tuple(k) for k in kernels}) == 84
    assert np.all(kernels.sum(axis=1) == 0)
    assert np.all(np.sort(kernels, axis=1) == [-1] * 6 + [2] * 3)


def test_dilations_reach_over_the_take() -> None:
    assert spread_dilations(129, 5).tolist() == [1, 2, 4, 8, 16]
    assert spread_dilations(5, 5).tolist() == [1]


def test_answers_are_the_convolutions_written_out() -> None:
    takes, _ = swings(4, 0)
    features = KernelFeatures.fit(takes, 2000, 3, np.random.default_rng(1))
    for bank in features.banks:
        answers = bank.answers(takes[:2].astype(np.float32))
        reach = 4 * bank.dilation
        padded = np.pad(takes[1], ((0, 0), (reach, reach)), mode="constant" if bank.padding == "constant" else "edge")
        weights = bank.weights[17].reshape(9, 4)
        for t in (0, 31, 63):
            by_hand = sum(weights[j, c] * padded[c, t + j * bank.dilation] for j in range(9) for c in range(4))
            assert answers[1, 17, t] == pytest.approx(by_hand, abs=1e-4)


def test_features_are_shares_of_time_and_wins() -> None:
    takes, _ = swings(4, 2)
    features = KernelFeatures.fit(takes, 1000, 2, np.random.default_rng(3))
    bank = features.banks[-1]
    answers = bank.answers(takes.astype(np.float32))
    above, wins = bank.features(takes.astype(np.float32))
    each = bank.thresholds.shape[1]
    assert above[5, 40 * each] == pytest.approx(sum(a > bank.thresholds[40, 0] for a in answers[5, 40]) / 64)
    group = answers[5, 24:36]
    assert wins[5, 30] ** 2 == pytest.approx(sum(group[:, t].argmax() == 6 for t in range(64)) / 64)
    assert np.all(np.square(wins).reshape(12, 7, 12).sum(axis=2) > 1 - 1e-6)  # somebody always wins, all in a tie


def test_left_out_residuals_are_those_of_refits() -> None:
    rng = np.random.default_rng(4)
    A, wanted, groups = rng.normal(size=(12, 7)), rng.normal(size=(12, 3)), np.repeat([0, 1, 2], [3, 4, 5])
    A -= A.mean(axis=0)
    rows = [np.flatnonzero(groups == g) for g in range(3)]
    for members_of, penalty in ((rows, 0.7), ([np.array([i]) for i in range(12)], 2.0)):
        found = left_out_residuals(*left_basis(A), wanted, members_of, penalty)
        for members in members_of:
            others = np.setdiff1d(np.arange(12), members)
            plain = PlainRidge(alpha=penalty).fit(A[others], wanted[others])
            np.testing.assert_allclose(found[members], wanted[members] - plain.predict(A[members]), atol=1e-9)


@pytest.mark.parametrize("shape", [(10, 30), (30, 10)])
def test_head_is_ridge_regression(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(5)
    F, labels = rng.normal(size=shape), np.arange(shape[0]) % 2
    head = Ridge.fit(F, labels, 2)
    Z = (F - F.mean(axis=0)) / (F.std(axis=0) + SOFTENING)
    plain = PlainRidge(alpha=head.penalty * shape[1]).fit(Z, np.where(np.arange(2) == labels[:, None], 1.0, -1.0))
    np.testing.assert_allclose(head.scores(F), plain.predict(Z), atol=1e-8)


def test_penalty_is_larger_where_people_differ_than_where_their_takes_vouch_for_each_other() -> None:
    rng = np.random.default_rng(6)
    people, labels = np.repeat(np.arange(6), 20), np.tile(np.arange(2), 60)
    own = rng.normal(0, 1, (6, 2, 40))[people, labels]  # what only this person's takes have in common
    F = own + rng.normal(0, 0.05, own.shape)
    F[:, 0] += labels
    assert Ridge.fit(F, labels, 2, people).penalty > 10 * Ridge.fit(F, labels, 2).penalty


def test_copies_are_the_take_at_other_times_and_hold_its_ends() -> None:
    ramp = np.arange(101.0)
    copies = retimed(np.tile(ramp, (200, 1, 1)), np.random.default_rng(7))[:, 0]
    assert copies.min() >= 0
    assert copies.max() <= 100
    middle = copies[:, 50] - 50
    assert -5 <= middle.min() < -4
    assert 4 < middle.max() <= 5
    speed = copies[:, 60] - copies[:, 59]
    assert 0.95 <= speed.min() < 0.96
    assert 1.04 < speed.max() <= 1.05


def test_copies_stop_where_takes_are_many_and_do_not_vouch_for_their_take() -> None:
    takes, labels = swings(6, 15)
    few = Kernels(n_features=500, most_takes=35).fit(takes, labels)
    none = Kernels(n_features=500, copies=0).fit(takes, labels)
    np.testing.assert_array_equal(few.head_.weights, none.head_.weights)
    rng = np.random.default_rng(16)
    noise, chance = rng.normal(size=(24, 2, 40)), np.arange(24) % 2
    assert Kernels(n_features=500).fit(noise, chance).head_.penalty >= 1.0  # nothing to learn, copies or not


def test_one_take_a_class_still_trains() -> None:
    takes, labels = swings(1, 7)
    model = Kernels().fit(takes, labels)
    assert model.head_.penalty == LONE
    assert model.predict(takes).tolist() == labels.tolist()


@pytest.mark.parametrize("n_classes", [2, 3, 4])
def test_learns_frequencies_whatever_the_phase(n_classes: int) -> None:
    model = Kernels(n_features=1000).fit(*swings(8, 8, n_classes))
    takes, labels = swings(20, 9, n_classes)
    scores = model.decision_function(takes)
    assert scores.shape == (20 * n_classes, n_classes)
    assert np.mean(model.predict(takes) == labels) >= 0.97
    assert model.classes_.tolist() == sorted(set(labels))


def test_same_seed_same_model_and_units_do_not_matter() -> None:
    takes, labels = swings(6, 10)
    windows = swings(6, 20)[0]
    first, again = (Kernels(seed=3).fit(takes, labels).decision_function(windows) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    other = Kernels(seed=4).fit(takes, labels).decision_function(windows)
    assert np.abs(first - other).max() > 1e-3
    in_degrees = Kernels(seed=3).fit(takes * 64.0, labels).decision_function(windows * 64.0)
    np.testing.assert_allclose(first, in_degrees, atol=1e-6)


def test_one_window_scores_as_in_a_batch() -> None:
    takes, labels = swings(30, 11)
    model = Kernels(n_features=1000).fit(takes, labels)
    alone = np.concatenate([model.decision_function(take[None]) for take in takes])
    np.testing.assert_allclose(alone, model.decision_function(takes), atol=1e-9)


def test_state_holds_no_objects_and_gives_the_same_model() -> None:
    takes, labels = swings(5, 12)
    model = Kernels(seed=5).fit(takes, labels.astype(object), groups=np.tile(np.array(["a", "b"]), 8)[:15])
    state = model.state()
    for value in state.values():
        assert isinstance(value, np.ndarray | float | int | str | list)
        assert not isinstance(value, np.ndarray) or value.dtype != object
    copy = Kernels.from_state(state)
    np.testing.assert_array_equal(copy.decision_function(takes), model.decision_function(takes))
    np.testing.assert_array_equal(copy.predict(takes), model.predict(takes))
    assert copy.get_params() == model.get_params() == clone(model).get_params()


def test_short_still_and_single_channel_takes() -> None:
    rng = np.random.default_rng(13)
    takes = rng.normal(size=(8, 2, 3))
    takes[:, 1] = 9.81
    takes[4:, 0] += 5
    model = Kernels(n_features=500).fit(takes, np.repeat([0, 1], 4))
    assert model.predict(takes).tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    assert np.isfinite(model.decision_function(takes)).all()


def test_refuses_what_cannot_teach_or_does_not_fit() -> None:
    takes, labels = swings(3, 14)
    gap = takes.copy()
    gap[2, 1, 5] = np.nan
    with pytest.raises(ModelError, match="NaN"):
        Kernels().fit(gap, labels)
    with pytest.raises(ModelError, match="'push'"):
        Kernels().fit(takes, np.full(9, "push"))
    with pytest.raises(ModelError, match="8 labels"):
        Kernels().fit(takes, labels[:8])
    model = Kernels(n_features=500).fit(takes, labels)
    with pytest.raises(ModelError, match="4 channels, 64 times"):
        model.predict(takes[:, :, :60])
