"""The EPFL report's convolution network: trained in torch (extra ``cnn``), run in NumPy ever after."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.linear_model import LogisticRegression

from armspan.errors import MissingExtra, ModelError
from armspan.gesture.kernels import checked_takes
from armspan.gesture.network import Block, Network, softmax

TAPS = (7, 5, 3)
BATCH = 32
EPOCHS = 20
"""A set too large for ``steps`` batches is still seen this often."""
RATE = 3e-3
DECAY = 0.01
DROPOUT = 0.2
SMOOTHING = 0.1
"""Share of each label that is spread over all classes."""
MIXUP = 0.4
"""Both parameters of the beta distribution of a take's share in a mixture of two."""
WARP = 0.2
"""Deviation of the logarithm of the speed at five times of a take."""
JITTER = 0.1
"""Noise, in deviations of the channel."""


PULL = 0.01
"""Inverse penalty of the refitted head, on embeddings of unit deviation."""


class Cnn(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn has no types
    """An ensemble of 1D convolution networks: three blocks of convolution, batch norm and ReLU, averaged over time.

    X is (n, c, t), raw: channels are standardised by the training takes. ``filters`` per block, ``members`` of the
    ensemble, ``steps`` of AdamW at least for each. The same ``seed`` gives the same model on one machine. Only `fit`
    needs torch.
    """

    def __init__(self, filters: int = 64, members: int = 3, steps: int = 400, seed: int = 0) -> None:
        self.filters = filters
        self.members = members
        self.steps = steps
        self.seed = seed

    def fit(self, X: NDArray[Any], y: NDArray[Any], groups: NDArray[Any] | None = None) -> Self:
        """Train; groups change nothing.

        Raises:
            MissingExtra: torch is not installed.
            ModelError: the takes cannot teach.

        """
        X, self.classes_, labels = checked_takes(X, y)
        if X.shape[2] < 2 ** (len(TAPS) - 1):
            raise ModelError(
                f"Takes of {X.shape[2]} times: this network halves them {len(TAPS) - 1} times and needs "
                f"{2 ** (len(TAPS) - 1)} at least: cut longer takes."
            )
        centre, spread = _standards(X)
        Z = ((X - centre[:, None]) / spread[:, None]).astype(np.float32)
        with quiet_torch(self.seed) as torch:
            nets = [self._trained(torch, Z, labels, np.random.default_rng([self.seed, k])) for k in range(self.members)]
        self.network_ = folded(nets, centre, spread)
        # Kept for `refine`, which has no generic takes any more.
        self.embeddings_, self.labels_ = self.network_.embed(X), self.classes_[labels]
        return self

    def _trained(self, torch: Any, Z: NDArray[np.float32], labels: NDArray[Any], rng: np.random.Generator) -> Any:
        net = layers(torch, Z.shape[1], self.filters, len(self.classes_))
        return train(torch, net, Z, np.eye(len(self.classes_), dtype=np.float32)[labels], self.steps, rng)

    def decision_function(self, X: NDArray[Any]) -> NDArray[Any]:
        """A value per class (n, n_classes): the members' mean of the logarithms of odds, up to a constant."""
        return self.network_.scores(X)

    def predict_proba(self, X: NDArray[Any]) -> NDArray[Any]:
        """Probabilities (n, n_classes), as trained with smoothed labels."""
        return softmax(self.decision_function(X))

    def predict(self, X: NDArray[Any]) -> NDArray[Any]:
        """The class of the largest value (n,)."""
        return np.asarray(self.classes_[self.decision_function(X).argmax(axis=1)])

    def refine(self, X: NDArray[Any], y: NDArray[Any], weight: float = 50.0) -> Self:
        """A copy whose head is refitted on the generic takes and a person's own, these ``weight`` times as heavy.

        A label that is new becomes a new class. Refining again starts from the generic takes again: give all own takes
        at once. Needs no torch. ModelError for takes that do not fit.
        """
        y = np.asarray(y)
        y = y.astype(np.str_) if y.dtype == object else y
        E = np.concatenate([self.embeddings_, self.network_.embed(np.asarray(X, dtype=np.float64))])
        if len(E) != len(self.labels_) + len(y) or not np.isfinite(E).all():
            raise ModelError(f"{len(X)} takes with {len(y)} labels: expected one label each, and no gaps in the takes.")
        emphasis = np.r_[np.ones(len(self.labels_)), np.full(len(y), weight)]
        fresh = type(self)(**self.get_params())
        fresh.embeddings_, fresh.labels_ = self.embeddings_, self.labels_
        fresh.classes_, weights, bias = refitted_head(E, np.concatenate([self.labels_, y]), emphasis)
        fresh.network_ = replace(self.network_, weights=weights, bias=bias)
        return fresh

    def state(self) -> dict[str, Any]:
        """Everything `from_state` needs: arrays and numbers."""
        fitted = {"classes": self.classes_, "embeddings": self.embeddings_, "labels": self.labels_}
        return {**self.get_params(), **fitted, **self.network_.state()}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """The fitted classifier that was written down."""
        self = cls(**{name: int(state[name]) for name in ("filters", "members", "steps", "seed")})
        self.classes_, self.labels_ = np.asarray(state["classes"]), np.asarray(state["labels"])
        self.embeddings_ = np.asarray(state["embeddings"])
        self.network_ = Network.from_state(state)
        return self


def _standards(X: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Each channel's mean and deviation (c,); a channel that never moves keeps its unit."""
    centre, spread = X.mean(axis=(0, 2)), X.std(axis=(0, 2))
    return centre, np.where(spread > 1e-9 * np.maximum(1.0, np.abs(centre)), spread, 1.0)


def refitted_head(
    E: NDArray[Any], labels: NDArray[Any], emphasis: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[np.float32], NDArray[np.float32]]:
    """Classes, weights (d, classes) and bias (classes,) of logistic regression on embeddings (n, d), weighted (n,)."""
    centre, spread = E.mean(axis=0, dtype=np.float64), E.std(axis=0, dtype=np.float64) + 1e-6
    head = LogisticRegression(C=PULL, max_iter=1000).fit((E - centre) / spread, labels, sample_weight=emphasis)
    weights, bias = head.coef_, head.intercept_
    if len(weights) == 1:  # two classes: scikit-learn keeps one row, its sign tells them apart
        weights, bias = np.concatenate([-weights, weights]) / 2, np.r_[-bias, bias] / 2
    weights = weights / spread
    return head.classes_, weights.T.astype(np.float32), (bias - weights @ centre).astype(np.float32)


@contextmanager
def quiet_torch(seed: int) -> Iterator[Any]:
    """Torch with one thread, deterministic, its dice thrown from ``seed``; all put back afterwards."""
    try:
        import torch
    except ImportError:
        raise MissingExtra("torch", "cnn") from None
    threads, strict = torch.get_num_threads(), torch.are_deterministic_algorithms_enabled()
    with torch.random.fork_rng(devices=[]):
        try:
            torch.manual_seed(seed)
            torch.set_num_threads(1)
            torch.use_deterministic_algorithms(True)
            yield torch
        finally:
            torch.set_num_threads(threads)
            torch.use_deterministic_algorithms(strict)


def layers(torch: Any, channels: int, filters: int, classes: int) -> Any:
    """The untrained network on (n, c, t), for logits (n, classes)."""
    nn, parts = torch.nn, []
    for k, taps in enumerate(TAPS):
        parts += [
            nn.Conv1d(filters if k else channels, filters, taps, padding=taps // 2, bias=False),
            nn.BatchNorm1d(filters),
            nn.ReLU(),
        ]
        if k < len(TAPS) - 1:
            parts.append(nn.MaxPool1d(2))
    head = [nn.AdaptiveAvgPool1d(1), nn.Flatten(), nn.Dropout(DROPOUT), nn.Linear(filters, classes)]
    return nn.Sequential(*parts, *head)


def train(
    torch: Any, net: Any, Z: NDArray[np.float32], targets: NDArray[np.float32], steps: int, rng: np.random.Generator
) -> Any:
    """The network trained on standardised takes Z (n, c, t) and one-hot targets (n, classes), ready to judge.

    AdamW under a one-cycle cosine schedule, on smoothed labels and takes made anew for every batch.
    """
    size = min(BATCH, len(Z))
    steps = max(steps, EPOCHS * len(Z) // size)
    targets = (1 - SMOOTHING) * targets + np.float32(SMOOTHING / targets.shape[1])
    optimiser = torch.optim.AdamW(net.parameters(), lr=RATE, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, RATE, total_steps=steps, pct_start=0.1)
    drawn = batches(len(Z), size, rng)
    net.train()
    for _ in range(steps):
        rows = next(drawn)
        x, wanted = mixed(varied(Z[rows], rng), targets[rows], rng)
        logits = torch.log_softmax(net(torch.from_numpy(x)), 1)
        loss = -(torch.from_numpy(wanted) * logits).sum(1).mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    return net.eval()


def batches(n: int, size: int, rng: np.random.Generator) -> Iterator[NDArray[np.intp]]:
    """Batches of ``size`` of n rows without end; every row comes once before one comes twice."""
    pool = np.empty(0, dtype=np.intp)
    while True:
        if len(pool) < size:
            pool = np.concatenate([pool, rng.permutation(n)])
        yield pool[:size]
        pool = pool[size:]


def varied(x: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Takes (n, c, t) as they might have been made a moment faster, slower, earlier or later, and less quietly."""
    at = warped_times(len(x), x.shape[2], rng)
    before = np.minimum(at.astype(np.intp), x.shape[2] - 2)
    part = (at - before)[:, None].astype(np.float32)
    left = np.take_along_axis(x, np.broadcast_to(before[:, None], x.shape), axis=2)
    right = np.take_along_axis(x, np.broadcast_to(before[:, None] + 1, x.shape), axis=2)
    noise = JITTER * rng.standard_normal(x.shape, dtype=np.float32)
    return np.asarray(left + part * (right - left) + noise)


def warped_times(n: int, t: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Where each of n takes is read (n, t), in samples: never backwards, never outside.

    The speed is log-linear between five random values; then the whole is zoomed about its middle by half that
    deviation and shifted by a tenth of it.
    """
    knots = np.exp(WARP * rng.standard_normal((n, 5)))
    at = np.linspace(0.0, 4.0, t - 1)
    knot = np.minimum(at.astype(np.intp), 3)
    speed = knots[:, knot] + (at - knot) * (knots[:, knot + 1] - knots[:, knot])
    times = np.concatenate([np.zeros((n, 1)), np.cumsum(speed, axis=1)], axis=1)
    times *= (t - 1) / times[:, -1:]
    zoom = np.exp(WARP / 2 * rng.standard_normal((n, 1)))
    shift = WARP / 10 * t * rng.standard_normal((n, 1))
    return np.asarray(np.clip((times - (t - 1) / 2) * zoom + (t - 1) / 2 + shift, 0.0, t - 1))


def mixed(
    x: NDArray[np.float32], targets: NDArray[np.float32], rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Each take and its target mixed with another's by a random share (mixup: Zhang et al. 2018)."""
    other = rng.permutation(len(x))
    share = rng.beta(MIXUP, MIXUP, (len(x), 1)).astype(np.float32)
    blend = share[:, :, None] * x + (1 - share[:, :, None]) * x[other]
    return blend, share * targets + (1 - share) * targets[other]


def folded(nets: list[Any], centre: NDArray[Any], spread: NDArray[Any]) -> Network:
    """Trained networks as one `Network`: batch norm inside the convolutions, the heads' mean as one head."""
    members = [list(net) for net in nets]
    convolutions = [k for k, part in enumerate(members[0]) if hasattr(part, "kernel_size") and hasattr(part, "weight")]
    blocks = []
    for k in convolutions:
        pairs = [_folded(parts[k], parts[k + 1]) for parts in members]
        weights, offset = (np.stack(arrays).astype(np.float32) for arrays in zip(*pairs, strict=True))
        blocks.append(Block(weights, offset, k != convolutions[-1]))
    head = np.concatenate([_array(parts[-1].weight).T for parts in members]) / len(members)
    bias = np.mean([_array(parts[-1].bias) for parts in members], axis=0)
    return Network(centre, spread, tuple(blocks), head.astype(np.float32), bias.astype(np.float32))


def _folded(convolution: Any, norm: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    gain = _array(norm.weight) / np.sqrt(_array(norm.running_var) + norm.eps)
    return _array(convolution.weight) * gain[:, None, None], _array(norm.bias) - _array(norm.running_mean) * gain


def _array(tensor: Any) -> NDArray[np.float64]:
    return np.asarray(tensor.detach().numpy(), dtype=np.float64)
