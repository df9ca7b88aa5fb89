"""The floor that every model must beat: the nearest training take under dynamic time warping."""

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, ClassifierMixin

from armspan.errors import ModelError
from armspan.gesture.kernels import checked_takes


def warped_distances(query: NDArray[Any], takes: NDArray[Any], band: float) -> NDArray[Any]:
    """Dependent DTW distances (n,) of a query (c, t) to takes (n, c, t), within a Sakoe-Chiba band.

    One warping path for all channels, steps (1, 0), (0, 1) and (1, 1) of equal weight, costs squared Euclidean, the
    root of their sum (Shokoohi-Yekta et al. 2017, DTW_D); ``band`` is the path's largest distance from the diagonal as
    a share of t. Costs of one anti-diagonal depend on the two before it only, so that all takes advance together.
    """
    times = query.shape[1]
    radius = int(np.floor(band * times + 1e-9))
    cost = np.full((3, len(takes), times + 1), np.inf)  # of the diagonals k - 2, k - 1 and k; column i + 1 is time i
    for k in range(2 * times - 1):
        first, last = max(0, k - times + 1, (k - radius + 1) // 2), min(k, times - 1, (k + radius) // 2)
        before2, before, now = cost[(k + 1) % 3], cost[(k + 2) % 3], cost[k % 3]
        now[:] = np.inf
        if first > last:
            continue  # a band of zero width skips every other anti-diagonal
        i = np.arange(first, last + 1)
        local = np.square(query[:, i] - takes[:, :, k - i]).sum(axis=1)
        paths = np.minimum(np.minimum(before[:, i], before[:, i + 1]), before2[:, i]) if k else np.zeros_like(local)
        now[:, i + 1] = local + paths
    return np.asarray(np.sqrt(cost[(2 * times - 2) % 3][:, times]))


class Dtw(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn has no types
    """The nearest neighbour under dependent DTW, channels standardised by the training takes.

    X is (n, c, t); ``band`` is the Sakoe-Chiba band as a share of t.
    """

    def __init__(self, band: float = 0.1) -> None:
        self.band = band

    def fit(self, X: NDArray[Any], y: NDArray[Any], groups: NDArray[Any] | None = None) -> Self:
        """Keep the takes; groups change nothing. ModelError for takes that cannot teach."""
        X, self.classes_, self.labels_ = checked_takes(X, y)
        self.mean_ = X.mean(axis=(0, 2))
        deviation = X.std(axis=(0, 2))
        self.scale_ = np.where(deviation > 1e-9 * np.maximum(1.0, np.abs(self.mean_)), deviation, 1.0)
        self.takes_ = self._standardised(X)
        return self

    def decision_function(self, X: NDArray[Any]) -> NDArray[Any]:
        """Minus the distance to the nearest training take of each class (n, n_classes)."""
        X = np.asarray(X, dtype=np.float64)
        if X.ndim != 3 or X.shape[1:] != self.takes_.shape[1:]:
            raise ModelError(
                f"Takes of shape {X.shape} do not fit this model, which was trained on (takes, "
                f"{self.takes_.shape[1]} channels, {self.takes_.shape[2]} times): resample them, or train again."
            )
        scores = np.empty((len(X), len(self.classes_)))
        for row, query in zip(scores, self._standardised(X), strict=True):
            distances = warped_distances(query, self.takes_, self.band)
            row[:] = [-distances[self.labels_ == k].min() for k in range(len(self.classes_))]
        return scores

    def predict(self, X: NDArray[Any]) -> NDArray[Any]:
        """The nearest take's class (n,)."""
        return np.asarray(self.classes_[self.decision_function(X).argmax(axis=1)])

    def state(self) -> dict[str, Any]:
        """Everything `from_state` needs: arrays and numbers."""
        fitted = {name: getattr(self, f"{name}_") for name in ("classes", "labels", "mean", "scale", "takes")}
        return {"band": self.band, **fitted}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """The fitted classifier that was written down."""
        self = cls(float(state["band"]))
        for name in ("classes", "labels", "mean", "scale", "takes"):
            setattr(self, f"{name}_", np.asarray(state[name]))
        return self

    def _standardised(self, X: NDArray[Any]) -> NDArray[Any]:
        return np.asarray((X - self.mean_[:, None]) / self.scale_[:, None])
