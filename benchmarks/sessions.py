"""Real sessions of a person who follows a flying robot: residual and error of the head by the seconds used.

Gromov, Gambardella, Giusti, IROS 2018 (published: head within 0.25 m after 3 to 5 s). Random segments of three
sessions; the error is that of the eye's place against the head's, horizontally. Run: python benchmarks/sessions.py
"""

import argparse
from pathlib import Path

import numpy as np

from armspan.config.body_file import read_body
from armspan.config.recordings import Recording, read_pairs
from armspan.errors import CalibrationError
from armspan.frames import Array, rotation_from_quaternion
from armspan.pointing.calibration import calibrate
from armspan.pointing.pairs import moving_pairs
from armspan.records import Body, Model

SESSIONS = ("circle_0", "triangle_2", "triangle_3")
SECONDS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, None)
LAGS = (0.0, 0.05, 0.10, 0.15, 0.20)


def head_error(body: Body, session: Recording, head: Array, rows: slice, model: Model, lag: float) -> tuple[float, ...]:
    """Horizontal error [m], residual [rad] and cost of one segment, the robot taken ``lag`` seconds earlier."""
    times = session.times
    points = np.column_stack([np.interp(times - lag, times, axis) for axis in session.points.T])
    forearm = rotation_from_quaternion(session.forearm[rows])
    fit = calibrate(body, moving_pairs(forearm, None, points[rows], times[rows]), model, z_up=True)
    eye = fit.transform().points([0.0, 0.0, body.eye_height_m])
    return float(np.hypot(*(eye - head[rows].mean(axis=0))[:2])), fit.rms, fit.cost


def segments(session: Recording, seconds: float | None, count: int, rng: np.random.Generator) -> list[slice]:
    if seconds is None:
        return [slice(0, len(session.times))]
    starts = rng.uniform(max(LAGS), session.times[-1] - seconds, count)
    return [slice(*np.searchsorted(session.times, (start, start + seconds))) for start in starts]


def measure(data: Path, model: Model, count: int, seed: int) -> None:
    body, rng = read_body(data / "body.toml"), np.random.default_rng(seed)
    sessions = [read_pairs(data / f"{name}.csv") for name in SESSIONS]
    heads = [np.loadtxt(data / f"{name}_head.csv", delimiter=",", skiprows=1)[:, 1:] for name in SESSIONS]
    print(f"\n{model}\n")
    print(
        "| seconds | segments | refused | residual deg | head error m, median / p90 | lag 0.1 s | lag of least cost |"
    )
    print("|---|---|---|---|---|---|---|")
    for seconds in SECONDS:
        found, refused = [], 0
        for session, head in zip(sessions, heads, strict=True):
            for rows in segments(session, seconds, count, rng):
                try:
                    found.append([head_error(body, session, head, rows, model, lag) for lag in LAGS])
                except CalibrationError:
                    refused += 1
        table = np.array(found)  # segment, lag, (error, residual, cost)
        by_cost = table[np.arange(len(table)), table[:, :, 2].argmin(axis=1), 0]
        plain = table[:, 0, 0]
        print(
            f"| {'whole' if seconds is None else f'{seconds:g}'} | {len(found)} | {refused} "
            f"| {np.degrees(np.median(table[:, 0, 1])):.2f} | {np.median(plain):.2f} / {np.percentile(plain, 90):.2f} "
            f"| {np.median(table[:, LAGS.index(0.1), 0]):.2f} | {np.median(by_cost):.2f} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    shared = Path(__file__).resolve().parents[2] / "shared"
    parser.add_argument("--shared", type=Path, default=shared, help="folder with data/pointing")
    parser.add_argument("--segments", type=int, default=40, help="random segments of each session and length")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    data = args.shared / "data" / "pointing"
    if not data.is_dir():
        print(f"No recordings at {data}: name the folder with --shared. Nothing was measured.")
        return
    models: tuple[Model, ...] = ("head-finger", "shoulder-finger")
    for model in models:
        measure(data, model, args.segments, args.seed)


if __name__ == "__main__":
    main()
