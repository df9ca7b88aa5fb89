"""Arms that point exactly, worked out by intersecting the line of sight with the reach of a stiff arm."""

import numpy as np
from numpy.typing import NDArray

from armspan.records import Body

Array = NDArray[np.float64]

BODY = Body(
    eye_height_m=1.65,
    shoulder_to_eye_m=(0.02, 0.18, 0.24),
    shoulder_to_fingertip_m=0.72,
    upper_arm_m=0.36,
    elbow_to_fingertip_m=0.36,
)
SQUARE = np.array([[0.0, 0.0, 0.0], [0.8, 0.0, 0.0], [0.8, 0.6, 0.0], [0.0, 0.6, 0.0]])


def with_x(directions: Array) -> Array:
    """Some attitudes (n, 3, 3) whose x axes are the unit directions (n, 3)."""
    side = np.cross([0.0, 0.0, 1.0], directions)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return np.stack([directions, side, np.cross(directions, side)], axis=-1)


def pointing_at(targets_user: Array, body: Body = BODY) -> Array:
    """Attitudes (n, 3, 3) that put the fingertip of a stiff arm on the line from the eye to each target (n, 3)."""
    eye = np.array([0.0, 0.0, body.eye_height_m])
    shoulder = eye - np.array(body.shoulder_to_eye_m)
    sight = targets_user - eye
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    from_shoulder = eye - shoulder
    b = sight @ from_shoulder
    reach = -b + np.sqrt(b**2 - from_shoulder @ from_shoulder + body.shoulder_to_fingertip_m**2)
    arm = eye + reach[:, None] * sight - shoulder
    return with_x(arm / np.linalg.norm(arm, axis=1, keepdims=True))


def seen_from(points_sheet: Array, xyz: Array, yaw: float, z_up: bool = False) -> Array:
    """Points (n, 3) of ``sheet`` in ``user``: the inverse of p = F Rz(yaw) q + xyz, written out."""
    x, y, z = (points_sheet - xyz).T
    if not z_up:
        y, z = -y, -z
    return np.column_stack([np.cos(yaw) * x + np.sin(yaw) * y, -np.sin(yaw) * x + np.cos(yaw) * y, z])


def place_before(points_sheet: Array, ahead: Array, yaw: float, z_up: bool = False) -> Array:
    """The xyz (3,) for which the points' middle lies at ``ahead`` (3,) in ``user``."""
    x, y, z = ahead
    turned = np.array([np.cos(yaw) * x - np.sin(yaw) * y, np.sin(yaw) * x + np.cos(yaw) * y, z])
    if not z_up:
        turned = turned * [1.0, -1.0, -1.0]
    return points_sheet.mean(axis=0) - turned
