"""Solvers of the calibration on identical random set-ups: right minima, error on the sheet, CPU time.

Four corners of a 0.4 to 1 m square, the user 0.6 to 2 m from its middle, a table of 0 to 0.9 m, any yaw; every ray
is turned by N(0, 2 deg) about each axis. Run: python benchmarks/solver.py
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares as scipy_least_squares
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from armspan.frames import Array, plane_hit, sheet_from_user
from armspan.pointing.closed_form import stationary_poses
from armspan.pointing.least_squares import Problem, angles, linearise, minimise, miss, solve
from armspan.pointing.nelder_mead import nelder_mead, nelder_mead_report

FLIP = np.array([1.0, -1.0, -1.0])
EYE_HEIGHT = 1.65


@dataclass(frozen=True)
class SetUp:
    """Pairs of a random user and sheet, and the true ``sheet_from_user`` behind them."""

    problem: Problem
    centre: Array
    side: float
    xyz: Array
    yaw: float


def random_set_up(rng: np.random.Generator, sigma: float) -> SetUp:
    side, yaw = rng.uniform(0.4, 1.0), rng.uniform(-np.pi, np.pi)
    points = np.array([[0.0, 0, 0], [side, 0, 0], [side, side, 0], [0, side, 0]])
    centre = points.mean(axis=0)
    bearing, away = rng.uniform(-0.4, 0.4), rng.uniform(0.6, 2.0)
    centre_user = np.array([away * np.cos(bearing), away * np.sin(bearing), rng.uniform(0.0, 0.9)])
    turn = sheet_from_user((0.0, 0.0, 0.0), yaw)
    xyz = centre - turn.points(centre_user)
    eye = np.array([0.0, 0.0, EYE_HEIGHT])
    rays = sheet_from_user(xyz, yaw).inverse().points(points) - eye
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    rays = Rotation.from_rotvec(rng.normal(0.0, 1.0, (4, 3)) * sigma).apply(rays)
    problem = Problem(np.tile(eye, (4, 1)), rays, (points - centre) * FLIP, np.ones(4))
    return SetUp(problem, centre, side, xyz, yaw)


def pose_of(set_up: SetUp, place: Array) -> tuple[Array, float]:
    turn = sheet_from_user((0.0, 0.0, 0.0), float(place[3]))
    return set_up.centre - turn.points(place[:3]), float(place[3])


def place_of(set_up: SetUp, pose: Array) -> Array:
    back = sheet_from_user(pose[:3], float(pose[3])).inverse()
    return np.array([*back.points(set_up.centre), pose[3]])


def sheet_rms(set_up: SetUp, place: Array) -> float:
    """Where perfect rays to a 9 x 9 grid of the square seem to end, rms [m]."""
    line = np.linspace(0.0, set_up.side, 9)
    grid = np.stack([*np.meshgrid(line, line), np.zeros((9, 9))], axis=-1).reshape(-1, 3)
    eye = np.array([0.0, 0.0, EYE_HEIGHT])
    rays = sheet_from_user(set_up.xyz, set_up.yaw).inverse().points(grid) - eye
    found = sheet_from_user(*pose_of(set_up, place))
    hits = plane_hit(np.tile(found.points(eye), (81, 1)), found.directions(rays), 0.0)
    errors = ((hits - grid) ** 2).sum(axis=1)
    return float(np.sqrt(errors.mean())) if np.isfinite(errors).all() else np.inf


def mean_angle(set_up: SetUp, place: Array) -> float:
    return float(angles(set_up.problem, place[None])[0].mean())


def closed_form_starts(problem: Problem) -> Array:
    return np.column_stack(stationary_poses(problem.origins, problem.directions, problem.points, problem.weights))


def closed_form(set_up: SetUp) -> Array:
    starts = closed_form_starts(set_up.problem)
    return starts[angles(set_up.problem, starts).mean(axis=1).argmin()]


def nelder_mead_same_start(set_up: SetUp) -> Array:
    found = minimize(
        lambda pose: mean_angle(set_up, place_of(set_up, pose)),
        [0.0, 0.0, 0.8, 0.0],
        method="Nelder-Mead",
        tol=1e-8,
        options={"maxiter": 10000},
    )
    return place_of(set_up, found.x)


def nelder_mead_closed_form(set_up: SetUp) -> Array:
    found = minimize(
        lambda place: mean_angle(set_up, place),
        closed_form(set_up),
        method="Nelder-Mead",
        tol=1e-8,
        options={"maxiter": 10000},
    )
    return found.x


def bfgs(set_up: SetUp) -> Array:
    found = minimize(lambda pose: mean_angle(set_up, place_of(set_up, pose)), np.zeros(4), method="BFGS")
    return place_of(set_up, found.x)


def scipy_trf(set_up: SetUp, start: Array) -> tuple[Array, float]:
    found = scipy_least_squares(lambda place: miss(set_up.problem, place).ravel(), start)
    return found.x, found.cost


def trf_one_start(set_up: SetUp) -> Array:
    return scipy_trf(set_up, place_of(set_up, np.array([0.0, 0.0, 0.8, 0.0])))[0]


def trf_eight_starts(set_up: SetUp) -> Array:
    yaws = np.arange(8) * np.pi / 4
    found = [scipy_trf(set_up, place_of(set_up, np.array([0.0, 0.0, 0.8, yaw]))) for yaw in yaws]
    return min(found, key=lambda pair: pair[1])[0]


def trf_closed_form(set_up: SetUp) -> Array:
    return scipy_trf(set_up, closed_form(set_up))[0]


def armspan(set_up: SetUp) -> Array:
    return solve(set_up.problem)[0]


SOLVERS: dict[str, Callable[[SetUp], Array]] = {
    "Nelder-Mead as in the report (mm, x0 = (0, 0, 800, 0))": lambda s: nelder_mead_report(s.problem, s.centre),
    "Nelder-Mead in metres, same start": nelder_mead_same_start,
    "Nelder-Mead in metres, simplex set by hand": lambda s: nelder_mead(s.problem, s.centre),
    "Nelder-Mead from the closed form": nelder_mead_closed_form,
    "BFGS from 0 (IROS 2018)": bfgs,
    "scipy TRF, one start": trf_one_start,
    "scipy TRF, 8 yaws": trf_eight_starts,
    "closed form only": closed_form,
    "closed form + scipy TRF": trf_closed_form,
    "**Armspan: closed form + batched robust LM**": armspan,
}


def best_of_many(set_up: SetUp, others: list[Array], rng: np.random.Generator) -> tuple[Array, float]:
    """The least robust cost from 24 yaws about the truth, the truth, and what every solver found."""
    true = place_of(set_up, np.array([*set_up.xyz, set_up.yaw]))
    starts = np.tile(true, (25, 1))
    starts[1:, :3] += rng.normal(0.0, 0.4, (24, 3))
    starts[1:, 3] = np.linspace(-np.pi, np.pi, 24, endpoint=False)
    places, costs = minimise(set_up.problem, np.vstack([starts, others]), iterations=200)
    return places[costs.argmin()], float(costs.min())


def yaw_error(set_up: SetUp, place: Array) -> float:
    return abs((place[3] - set_up.yaw + np.pi) % (2 * np.pi) - np.pi)


def compare(count: int, sigma: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    set_ups = [random_set_up(rng, sigma) for _ in range(count)]
    places: dict[str, list[Array]] = {}
    cpu: dict[str, Array] = {}
    for name, solver in SOLVERS.items():
        solver(set_ups[0])
        times = []
        for set_up in set_ups:
            started = time.process_time()
            places.setdefault(name, []).append(solver(set_up))
            times.append(time.process_time() - started)
        cpu[name] = np.array(times)
    reference = [best_of_many(s, [places[n][i] for n in SOLVERS], rng) for i, s in enumerate(set_ups)]
    least_angle = [min(mean_angle(s, places[n][i]) for n in SOLVERS) for i, s in enumerate(set_ups)]
    print(f"\n{count} set-ups, sigma {np.degrees(sigma):g} deg, seed {seed}\n")
    print(
        "| solver | CPU ms, median / p90 | mean angle > best + 0.6 deg | yaw off > 30 deg | sheet RMS mm, p50 / p90 |"
    )
    print("|---|---|---|---|---|")
    for name, found in places.items():
        wrong = np.mean(
            [mean_angle(s, p) > a + np.radians(0.6) for s, p, a in zip(set_ups, found, least_angle, strict=True)]
        )
        off = np.mean([yaw_error(s, p) > np.radians(30) for s, p in zip(set_ups, found, strict=True)])
        rms = 1e3 * np.array([sheet_rms(s, p) for s, p in zip(set_ups, found, strict=True)])
        ms = 1e3 * cpu[name]
        print(
            f"| {name} | {np.median(ms):.2f} / {np.percentile(ms, 90):.2f} | {100 * wrong:.1f} % | {100 * off:.1f} % "
            f"| {np.median(rms):.3g} / {np.percentile(rms, 90, method='lower'):.3g} |"
        )
    ours = places["**Armspan: closed form + batched robust LM**"]
    costs = np.array([linearise(s.problem, p[None]).cost[0] for s, p in zip(set_ups, ours, strict=True)])
    best = np.array([cost for _, cost in reference])
    rms = np.median([sheet_rms(s, p) for s, p in zip(set_ups, ours, strict=True)])
    rms_best = np.median([sheet_rms(s, p) for s, (p, _) in zip(set_ups, reference, strict=True)])
    wrong = int(np.sum(costs > best * (1 + 1e-6) + 1e-18))
    print(f"\nArmspan's own cost above the best of many starts (by more than 1e-6): {wrong} of {count}.")
    print(f"Its sheet RMS, median: {1e3 * rms:.4g} mm; that of the best fits: {1e3 * rms_best:.4g} mm.")
    if not sigma:
        worst = max(float(np.abs(pose_of(s, p)[0] - s.xyz).max()) for s, p in zip(set_ups, ours, strict=True))
        print(f"Largest error of x, y or z without noise: {worst:.1e} m.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--setups", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    compare(args.setups, np.radians(2.0), args.seed)
    compare(max(1, args.setups // 5), 0.0, args.seed + 1)


if __name__ == "__main__":
    main()
