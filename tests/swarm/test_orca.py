import numpy as np
import pytest

from armspan.swarm.orca import Pairs, avoidance_lines

REACH, HORIZON = 0.1, 1.0
BOTH = Pairs(np.array([0, 1]), np.array([1, 0]))


def lines(at, velocity, share=0.5, reach=REACH):
    expected = velocity[[1, 0]]
    return avoidance_lines(at, velocity, expected, BOTH, np.full(2, reach), np.full(2, share), HORIZON, 0.3)


def least_distance(at, velocity, seconds):
    """Of two that keep their velocities for so long, worked out from the parabola."""
    gap, speed = at[1] - at[0], velocity[1] - velocity[0]
    when = np.clip(-(gap @ speed) / max(speed @ speed, 1e-12), 0.0, seconds)
    return np.hypot(*(gap + speed * when))


@pytest.mark.parametrize("seed", range(6))
def test_two_that_choose_within_their_lines_do_not_meet_within_the_horizon(seed):
    rng = np.random.default_rng(seed)
    met = 0
    for _ in range(300):
        at, velocity = rng.uniform(-0.15, 0.15, (2, 2)), rng.uniform(-0.2, 0.2, (2, 2))
        if np.hypot(*(at[1] - at[0])) < REACH:
            continue
        met += least_distance(at, velocity, HORIZON) < REACH - 1e-6
        normal, offset = lines(at, velocity)
        wished = rng.uniform(-0.3, 0.3, (2, 2))
        over = np.maximum(np.einsum("pi,pi->p", normal, wished) - offset, 0.0)
        chosen = wished - normal * over[:, None]  # the nearest one on the allowed side
        assert least_distance(at, chosen, HORIZON) >= REACH - 1e-6
    assert met > 20


def test_two_heads_on_are_stopped_short_by_their_lines_alone():
    at, velocity = np.array([[0.0, 0.0], [0.3, 0.0]]), np.array([[0.15, 0.0], [-0.15, 0.0]])
    normal, offset = lines(at, velocity)
    # The gap of 0.2 m lasts a second: no change is needed before 0.2 m/s of approach, and 0.3 are there.
    assert np.einsum("pi,pi->p", normal, velocity) - offset == pytest.approx([0.05, 0.05], abs=0.03)


def test_who_alone_avoids_does_all_of_it():
    at, velocity = np.array([[0.0, 0.0], [0.2, 0.01]]), np.array([[0.15, 0.0], [0.0, 0.0]])
    normal, half = lines(at, velocity, share=0.5)
    _, whole = lines(at, velocity, share=1.0)
    speed = np.einsum("pi,pi->p", normal, velocity)
    assert speed - whole == pytest.approx(2 * (speed - half))


def test_two_that_are_too_near_part():
    at, velocity = np.array([[0.0, 0.0], [0.07, 0.0]]), np.zeros((2, 2))
    normal, offset = lines(at, velocity)
    assert normal[0] == pytest.approx([1.0, 0.0])
    assert offset == pytest.approx([-0.05, -0.05])  # 3 cm too near, in 0.3 s, half each


def test_two_in_the_same_place_part_anyhow():
    normal, offset = lines(np.zeros((2, 2)), np.zeros((2, 2)))
    assert np.isfinite(normal).all()
    assert np.isfinite(offset).all()
