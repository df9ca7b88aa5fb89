"""Does it pay to free the body's measures (MAP)? Simulated stops, six real people, three sessions.

Simulated: a person of 1.75 m, a man, whose true measures are drawn from the prior of height and sex; a straight arm
points at the stops with noise; the calibration knows the prior's mean only. Errors are the median distance [mm] of
noise-free spots on a 9 x 9 grid of the sheet. Real: as benchmarks/people.py, with a covariance put to the people's own
measures. Run: python benchmarks/map.py
"""

import argparse
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from scipy.spatial.transform import Rotation

from armspan.body.anthropometry import prior
from armspan.body.told import Told
from armspan.config.body_file import read_body
from armspan.config.recordings import read_pairs
from armspan.frames import Array, plane_hit, rotation_from_quaternion, sheet_from_user
from armspan.pointing.calibration import Fit, Noise, calibrate
from armspan.pointing.pairs import Pairs, moving_pairs, still_pairs
from armspan.pointing.priors import PITCH_SD, Priors
from armspan.records import Body, Model
from people import Tally, corner_draw, read_people, together
from sessions import SESSIONS

REAL_SD = np.array([0.008, 0.022, 0.008, 0.023, 0.025])
"""Doubt [m] put to the measures of the real people, in the order of `Body.covariance`."""

TOLD = {False: "noise assumed as in a session", True: "noise told"}


@dataclass(frozen=True)
class Scene:
    """A sheet of ``size`` [m] at ``height`` [m] above the floor, its middle ``away`` [m] from the user."""

    name: str
    size: tuple[float, float]
    height: float
    away: float


TABLE = Scene("table 0.56 x 0.4 m", (0.56, 0.4), 0.75, 0.6)
FLOOR = Scene("floor 1.6 x 1.2 m", (1.6, 1.2), 0.0, 1.5)
CELLS = (
    (TABLE, 1.5, 2),
    (TABLE, 1.5, 4),
    (FLOOR, 1.5, 2),
    (FLOOR, 1.5, 4),
    (TABLE, 0.5, 4),
    (FLOOR, 0.5, 2),
    (FLOOR, 0.5, 4),
)
"""Scene, noise [deg] and stops along each side."""

WAYS: dict[str, Priors] = {
    "fixed": Priors(),
    "fixed, height": Priors(plane_height=(0.0, 0.005)),
    "MAP": Priors(measures=True),
    "MAP, height": Priors(plane_height=(0.0, 0.005), measures=True),
    "MAP, height, pitch": Priors(plane_height=(0.0, 0.005), measures=True, pitch_sd=PITCH_SD),
}


REAL_WAYS: dict[str, Priors] = {
    "fixed": Priors(),
    "MAP": Priors(measures=True),
    "MAP, pitch": Priors(measures=True, pitch_sd=PITCH_SD),
}


def grid(scene: Scene, count: int) -> Array:
    """(count², 3) [m] in ``sheet``."""
    x, y = (np.linspace(0.0, side, count) for side in scene.size)
    return np.stack([*np.meshgrid(x, y), np.zeros((count, count))], axis=-1).reshape(-1, 3)


def body_of(measures: Array, covariance: Array) -> Body:
    eye, forward, left, up, arm = (float(v) for v in measures)
    return Body(eye, (forward, left, up), arm, covariance=tuple(covariance.ravel()))


def attitudes(targets_user: Array, body: Body) -> Array:
    """(n, 3, 3) of a stiff arm whose fingertip lies on the line from the eye to each target."""
    eye, offset = np.array([0.0, 0.0, body.eye_height_m]), np.array(body.shoulder_to_eye_m)
    sight = targets_user - eye
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    along = sight @ offset
    reach = -along + np.sqrt(along**2 - offset @ offset + body.shoulder_to_fingertip_m**2)
    x = (offset + reach[:, None] * sight) / body.shoulder_to_fingertip_m
    y = np.cross([0.0, 0.0, 1.0], x)
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def spot_error(fit: Fit, arm: Array, targets: Array) -> float:
    """The median distance [m] of the spots of an arm from what it pointed at."""
    origins, directions = fit.rays(arm)
    found = fit.transform()
    hits = plane_hit(found.points(origins), found.directions(directions), 0.0)
    return float(np.median(np.nan_to_num(np.linalg.norm(hits - targets, axis=1), nan=10.0)))


def pairs_on(scene: Scene, body: Body, stops: int, degrees: float, rng: np.random.Generator) -> tuple[Pairs, Array]:
    """Noisy stops of a person before the sheet, and the attitudes that point at the 9 x 9 grid."""
    yaw, middle = rng.uniform(-np.pi, np.pi), np.array([*scene.size, 0.0]) / 2.0
    xyz = middle - sheet_from_user((0.0, 0.0, 0.0), yaw).points([scene.away, 0.0, scene.height])
    back, points = sheet_from_user(xyz, yaw).inverse(), grid(scene, stops)
    arm = Rotation.from_rotvec(np.radians(degrees) * rng.normal(size=points.shape)).as_matrix()
    arm = arm @ attitudes(back.points(points), body)
    names = tuple(str(k) for k in range(len(points)))
    return still_pairs(arm, None, points, names), attitudes(back.points(grid(scene, 9)), body)


def simulated(trials: int, seed: int) -> None:
    known = prior(Told(height_m=1.75, sex="man"))
    assumed = body_of(known.mean, known.covariance)
    print(f"\n{trials} simulated people a cell, seed {seed}; spots off by, median / p90 [mm]\n")
    print(f"| scene | noise | stops | noise known | {' | '.join(WAYS)} |")
    print("|---" * (len(WAYS) + 4) + "|")
    for scene, degrees, side in CELLS:
        for told in (False, True):
            rng = np.random.default_rng(seed)
            errors: dict[str, list[float]] = {name: [] for name in WAYS}
            for _ in range(trials):
                true = body_of(rng.multivariate_normal(known.mean, known.covariance), known.covariance)
                pairs, arm = pairs_on(scene, true, side, degrees, rng)
                for name, priors in WAYS.items():
                    if priors.plane_height:
                        height = (scene.height + 0.005 * rng.normal(), 0.005)
                        priors = Priors(height, priors.pitch_sd, priors.measures)
                    noise = Noise(np.radians(degrees), 1e6) if told else None
                    fit = calibrate(assumed, pairs, "head-finger", priors=priors, noise=noise)
                    errors[name].append(1e3 * spot_error(fit, arm, grid(scene, 9)))
            cells = (f"{np.median(e):.0f} / {np.percentile(e, 90):.0f}" for e in errors.values())
            print(f"| {scene.name} | {degrees} deg | {side**2} | {TOLD[told]} | {' | '.join(cells)} |", flush=True)


def real(data: Path, draws: int, seed: int) -> None:
    people = read_people(data)
    print(f"\nSix people, {draws} draws of the corner gestures for each, seed {seed}\n")
    print("| bands | measures | median cm | p90 cm | median deg | p90 deg | in own 90 % ellipse | refused |")
    print("|---|---|---|---|---|---|---|---|")
    models: dict[Model, str] = {"head-finger": "one", "two-band": "two"}
    said = []
    for model, bands in models.items():
        for name, priors in REAL_WAYS.items():
            rng, tallies, verdicts = np.random.default_rng(seed), [], Counter[tuple[str, str]]()
            for person in people:
                body = msgspec.structs.replace(person.body, covariance=tuple(np.diag(REAL_SD**2).ravel()))
                tally = Tally([], [], [])
                for _ in range(draws):
                    rows = corner_draw(person, rng)
                    stops = tuple(str(k) for k in range(len(rows)))
                    pairs = still_pairs(person.forearm[rows], person.upperarm[rows], person.targets[rows], stops)
                    fit = calibrate(body, pairs, model, z_up=True, priors=priors)
                    verdicts.update((p.name, p.verdict) for p in fit.parameters if p.prior_sd)
                    origins, directions = fit.rays(person.forearm, person.upperarm)
                    for i in np.flatnonzero(~person.corners):
                        tally.add(fit, (origins[i], directions[i]), person.targets[i], True)
                tallies.append(tally)
            print(f"| {bands} | {name} | {together(tallies).row()} |", flush=True)
            told = (f"{n} {v}: {c}" for (n, v), c in sorted(verdicts.items()) if n != "eye height")
            said.append(f"{bands} band(s), {name}: {', '.join(told) or 'nothing freed'}")
    print("\nVerdicts\n\n" + "\n".join(said))


def sessions(data: Path) -> None:
    """Whole sessions of a person who follows a flying robot; the error is that of the eye's place over ground."""
    body = msgspec.structs.replace(read_body(data / "body.toml"), covariance=tuple(np.diag(REAL_SD**2).ravel()))
    print("\nWhole sessions of Gromov et al. 2018: residual [deg] and head off by [m]\n")
    print(f"| session | {' | '.join(REAL_WAYS)} |")
    print("|---" * (len(REAL_WAYS) + 1) + "|")
    for name in SESSIONS:
        session = read_pairs(data / f"{name}.csv")
        head = np.loadtxt(data / f"{name}_head.csv", delimiter=",", skiprows=1)[:, 1:].mean(axis=0)
        pairs = moving_pairs(rotation_from_quaternion(session.forearm), None, session.points, session.times)
        cells = []
        for priors in REAL_WAYS.values():
            fit = calibrate(body, pairs, "head-finger", z_up=True, priors=priors)
            eye = fit.transform().points([0.0, 0.0, body.eye_height_m])
            cells.append(f"{np.degrees(fit.rms):.2f}, {np.hypot(*(eye - head)[:2]):.2f}")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    shared = Path(__file__).resolve().parents[2] / "shared"
    parser.add_argument("--shared", type=Path, default=shared, help="folder with data/people and data/pointing")
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    simulated(args.trials, args.seed)
    data = args.shared / "data"
    if data.is_dir():
        real(data / "people", args.draws, args.seed)
        sessions(data / "pointing")
    else:
        print(f"No recordings at {data}: name the folder with --shared. Nothing was measured of real people.")


if __name__ == "__main__":
    main()
