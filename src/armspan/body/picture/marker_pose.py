"""How a printed square lies before the camera, and what its perspective tells of the focal length.

The ``camera`` frame has x right and y down in the picture, and z along the view.
"""

from typing import NamedTuple

import numpy as np

from armspan.body.marker_sheet import MARKER_SIDE
from armspan.body.picture.image import focal_share, opencv
from armspan.frames import Array

USUAL_FOCAL_MM = 27.0
"""The main cameras of phones lie between 24 and 28 mm on film, webcams about there."""

_USUAL_SD = 0.2
"""Doubt of that for whatever camera (share)."""
_CORNER_SD_PX, _PAPER_SD = 0.1, 0.0005
"""Doubt of the corners [px], and of each one's height where the paper curls [m] (assumed)."""


class Pose(NamedTuple):
    """The sheet's ``normal`` and middle ``at`` (3,) in ``camera`` [m], and its squared misfit at the corners [px²]."""

    normal: Array
    at: Array
    misfit: float


def poses(corners: Array, focal: float, middle: Array, upright: Array) -> list[Pose]:
    """Both poses in which a square looks like these corners, the one that faces up along the body first."""
    cv2, half = opencv(), MARKER_SIDE / 2
    printed = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    lens = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])
    _, turns, moves, _ = cv2.solvePnPGeneric(printed, corners, lens, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
    both = []
    for turn, move in zip(turns, moves, strict=True):
        again = cv2.projectPoints(printed, turn, move, lens, None)[0].reshape(4, 2)
        normal = cv2.Rodrigues(turn)[0][:, 2]
        both.append(Pose(normal, np.ravel(move), float(((again - corners) ** 2).sum())))
    return sorted(both, key=lambda pose: -float(pose.normal[:2] @ upright))


def likely_focal(corners: Array, upright: Array, size: tuple[int, int]) -> tuple[float, float]:
    """Mean and standard deviation (share) of the focal length [px], by how well the corners stay a square."""
    middle, sd = (np.array(size, float) - 1) / 2, corner_sd(corners)
    shares = np.geomspace(0.4, 2.5, 93)
    focals = USUAL_FOCAL_MM * focal_share(*size) * shares
    misfits = np.array([poses(corners, float(focal), middle, upright)[0].misfit for focal in focals])
    cost = np.nan_to_num(misfits, nan=np.inf) / sd**2 + (np.log(shares) / _USUAL_SD) ** 2
    weights = np.exp(-(cost - cost.min()) / 2)
    weights /= weights.sum()
    mean = float(weights @ np.log(focals))
    return float(np.exp(mean)), float(np.sqrt(weights @ (np.log(focals) - mean) ** 2))


def corner_sd(corners: Array) -> float:
    """Doubt of a corner [px]: that of finding it, and paper that does not lie flat."""
    side = float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).max())
    return float(np.hypot(_CORNER_SD_PX, _PAPER_SD * side / MARKER_SIDE))
