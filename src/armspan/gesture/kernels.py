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


class Kernels(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn has no types
    """Random convolution kernels with a ridge head.

    X is (n, c, t). ``n_features`` shares above a threshold are computed over ``n_dilations`` dilations, beside each
    kernel's wins in its group and plain statistics. The penalty leaves one of ``groups`` (a person) out at a time where
    there are two or more, else one take. The same ``seed`` gives the same model.
    """

    def __init__(self, n_features: int = 4000, n_dilations: int = 6, seed: int = 0) -> None:
        self.n_features = n_features
        self.n_dilations = n_dilations
        self.seed = seed

    def fit(self, X: NDArray[Any], y: NDArray[Any], groups: NDArray[Any] | None = None) -> Self:
        """Learn from takes and their labels; ModelError for takes that cannot teach."""
        X, self.classes_, labels = checked_takes(X, y)
        rng = np.random.default_rng(self.seed)
        self.features_ = KernelFeatures.fit(X, self.n_features, self.n_dilations, rng)
        people = None if groups is None else np.asarray(groups)
        self.head_ = Ridge.fit(self.features_.transform(X), labels, len(self.classes_), people)
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
        self = cls(int(state["n_features"]), int(state["n_dilations"]), int(state["seed"]))
        self.classes_ = np.asarray(state["classes"])
        self.features_ = KernelFeatures.from_state(_part("features", state))
        self.head_ = Ridge.from_state(_part("head", state))
        return self


def _named(name: str, state: dict[str, Any]) -> dict[str, Any]:
    return {f"{name}_{key}": value for key, value in state.items()}


def _part(name: str, state: dict[str, Any]) -> dict[str, Any]:
    return {key.removeprefix(f"{name}_"): value for key, value in state.items() if key.startswith(f"{name}_")}
