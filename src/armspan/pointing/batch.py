"""Many calibrations at once: the single solver's own formulas on stacked arrays, for Monte-Carlo studies.

All stationary poses of the closed form are the starts, as in the single solve, and all problems of a chunk step
together until they have ended one by one, so that each takes the very steps it would take alone.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from armspan.frames import SHEET_FLIP, Array
from armspan.pointing.closed_form import across_sum, stationary_poses
from armspan.pointing.least_squares import (
    ITERATIONS,
    LOSS_SCALE,
    Descent,
    Linear,
    Problem,
    advance,
    angles,
    begin,
    ended,
    linearise,
)

Progress: TypeAlias = Callable[[int, int], None]
"""Told after each chunk: how many calibrations are done, and of how many."""

_ROWS = 8192
"""Rays times starts of one chunk: its arrays stay in the second cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Many:
    """``sheet_from_user`` of m calibrations: ``xyz`` (m, 3) [m], ``yaw`` (m,) [rad].

    ``rms`` (m,) [rad] is the residual angle, ``cost`` (m,) [rad²] the robust cost; ``information`` (m, 4, 4) over
    (x, y, z, yaw) is the inverse of the covariance for a pointing noise of 1 rad per axis. All are NaN where the
    rays of a problem run parallel or are no numbers.
    """

    xyz: Array
    yaw: Array
    rms: Array
    cost: Array
    information: Array

    def covariance(self, sigma: float) -> Array:
        """Covariances (m, 4, 4) over (x, y, z, yaw) for a pointing noise ``sigma`` [rad] per axis."""
        return np.asarray(sigma**2 * np.linalg.inv(self.information))


def calibrate_many(
    origins: Array,
    directions: Array,
    points: Array,
    weights: Array | None = None,
    *,
    z_up: bool = False,
    loss_scale: float = LOSS_SCALE,
    progress: Progress | None = None,
) -> Many:
    """Place m users, each so that his n rays meet his n points.

    ``origins`` [m] and unit ``directions`` (m, n, 3) are in ``user``; one origin for all rays may be (m, 1, 3) or
    (3,). ``points`` [m] in ``sheet`` are (m, n, 3), or (n, 3) where all share them; ``weights`` are (m, n) or
    (n,), and 0 leaves a ray out. ``loss_scale`` [rad] as in `Problem`. No stop is left out as a misfit.
    """
    flip = np.eye(3) if z_up else SHEET_FLIP
    count, rays = directions.shape[:2]
    shape = (count, rays, 3)
    points = np.broadcast_to(points, shape)
    origins = np.broadcast_to(origins, shape)
    weights = np.broadcast_to(1.0 if weights is None else weights, shape[:2])
    many = _empty(count)
    for rows in _chunks(count, max(1, _ROWS // (4 * rays))):
        centre = points[rows].mean(axis=1)
        centred = (points[rows] - centre[:, None]) @ flip
        problem = Problem(
            origins[rows, None], directions[rows, None], centred[:, None], weights[rows, None], loss_scale
        )
        _solve(problem, centre, flip, many, rows)
        if progress is not None:
            progress(rows.stop, count)
    return many


def _chunks(count: int, size: int) -> Iterator[slice]:
    return (slice(first, min(first + size, count)) for first in range(0, count, size))


def _empty(count: int) -> Many:
    def nan(*shape: int) -> Array:
        return np.full((count, *shape), np.nan)

    return Many(nan(3), nan(), nan(), nan(), nan(4, 4))


def _solve(problem: Problem, centre: Array, flip: Array, many: Many, rows: slice) -> None:
    """Write the calibrations of a chunk; rays that run parallel are left as they are."""
    told = _told(problem)
    where, problem, centre = rows.start + np.flatnonzero(told), _kept(problem, told), centre[told]
    arrays = (problem.origins, problem.directions, problem.points, problem.weights)
    centroids, yaws = stationary_poses(*(array[:, 0] for array in arrays))
    places, costs = minimise_many(problem, np.concatenate([centroids, yaws[..., None]], axis=-1))
    best = costs.argmin(axis=1)[:, None]
    place = np.take_along_axis(places, best[..., None], axis=1)
    many.cost[where] = np.take_along_axis(costs, best, axis=1)[:, 0]
    many.yaw[where] = np.arctan2(np.sin(place[:, 0, 3]), np.cos(place[:, 0, 3]))
    turn = flip @ _turns(place[:, 0, 3])
    many.xyz[where] = centre - (turn @ place[:, 0, :3, None])[..., 0]
    squares = angles(problem, place)[:, 0] ** 2
    weights = problem.weights[:, 0]
    many.rms[where] = np.sqrt((weights * squares).sum(axis=1) / weights.sum(axis=1))
    many.information[where] = _information(problem, place, squares, turn)


def _told(problem: Problem) -> NDArray[np.bool_]:
    """Which problems (m,) hold numbers, and rays that do not all run parallel."""
    finite = np.asarray(np.isfinite(problem.origins + problem.directions + problem.points).all(axis=(1, 2, 3)))
    directions = np.where(finite[:, None, None], problem.directions[:, 0], 0.0)
    across = across_sum(directions, problem.weights[:, 0])
    return np.asarray(finite & (np.linalg.det(across) != 0.0))


def minimise_many(problem: Problem, starts: Array, iterations: int = ITERATIONS) -> tuple[Array, Array]:
    """As `minimise` for each of m problems alone: parameters (m, k, 4) and costs (m, k) from starts (m, k, 4)."""
    places, costs = starts.copy(), np.empty(starts.shape[:2])
    under_way, now = np.arange(len(starts)), begin(problem, starts)
    for iteration in range(iterations):
        now = advance(problem, now)
        done = ended(now, iteration)
        if done.any():
            places[under_way[done]], costs[under_way[done]] = now.parameters[done], now.here.cost[done]
            under_way, problem, now = under_way[~done], _kept(problem, ~done), _going_on(now, ~done)
        if not len(under_way):
            break
    places[under_way], costs[under_way] = now.parameters, now.here.cost
    return places, costs


def _kept(problem: Problem, kept: NDArray[np.bool_]) -> Problem:
    return Problem(
        problem.origins[kept],
        problem.directions[kept],
        problem.points[kept],
        problem.weights[kept],
        problem.loss_scale,
    )


def _going_on(now: Descent, kept: NDArray[np.bool_]) -> Descent:
    here = Linear(now.here.cost[kept], now.here.gradient[kept], now.here.curvature[kept])
    return Descent(now.parameters[kept], here, now.damping[kept], now.gain[kept])


def _turns(yaws: Array) -> Array:
    """Rz(yaw), (m, 3, 3)."""
    turns = np.zeros((len(yaws), 3, 3))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(yaws)
    turns[:, 1, 0] = np.sin(yaws)
    turns[:, 0, 1] = -turns[:, 1, 0]
    turns[:, 2, 2] = 1.0
    return turns


def _information(problem: Problem, place: Array, squares: Array, turn: Array) -> Array:
    """(m, 4, 4) over (x, y, z, yaw); a ray counts as much as the loss leaves it, as in `calibrate`."""
    weights = problem.weights / np.sqrt(1.0 + squares[:, None] / problem.loss_scale**2)
    plain = Problem(problem.origins, problem.directions, problem.points, weights, 1e6)
    curvature = linearise(plain, place).curvature[:, 0]
    back = np.zeros((len(turn), 4, 4))  # (centroid in user, yaw) by (x, y, z, yaw)
    back[:, :3, :3] = -turn.swapaxes(1, 2)
    back[:, 0, 3], back[:, 1, 3], back[:, 3, 3] = place[:, 0, 1], -place[:, 0, 0], 1.0
    return np.asarray(back.swapaxes(1, 2) @ curvature @ back)
