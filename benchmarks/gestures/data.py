"""The public gesture sets next to the checkout: loaded, cut and split the way the anchors were measured."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data" / "gestures"
NAMES = (
    "UTDMHAD21arm",
    "BerkeleyMHAD2w",
    "ActRecTut_within",
    "SPARwatch7",
    "NATOPS",
    "RacketSports",
    "Epilepsy",
    "ERing",
    "BasicMotions",
)
CUT_LENGTH = 128  # samples; cut gestures last 2-8 s at 32 Hz
ROUNDS = 26


@dataclass(frozen=True, slots=True)
class Split:
    """Takes (n, channels, times) with labels; `groups` are people, None where the set does not say who."""

    X: NDArray[np.float64]
    y: NDArray[np.str_]
    groups: NDArray[np.int64] | None


@dataclass(frozen=True, slots=True)
class GestureSet:
    """A named set with its stated split."""

    name: str
    train: Split
    test: Split


def load(name: str) -> GestureSet:
    """One set by name; raises FileNotFoundError where the data folder is absent."""
    if name == "ActRecTut_within":
        return _rounds(name)
    with np.load(FOLDER / f"{name}.npz") as file:
        X, y, train = file["X"].astype(float), file["classes"][file["y"]], file["train"]
        groups = file["subject"].astype(np.int64) if np.unique(file["subject"]).size > 1 else None
    return _split(name, X, y, groups, train)


def _split(
    name: str, X: NDArray[np.float64], y: NDArray[np.str_], groups: NDArray[np.int64] | None, train: NDArray[np.bool_]
) -> GestureSet:
    first, second = (Split(X[rows], y[rows], None if groups is None else groups[rows]) for rows in (train, ~train))
    return GestureSet(name, first, second)


def _rounds(name: str) -> GestureSet:
    """ActRecTut's labelled gestures: the first 13 rounds of each class train, the last 13 test."""
    takes, labels, rounds = cut_rounds()
    return _split(name, takes, labels, None, rounds < ROUNDS // 2)


def cut_rounds(length: int = CUT_LENGTH) -> tuple[NDArray[np.float64], NDArray[np.str_], NDArray[np.int64]]:
    """ActRecTut's stream cut by its labels, resampled linearly to `length`: takes, labels, number of the round."""
    with np.load(FOLDER / "ActRecTut_stream_s1.npz") as file:
        stream, y, classes = file["X"].astype(float), file["y"], file["classes"]
    edges = np.flatnonzero(np.diff(y)) + 1
    spans = [(i, j) for i, j in zip(np.r_[0, edges], np.r_[edges, y.size], strict=True) if classes[y[i]] != "NULL"]
    labels = np.array([classes[y[i]] for i, _ in spans])
    rounds = np.array([np.count_nonzero(labels[:k] == label) for k, label in enumerate(labels)])
    return np.stack([_resample(stream[i:j], length) for i, j in spans]), labels, rounds


def _resample(piece: NDArray[np.float64], length: int) -> NDArray[np.float64]:
    """A piece (times, channels) at `length` evenly spread times, as (channels, length)."""
    old, new = np.linspace(0, 1, len(piece)), np.linspace(0, 1, length)
    return np.stack([np.interp(new, old, channel) for channel in piece.T])
