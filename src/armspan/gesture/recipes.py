"""What is done to takes before a model sees them: fitted on training takes, then the same for every window."""

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, TransformerMixin

from armspan.errors import ModelError


def checked_channels(X: NDArray[Any], groups: tuple[int, ...] | None) -> tuple[NDArray[Any], NDArray[Any]]:
    """Takes (n, c, t) and the sensor number (c,) of each channel; without groups every channel is its own sensor."""
    X = np.asarray(X, dtype=np.float64)
    if X.ndim != 3:
        raise ModelError(f"Takes of shape {X.shape}: expected (takes, channels, times).")
    sensors = np.arange(X.shape[1]) if groups is None else np.asarray(groups, dtype=np.int64)
    if len(sensors) != X.shape[1]:
        raise ModelError(f"{X.shape[1]} channels, but the recipe's groups name {len(sensors)}: give one per channel.")
    return X, sensors


def fitting_channels(X: NDArray[Any], n: int) -> NDArray[Any]:
    """Takes (n, c, t) that have as many channels as the recipe was fitted on."""
    X, _ = checked_channels(X, None)
    if X.shape[1] != n:
        raise ModelError(f"{X.shape[1]} channels, but the recipe was fitted on {n}: use the same.")
    return X


class Standard(TransformerMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn has no types
    """Each channel centred, then divided by its sensor's one scale, both from the training takes.

    ``groups`` are the channels' sensors (one band's accelerometer, say): channels of one sensor share a scale, so that
    their proportions, and with them directions, are kept. Levels such as gravity's are kept too: a take is not centred
    on itself.
    """

    def __init__(self, groups: tuple[int, ...] | None = None) -> None:
        self.groups = groups

    def fit(self, X: NDArray[Any], y: Any = None) -> Self:
        """Measure centres and scales (c,) of takes X (n, c, t)."""
        X, sensors = checked_channels(X, self.groups)
        self.mean_ = X.mean(axis=(0, 2))
        variance = np.square(X - self.mean_[:, None]).mean(axis=(0, 2))
        size = np.array([np.sqrt(variance[sensors == sensor].mean()) for sensor in sensors])
        level = np.maximum(1.0, np.abs(self.mean_))
        self.scale_ = np.where(size > 1e-9 * level, size, 1.0)  # a sensor that never moved stays at zero
        return self

    def transform(self, X: NDArray[Any]) -> NDArray[Any]:
        """Takes (n, c, t) in training units."""
        X = fitting_channels(X, len(self.mean_))
        return np.asarray((X - self.mean_[:, None]) / self.scale_[:, None])

    def state(self) -> dict[str, Any]:
        """Arrays and lists from which `from_state` rebuilds it."""
        return {"groups": _listed(self.groups), "mean": self.mean_, "scale": self.scale_}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """The fitted recipe that was written down."""
        self = cls(_named(state["groups"]))
        self.mean_, self.scale_ = np.asarray(state["mean"]), np.asarray(state["scale"])
        return self


class Report(TransformerMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn has no types
    """Each channel of each take stretched to [-1, 1], then its first differences: the EPFL report's front end.

    Nothing is learnt; ``groups`` are taken so that both recipes are made alike. A channel that does not move gives
    zeros. One sample is lost.
    """

    def __init__(self, groups: tuple[int, ...] | None = None) -> None:
        self.groups = groups

    def fit(self, X: NDArray[Any], y: Any = None) -> Self:
        """Nothing but a check of the shape."""
        self.n_channels_ = checked_channels(X, self.groups)[0].shape[1]
        return self

    def transform(self, X: NDArray[Any]) -> NDArray[Any]:
        """Takes (n, c, t - 1)."""
        X = fitting_channels(X, self.n_channels_)
        least = X.min(axis=2, keepdims=True)
        span = X.max(axis=2, keepdims=True) - least
        return np.diff(2.0 * (X - least) / np.where(span > 0.0, span, 1.0) - 1.0, axis=2)

    def state(self) -> dict[str, Any]:
        """Lists and numbers from which `from_state` rebuilds it."""
        return {"groups": _listed(self.groups), "n_channels": self.n_channels_}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """The recipe that was written down."""
        self = cls(_named(state["groups"]))
        self.n_channels_ = int(state["n_channels"])
        return self


def _listed(groups: tuple[int, ...] | None) -> list[int]:
    """Groups as a list; an empty one says that there are none."""
    return [] if groups is None else [int(group) for group in groups]


def _named(groups: Any) -> tuple[int, ...] | None:
    return tuple(int(group) for group in groups) or None
