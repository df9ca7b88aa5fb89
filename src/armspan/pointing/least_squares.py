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


ITERATIONS = 60
"""Steps after which a descent is given up; from the closed form nearly all end within 15."""


_FAR_M = 50.0
"""Nobody points at a table from farther away [m]."""

_ONES = np.ones(3)


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """What the pairs say: rays in ``user``, centred points in axes that are z up, one weight each.

    ``origins`` [m], unit ``directions`` and ``points`` [m] are (n, 3), ``weights`` (n,); ``loss_scale`` [rad].
    Parameters are (k, 4): the points' centroid in ``user`` [m] and the yaw [rad].
    Many problems are one of arrays (m, 1, n, 3) and (m, 1, n), with parameters (m, k, 4).
    """

    origins: Array
    directions: Array
    points: Array
    weights: Array
    loss_scale: float = LOSS_SCALE


@dataclass(frozen=True, slots=True, eq=False)
class Linear:
    """A problem near parameters (..., 4): ``cost`` (...), its ``gradient`` (..., 4), ``curvature`` (..., 4, 4)."""

    cost: Array
    gradient: Array
    curvature: Array


def angles(problem: Problem, parameters: Array) -> Array:
    """Angles (..., n) [rad] between the rays and the directions of their points."""
    seen, _ = _seen(problem, parameters)
    seen /= np.sqrt(_dot(seen, seen))[..., None]
    cosine = _dot(seen, problem.directions)
    across = problem.directions - cosine[..., None] * seen
    return np.arctan2(np.sqrt(_dot(across, across)), cosine)


def robust_cost(problem: Problem, residuals: Array) -> Array:
    """The cost (...) [rad²] of residual angles (..., n)."""
    bend = np.sqrt(1.0 + (residuals / problem.loss_scale) ** 2)
    return np.asarray((residuals**2 / (1.0 + bend) * problem.weights).sum(axis=-1))


def miss(problem: Problem, place: Array) -> Array:
    """Rotation vectors (n, 3) [rad] from the rays to the directions of their points, at parameters (4,)."""
    seen, _ = _seen(problem, place[None])
    seen /= np.sqrt(_dot(seen, seen))[..., None]
    axis = np.cross(problem.directions, seen[0])
    sine = np.sqrt(_dot(axis, axis))
    angle = np.arctan2(sine, _dot(problem.directions, seen[0]))
    return np.asarray(axis * (angle / np.maximum(sine, 1e-300))[:, None])


def linearise(problem: Problem, parameters: Array) -> Linear:
    """Cost, gradient and curvature at parameters (..., 4).

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
    cost = (angle**2 / (1.0 + bend) * problem.weights).sum(axis=-1)
    pull = problem.weights * stretch / (bend * reach)
    sideways = pull * stretch / reach
    radial = (problem.weights / (bend**3 * reach**2) - sideways) / sine**2
    by_across, by_seen = _by_parameters(across, slope), _by_parameters(seen, slope)
    gradient = -(pull[..., None, :] @ by_across)[..., 0, :]
    curvature = by_across.swapaxes(-1, -2) @ (radial[..., None] * by_across)
    curvature -= by_seen.swapaxes(-1, -2) @ (sideways[..., None] * by_seen)
    curvature += _moved(sideways, slope)
    return Linear(cost, gradient, curvature)


def _dot(left: Array, right: Array) -> Array:
    return np.asarray((left * right) @ _ONES)


def _seen(problem: Problem, parameters: Array) -> tuple[Array, Array]:
    """Vectors (..., n, 3) [m] from the rays' origins to the points, and their slope by the yaw."""
    cosine, sine = np.cos(parameters[..., 3:]), np.sin(parameters[..., 3:])
    x, y = problem.points[..., 0], problem.points[..., 1]
    seen = parameters[..., None, :3] + (problem.points - problem.origins)
    slope = np.zeros_like(seen)
    slope[..., 0] = cosine * y - sine * x
    slope[..., 1] = -cosine * x - sine * y
    seen[..., 0] -= slope[..., 1] + x
    seen[..., 1] += slope[..., 0] - y
    return seen, slope


def _by_parameters(vectors: Array, slope: Array) -> Array:
    """(..., n, 4): how far a change of each parameter moves the points along vectors (..., n, 3)."""
    moved = np.empty((*vectors.shape[:-1], 4))
    moved[..., :3] = vectors
    moved[..., 3] = _dot(vectors, slope)
    return moved


def _moved(weights: Array, slope: Array) -> Array:
    """(..., 4, 4): the weighted sum of squared motions of the points by the parameters."""
    squares = np.zeros((*weights.shape[:-1], 4, 4))
    squares[..., 0, 0] = squares[..., 1, 1] = squares[..., 2, 2] = weights.sum(axis=-1)
    squares[..., 3, :3] = squares[..., :3, 3] = (weights[..., None, :] @ slope)[..., 0, :]
    squares[..., 3, 3] = (weights * _dot(slope, slope)).sum(axis=-1)
    return squares


def solve(problem: Problem) -> tuple[Array, float]:
    """The place (4,) of least cost, and that cost [rad²]: from every pose the closed form offers."""
    centroids, yaws = stationary_poses(problem.origins, problem.directions, problem.points, problem.weights)
    places, costs = minimise(problem, np.column_stack([centroids, yaws]))
    best = costs.argmin()
    return places[best], float(costs[best])


@dataclass(frozen=True, slots=True, eq=False)
class Descent:
    """How far starts have come: ``parameters`` (..., k, 4), the problem there, ``damping`` and last ``gain`` (..., k).

    ``gain`` is the drop of the cost [rad²] that the last step promised.
    """

    parameters: Array
    here: Linear
    damping: Array
    gain: Array


def minimise(problem: Problem, starts: Array, iterations: int = ITERATIONS) -> tuple[Array, Array]:
    """Where Levenberg-Marquardt ends from each start (k, 4): parameters (k, 4) and costs (k,)."""
    now = begin(problem, starts)
    for iteration in range(iterations):
        now = advance(problem, now)
        if ended(now, iteration):
            break
    return now.parameters, now.here.cost


def begin(problem: Problem, starts: Array) -> Descent:
    """The descent before its first step."""
    here = linearise(problem, starts)
    return Descent(starts, here, np.full(here.cost.shape, 1e-4), here.cost)


def advance(problem: Problem, now: Descent) -> Descent:
    """The descent one damped step on; a step that would climb is not made."""
    here = now.here
    step = _damped_step(here, now.damping)
    there = linearise(problem, now.parameters - step)
    better = there.cost < here.cost
    return Descent(
        np.where(better[..., None], now.parameters - step, now.parameters),
        _choose(better, there, here),
        np.where(better, now.damping * 0.1, np.minimum(now.damping * 10.0, 1e12)),
        np.abs((step * here.gradient).sum(axis=-1)),
    )


def ended(now: Descent, iteration: int) -> NDArray[np.bool_]:
    """Whether each problem (...) is done: its best start has settled and the others have too or are hopeless.

    Hopeless are those that cost three times as much, cannot reach the best in a hundred steps like their last, or
    ran away. From a wrong start the user backs off for ever, until all points are seen in one direction.
    """
    cost = now.here.cost
    best = cost.min(axis=-1, keepdims=True)
    settled = now.gain <= 1e-9 * cost + 1e-24
    given_up = np.abs(now.parameters[..., :3]).max(axis=-1) > _FAR_M
    if iteration >= 4:
        given_up |= cost > np.minimum(3.0 * best, best + 100.0 * now.gain)
    return np.asarray((settled | (given_up & (cost > best))).all(axis=-1))


def _damped_step(here: Linear, damping: Array) -> Array:
    damped = here.curvature.copy()
    diagonal = np.einsum("...ii->...i", damped)  # a view that can be written
    diagonal *= 1.0 + damping[..., None]
    diagonal += 1e-12
    return np.asarray(np.linalg.solve(damped, here.gradient[..., None])[..., 0])


def _choose(better: NDArray[np.bool_], there: Linear, here: Linear) -> Linear:
    return Linear(
        np.where(better, there.cost, here.cost),
        np.where(better[..., None], there.gradient, here.gradient),
        np.where(better[..., None, None], there.curvature, here.curvature),
    )
