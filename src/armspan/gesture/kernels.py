"""The classifier of choice: random convolution kernels and a ridge head, trained in a second without a compiler."""

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, ClassifierMixin

from armspan.errors import ModelError
from armspan.gesture.kernel_features import KernelFeatures
from armspan.gesture.kernel_ridge import Ridge


def checked_takes(X: Any, y: Any) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Takes (n, c, t) as finite floats, their classes, sorted, and each take's number among them (else ModelError)."""
    X, y = np.asarray(X, dtype=np.float64), np.asarray(y)
    y = y.astype(np.str_) if y.dtype == object else y  # objects could only be stored pickled
    if X.ndim != 3 or not X.size or len(X) != len(y):
        raise ModelError(f"Takes of shape {X.shape} with {len(y)} labels: expected (takes, channels, times), one each.")
    if not np.isfinite(X).all():
        raise ModelError("The takes hold NaN or infinity: fill or drop the gaps before training.")
    classes, labels = np.unique(y, return_inverse=True)
    if len(classes) < 2:
        raise ModelError(f"All {len(y)} takes are {classes[0]!r}: record at least one other gesture, or null.")
    return X, classes, labels


SPEED, SHIFT = 0.05, 0.05
"""How much slower or faster, and how much earlier or later (as a share of the take), a copy is at most."""


def retimed(X: NDArray[Any], rng: np.random.Generator) -> NDArray[Any]:
    """Takes (n, c, t) a little slower or faster about their middle, and earlier or later; their ends are held."""
    n, _, times = X.shape
    middle = (times - 1) / 2
    speed = 1.0 + SPEED * rng.uniform(-1.0, 1.0, (n, 1))
    shift = SHIFT * (times - 1) * rng.uniform(-1.0, 1.0, (n, 1))
    at = np.clip(speed * (np.arange(times) - middle) + middle + shift, 0.0, times - 1.0)
    before = at.astype(np.int64)[:, None, :]
    after = np.minimum(before + 1, times - 1)
    share = at[:, None, :] - before
    return np.asarray(
        np.take_along_axis(X, before, axis=2) * (1.0 - share) + np.take_along_axis(X, after, axis=2) * share
    )


class Kernels(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn has no types
    """Random convolution kernels with a ridge head.

    X is (n, c, t). ``n_features`` shares above a threshold are computed over ``n_dilations`` dilations, beside each
    kernel's wins in its group and plain statistics. The penalty leaves one of ``groups`` (a person) out at a time where
    there are two or more, else one take. Each take also trains in ``copies`` retimed copies, as far as that makes no
    more than ``most_takes`` in all. The same ``seed`` gives the same model.
    """

    def __init__(
        self, n_features: int = 4000, n_dilations: int = 6, copies: int = 2, most_takes: int = 1000, seed: int = 0
    ) -> None:
        self.n_features = n_features
        self.n_dilations = n_dilations
        self.copies = copies
        self.most_takes = most_takes
        self.seed = seed

    def fit(self, X: NDArray[Any], y: NDArray[Any], groups: NDArray[Any] | None = None) -> Self:
        """Learn from takes and their labels; ModelError for takes that cannot teach."""
        X, self.classes_, labels = checked_takes(X, y)
        rng = np.random.default_rng(self.seed)
        self.features_ = KernelFeatures.fit(X, self.n_features, self.n_dilations, rng)
        left_out = np.arange(len(X)) if groups is None or len(set(groups)) < 2 else np.asarray(groups)
        copies = max(0, min(self.copies, self.most_takes // len(X) - 1))
        F = self.features_.transform(np.concatenate([X, *(retimed(X, rng) for _ in range(copies))]))
        # copies are left out together with their take, which they would otherwise give away
        taught, left_out = np.tile(labels, copies + 1), np.tile(left_out, copies + 1)
        self.head_ = Ridge.fit(F, taught, len(self.classes_), left_out)
        return self

    def decision_function(self, X: NDArray[Any]) -> NDArray[Any]:
        """A value per class (n, n_classes), about +1 for the right one and -1 for the others."""
        return self.head_.scores(self.features_.transform(np.asarray(X, dtype=np.float64)))

    def predict(self, X: NDArray[Any]) -> NDArray[Any]:
        """The class of the largest value (n,)."""
        return np.asarray(self.classes_[self.decision_function(X).argmax(axis=1)])

    def state(self) -> dict[str, Any]:
        """Everything `from_state` needs: arrays, numbers, strings and lists of them, no objects."""
        parts = {**_named("features", self.features_.state()), **_named("head", self.head_.state())}
        return {**self.get_params(), "classes": self.classes_, **parts}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """The fitted classifier that was written down."""
        self = cls(**{name: int(state[name]) for name in ("n_features", "n_dilations", "copies", "most_takes", "seed")})
        self.classes_ = np.asarray(state["classes"])
        self.features_ = KernelFeatures.from_state(_part("features", state))
        self.head_ = Ridge.from_state(_part("head", state))
        return self


def _named(name: str, state: dict[str, Any]) -> dict[str, Any]:
    return {f"{name}_{key}": value for key, value in state.items()}


def _part(name: str, state: dict[str, Any]) -> dict[str, Any]:
    return {key.removeprefix(f"{name}_"): value for key, value in state.items() if key.startswith(f"{name}_")}
