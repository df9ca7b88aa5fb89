"""Six people pointing naturally: where their gestures are taken to point, with one band and with two.

Calibrated on one gesture at each of four corners of a 2 x 2 m square (heights 0.49 m, the eye about 1.15 m above
it, 1.5 to 3.5 m away), tested on all single gestures at the five other targets, over many draws of the corner
gestures; and on the one draw kept as files. A refused ray counts as 10 m off. Run: python benchmarks/people.py
"""

import argparse
import csv
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import numpy as np

from armspan.config.body_file import read_body
from armspan.config.recordings import read_pairs, read_rays
from armspan.frames import Array, rotation_from_quaternion
from armspan.pointing import misfits
from armspan.pointing.calibration import Fit, calibrate
from armspan.pointing.pairs import still_pairs
from armspan.pointing.spots import spot
from armspan.records import Body, Model

INSIDE_90 = 4.605
"""Squared Mahalanobis distance of the 90 % ellipse in two dimensions."""

MISSED_M = 10.0
HEIGHT_M = 0.49


@dataclass(frozen=True)
class Person:
    """Gestures at the targets of 0.49 m: attitudes (n, 3, 3), targets (n, 3) and which are corners (n,)."""

    body: Body
    forearm: Array
    upperarm: Array
    targets: Array
    corners: Array
    eye: Array


@dataclass
class Tally:
    """Errors [m] and [deg], and whether the target lay in the spot's own 90 % ellipse (NaN: refused)."""

    metres: list[float]
    degrees: list[float]
    inside: list[float]

    def add(self, fit: Fit, ray: tuple[Array, Array], target: Array, shrink: bool) -> None:
        """Score one ray that was meant for ``target`` (3,)."""
        found = spot(fit, *ray, float(target[2]), area=fit.area if shrink else None)
        if found.xy is None or found.covariance is None:
            self.metres.append(MISSED_M)
            self.inside.append(np.nan)
            return
        eye = fit.transform().points([0.0, 0.0, fit.body.eye_height_m])
        seen, meant = np.array([*found.xy, target[2]]) - eye, target - eye
        cosine = seen @ meant / np.linalg.norm(seen) / np.linalg.norm(meant)
        off = found.xy - target[:2]
        self.metres.append(float(np.hypot(*off)))
        self.degrees.append(float(np.degrees(np.arccos(min(1.0, cosine)))))
        self.inside.append(float(off @ np.linalg.solve(found.covariance, off) < INSIDE_90))

    def row(self) -> str:
        """The cells of a table."""
        cm, inside = 100 * np.array(self.metres), np.array(self.inside)
        return (
            f"{np.median(cm):.1f} | {np.percentile(cm, 90):.0f} | {np.median(self.degrees):.2f} "
            f"| {np.percentile(self.degrees, 90):.1f} | {100 * np.nanmean(inside):.0f} % | {np.isnan(inside).sum()}"
        )


def limb(start: Array, end: Array) -> Array:
    """Attitudes (n, 3, 3) with x along a limb, y level."""
    x = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    y = np.cross([0.0, 0.0, 1.0], x)
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def read_people(data: Path) -> list[Person]:
    with (data / "gestures.csv").open() as file:
        rows = list(csv.DictReader(file))
    people = []
    for number, name in enumerate(dict.fromkeys(row["person"] for row in rows), 1):
        own = [row for row in rows if row["person"] == name]
        marker = {
            m: np.array([[float(row[f"{m}_{axis}_m"]) for axis in "xyz"] for row in own])
            for m in ("eyes", "shoulder", "elbow", "wrist", "target")
        }
        low = np.isclose(marker["target"][:, 2], HEIGHT_M)
        eye = marker["eyes"].mean(axis=0) * [1.0, 1.0, 0.0]  # the floor straight below the eyes
        marker = {m: values[low] for m, values in marker.items()}
        x, y = marker["target"][:, 0], marker["target"][:, 1]
        corners = np.isclose(abs(x - 2.5), 1.0) & np.isclose(abs(y), 1.0)
        forearm, upperarm = limb(marker["elbow"], marker["wrist"]), limb(marker["shoulder"], marker["elbow"])
        body = read_body(data / f"p{number:02d}" / "body.toml")
        people.append(Person(body, forearm, upperarm, marker["target"] - eye, corners, eye))
    return people


def corner_draw(person: Person, rng: np.random.Generator) -> Array:
    rows = np.flatnonzero(person.corners)
    places = np.unique(person.targets[rows].round(3), axis=0)
    return np.array([rng.choice(rows[(person.targets[rows].round(3) == place).all(axis=1)]) for place in places])


def many_draws(people: list[Person], model: Model, draws: int, seed: int, shrink: bool) -> list[Tally]:
    rng, tallies = np.random.default_rng(seed), []
    for person in people:
        tally = Tally([], [], [])
        for _ in range(draws):
            rows = corner_draw(person, rng)
            stops = tuple(str(k) for k in range(len(rows)))
            pairs = still_pairs(person.forearm[rows], person.upperarm[rows], person.targets[rows], stops)
            fit = calibrate(person.body, pairs, model, z_up=True)
            origins, directions = fit.rays(person.forearm, person.upperarm)
            for i in np.flatnonzero(~person.corners):
                tally.add(fit, (origins[i], directions[i]), person.targets[i], shrink)
        tallies.append(tally)
    return tallies


def files(data: Path, model: Model, shrink: bool) -> list[Tally]:
    tallies = []
    for folder in sorted(data.glob("p[0-9][0-9]")):
        body, pairs, rays = (
            read_body(folder / "body.toml"),
            read_pairs(folder / "pairs.csv"),
            read_rays(folder / "rays.csv"),
        )
        truth = np.loadtxt(folder / "truth.csv", delimiter=",", skiprows=1)[:, 1:]
        attitudes = [rotation_from_quaternion(q) for q in (pairs.forearm, pairs.upperarm)]
        fit = calibrate(body, still_pairs(*attitudes, pairs.points, pairs.stops), model, z_up=True)
        origins, directions = fit.rays(*(rotation_from_quaternion(q) for q in (rays.forearm, rays.upperarm)))
        tally = Tally([], [], [])
        for ray, target, point in zip(zip(origins, directions, strict=True), truth, rays.points, strict=True):
            tally.add(fit, ray, np.array([*target, point[2]]), shrink)
        tallies.append(tally)
    return tallies


def together(tallies: list[Tally]) -> Tally:
    fields = ("metres", "degrees", "inside")
    return Tally(*([value for tally in tallies for value in getattr(tally, name)] for name in fields))


def report(data: Path, draws: int, seed: int) -> None:
    people = read_people(data)
    bands: dict[Model, str] = {"head-finger": "one", "two-band": "two"}
    header = (
        "median cm | p90 cm | median deg | p90 deg | in own 90 % ellipse | refused |\n|---|---|---|---|---|---|---|---|"
    )
    print(f"\n{draws} draws of the corner gestures for each person, seed {seed}\n")
    print(f"| bands | spots | {header}")
    for model, name in bands.items():
        with patch.object(misfits, "SURPRISE", np.inf):
            plain = many_draws(people, model, draws, seed, shrink=False)
        print(f"| {name} | plain fit | {together(plain).row()} |")
        kept = many_draws(people, model, draws, seed, shrink=False)
        print(f"| {name} | misfits left out (`--anywhere`) | {together(kept).row()} |")
        full = many_draws(people, model, draws, seed, shrink=True)
        print(f"| {name} | **misfits left out, drawn to the area (default)** | {together(full).row()} |")
        for number, tally in enumerate(full, 1):
            print(f"| {name} | default, person {number} | {tally.row()} |")
    print(f"\nThe one draw kept as files\n\n| bands | spots | {header}")
    for model, name in bands.items():
        for shrink, label in ((False, "`--anywhere`"), (True, "default")):
            print(f"| {name} | {label} | {together(files(data, model, shrink)).row()} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    shared = Path(__file__).resolve().parents[2] / "shared"
    parser.add_argument("--shared", type=Path, default=shared, help="folder with data/people")
    parser.add_argument("--draws", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    data = args.shared / "data" / "people"
    if not data.is_dir():
        print(f"No recordings at {data}: name the folder with --shared. Nothing was measured.")
        return
    report(data, args.draws, args.seed)


if __name__ == "__main__":
    main()
