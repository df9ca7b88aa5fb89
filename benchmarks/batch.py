"""10^5 calibrations of four stops at once, against a loop over scipy on a sample of the same data.

Four corners of a 0.4 to 1 m square, the user 0.6 to 2 m from its middle, a table of 0 to 0.9 m, any yaw; every ray
is turned by N(0, 2 deg) about each axis. Run: python benchmarks/batch.py
"""

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from rich.progress import Progress
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from armspan.frames import SHEET_FLIP, Array
from armspan.pointing.batch import Many, calibrate_many
from armspan.pointing.closed_form import stationary_poses
from armspan.pointing.least_squares import LOSS_SCALE, Problem, angles, minimise, miss, solve

EYE = np.array([0.0, 0.0, 1.65])


@dataclass(frozen=True)
class Scenes:
    """Rays (m, 4, 3) to points (m, 4, 3) [m] in ``sheet``, and the true ``sheet_from_user`` behind them."""

    directions: Array
    points: Array
    xyz: Array
    yaw: Array


def random_scenes(rng: np.random.Generator, count: int, sigma: float) -> Scenes:
    side, yaw = rng.uniform(0.4, 1.0, count), rng.uniform(-np.pi, np.pi, count)
    points = side[:, None, None] * np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    bearing, away = rng.uniform(-0.4, 0.4, count), rng.uniform(0.6, 2.0, count)
    middle = np.stack([away * np.cos(bearing), away * np.sin(bearing), rng.uniform(0.0, 0.9, count)], axis=1)
    turn = SHEET_FLIP @ Rotation.from_euler("z", yaw[:, None]).as_matrix()
    xyz = points.mean(axis=1) - (turn @ middle[..., None])[..., 0]
    rays = (points - xyz[:, None]) @ turn - EYE
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    rays = Rotation.from_rotvec(sigma * rng.normal(size=(4 * count, 3))).apply(rays.reshape(-1, 3))
    return Scenes(rays.reshape(count, 4, 3), points, xyz, yaw)


def problem_of(scenes: Scenes, number: int) -> Problem:
    points = scenes.points[number]
    centred = (points - points.mean(axis=0)) @ SHEET_FLIP
    return Problem(np.tile(EYE, (4, 1)), scenes.directions[number], centred, np.ones(4))


def pose_of(scenes: Scenes, number: int, place: Array) -> Array:
    turn = SHEET_FLIP @ Rotation.from_euler("z", place[3]).as_matrix()
    return np.array([*(scenes.points[number].mean(axis=0) - turn @ place[:3]), place[3]])


def scipy_solve(problem: Problem) -> tuple[Array, float]:
    """One start by the closed form, then scipy's trust region on the very same cost."""
    arrays = (problem.origins, problem.directions, problem.points, problem.weights)
    starts = np.column_stack(stationary_poses(*arrays))
    start = starts[angles(problem, starts).mean(axis=1).argmin()]
    found = least_squares(lambda x: bent_misses(problem, x), start)
    return found.x, float(found.cost)


def bent_misses(problem: Problem, place: Array) -> Array:
    """Residuals (3n,) whose squares sum to twice the robust cost; vectors, as lone angles have a kink at 0."""
    misses = miss(problem, place)
    bend = np.sqrt(1.0 + (misses**2).sum(axis=1) / LOSS_SCALE**2)
    return np.ravel(misses * np.sqrt(2.0 / (1.0 + bend))[:, None])


def best_of_many(problem: Problem, place: Array, rng: np.random.Generator) -> float:
    """The least cost [rad²] from 24 yaws about a place."""
    starts = np.tile(place, (24, 1))
    starts[:, :3] += rng.normal(0.0, 0.4, (24, 3))
    starts[:, 3] = np.linspace(-np.pi, np.pi, 24, endpoint=False)
    return float(minimise(problem, np.vstack([starts, place]), iterations=200)[1].min())


def half(directions: Array, points: Array) -> Array:
    return calibrate_many(EYE, directions, points).xyz


def timed_in_two_processes(scenes: Scenes) -> float:
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(half, *([array[:4]] * 2 for array in (scenes.directions, scenes.points))))
        started = time.perf_counter()
        list(pool.map(half, np.array_split(scenes.directions, 2), np.array_split(scenes.points, 2)))
        return time.perf_counter() - started


def compare(scenes: Scenes, many: Many, sample: int, rng: np.random.Generator) -> None:
    """The batch against the single solve and scipy on the first ``sample`` scenes."""
    problems = [problem_of(scenes, number) for number in range(sample)]
    started = time.process_time()
    alone = [solve(problem) for problem in problems]
    solve_s = time.process_time() - started
    started = time.process_time()
    scipys = [scipy_solve(problem) for problem in problems]
    scipy_s = time.process_time() - started
    print(f"| `solve` one by one ({sample} of the same) | {1e5 * solve_s / sample:.0f} s |")
    print(f"| loop over `scipy.optimize.least_squares` ({sample} of the same) | {1e5 * scipy_s / sample:.0f} s |\n")
    poses = np.array([pose_of(scenes, number, place) for number, (place, _) in enumerate(alone)])
    off = np.abs(many.xyz[:sample] - poses[:, :3]).max()
    print(f"Largest difference of x, y or z from the single solve: {off:.1e} m.")
    cost = many.cost[:sample]
    best = np.array([best_of_many(p, place, rng) for p, (place, _) in zip(problems, alone, strict=True)])
    for name, costs in (
        ("batch", cost),
        ("single solve", np.array([c for _, c in alone])),
        ("scipy", np.array([c for _, c in scipys])),
    ):
        wrong = int(np.sum(costs > best * (1 + 1e-6) + 1e-18))
        print(f"Cost above the best of 25 starts by more than 1e-6, {name}: {wrong} of {sample}.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=100_000)
    parser.add_argument("--sample", type=int, default=1000, help="scenes that are solved one by one too")
    parser.add_argument("--sigma-deg", type=float, default=2.0)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    rng = np.random.default_rng(args.seed)
    scenes = random_scenes(rng, args.scenes, np.radians(args.sigma_deg))
    with Progress(transient=True) as bar:
        task = bar.add_task("calibrations", total=args.scenes)
        wall, cpu = time.perf_counter(), time.process_time()
        many = calibrate_many(
            EYE, scenes.directions, scenes.points, progress=lambda done, _: bar.update(task, completed=done)
        )
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"\n{args.scenes} scenes of four stops, sigma {args.sigma_deg:g} deg, seed {args.seed}\n")
    print("| solver | seconds per 10^5 |\n|---|---|")
    per = 1e5 / args.scenes
    print(f"| `calibrate_many`, one core | {per * cpu:.1f} s CPU, {per * wall:.1f} s wall |")
    print(f"| `calibrate_many`, two processes | {per * timed_in_two_processes(scenes):.1f} s wall |")
    compare(scenes, many, min(args.sample, args.scenes), rng)
    error = np.linalg.norm(many.xyz - scenes.xyz, axis=1)
    print(f"Place off by, median / p90: {100 * np.median(error):.1f} / {100 * np.percentile(error, 90):.1f} cm.")


if __name__ == "__main__":
    main()
