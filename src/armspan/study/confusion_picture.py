"""A confusion matrix as a picture."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from armspan.frames import Array


def draw_confusion(path: Path, table: Array, labels: Sequence[str], title: str) -> None:
    """Draw a confusion matrix (rows: made, columns: recognised) with its counts into a PNG."""
    size = max(4.0, 0.55 * len(labels) + 2.5)
    figure = Figure(figsize=(size, size * 0.92), layout="constrained")
    axes = figure.subplots()
    shares = table / np.maximum(table.sum(axis=1, keepdims=True), 1)
    axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0)
    axes.set_xticks(range(len(labels)), labels, rotation=45, ha="right")
    axes.set_yticks(range(len(labels)), labels)
    axes.set_xlabel("recognised as")
    axes.set_ylabel("made")
    for row, column in np.argwhere(table > 0):
        colour = "white" if shares[row, column] > 0.5 else "black"
        axes.text(column, row, str(int(table[row, column])), ha="center", va="center", color=colour, fontsize=8)
    right = int(np.trace(table))
    axes.set_title(f"{title}\n{right} of {int(table.sum())} right", fontsize=10)
    figure.savefig(path, dpi=130)
