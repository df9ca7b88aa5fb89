"""A linear head by ridge regression on +1 and -1, its penalty chosen by leaving one person, or one take, out."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

PENALTIES = np.logspace(-5.0, 2.0, 15)
"""Tried penalties, in units of one feature's variance: the Gram matrix is divided by the number of features."""

LONE = 0.03
"""The penalty where nothing can be left out, since each class has one take only (or one person's)."""

SOFTENING = 0.1
"""Added to each feature's deviation, so that features that hardly ever vary are not blown up to equals."""


@dataclass(frozen=True, slots=True, eq=False)
class Ridge:
    """Scores = (F - centre) / spread @ weights + offset.

    ``centre`` and ``spread`` are (p,), ``weights`` (p, classes), ``offset`` (classes,).
    """

    centre: NDArray[Any]
    spread: NDArray[Any]
    weights: NDArray[Any]
    offset: NDArray[Any]
    penalty: float

    @classmethod
    def fit(cls, F: NDArray[Any], labels: NDArray[Any], n_classes: int, groups: NDArray[Any] | None = None) -> Self:
        """Fit on features F (n, p) and labels 0 .. n_classes - 1; takes of one of ``groups`` are left out together."""
        centre, spread = F.mean(axis=0, dtype=np.float64), F.std(axis=0, dtype=np.float64) + SOFTENING
        A = (F - centre) / (spread * np.sqrt(F.shape[1]))
        wanted = np.where(np.arange(n_classes) == labels[:, None], 1.0, -1.0)
        offset = wanted.mean(axis=0)
        Q, gains = left_basis(A)
        kept = (
            np.arange(len(F)) if groups is None or len(set(groups)) < 2 else np.unique(groups, return_inverse=True)[1]
        )
        penalty = chosen_penalty(Q, gains, wanted, labels, kept)
        projected = (Q / (gains + penalty)).T @ (wanted - offset)
        return cls(centre, spread, A.T @ (Q @ projected) / np.sqrt(F.shape[1]), offset, penalty)

    def scores(self, F: NDArray[Any]) -> NDArray[Any]:
        """One value per class (n, classes)."""
        return np.asarray((F - self.centre) / self.spread @ self.weights + self.offset)

    def state(self) -> dict[str, Any]:
        """Arrays and numbers from which `from_state` rebuilds it."""
        return {name: getattr(self, name) for name in ("centre", "spread", "weights", "offset", "penalty")}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """The head that was written down."""
        centre, spread, weights, offset = (
            np.asarray(state[name]) for name in ("centre", "spread", "weights", "offset")
        )
        return cls(centre, spread, weights, offset, float(state["penalty"]))


def left_basis(A: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Left singular vectors (n, r) and squared singular values (r,) of centred A (n, p), from its smaller Gram matrix.

    Directions without variance are dropped.
    """
    n, p = A.shape
    gains, vectors = np.linalg.eigh(A @ A.T if n <= p else A.T @ A)
    real = gains > 1e-10 * max(float(gains[-1]), 1e-10)
    gains, vectors = gains[real], vectors[:, real]
    return (vectors if n <= p else A @ vectors / np.sqrt(gains)), gains


def chosen_penalty(
    Q: NDArray[Any], gains: NDArray[Any], wanted: NDArray[Any], labels: NDArray[Any], groups: NDArray[Any]
) -> float:
    """The penalty with the least squared error on takes whose group was left out (closed form).

    A take whose class only its own group shows cannot be foretold and is not counted.
    """
    rows = [np.flatnonzero(groups == group) for group in np.unique(groups)]
    shown = np.zeros((len(rows), wanted.shape[1]), dtype=bool)
    for mark, members in zip(shown, rows, strict=True):
        mark[labels[members]] = True
    counted = shown.sum(axis=0)[labels] > 1
    if not counted.any():
        return LONE
    errors = [np.square(left_out_residuals(Q, gains, wanted, rows, p)[counted]).mean() for p in PENALTIES]
    return float(PENALTIES[int(np.argmin(errors))])


def left_out_residuals(
    Q: NDArray[Any], gains: NDArray[Any], wanted: NDArray[Any], rows: list[NDArray[Any]], penalty: float
) -> NDArray[Any]:
    """Errors (n, classes) on each of ``rows`` by the fit without these rows, from one fit.

    With the smoother H = 1/n + Q diag(s / (s + penalty)) Q', they are (I - H_gg)^-1 r_g: the intercept is refitted too,
    only the features' centre and spread are not.
    """
    shrink = gains / (gains + penalty)
    residuals = wanted - wanted.mean(axis=0)
    residuals = residuals - Q @ (shrink[:, None] * (Q.T @ residuals))
    if len(rows) == len(Q):
        return np.asarray(residuals / (1.0 - 1.0 / len(Q) - np.square(Q) @ shrink)[:, None])
    out: NDArray[Any] = np.empty_like(residuals)
    for members in rows:
        block = Q[members]
        smoother = 1.0 / len(Q) + (block * shrink) @ block.T
        out[members] = np.linalg.solve(np.eye(len(members)) - smoother, residuals[members])
    return out
