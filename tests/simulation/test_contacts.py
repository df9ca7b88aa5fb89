import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.simulation.contacts import Discs

RADIUS, FRAME, SPEED = 0.043, 0.011, 0.16


def nearest(xy):
    gaps = np.hypot(*(xy[:, :, None] - xy[:, None, :])) + np.eye(xy.shape[1])
    return gaps.min()


def solid(n):
    return np.ones(n, dtype=bool)


def test_two_discs_meet_head_on_and_push_equally():
    discs = Discs(RADIUS, SPEED * FRAME)
    xy, velocity = np.array([[0.0, 0.080], [0.0, 0.0]]), np.array([[0.1, -0.06], [0.05, 0.0]])
    discs.part(xy, velocity, solid(2))
    np.testing.assert_allclose(xy, [[-0.003, 0.083], [0.0, 0.0]], atol=1e-4)
    np.testing.assert_allclose(velocity, [[0.02, 0.02], [0.05, 0.0]], atol=1e-12)  # the mean, along x only
    assert discs.contacts == 1


def test_discs_that_part_keep_their_speed():
    discs = Discs(RADIUS, SPEED * FRAME)
    xy, velocity = np.array([[0.0, 0.0855], [0.0, 0.0]]), np.array([[-0.1, 0.1], [0.0, 0.0]])
    discs.part(xy, velocity, solid(2))
    np.testing.assert_array_equal(velocity, [[-0.1, 0.1], [0.0, 0.0]])


def test_a_contact_is_counted_once_while_it_lasts():
    discs, velocity = Discs(RADIUS, SPEED * FRAME), np.zeros((2, 2))
    for distance in (0.2, 0.0855, 0.0858, 0.0865, 0.0855, 0.09, 0.0855):
        discs.disturb()
        discs.part(np.array([[0.0, distance], [0.0, 0.0]]), velocity, solid(2))
    assert discs.contacts == 2


def test_a_lifted_disc_touches_nobody():
    discs = Discs(RADIUS, SPEED * FRAME)
    xy = np.array([[0.0, 0.05, 0.5], [0.0, 0.0, 0.0]])
    before = xy.copy()
    discs.part(xy, np.zeros((2, 3)), np.array([True, False, True]))
    np.testing.assert_array_equal(xy, before)
    assert discs.contacts == 0


def test_two_discs_in_one_place_part():
    discs, xy = Discs(RADIUS, SPEED * FRAME), np.zeros((2, 2))
    discs.part(xy, np.zeros((2, 2)), solid(2))
    assert nearest(xy) == pytest.approx(2 * RADIUS, abs=1e-3)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(2, 12))
def test_a_crowd_on_its_way_to_one_point_never_overlaps(seed, n):
    rng = np.random.default_rng(seed)
    xy = np.stack(np.meshgrid(np.arange(4) * 0.1, np.arange(3) * 0.1)).reshape(2, -1)
    xy = xy[:, rng.permutation(12)[:n]] + rng.uniform(-0.005, 0.005, (2, n))
    discs, goal = Discs(RADIUS, SPEED * FRAME), rng.uniform(0.0, 0.3, (2, 1))
    worst = 1.0
    for _ in range(300):
        away = goal - xy
        velocity = SPEED * away / np.maximum(np.hypot(*away), 1e-3)
        xy += velocity * FRAME
        middle = xy.mean(axis=1)
        momentum = velocity.sum(axis=1)
        discs.part(xy, velocity, solid(n))
        np.testing.assert_allclose(xy.mean(axis=1), middle, atol=1e-12)
        np.testing.assert_allclose(velocity.sum(axis=1), momentum, atol=1e-12)
        worst = min(worst, nearest(xy))
    assert worst > 2 * RADIUS - 0.0005
    assert discs.contacts >= n - 1
