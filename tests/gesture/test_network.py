"""The NumPy network against convolutions written out."""

import numpy as np
import pytest

from armspan.errors import ModelError
from armspan.gesture.network import CHUNK, Block, Network, softmax


def random_network(rng: np.random.Generator, members: int = 2, channels: int = 3, filters: int = 4) -> Network:
    blocks = tuple(
        Block(
            rng.normal(size=(members, filters, channels if k == 0 else filters, taps)).astype(np.float32),
            rng.normal(size=(members, filters)).astype(np.float32),
            k < 2,
        )
        for k, taps in enumerate((5, 3, 1))
    )
    weights = rng.normal(size=(members * filters, 3)).astype(np.float32)
    centre, spread = rng.normal(size=channels), rng.uniform(0.5, 2.0, channels)
    return Network(centre, spread, blocks, weights, rng.normal(size=3).astype(np.float32))


def plainly(network: Network, take: np.ndarray) -> np.ndarray:
    """One take (c, t), one number at a time, in double precision."""
    embedding: list[float] = []
    for member in range(len(network.blocks[0].weights)):
        x = (take - network.centre[:, None]) / network.spread[:, None]
        for block in network.blocks:
            weights, t = block.weights[member].astype(float), x.shape[1]
            half = weights.shape[2] // 2
            y = np.zeros((len(weights), t))
            for out in range(len(weights)):
                for i in range(t):
                    total = float(block.offset[member, out])
                    for k in range(-half, half + 1):
                        if 0 <= i + k < t:
                            total += float(weights[out, :, k + half] @ x[:, i + k])
                    y[out, i] = max(0.0, total)
            x = np.array([[max(row[i], row[i + 1]) for i in range(0, t - 1, 2)] for row in y]) if block.halves else y
        embedding += [float(row.mean()) for row in x]
    return np.array(embedding) @ network.weights.astype(float) + network.bias


@pytest.mark.parametrize("times", [4, 13, 16])
def test_scores_are_the_convolutions_written_out(times: int) -> None:
    rng = np.random.default_rng(times)
    network, takes = random_network(rng), rng.normal(size=(3, 3, times))
    expected = [plainly(network, take) for take in takes]
    np.testing.assert_allclose(network.scores(takes), expected, rtol=1e-4, atol=1e-4)


def test_known_by_hand() -> None:
    """A difference filter, ReLU and the larger of two, then the mean: rises 1, 0, 2, 0 of 0 1 1 3 give (1 + 2) / 2."""
    rise = Block(np.array([[[[-1.0, 1.0, 0.0]]]], np.float32), np.zeros((1, 1), np.float32), True)
    same = Block(np.ones((1, 1, 1, 1), np.float32), np.zeros((1, 1), np.float32), False)
    head = np.array([[1.0, -2.0]], np.float32)
    network = Network(np.zeros(1), np.ones(1), (rise, same), head, np.array([0.0, 10.0], np.float32))
    assert network.embed(np.array([[[0.0, 1, 1, 3]]])).tolist() == [[1.5]]
    assert network.scores(np.array([[[0.0, 1, 1, 3]]])).tolist() == [[1.5, 7.0]]


def test_many_windows_are_each_as_one_alone() -> None:
    rng = np.random.default_rng(1)
    network, takes = random_network(rng), rng.normal(size=(CHUNK + 3, 3, 20))
    alone = np.concatenate([network.scores(take[None]) for take in takes])
    np.testing.assert_allclose(network.scores(takes), alone, rtol=1e-5, atol=1e-5)
    assert network.scores(takes[:0]).shape == (0, 3)


def test_small_motion_on_a_large_level_is_not_rounded_away() -> None:
    rng = np.random.default_rng(2)
    network, takes = random_network(rng), rng.normal(size=(4, 3, 16))
    raised = Network(network.centre + 1e6, network.spread, network.blocks, network.weights, network.bias)
    np.testing.assert_allclose(raised.scores(takes + 1e6), network.scores(takes), rtol=1e-4, atol=1e-4)


def test_state_round_trip() -> None:
    rng = np.random.default_rng(3)
    network, takes = random_network(rng), rng.normal(size=(4, 3, 16))
    copy = Network.from_state({**network.state(), "something": 3})
    np.testing.assert_array_equal(copy.scores(takes), network.scores(takes))
    assert [block.halves for block in copy.blocks] == [True, True, False]


@pytest.mark.parametrize("shape", [(4, 16), (2, 4, 16), (2, 3, 3)])
def test_windows_that_do_not_fit(shape: tuple[int, ...]) -> None:
    network = random_network(np.random.default_rng(4))
    with pytest.raises(ModelError, match="3 channels, 4 times or more"):
        network.scores(np.zeros(shape))


def test_softmax() -> None:
    np.testing.assert_allclose(softmax(np.array([[0.0, np.log(3.0)], [1e4, 0.0]])), [[0.25, 0.75], [1.0, 0.0]])
