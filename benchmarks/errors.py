"""Monte-Carlo calibrations of four stops: how long 100,000 of them take, against a loop over scipy's least_squares.

The same simulated rays are fitted by both; the loop starts from the closed form, as the batch does, and is timed on a
sample. With --study the whole study of `armspan.study.pointing_error` is run and its numbers are printed.
Run: python benchmarks/errors.py [--count 100000] [--jobs 2] [--sample 300] [--study [--shared DIR] [--pictures DIR]]
"""

import argparse
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from armspan.config.error_recordings import read_error_recordings
from armspan.pointing.batch import calibrate_many
from armspan.pointing.closed_form import stationary_poses
from armspan.pointing.least_squares import LOSS_SCALE, Problem, angles, miss
from armspan.study.pointing_error.monte_carlo import (
    BELIEVED,
    TABLE,
    TARGETS,
    believed_rays,
    chunk_errors,
    chunks,
    stop_shares,
)
from armspan.study.pointing_error.sources import draw_wrongs
from armspan.study.pointing_error.value import study
from armspan.study.pointing_error.value_pictures import draw_values


def simulate(count, seed, jobs):
    """Errors [m] of so many set-ups, wall-clock seconds with a pool that is up already, and CPU seconds of all."""
    tasks = chunks(TABLE, count, seed)
    with ProcessPoolExecutor(jobs) as pool:
        list(pool.map(chunk_errors, chunks(TABLE, 10 * jobs, seed)))
        start = time.perf_counter()
        errors = np.concatenate([found for found, _ in pool.map(timed, tasks)])
        wall = time.perf_counter() - start
        cpu = sum(seconds for _, seconds in pool.map(timed, tasks[:: max(1, len(tasks) // 8)]))
    return errors, wall, cpu * len(tasks) / len(tasks[:: max(1, len(tasks) // 8)])


def timed(task):
    start = time.process_time()
    found = chunk_errors(task)
    return found, time.process_time() - start


def rays(count, seed):
    """The stops' rays and points of so many set-ups, as `chunk_errors` makes them."""
    wrongs = draw_wrongs(np.random.default_rng(seed), count, 4, TARGETS)
    points = np.broadcast_to(TABLE.places(stop_shares(4)), (count, 4, 3))
    places = np.concatenate([points, np.broadcast_to(points[:, :1], (count, TARGETS, 3))], axis=1)
    origins, directions = believed_rays(BELIEVED, wrongs, places)
    return origins[:, :4], directions[:, :4], points


def scipy_fit(origins, directions, points, robust):
    """The cost [rad²] at which scipy ends from the best pose of the closed form, its robust loss or plain squares."""
    centred = points - points.mean(axis=0)
    problem = Problem(origins, directions, centred, np.ones(len(points)))
    poses = np.column_stack(stationary_poses(origins, directions, centred, problem.weights))
    start = poses[(angles(problem, poses) ** 2).sum(axis=1).argmin()]
    if not robust:
        return least_squares(lambda place: miss(problem, place).ravel(), start).cost
    return least_squares(lambda place: angles(problem, place[None])[0], start, loss="soft_l1", f_scale=LOSS_SCALE).cost


def compare(sample, seed):
    """Milliseconds of CPU a calibration by the batch and by two scipy loops; the batch's worst cost above scipy's."""
    origins, directions, points = rays(sample, seed)
    start = time.process_time()
    many = calibrate_many(origins, directions, points, z_up=True)
    batch = time.process_time() - start
    rows = {}
    for kind, robust in (("plain squares", False), ("the same robust cost", True)):
        start = time.process_time()
        costs = np.array([scipy_fit(*one, robust) for one in zip(origins, directions, points, strict=True)])
        above = f"{np.max(many.cost - costs):.1e}" if robust else "(another cost)"
        rows[kind] = (1000 * (time.process_time() - start) / sample, above)
    return 1000 * batch / sample, rows


def report(args):
    errors, wall, cpu = simulate(args.count, args.seed, args.jobs)
    batch, loops = compare(args.sample, args.seed)
    print(f"\n{args.count} calibrations of four stops with {TARGETS} gestures each, table, seed {args.seed}\n")
    print(f"wall clock, {args.jobs} processes: {wall:.1f} s; CPU time {cpu:.1f} s; errors of gestures, mm:")
    print(", ".join(f"p{p} {1000 * np.percentile(errors, p):.0f}" for p in (50, 90, 99)))
    print(
        f"\n| {args.sample} of them | CPU ms each | {args.count} on one core, s | batch's cost above it, worst rad² |"
    )
    print("|---|---|---|---|")
    print(f"| batch | {batch:.3f} | {batch * args.count / 1000:.0f} | |")
    for kind, (each, above) in loops.items():
        print(f"| loop over scipy, {kind} | {each:.2f} | {each * args.count / 1000:.0f} | {above} |")


def whole(args):
    folder = args.shared / "data"
    recordings = read_error_recordings(folder) if folder.is_dir() else None
    with ProcessPoolExecutor(args.jobs) as pool:
        start = time.perf_counter()
        values = study(recordings, count=args.count, seed=args.seed, progress=say, mapper=pool.map)
        wall = time.perf_counter() - start
    print(file=sys.stderr)
    print(json.dumps(values.document(), indent=1))
    print(f"\nThe whole study: {wall:.0f} s with {args.jobs} processes", file=sys.stderr)
    if args.pictures:
        args.pictures.mkdir(parents=True, exist_ok=True)
        draw_values(args.pictures, values)


def say(what, done, total):
    print(f"\r{what}: {done} of {total}        ", end="", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sample", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--study", action="store_true")
    parser.add_argument("--shared", type=Path, default=Path(__file__).resolve().parents[2] / "shared")
    parser.add_argument("--pictures", type=Path)
    args = parser.parse_args()
    if args.study:
        whole(args)
    else:
        report(args)


if __name__ == "__main__":
    main()
