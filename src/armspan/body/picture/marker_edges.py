"""The corners of a printed marker, from all edges between its cells."""

from typing import Any

import numpy as np

from armspan.body.marker_sheet import MARKER_BITS
from armspan.body.picture.image import opencv
from armspan.frames import Array

_ROUNDS = 8
_FARTHEST = 0.08
"""How far corners may move from where the detector put them, share of the marker's side: 5 of 60 pixels."""


def refined(grey: Any, corners: Array) -> Array:
    """Corners (4, 2) [px] of the homography that fits all edges between black and white cells best.

    An edge's middle grey is not where the edge is: blur before the camera's tone curve, glare and ink shift every
    edge by one distance towards black or white, which is fitted along. (Corners found one by one make the marker up
    to 1 px smaller, and the person 30 mm taller.)
    """
    ends, white = _cell_edges()
    along = np.linspace(0.2, 0.8, 7)[:, None, None]
    points = (ends[:, 0] * (1 - along) + ends[:, 1] * along).reshape(-1, 2)
    beside = points + np.tile(white, (len(along), 1))
    fitted, farthest = corners, _FARTHEST * np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).max()
    for _ in range(_ROUNDS):
        shifts, normals, seen = _edge_shifts(grey, fitted, points, beside)
        moves = np.eye(8).reshape(8, 4, 2)
        slopes = [(_projected(fitted + move, points) - _projected(fitted, points)) for move in moves]
        columns = [(slope * normals).sum(axis=1) for slope in slopes] + [np.ones(len(points))]
        step = np.linalg.lstsq(np.stack(columns, axis=1)[seen], shifts[seen], rcond=None)[0]
        fitted = fitted + step[:8].reshape(4, 2)
        if not np.abs(fitted - corners).max() < farthest:  # NaN too
            return corners
    return fitted


def _cell_edges() -> tuple[Array, Array]:
    """The edges between cells of two colours: ends (n, 2, 2) and step to the white side (n, 2), in cells from above."""
    rim = np.pad(np.array([[int(bit) for bit in row] for row in MARKER_BITS]), 1, constant_values=1)
    ends, white = [], []
    for step in np.array([[1, 0], [0, 1]]):
        change = (rim[:, 1:] - rim[:, :-1]) if step[0] else (rim[1:] - rim[:-1])
        for row, column in np.argwhere(change != 0):
            start = np.array([column, row - 1]) if step[0] else np.array([column - 1, row])
            ends.append([start, start + 1 - step])
            white.append(step * change[row, column])
    return np.array(ends, float), np.array(white, float)


def _edge_shifts(grey: Any, corners: Array, points: Array, beside: Array) -> tuple[Array, Array, Any]:
    """How far [px] edges lie to the white side of where ``corners`` put them, unit normals, which have contrast."""
    at = _projected(corners, points)
    towards = _projected(corners, beside) - at
    turned = _projected(corners, points + (beside - points)[:, ::-1]) - at
    normals = np.stack([-turned[:, 1], turned[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    across = (normals * towards).sum(axis=1)
    normals *= np.sign(across)[:, None]
    reach = float(np.clip(0.45 * np.abs(across).min(), 1.0, 4.0))
    steps = np.linspace(-reach, reach, 17)
    places = (at[:, None] + steps[:, None] * normals[:, None]).astype(np.float32)
    levels = opencv().remap(grey, places[..., 0], places[..., 1], opencv().INTER_LINEAR).astype(float)
    black, bright = levels[:, :3].mean(axis=1), levels[:, -3:].mean(axis=1)
    contrast = np.maximum(bright - black, 1.0)
    share = np.clip((levels - black[:, None]) / contrast[:, None], 0.0, 1.0).mean(axis=1)
    return reach * (1 - 2 * share), normals, contrast > 0.5 * np.median(contrast)


def _projected(corners: Array, points: Array) -> Array:
    """Points (n, 2) in cells of a marker as pixels (n, 2)."""
    cells = float(len(MARKER_BITS))
    square = np.array([[0, 0], [cells, 0], [cells, cells], [0, cells]], np.float32)
    homography = opencv().getPerspectiveTransform(square, corners.astype(np.float32))
    pixels = np.column_stack([points, np.ones(len(points))]) @ homography.T
    projected: Array = pixels[:, :2] / pixels[:, 2:]
    return projected
