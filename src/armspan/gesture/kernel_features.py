"""Features of a take: how often random convolution kernels answer above a threshold, or loudest of their group.

Written from the published ideas: the 84 two-valued kernels of length 9, dilations that grow with the take and
proportions of positive values (Dempster, Schmidt and Webb 2021, MiniRocket); counting which kernel of a group answers
loudest, all of them in a tie (Dempster, Schmidt and Webb 2023, Hydra); plain statistics of parts of the take beside.
"""

from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from armspan.errors import ModelError

LENGTH = 9
"""Taps of a kernel: six of weight -1 and three of weight 2, so that each kernel sums to zero."""

PADDINGS = ("constant", "edge")
"""What lies beyond a take's ends: nothing (zeros) answers to where a take starts, its held end does not."""

RIVALS = 12
"""Kernels of one group, of which one answers loudest."""

PARTS = (1, 2, 4)
"""A take's statistics are taken of the whole, its halves and its quarters."""

_REACH = LENGTH // 2
_SAMPLED = 16  # takes whose answers the thresholds are drawn from
_CHUNK = 64  # takes at once, so that thousands of windows fit in memory


def two_valued_kernels() -> NDArray[Any]:
    """All kernels (84, 9) with three taps of 2 among nine of -1 (MiniRocket, section 3)."""
    kernels = np.full((84, LENGTH), -1.0, dtype=np.float32)
    for kernel, taps in zip(kernels, combinations(range(LENGTH), 3), strict=True):
        kernel[list(taps)] = 2.0
    return kernels


def spread_dilations(n_times: int, n: int) -> NDArray[Any]:
    """Up to ``n`` different dilations, from 1 to the one whose kernel spans the take, evenly in their logarithm."""
    largest = max((n_times - 1) / (LENGTH - 1), 1.0)
    return np.unique(np.floor(np.logspace(0.0, np.log2(largest), n, base=2.0) + 1e-9).astype(np.int64))


@dataclass(frozen=True, slots=True, eq=False)
class Bank:
    """The 84 kernels at one dilation and padding: ``weights`` (84, 9 c), tap by tap; ``thresholds`` (84, b)."""

    dilation: int
    padding: str
    weights: NDArray[Any]
    thresholds: NDArray[Any]

    def answers(self, X: NDArray[Any]) -> NDArray[Any]:
        """The kernels' convolutions (n, 84, t) with takes X (n, c, t)."""
        return np.asarray(np.matmul(self.weights, _shifted(X, self.dilation, self.padding)))

    def features(self, X: NDArray[Any]) -> list[NDArray[Any]]:
        """Shares of time above each threshold (n, 84 b), and roots of the shares won in a group (n, 84)."""
        answers = self.answers(X)
        n, kernels, times = answers.shape
        above = answers[:, :, None] > self.thresholds[:, :, None]
        rivals = answers.reshape(n, kernels // RIVALS, RIVALS, times)
        wins = rivals == rivals.max(axis=2, keepdims=True)
        return [_share(above), np.sqrt(_share(wins))]


def _share(hits: NDArray[Any]) -> NDArray[Any]:
    """The share of True along the last axis, per item in a row."""
    counts = hits.sum(axis=-1, dtype=np.uint32).astype(np.float32)
    return np.asarray(counts.reshape(len(hits), -1) / np.float32(hits.shape[-1]))


def _shifted(X: NDArray[Any], dilation: int, padding: Any) -> NDArray[Any]:
    """The nine shifts of every channel under one another (n, 9 c, t)."""
    reach, times = _REACH * dilation, X.shape[2]
    padded = np.pad(X, ((0, 0), (0, 0), (reach, reach)), mode=padding)
    return np.concatenate([padded[:, :, k * dilation : k * dilation + times] for k in range(LENGTH)], axis=1)


def _mixed_kernels(n_channels: int, rng: np.random.Generator) -> NDArray[Any]:
    """Each kernel on a random subset of channels with random signs (84, 9 c): small subsets as likely as large ones."""
    mix = np.zeros((84, n_channels), dtype=np.float32)
    for row in mix:
        size = min(int(2 ** rng.uniform(0.0, np.log2(min(n_channels, LENGTH) + 1))), n_channels)
        row[rng.choice(n_channels, size, replace=False)] = rng.choice((-1.0, 1.0), size) / np.sqrt(size)
    return (two_valued_kernels()[:, :, None] * mix[:, None, :]).reshape(84, -1)


def _drawn_thresholds(answers: NDArray[Any], n: int, rng: np.random.Generator) -> NDArray[Any]:
    """Quantiles (84, n) of the answers (takes, 84, t): one at a random place of each n-th part of their range."""
    ordered = np.sort(answers.transpose(1, 0, 2).reshape(84, -1), axis=1)
    levels = (np.arange(n) + rng.uniform(size=(84, n))) / n
    return np.take_along_axis(ordered, (levels * ordered.shape[1]).astype(np.int64), axis=1)


def _statistics(X: NDArray[Any]) -> list[NDArray[Any]]:
    """Mean, deviation, least and largest value of every channel in each part of the take."""
    found = []
    for parts in PARTS:
        edges = np.unique(np.linspace(0, X.shape[2], parts + 1).astype(np.int64))
        for start, end in pairwise(edges):
            piece = X[:, :, start:end]
            found += [piece.mean(axis=2), piece.std(axis=2), piece.min(axis=2), piece.max(axis=2)]
    return found


@dataclass(frozen=True, slots=True, eq=False)
class KernelFeatures:
    """A fitted transform: channels centred by ``mean`` and divided by ``scale`` (c,), then every bank's features."""

    mean: NDArray[Any]
    scale: NDArray[Any]
    n_times: int
    banks: tuple[Bank, ...]

    @classmethod
    def fit(cls, X: NDArray[Any], n_features: int, n_dilations: int, rng: np.random.Generator) -> Self:
        """Draw kernels and thresholds for takes X (n, c, t), about ``n_features`` shares above a threshold in all."""
        mean, deviation = X.mean(axis=(0, 2)), X.std(axis=(0, 2))
        scale = np.where(deviation > 1e-9 * np.maximum(1.0, np.abs(mean)), deviation, 1.0)
        self = cls(mean, scale, X.shape[2], ())
        sampled = self._standardised(X[rng.choice(len(X), min(len(X), _SAMPLED), replace=False)])
        places = [(int(d), p) for d in spread_dilations(X.shape[2], n_dilations) for p in PADDINGS]
        each = max(1, round(n_features / (84 * len(places))))
        banks = tuple(_drawn_bank(sampled, d, p, each, rng) for d, p in places)
        return cls(mean, scale, X.shape[2], banks)

    def transform(self, X: NDArray[Any]) -> NDArray[Any]:
        """Features (n, p), single precision; ModelError for takes of other channels or another length."""
        wanted = (len(self.mean), self.n_times)
        if X.ndim != 3 or X.shape[1:] != wanted:
            raise ModelError(
                f"Takes of shape {X.shape} do not fit this model, which was trained on (takes, {wanted[0]} channels, "
                f"{wanted[1]} times): resample them, or train again."
            )
        return np.concatenate([self._features(X[i : i + _CHUNK]) for i in range(0, max(len(X), 1), _CHUNK)])

    def _features(self, X: NDArray[Any]) -> NDArray[Any]:
        Z = self._standardised(X)
        parts = _statistics(Z)
        for bank in self.banks:
            parts += bank.features(Z)
        return np.concatenate(parts, axis=1)

    def _standardised(self, X: NDArray[Any]) -> NDArray[Any]:
        """Centred and scaled, in single precision, which is enough for counting and twice as fast."""
        return np.asarray((X - self.mean[:, None]) / self.scale[:, None], dtype=np.float32)

    def state(self) -> dict[str, Any]:
        """Arrays and plain numbers from which `from_state` rebuilds it."""
        return {
            "mean": self.mean,
            "scale": self.scale,
            "n_times": self.n_times,
            "dilations": [bank.dilation for bank in self.banks],
            "paddings": [bank.padding for bank in self.banks],
            "weights": np.stack([bank.weights for bank in self.banks]),
            "thresholds": np.stack([bank.thresholds for bank in self.banks]),
        }

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """The transform that was written down."""
        rows = zip(state["dilations"], state["paddings"], state["weights"], state["thresholds"], strict=True)
        banks = tuple(Bank(int(d), str(p), np.asarray(w), np.asarray(h)) for d, p, w, h in rows)
        return cls(np.asarray(state["mean"]), np.asarray(state["scale"]), int(state["n_times"]), banks)


def _drawn_bank(sampled: NDArray[Any], dilation: int, padding: str, each: int, rng: np.random.Generator) -> Bank:
    weights = _mixed_kernels(sampled.shape[1], rng)
    answers = Bank(dilation, padding, weights, np.empty((84, 0))).answers(sampled)
    return Bank(dilation, padding, weights, _drawn_thresholds(answers, each, rng))
