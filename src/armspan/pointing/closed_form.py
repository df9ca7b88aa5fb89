"""The closed form of the calibration: all poses at which the squared distances of points to rays are stationary.

Minimises sum w |(I - d dᵀ)(q - o)|² over q = Rz(-yaw) g + c, with g the points in axes that are z up and c
their centroid in ``user``. For a given yaw, c is linear; what is left is a quadratic form in (cos yaw, sin yaw)
on the unit circle. Its stationary points are the roots of a quartic in exp(i yaw), the trigonometric form of
the secular equation of a norm-constrained least squares problem (Gander 1981); written on the circle there is
no hard case apart, which one common eye and a flat sheet would otherwise always hit.
"""

import numpy as np

from armspan.frames import Array


def stationary_poses(origins: Array, directions: Array, points: Array, weights: Array) -> tuple[Array, Array]:
    """Centroids (k, 3) [m] in ``user`` and yaws (k,) [rad], k <= 4, of every stationary pose.

    ``origins`` [m] and unit ``directions`` (n, 3) are in ``user``; ``points`` (n, 3) [m] are centred and in
    axes that are z up; ``weights`` are (n,). Roots off the circle come in pairs with one angle and are kept:
    as starts they cost little.
    """
    across = weights[:, None, None] * (np.eye(3) - directions[:, :, None] * directions[:, None, :])
    turned = _turned_points(points)
    constant = -origins
    constant[:, 2] += points[:, 2]
    stacked = np.concatenate([turned, constant[:, :, None]], axis=2)  # q - o - c = stacked @ (cos, sin, 1)
    across_stacked = across @ stacked
    pull = across_stacked.sum(axis=0)
    centroid_of = -np.linalg.solve(across.sum(axis=0), pull)
    form = np.tensordot(stacked, across_stacked, axes=((0, 1), (0, 1))) + pull.T @ centroid_of
    yaws = _stationary_yaws(form)
    circle = np.stack([np.cos(yaws), np.sin(yaws), np.ones_like(yaws)])
    return (centroid_of @ circle).T, yaws


def _turned_points(points: Array) -> Array:
    """(n, 3, 2): Rz(-yaw) times the horizontal part of the points, linear in (cos yaw, sin yaw)."""
    turned = np.zeros((len(points), 3, 2))
    turned[:, 0, 0] = points[:, 0]
    turned[:, 0, 1] = points[:, 1]
    turned[:, 1, 0] = points[:, 1]
    turned[:, 1, 1] = -points[:, 0]
    return turned


def _stationary_yaws(form: Array) -> Array:
    """Angles at which u' form u with u = (cos, sin, 1) has no slope, by the quartic in z = exp(i yaw)."""
    a, b = (form[0, 0] - form[1, 1]) / 2, (form[0, 1] + form[1, 0]) / 2
    c, d = (form[0, 2] + form[2, 0]) / 2, (form[1, 2] + form[2, 1]) / 2
    roots = np.roots([b + 1j * a, d + 1j * c, 0.0, d - 1j * c, b - 1j * a])
    return np.asarray(np.angle(roots), dtype=float)
