"""A trained convolution network run in NumPy: what is left of training when torch is not there."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy import special

from armspan.errors import ModelError

CHUNK = 64
"""Windows computed at a time, so that the unfolded inputs stay small."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """One convolution over time with batch norm folded in, then ReLU, then halving by the larger of two neighbours.

    ``weights`` (members, out, in, taps) with an odd number of taps, ``offset`` (members, out); the last block of a
    network does not halve.
    """

    weights: NDArray[np.float32]
    offset: NDArray[np.float32]
    halves: bool

    def run(self, x: NDArray[np.float32]) -> NDArray[np.float32]:
        """Signals (n, members or 1, in, t) to (n, members, out, t or t // 2)."""
        members, out, channels, taps = self.weights.shape
        padded = np.pad(x, ((0, 0), (0, 0), (0, 0), (taps // 2, taps // 2)))
        shifts = np.lib.stride_tricks.sliding_window_view(padded, x.shape[-1], axis=-1)  # (n, m, in, taps, t)
        columns = shifts.reshape(*x.shape[:2], channels * taps, x.shape[-1])
        y = np.matmul(self.weights.reshape(members, out, channels * taps), columns)
        y += self.offset[:, :, None]
        np.maximum(y, 0.0, out=y)
        even = y.shape[-1] // 2 * 2
        return np.asarray(np.maximum(y[..., 0:even:2], y[..., 1:even:2]) if self.halves else y)


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """An ensemble of small convolution networks with one linear head on all of their averages over time.

    Scores = embedding @ ``weights`` + ``bias``; the embedding (d,) holds, member after member, each last filter's mean
    over time. ``centre`` and ``spread`` (c,) standardise the raw channels first; ``weights`` are (d, classes), ``bias``
    (classes,).
    """

    centre: NDArray[Any]
    spread: NDArray[Any]
    blocks: tuple[Block, ...]
    weights: NDArray[np.float32]
    bias: NDArray[np.float32]

    @property
    def shortest(self) -> int:
        """The fewest times a window must have: one is left after all halvings."""
        return int(2 ** sum(block.halves for block in self.blocks))

    def embed(self, X: NDArray[Any]) -> NDArray[np.float32]:
        """Embeddings (n, d) of windows (n, c, t); ModelError where they do not fit."""
        X = np.asarray(X)
        if X.ndim != 3 or X.shape[1] != len(self.centre) or X.shape[2] < self.shortest:
            raise ModelError(
                f"Windows of shape {X.shape} do not fit this network, which takes (windows, {len(self.centre)} "
                f"channels, {self.shortest} times or more): use the channels it was trained on."
            )
        parts = [self._embed(X[k : k + CHUNK]) for k in range(0, len(X), CHUNK)]
        return np.concatenate(parts) if parts else np.empty((0, len(self.weights)), np.float32)

    def _embed(self, X: NDArray[Any]) -> NDArray[np.float32]:
        # Centred in double precision: a small motion on a large level would lose digits.
        x = ((X - self.centre[:, None]) / self.spread[:, None]).astype(np.float32)[:, None]
        for block in self.blocks:
            x = block.run(x)
        return np.asarray(x.mean(axis=-1).reshape(len(X), -1))

    def scores(self, X: NDArray[Any]) -> NDArray[np.float64]:
        """One value per class (n, classes) of windows (n, c, t)."""
        return self.judge(self.embed(X))

    def judge(self, embedding: NDArray[np.float32]) -> NDArray[np.float64]:
        """The head alone: scores (n, classes) of embeddings (n, d)."""
        return np.asarray(embedding @ self.weights + self.bias, dtype=np.float64)

    def state(self) -> dict[str, Any]:
        """Arrays from which `from_state` rebuilds it."""
        blocks = {
            f"block{k}_{name}": getattr(block, name)
            for k, block in enumerate(self.blocks)
            for name in ("weights", "offset")
        }
        return {**{name: getattr(self, name) for name in ("centre", "spread", "weights", "bias")}, **blocks}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """The network that was written down; entries of other names are left alone."""
        depth = sum(name.startswith("block") and name.endswith("_offset") for name in state)
        blocks = tuple(
            Block(
                np.asarray(state[f"block{k}_weights"], np.float32),
                np.asarray(state[f"block{k}_offset"], np.float32),
                k < depth - 1,
            )
            for k in range(depth)
        )
        centre, spread, weights, bias = (np.asarray(state[name]) for name in ("centre", "spread", "weights", "bias"))
        return cls(centre, spread, blocks, weights, bias)


def softmax(scores: NDArray[np.float64]) -> NDArray[np.float64]:
    """Probabilities (n, classes) of scores (n, classes)."""
    return np.asarray(special.softmax(scores, axis=1))
