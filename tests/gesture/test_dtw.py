"""Dynamic time warping against the recurrence written out."""

import numpy as np
import pytest

from armspan.errors import ModelError
from armspan.gesture.dtw import Dtw, warped_distances


def plainly(a: np.ndarray, b: np.ndarray, radius: int) -> float:
    """The recurrence cell by cell."""
    times = a.shape[1]
    cost = np.full((times + 1, times + 1), np.inf)
    cost[0, 0] = 0
    for i in range(times):
        for j in range(max(0, i - radius), min(times, i + radius + 1)):
            steps = min(cost[i, j], cost[i, j + 1], cost[i + 1, j])
            cost[i + 1, j + 1] = np.sum((a[:, i] - b[:, j]) ** 2) + steps
    return float(np.sqrt(cost[times, times]))


@pytest.mark.parametrize(
    ("times", "band", "radius"), [(1, 0.1, 0), (7, 0.0, 0), (13, 0.1, 1), (20, 0.1, 2), (20, 0.3, 6), (9, 1.0, 9)]
)
def test_distances_are_the_recurrence(times: int, band: float, radius: int) -> None:
    rng = np.random.default_rng(times)
    query, takes = rng.normal(size=(3, times)), rng.normal(size=(5, 3, times))
    expected = [plainly(query, take, radius) for take in takes]
    np.testing.assert_allclose(warped_distances(query, takes, band), expected, rtol=1e-12)


def test_known_by_hand() -> None:
    """A step one sample late is free within a band of one sample, and costs 1 with none."""
    early, late = np.array([[0.0, 1, 1, 1]]), np.array([[[0.0, 0, 1, 1]]])
    assert warped_distances(early, late, 0.25) == 0
    assert warped_distances(early, late, 0.0) == 1


def test_nearest_of_each_class_and_units_do_not_matter() -> None:
    rng = np.random.default_rng(1)
    takes = rng.normal(size=(6, 2, 30)) * np.array([1.0, 500.0])[:, None]
    labels = np.array(["stop", "wave", "mixing"] * 2)
    model = Dtw().fit(takes, labels)
    scores = model.decision_function(takes)
    assert model.classes_.tolist() == ["mixing", "stop", "wave"]
    assert model.predict(takes).tolist() == labels.tolist()
    Z = (takes - takes.mean(axis=(0, 2), keepdims=True)) / takes.std(axis=(0, 2), keepdims=True)
    nearest = min(plainly(Z[0], Z[1], 3), plainly(Z[0], Z[4], 3))
    assert scores[0, 2] == pytest.approx(-nearest)
    assert scores[0, 1] == 0


def test_state_round_trip_and_wrong_shapes() -> None:
    rng = np.random.default_rng(2)
    takes, labels = rng.normal(size=(6, 2, 16)), np.array([0, 1] * 3)
    takes[:, 1] = 4.0  # a channel that never moves
    model = Dtw(band=0.2).fit(takes, labels)
    queries = rng.normal(size=(3, 2, 16))
    copy = Dtw.from_state(model.state())
    np.testing.assert_array_equal(copy.decision_function(queries), model.decision_function(queries))
    assert copy.band == 0.2
    with pytest.raises(ModelError, match="2 channels, 16 times"):
        model.predict(queries[:, :1])
    with pytest.raises(ModelError, match="at least one other"):
        Dtw().fit(takes, np.zeros(6))
