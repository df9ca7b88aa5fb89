import numpy as np
import pytest

from armspan.pointing.field import MEMORY, REPEATED, MissField

AHEAD = np.array([1.0, 0.0, 0.0])


def turned(deg: float) -> np.ndarray:
    return np.array([np.cos(np.radians(deg)), np.sin(np.radians(deg)), 0.0])


def test_nothing_known_expects_nothing():
    miss, stays = MissField().at(AHEAD)
    assert miss == pytest.approx([0, 0])
    assert stays == 1.0


def test_one_miss_is_expected_again_by_its_repeated_share():
    """With one observation the posterior mean is r·m and its variance 1 - r², for unit total variance."""
    field = MissField()
    field.learn(AHEAD, np.array([0.02, -0.01]), 0.0)
    miss, stays = field.at(AHEAD)
    assert miss == pytest.approx(REPEATED * np.array([0.02, -0.01]))
    assert stays == pytest.approx(1 - REPEATED**2)


def test_far_directions_learn_nothing_from_each_other():
    field = MissField()
    field.learn(AHEAD, np.array([0.02, 0.0]), 0.0)
    miss, stays = field.at(turned(60))
    assert abs(miss).max() < 1e-5
    assert stays == pytest.approx(1.0, abs=1e-5)


def test_a_doubtful_miss_counts_for_less():
    sure, doubtful = MissField(), MissField()
    sure.learn(AHEAD, np.array([0.02, 0.0]), 0.0)
    doubtful.learn(AHEAD, np.array([0.02, 0.0]), 3.0)
    assert doubtful.at(AHEAD)[0][0] < sure.at(AHEAD)[0][0] / 3


def test_a_field_drawn_from_its_own_assumptions_is_found_with_honest_variance():
    rng = np.random.default_rng(0)
    angles = np.arange(-30, 31, 10.0)
    apart = (angles[:, None] - angles) / 12
    shape = np.linalg.cholesky(REPEATED * np.exp(-0.5 * apart**2) + 1e-9 * np.eye(len(angles)))
    ratios = []
    for _ in range(200):
        truth, field = shape @ rng.normal(size=(len(angles), 2)), MissField()
        for k in rng.permutation(len(angles))[:-1]:
            field.learn(turned(angles[k]), truth[k] + rng.normal(0, np.sqrt(1 - REPEATED), 2), 0.0)
        k = 3
        miss, stays = field.at(turned(angles[k]))
        ratios.append(np.sum((truth[k] + rng.normal(0, np.sqrt(1 - REPEATED), 2) - miss) ** 2) / (2 * stays))
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.15)


def test_old_misses_are_forgotten():
    field = MissField()
    for k in range(MEMORY + 10):
        field.learn(turned(k), np.zeros(2), 0.0)
    assert len(field.directions) == len(field.doubts) == MEMORY
