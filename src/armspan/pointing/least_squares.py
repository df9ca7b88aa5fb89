"""Robust Levenberg-Marquardt over a user's place, all starts advancing at once in one set of arrays.

The cost is 1/2 sum w s² rho(angle² / s²), where the angle [rad] is that between a ray and the direction in
which its point is seen, with soft-l1 rho(z) = 2 (sqrt(1 + z) - 1) as in ``scipy.optimize.least_squares``.
The curvature is Gauss-Newton's with the loss's second derivative (Triggs et al. 1999, Bundle Adjustment, §4.3),
which for soft-l1 stays positive.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armspan.frames import Array
from armspan.pointing.closed_form import stationary_poses

LOSS_SCALE = float(np.radians(5.0))
"""Angle [rad] at which the loss bends: above the 2 deg of a careful straight arm, below a wrong stop."""


_FAR_M = 50.0
"""Nobody points at a table from farther away [m]."""

_ONES = np.ones(3)


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """What the pairs say: rays in ``user``, centred points in axes that are z up, one weight each.

    ``origins`` [m], unit ``directions`` and ``points`` [m] are (n, 3), ``weights`` (n,); ``loss_scale`` [rad].
    Parameters are (k, 4): the points' centroid in ``user`` [m] and the yaw [rad].
    """

    origins: Array
    directions: Array
    points: Array
    weights: Array
    loss_scale: float = LOSS_SCALE


@dataclass(frozen=True, slots=True, eq=False)
class Linear:
    """A problem near parameters (k, 4): ``cost`` (k,), its ``gradient`` (k, 4) and ``curvature`` (k, 4, 4)."""

    cost: Array
    gradient: Array
    curvature: Array


def angles(problem: Problem, parameters: Array) -> Array:
    """Angles (k, n) [rad] between the rays and the directions of their points."""
    seen, _ = _seen(problem, parameters)
    seen /= np.sqrt(_dot(seen, seen))[..., None]
    cosine = _dot(seen, problem.directions)
    across = problem.directions - cosine[..., None] * seen
    return np.arctan2(np.sqrt(_dot(across, across)), cosine)


def robust_cost(problem: Problem, residuals: Array) -> Array:
    """The cost (...) [rad²] of residual angles (..., n)."""
    bend = np.sqrt(1.0 + (residuals / problem.loss_scale) ** 2)
    return np.asarray((residuals**2 / (1.0 + bend)) @ problem.weights)


def miss(problem: Problem, place: Array) -> Array:
    """Rotation vectors (n, 3) [rad] from the rays to the directions of their points, at parameters (4,)."""
    seen, _ = _seen(problem, place[None])
    seen /= np.sqrt(_dot(seen, seen))[..., None]
    axis = np.cross(problem.directions, seen[0])
    sine = np.sqrt(_dot(axis, axis))
    angle = np.arctan2(sine, _dot(problem.directions, seen[0]))
    return np.asarray(axis * (angle / np.maximum(sine, 1e-300))[:, None])


def linearise(problem: Problem, parameters: Array) -> Linear:
    """Cost, gradient and curvature at parameters (k, 4).

    With v the vector from a ray's origin to its point, u = v / |v|, the ray d and a = d - (d·u) u, the angle's
    slope by v is -a / (|v| sin), and a sideways motion of u turns it by angle / sin.
    """
    rays, scale = problem.directions, problem.loss_scale
    seen, slope = _seen(problem, parameters)
    reach = np.sqrt(_dot(seen, seen))
    seen /= reach[..., None]
    cosine = _dot(seen, rays)
    across = rays - cosine[..., None] * seen
    sine = np.sqrt(_dot(across, across))
    angle = np.arctan2(sine, cosine)
    sine = np.maximum(sine, 1e-15)
    stretch = np.where(sine < 1e-8, 1.0, angle / sine)
    bend = np.sqrt(1.0 + (angle / scale) ** 2)
    cost = (angle**2 / (1.0 + bend)) @ problem.weights
    pull = problem.weights * stretch / (bend * reach)
    sideways = pull * stretch / reach
    radial = (problem.weights / (bend**3 * reach**2) - sideways) / sine**2
    by_across, by_seen = _by_parameters(across, slope), _by_parameters(seen, slope)
    gradient = -(pull[:, None, :] @ by_across)[:, 0]
    curvature = by_across.swapaxes(1, 2) @ (radial[..., None] * by_across)
    curvature -= by_seen.swapaxes(1, 2) @ (sideways[..., None] * by_seen)
    curvature += _moved(sideways, slope)
    return Linear(cost, gradient, curvature)


def _dot(left: Array, right: Array) -> Array:
    return np.asarray((left * right) @ _ONES)


def _seen(problem: Problem, parameters: Array) -> tuple[Array, Array]:
    """Vectors (k, n, 3) [m] from the rays' origins to the points, and their slope by the yaw."""
    cosine, sine = np.cos(parameters[:, 3:]), np.sin(parameters[:, 3:])
    x, y = problem.points[:, 0], problem.points[:, 1]
    seen = parameters[:, None, :3] + (problem.points - problem.origins)
    slope = np.zeros_like(seen)
    slope[..., 0] = cosine * y - sine * x
    slope[..., 1] = -cosine * x - sine * y
    seen[..., 0] -= slope[..., 1] + x
    seen[..., 1] += slope[..., 0] - y
    return seen, slope


def _by_parameters(vectors: Array, slope: Array) -> Array:
    """(k, n, 4): how far a change of each parameter moves the points along vectors (k, n, 3)."""
    moved = np.empty((*vectors.shape[:2], 4))
    moved[..., :3] = vectors
    moved[..., 3] = _dot(vectors, slope)
    return moved


def _moved(weights: Array, slope: Array) -> Array:
    """(k, 4, 4): the weighted sum of squared motions of the points by the parameters."""
    squares = np.zeros((len(weights), 4, 4))
    squares[:, [0, 1, 2], [0, 1, 2]] = weights.sum(axis=1)[:, None]
    squares[:, 3, :3] = squares[:, :3, 3] = (weights[:, None, :] @ slope)[:, 0]
    squares[:, 3, 3] = (weights * _dot(slope, slope)).sum(axis=1)
    return squares


def solve(problem: Problem) -> tuple[Array, float]:
    """The place (4,) of least cost, and that cost [rad²]: from every pose the closed form offers."""
    centroids, yaws = stationary_poses(problem.origins, problem.directions, problem.points, problem.weights)
    places, costs = minimise(problem, np.column_stack([centroids, yaws]))
    best = costs.argmin()
    return places[best], float(costs[best])


def minimise(problem: Problem, starts: Array, iterations: int = 60) -> tuple[Array, Array]:
    """Where Levenberg-Marquardt ends from each start (k, 4): parameters (k, 4) and costs (k,).

    It ends when the best start has settled and the others have too or are hopeless: three times as costly, not
    near enough to reach the best in a hundred steps like their last, or run away. From a wrong start the user backs
    off for ever, until all points are seen in one direction.
    """
    parameters, here = starts, linearise(problem, starts)
    damping = np.full(len(starts), 1e-4)
    for iteration in range(iterations):
        step = _damped_step(here, damping)
        there = linearise(problem, parameters - step)
        better = there.cost < here.cost
        gain = np.abs((step * here.gradient).sum(axis=1))
        parameters = np.where(better[:, None], parameters - step, parameters)
        here = _choose(better, there, here)
        damping = np.where(better, damping * 0.1, np.minimum(damping * 10.0, 1e12))
        settled = gain <= 1e-9 * here.cost + 1e-24
        best = here.cost.argmin()
        given_up = np.abs(parameters[:, :3]).max(axis=1) > _FAR_M
        if iteration >= 4:
            given_up |= here.cost > np.minimum(3.0 * here.cost[best], here.cost[best] + 100.0 * gain)
        if settled[best] and (settled | given_up).all():
            break
    return parameters, here.cost


def _damped_step(here: Linear, damping: Array) -> Array:
    damped = here.curvature.copy()
    places = np.arange(damped.shape[-1])
    damped[:, places, places] = damped[:, places, places] * (1.0 + damping[:, None]) + 1e-12
    return np.asarray(np.linalg.solve(damped, here.gradient[..., None])[..., 0])


def _choose(better: NDArray[np.bool_], there: Linear, here: Linear) -> Linear:
    return Linear(
        np.where(better, there.cost, here.cost),
        np.where(better[:, None], there.gradient, here.gradient),
        np.where(better[:, None, None], there.curvature, here.curvature),
    )
