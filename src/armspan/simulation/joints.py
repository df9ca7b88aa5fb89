"""An arm by its joints' angles: for free movements, which blend along arcs as a real shoulder's and elbow's do.

Angles [rad] are written for either arm alike, with ``outward`` away from the body's middle:

- ``PLANE`` in which the upper arm is raised: 0 to the front, a quarter turn outward;
- ``ELEVATION`` of the upper arm: 0 hanging, half a turn straight up;
- ``AXIAL`` turn of the upper arm: at 0 the elbow flexes within the plane, below 0 inward;
- ``FLEXION`` of the elbow: 0 straight;
- ``PRONATION``: 0 with the thumb on the side to which the elbow flexes, a quarter turn further the palm
  faces away from there;
- ``TURN`` of the whole trunk to the left;
- ``LIFT`` of the shoulder [m].
"""

import numpy as np

from armspan.frames import Array
from armspan.simulation.figure import BACK, FOREARM, HAND, OUTER, ROWS, SHIFT, UPPER

PLANE, ELEVATION, AXIAL, FLEXION, PRONATION, TURN, LIFT = range(7)
ANGLES, JOINTS = 5, 7

_SHRUG = 0.05
"""By how much the shoulder's pivot rises [m] with an arm straight up."""


def directions(joints: Array) -> tuple[Array, Array, Array, Array]:
    """Upper arm, forearm, where the forearm flexes to and the flexion's outward normal: (3, m) each.

    Components are (forward, outward, up), before the trunk's turn.
    """
    plane, elevation, axial, flexion = joints[:PRONATION]
    c, s, ce, se = np.cos(plane), np.sin(plane), np.cos(elevation), np.sin(elevation)
    upper = np.array([se * c, se * s, -ce])
    rising = np.array([ce * c, ce * s, se])
    outward = np.array([-s, c, 0.0 * c])
    ca, sa, cf, sf = np.cos(axial), np.sin(axial), np.cos(flexion), np.sin(flexion)
    bending = ca * rising + sa * outward
    return upper, cf * upper + sf * bending, cf * bending - sf * upper, ca * outward - sa * rising


def posture_from_joints(joints: Array, side: float, offset: float) -> Array:
    """The posture (20, m) of ``joints`` (7, m) on the left (``side`` 1) or the right (-1).

    ``offset`` [m] is how far the shoulder lies to the left of the body's middle.
    """
    upper, forearm, bending, normal = directions(joints)
    cp, sp = np.cos(joints[PRONATION]), np.sin(joints[PRONATION])
    cf, sf = np.cos(joints[FLEXION]), np.sin(joints[FLEXION])
    outer = sf * forearm + cf * bending + 0.3 * normal
    posture = np.zeros((ROWS, joints.shape[1]))
    for rows, vector in ((UPPER, upper), (FOREARM, forearm), (HAND, forearm), (OUTER, outer)):
        posture[rows] = vector
    posture[BACK] = cp * normal + sp * bending
    c, s = np.cos(joints[TURN]), np.sin(joints[TURN])
    for rows in (UPPER, FOREARM, HAND, BACK, OUTER):
        x, y, _ = posture[rows]
        posture[rows][:2] = c * x - s * side * y, s * x + c * side * y
    rise = joints[LIFT] + _SHRUG * 0.5 * (1.0 - np.cos(joints[ELEVATION]))
    posture[SHIFT] = -offset * s, offset * (c - 1.0), rise
    return posture


def wrist_step(joints: Array, upper: float, forearm: float) -> Array:
    """How the wrist moves with the four joints that carry it: (3, 4) [m/rad], forward, outward, up, at (7,)."""
    step = 1e-4
    columns = []
    for joint in range(PRONATION):
        near = np.repeat(joints[:, None], 2, axis=1)
        near[joint] += (-step, step)
        along, below, _, _ = directions(near)
        wrist = upper * along + forearm * below
        columns.append((wrist[:, 1] - wrist[:, 0]) / (2.0 * step))
    return np.array(columns).T
