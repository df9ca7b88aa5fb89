import itertools

import numpy as np
import pytest

from armspan.swarm.halfplanes import least_broken, nearest_allowed


def allowed(x, normals, offsets, radius):
    return bool((normals @ x <= offsets + 1e-9).all()) and np.hypot(*x) <= radius + 1e-9


def by_trying_everything(wished, normals, offsets, radius):
    """The nearest allowed point: it is the wish, or lies on one border, or where two borders meet."""
    candidates = [wished, wished * radius / max(np.hypot(*wished), 1e-12)]
    for n, o in zip(normals, offsets, strict=True):
        candidates.append(wished - n * (n @ wished - o))
        if abs(o) <= radius:
            half = np.sqrt(radius**2 - o**2) * np.array([-n[1], n[0]])
            candidates += [n * o + half, n * o - half]
    for a, b in itertools.combinations(range(len(offsets)), 2):
        pair = normals[[a, b]]
        if abs(np.linalg.det(pair)) > 1e-9:
            candidates.append(np.linalg.solve(pair, offsets[[a, b]]))
    fitting = [x for x in candidates if allowed(x, normals, offsets, radius)]
    return min(fitting, key=lambda x: np.hypot(*(x - wished)), default=None)


def random_case(rng, n, k, push=0.3):
    angle = rng.uniform(-np.pi, np.pi, (n, k))
    normals = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    return rng.uniform(-2, 2, (n, 2)), normals, rng.uniform(-push, 1.0, (n, k)), rng.uniform(0.3, 1.5, n)


@pytest.mark.parametrize("k", [0, 1, 2, 5, 9])
def test_the_nearest_point_is_the_one_found_by_trying_everything(k):
    wished, normals, offsets, radius = random_case(np.random.default_rng(k), 400, k)
    found, possible = nearest_allowed(wished, normals, offsets, radius)
    for row in range(400):
        expected = by_trying_everything(wished[row], normals[row], offsets[row], radius[row])
        assert possible[row] == (expected is not None)
        if expected is not None:
            assert allowed(found[row], normals[row], offsets[row], radius[row])
            assert np.hypot(*(found[row] - wished[row])) == pytest.approx(np.hypot(*(expected - wished[row])), abs=1e-7)


def test_lines_at_infinity_are_not_there():
    wished, normals, offsets, radius = random_case(np.random.default_rng(3), 50, 4)
    more = np.concatenate([normals, np.tile([1.0, 0.0], (50, 3, 1))], axis=1)
    padded = np.concatenate([offsets, np.full((50, 3), np.inf)], axis=1)
    plain, with_padding = (
        nearest_allowed(wished, normals, offsets, radius),
        nearest_allowed(wished, more, padded, radius),
    )
    assert np.array_equal(plain[1], with_padding[1])
    assert np.array_equal(plain[0][plain[1]], with_padding[0][plain[1]])


def test_soft_lines_give_way_by_as_little_as_it_takes_and_hard_ones_never():
    # Two soft lines leave x >= 0.2 and x <= -0.4: shifted by 0.3 each they meet at -0.1; the hard line wants y <= 0.
    normals = np.array([[[0.0, 1.0], [-1.0, 0.0], [1.0, 0.0]]])
    found = least_broken(np.array([[0.5, 0.5]]), normals, np.array([[0.0, -0.2, -0.4]]), np.array([2.0]), 1)
    assert found[0] == pytest.approx([-0.1, 0.0], abs=1e-3)


def test_soft_lines_are_kept_where_they_can_be():
    wished, normals, offsets, radius = random_case(np.random.default_rng(8), 200, 5)
    plain, possible = nearest_allowed(wished, normals, offsets, radius)
    soft = least_broken(wished, normals, offsets, radius, 0)
    assert 20 < possible.sum() < 200
    assert np.array_equal(soft[possible], plain[possible])
    assert (np.hypot(*soft.T) <= radius + 1e-9).all()
