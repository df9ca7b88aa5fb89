"""How far a calibration is from the truth, in millimetres on the sheet."""

import numpy as np

from armspan.frames import Array, plane_hit, sheet_from_user
from armspan.records import Sheet, Vec3


def sheet_errors(
    found: tuple[Vec3, float], true: tuple[Vec3, float], eye_heights: tuple[float, float], sheet: Sheet
) -> Array:
    """Errors (n,) [m] of where perfect rays seem to meet a 9 by 9 grid of the sheet; NaN where they miss it.

    ``found`` and ``true`` are (xyz, yaw) of ``sheet_from_user``, ``eye_heights`` what was believed and what is true.
    The rays start in the true eye; they are then taken as the calibration takes them.
    """
    xs, ys = np.linspace(0, sheet.width_m, 9), np.linspace(0, sheet.height_m, 9)
    points = np.stack([*np.meshgrid(xs, ys), np.zeros((9, 9))], axis=-1).reshape(-1, 3)
    user_from_sheet = sheet_from_user(*true).inverse()
    rays_user = user_from_sheet.points(points) - [0.0, 0.0, eye_heights[1]]
    place = sheet_from_user(*found)
    eye = place.points([0.0, 0.0, eye_heights[0]])
    hits = plane_hit(np.broadcast_to(eye, points.shape), place.directions(rays_user), 0.0)
    return np.asarray(np.linalg.norm(hits - points, axis=1))


def sheet_rms(errors: Array) -> float:
    """Root mean square [m] over the grid, infinite when a ray does not meet the sheet."""
    return float("inf") if np.isnan(errors).any() else float(np.sqrt(np.mean(errors**2)))
