import numpy as np
import pytest

from armspan.gesture.decision import Spotted
from armspan.gesture.scoring import (
    Truth,
    accuracy,
    confused_pairs,
    confusion,
    macro_f1,
    rate_bound,
    score_events,
)


def at(t: float, label: str = "wave") -> Spotted:
    return Spotted(t, t - 1, t + 1, label, 0.9)


TRUTH = [Truth(10, 12, "wave"), Truth(20, 22, "clap"), Truth(30, 33, "wave"), Truth(40, 41, "null")]


def test_every_event_is_of_one_kind() -> None:
    events = [at(11), at(12.4), at(21), at(33.4), at(33.6), at(40.5)]
    score = score_events(events, TRUTH, 3600.0)
    assert (score.gestures, score.hits, score.deletions) == (3, 2, 1)
    assert (score.duplicates, score.substitutions, score.insertions) == (1, 1, 2)
    assert score.f1 == pytest.approx(2 * 2 / (3 + 6))
    assert score.latency_s is not None
    assert score.latency_s[0] == pytest.approx((1.0 + 3.4) / 2)
    assert score.per_hour == pytest.approx(2 / (3593 / 3600))


def test_an_event_before_the_onset_is_an_insertion() -> None:
    assert score_events([at(9.9)], TRUTH, 60.0).insertions == 1


def test_nothing_to_find_and_nothing_found_is_right() -> None:
    assert score_events([], [], 60.0).f1 == 1.0


def test_no_trigger_in_t_hours_only_bounds_the_rate_by_three_over_t() -> None:
    bound = rate_bound(0, 2.0)
    assert bound == pytest.approx(-np.log(0.05) / 2)  # exp(-2 r) = 0.05
    many = rate_bound(5, 1.0)
    assert many == pytest.approx(10.513, abs=1e-3)  # the tables' upper limit for five counts
    assert rate_bound(0, 0.0) is None


def test_confusion_counts_rows_of_truth() -> None:
    table = confusion(["a", "a", "b", "b", "b"], ["a", "b", "b", "b", "a"], ("a", "b", "c"))
    assert table.tolist() == [[1, 1, 0], [1, 2, 0], [0, 0, 0]]
    assert accuracy(table) == pytest.approx(0.6)
    assert macro_f1(table) == pytest.approx((2 / 4 + 4 / 6) / 2)  # c does not occur
    assert confused_pairs(table, ("a", "b", "c")) == [("b", "a", 2, 5)]
