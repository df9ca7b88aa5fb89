import numpy as np
import pytest
import shapely

from armspan.swarm.cells import cell_lines, separate
from armspan.swarm.orca import Pairs

CLEAR = 0.1


def hulls(ways):
    return [shapely.MultiPoint(way).convex_hull for way in ways]


@pytest.mark.parametrize("seed", range(4))
def test_the_distance_of_two_ways_is_that_of_their_hulls(seed):
    rng = np.random.default_rng(seed)
    first = rng.normal(size=(200, 5, 2)) * 0.03
    second = rng.normal(size=(200, 5, 2)) * 0.03 + rng.uniform(-0.3, 0.3, (200, 1, 2))
    direction, apart = separate(first, second)
    assert np.hypot(*direction.T) == pytest.approx(np.ones(200))
    exact = np.array([a.distance(b) for a, b in zip(hulls(first), hulls(second), strict=True)])
    assert (apart <= exact + 1e-12).all()  # never more than there is
    far = exact > 0.0
    assert far.sum() > 100
    assert apart[far] == pytest.approx(exact[far], abs=1e-6)
    assert (apart[~far] <= 0).all()
    gap = np.einsum("nki,ni->nk", second, direction).min(axis=1) - np.einsum("nki,ni->nk", first, direction).max(axis=1)
    assert gap == pytest.approx(apart)


@pytest.mark.parametrize("seed", range(8))
def test_new_goals_within_the_cells_keep_ways_apart(seed):
    rng = np.random.default_rng(seed)
    n = 8
    at = rng.uniform(0, 0.5, (n, 2))
    ways = np.concatenate([at[:, None], at[:, None] + rng.uniform(-0.03, 0.03, (n, 3, 2))], axis=1)
    first, second = np.triu_indices(n, 1)
    wished = rng.uniform(-0.06, 0.06, (n, 2))
    normal, ahead, behind = cell_lines(ways, at, wished, np.ones(n), Pairs(first, second), CLEAR)
    goals = []
    for k in range(n):  # by its own lines only, each robot takes the farthest share of its wish that they leave
        lines = np.concatenate([normal[first == k], -normal[second == k]])
        room = np.concatenate([ahead[first == k], behind[second == k]])
        along = lines @ wished[k]
        share = min([1.0, *(room[along > 0] / along[along > 0])])
        goals.append(at[k] + share * wished[k])
    before = hulls(ways)
    after = hulls(np.concatenate([ways, np.array(goals)[:, None]], axis=1))
    for a, b in zip(first, second, strict=True):
        assert after[a].distance(after[b]) >= min(CLEAR, before[a].distance(before[b])) - 1e-6


def test_robots_whose_ways_cross_come_no_nearer():
    at = np.array([[0.0, 0.0], [0.08, 0.0]])
    ways = np.array([[[0.0, 0.0], [0.06, 0.01]], [[0.08, 0.0], [0.02, 0.005]]])
    pair = Pairs(np.array([0]), np.array([1]))
    normal, ahead, behind = cell_lines(ways, at, np.array([[0.05, 0.0], [-0.05, 0.0]]), np.ones(2), pair, CLEAR)
    assert normal[0] == pytest.approx([1.0, 0.0])
    assert (ahead[0], behind[0]) == (0.0, 0.0)


def test_what_is_free_goes_to_the_one_that_asks():
    at = np.array([[0.0, 0.0], [0.16, 0.0]])
    ways, pair = at[:, None].repeat(2, axis=1), Pairs(np.array([0]), np.array([1]))
    ask = np.array([[0.05, 0.0], [0.0, 0.05]])
    _, ahead, behind = cell_lines(ways, at, ask, np.ones(2), pair, CLEAR)
    assert ahead[0] == pytest.approx(0.055)  # its 5 cm, and half of the sixth that nobody asked for
    assert behind[0] == pytest.approx(0.005)
    _, ahead, behind = cell_lines(ways, at, np.array([[0.06, 0.0], [-0.03, 0.0]]), np.ones(2), pair, CLEAR)
    assert (ahead[0], behind[0]) == pytest.approx((0.04, 0.02))
    _, ahead, behind = cell_lines(ways, at, ask, np.array([1.0, 0.0]), pair, CLEAR)
    assert (ahead[0], behind[0]) == pytest.approx((0.06, 0.0))
