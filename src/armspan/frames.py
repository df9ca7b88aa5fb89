"""Transforms with two named ends, rays and planes. ``docs/conventions.md`` tells every choice made here.

The frames are ``sensor``, ``wrist``, ``earth``, ``user``, ``sheet`` and ``robot``. Names read
``target_from_source``, so that inner names cancel in a product.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armspan.errors import FrameError
from armspan.records import Quaternion, Vec3

Array: TypeAlias = NDArray[np.float64]

SHEET_FLIP: Array = np.diag([1.0, -1.0, -1.0])
"""A half turn about x, between axes that are z up and the sheet's, z into the table."""


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """A rigid motion ``target_from_source``: p_target = rotation @ p_source + translation.

    ``rotation`` is (3, 3), ``translation`` (3,) [m] in ``target``.

    Raises:
        FrameError: on a product whose inner names differ, or points of another shape than (..., 3).

    """

    target: str
    source: str
    rotation: Array
    translation: Array

    def __matmul__(self, other: "Transform") -> "Transform":
        if self.source != other.target:
            raise FrameError(_inner_names_differ(self, other))
        rotation = self.rotation @ other.rotation
        translation = self.rotation @ other.translation + self.translation
        return Transform(self.target, other.source, rotation, translation)

    def inverse(self) -> "Transform":
        """``source_from_target``."""
        back = self.rotation.T
        return Transform(self.source, self.target, back, -back @ self.translation)

    def points(self, points_source: ArrayLike) -> Array:
        """Points (..., 3) [m] written in ``source``, written in ``target``."""
        points = _vectors(points_source, self)
        return points @ self.rotation.T + self.translation

    def directions(self, directions_source: ArrayLike) -> Array:
        """Directions (..., 3) written in ``source``, written in ``target``."""
        return _vectors(directions_source, self) @ self.rotation.T


def _vectors(values: ArrayLike, transform: Transform) -> Array:
    vectors = np.asarray(values, dtype=float)
    if vectors.ndim == 0 or vectors.shape[-1] != 3:
        name = f"{transform.target}_from_{transform.source}"
        raise FrameError(f"{name} moves vectors of 3 numbers (..., 3), not an array of shape {vectors.shape}")
    return vectors


def _inner_names_differ(left: Transform, right: Transform) -> str:
    names = f"{left.target}_from_{left.source} @ {right.target}_from_{right.source}"
    text = f"{names} does not cancel: {left.source!r} is not {right.target!r}."
    if left.source == right.source:
        return f"{text} {right.target}_from_{right.source} is likely inverted: use its .inverse()."
    if left.target == right.target:
        return f"{text} {left.target}_from_{left.source} is likely inverted: use its .inverse()."
    if left.target == right.source:
        return f"{text} The two are likely in the wrong order."
    return f"{text} A transform {left.source}_from_{right.target} is missing between them."


def identity(target: str, source: str) -> Transform:
    """Two frames that coincide."""
    return Transform(target, source, np.eye(3), np.zeros(3))


def yaw_rotation(yaw: float) -> Array:
    """Rz(yaw), (3, 3): counter-clockwise about z by ``yaw`` [rad]."""
    c, s = float(np.cos(yaw)), float(np.sin(yaw))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def sheet_from_user(xyz: Vec3 | Array, yaw: float, *, z_up: bool = False) -> Transform:
    """The place of the user: p_sheet = diag(1, -1, -1) Rz(yaw) p_user + xyz [m, rad].

    With ``z_up`` the data's frame has z up and the flip is left out.
    """
    turn = yaw_rotation(yaw)
    rotation = turn if z_up else SHEET_FLIP @ turn
    return Transform("sheet", "user", rotation, np.asarray(xyz, dtype=float))


def rotation_from_quaternion(wxyz: Quaternion | ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4), scalar first, active."""
    q = np.asarray(wxyz, dtype=float)
    w, x, y, z = q.transpose(-1, *range(q.ndim - 1))  # of one quaternion these are numbers, and fast
    rows = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return np.ascontiguousarray(rows.transpose(*range(2, rows.ndim), 0, 1))


def plane_hit(origins: ArrayLike, directions: ArrayLike, z: float | ArrayLike) -> Array:
    """Where rays meet the plane of height ``z`` [m]: points (..., 3) in the rays' frame.

    NaN where the ray runs parallel to the plane or meets it behind its origin.
    """
    o, d = np.asarray(origins, dtype=float), np.asarray(directions, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reach = (np.asarray(z, dtype=float) - o[..., 2]) / d[..., 2]
        hits = o + np.where(reach > 0, reach, np.nan)[..., None] * d
    return np.where(np.isfinite(hits).all(axis=-1, keepdims=True), hits, np.nan)


def polygon_middle(corners: ArrayLike) -> tuple[float, float]:
    """Centroid [m] of a polygon (n, 2) that does not cross itself, in its corners' frame."""
    here = np.asarray(corners, dtype=float)
    following = np.roll(here, -1, axis=0)
    cross = here[:, 0] * following[:, 1] - following[:, 0] * here[:, 1]
    x, y = ((here + following) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
    return float(x), float(y)
