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
    """Centroids (..., 4, 3) [m] in ``user`` and yaws (..., 4) [rad] of every stationary pose.

    ``origins`` [m] and unit ``directions`` (..., n, 3) are in ``user``; ``points`` (..., n, 3) [m] are centred and
    in axes that are z up; ``weights`` are (..., n); leading axes broadcast. Roots off the circle come in pairs with
    one angle and are kept: as starts they cost little.

    Raises:
        LinAlgError: if all rays of a problem run parallel.

    """
    shape = np.broadcast_shapes(origins.shape, directions.shape, points.shape)
    stacked = _stacked(origins, points, shape)  # q - o - c = stacked @ (cos, sin, 1)
    along = (directions[..., None, :] @ stacked)[..., 0, :]
    across_stacked = weights[..., None, None] * (stacked - directions[..., None] * along[..., None, :])
    pull = across_stacked.sum(axis=-3)
    centroid_of = -np.linalg.solve(across_sum(directions, weights), pull)
    rows = (*shape[:-2], 3 * shape[-2], 3)
    form = stacked.reshape(rows).swapaxes(-1, -2) @ across_stacked.reshape(rows) + pull.swapaxes(-1, -2) @ centroid_of
    yaws = stationary_yaws(form)
    circle = np.stack([np.cos(yaws), np.sin(yaws), np.ones_like(yaws)], axis=-1)
    return circle @ centroid_of.swapaxes(-1, -2), yaws


def across_sum(directions: Array, weights: Array) -> Array:
    """(..., 3, 3): the weighted sum of the projections across the rays; singular where all of them run parallel."""
    return np.asarray(
        weights.sum(axis=-1)[..., None, None] * np.eye(3)
        - (weights[..., None] * directions).swapaxes(-1, -2) @ directions
    )


def _stacked(origins: Array, points: Array, shape: tuple[int, ...]) -> Array:
    """(..., n, 3, 3): Rz(-yaw) times the points less the origins, linear in (cos yaw, sin yaw, 1)."""
    stacked = np.zeros((*shape, 3))
    stacked[..., 0, 0] = points[..., 0]
    stacked[..., 0, 1] = points[..., 1]
    stacked[..., 1, 0] = points[..., 1]
    stacked[..., 1, 1] = -points[..., 0]
    stacked[..., 2] = -origins
    stacked[..., 2, 2] += points[..., 2]
    return stacked


def stationary_yaws(form: Array) -> Array:
    """Angles (..., 4) at which u' form u with u = (cos, sin, 1) has no slope, by the quartic in z = exp(i yaw).

    The quartic (b + ia) z⁴ + (d + ic) z³ + (d - ic) z + (b - ia) has no square; its roots are the eigenvalues of
    its companion matrix. Where its ends vanish, a root lies at infinity and one at 0: far roots stand for them.
    """
    a, b = (form[..., 0, 0] - form[..., 1, 1]) / 2, (form[..., 0, 1] + form[..., 1, 0]) / 2
    c, d = (form[..., 0, 2] + form[..., 2, 0]) / 2, (form[..., 1, 2] + form[..., 2, 1]) / 2
    ends, inner = np.asarray(b + 1j * a), np.asarray(d + 1j * c)
    least = 1e-14 * np.abs(inner) + 1e-300
    ends = np.where(np.abs(ends) < least, least, ends)
    companion = np.zeros((*ends.shape, 4, 4), dtype=complex)
    companion[..., [1, 2, 3], [0, 1, 2]] = 1.0
    companion[..., 0, 0] = -inner / ends
    companion[..., 0, 2] = -inner.conj() / ends
    companion[..., 0, 3] = -ends.conj() / ends
    return np.asarray(np.angle(np.linalg.eigvals(companion)), dtype=float)
