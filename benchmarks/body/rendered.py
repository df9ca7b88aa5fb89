"""Measures of twenty-four rendered bodies, told by the picture routes against what is exactly known.

Each body stands in four pictures: front (T pose) and side (pointing), far (5 m, camera 1.3 m high) and near (2.6 to
3.4 m, 1.0 to 1.5 m, tilted, the printed sheet on the floor). They are drawn once into a folder, which needs the package
anny; the measuring needs OpenCV, LiteRT and the networks of ``armspan body --set-up``. Synthetic bodies have tight
clothes, no shoes and cropped hair, and stand as told: real pictures are worse.

Run: python benchmarks/body/rendered.py FOLDER [--clothes] [--weights FOLDER] [--no-networks]
"""

import argparse
import importlib.util
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from shots import SCALES, Find, Shot, draw_all, found_by, seen, sheet_scale, shots, true_points

from armspan.body.anthropometry import prior
from armspan.body.measured import measure
from armspan.body.observation import MEASURES, Measure
from armspan.body.scale import HeightScale
from armspan.body.told import Told
from armspan.body.views import observe
from armspan.config.weights import weights_folder
from armspan.errors import ArmspanError


@dataclass
class Column:
    """Errors [m] of one measure by one route: of the values seen, and z of what the route claims."""

    errors: list[float]
    claimed: list[float]

    def row(self) -> str:
        """Number, bias, SD, RMSE [mm], the SD claimed, and errors over it."""
        e, s = 1e3 * np.array(self.errors), 1e3 * np.array(self.claimed)
        root, z = np.sqrt((e**2).mean()), np.sqrt(((e / s) ** 2).mean())
        return f"{len(e):3d} {e.mean():+6.0f} {e.std():5.0f} {root:5.0f} {s.mean():6.0f} {z:5.1f}"


def true_measure(shot: Shot, measure: Measure, kind: str) -> float:
    """One of the five [m]; ``kind`` says from which pivot: "pivot" (15 mm below the acromion), "joint", "sum"."""
    truth = shot.truth
    if measure == "arm length" and kind == "sum":
        return truth["arm sum"]
    if kind == "joint" and measure != "eye height":
        return truth[f"{measure} from joint"]
    return truth[measure]


def table(title: str, rows: Mapping[tuple[str, Measure], Column]) -> None:
    print(f"\n{title}\n{'route':26s} {'measure':11s}   n   bias    SD  RMSE  claims   z  [mm]")
    for (route, name), column in rows.items():
        print(f"{route:26s} {name:11s} {column.row()}")


def single_views(all_shots: Sequence[Shot], find: Find, kind: str) -> tuple[dict[Any, Column], Counter[str], list[str]]:
    """Every picture by itself: errors of what it tells, how many say nothing, and why."""
    columns: dict[Any, Column] = {}
    fails: Counter[str] = Counter()
    why: list[str] = []
    for shot in all_shots:
        where = "near" if shot.known["sheet"] else "far"
        for scale_from in SCALES if shot.known["sheet"] else SCALES[:2]:
            route = f"{shot.known['view']} {where} {scale_from}"
            try:
                observations = seen(shot, find, scale_from, prior(shot.told())).observations
            except (ArmspanError, ValueError) as error:
                fails[route] += 1
                why.append(f"{shot.path.stem} by {scale_from}: {error}")
                continue
            for o in observations:
                column = columns.setdefault((route, o.measure), Column([], []))
                column.errors.append(o.value - true_measure(shot, o.measure, kind))
                column.claimed.append(o.sd)
    return dict(sorted(columns.items(), key=lambda item: (item[0][0], MEASURES.index(item[0][1])))), fails, why


def people(all_shots: Sequence[Shot]) -> Iterator[list[Shot]]:
    for person in sorted({shot.known["person"] for shot in all_shots}):
        yield [shot for shot in all_shots if shot.known["person"] == person]


def fused(all_shots: Sequence[Shot], find: Find, kind: str) -> tuple[dict[Any, Column], Counter[str]]:
    """Each person's pictures together with the prior, by several sets of pictures, as ``armspan body`` does it."""
    columns: dict[Any, Column] = {}
    rejected: Counter[str] = Counter()
    routes = {
        "prior alone": (),
        "front far, height": (("front", False, "height"),),
        "front near, height": (("front", True, "height"),),
        "both far, height": both(False, "height"),
        "both far, + lens": both(False, "height and lens"),
        "both near, height": both(True, "height"),
        "both near, + lens": both(True, "height and lens"),
        "both near, sheet": both(True, "sheet"),
    }
    for shots_of_one in people(all_shots):
        by_view = {(shot.known["view"], shot.known["sheet"]): shot for shot in shots_of_one}
        for route, wanted in routes.items():
            looks = [partial(seen, by_view[view, near], find, scale_from) for view, near, scale_from in wanted]
            try:
                result = measure(shots_of_one[0].told(), looks).fused
            except (ArmspanError, ValueError):
                rejected[f"{route}: a picture is refused"] += 1
                continue
            for r in result.rejected:
                rejected[f"{route}: {r.observation.measure}"] += 1
            body = result.body
            values = (body.eye_height_m, *body.shoulder_to_eye_m, body.shoulder_to_fingertip_m)
            sds = np.sqrt(np.diag(np.reshape(body.covariance, (5, 5))))
            for name, value, sd in zip(MEASURES, values, sds, strict=True):
                column = columns.setdefault((route, name), Column([], []))
                column.errors.append(value - true_measure(shots_of_one[0], name, kind))
                column.claimed.append(float(sd))
    return columns, rejected


def both(near: bool, scale_from: str) -> tuple[tuple[str, bool, str], ...]:
    return ("front", near, scale_from), ("side", near, scale_from)


def point_errors(all_shots: Sequence[Shot], find: Find) -> None:
    """Where the network puts points, seen from where they truly are [mm at the body], by view."""
    print("\npoints found less true [mm at the body: right in the picture, up]; of the shown side in side views")
    for view in ("front", "side"):
        offsets: dict[str, list[Any]] = {}
        for shot in all_shots:
            if shot.known["view"] != view:
                continue
            try:
                skeleton = find(shot)
            except (ArmspanError, ValueError):
                continue
            true = shot.known["pixels"]
            tall = np.hypot(*np.subtract(true["crown"], np.add(true["lheel"], true["rheel"]) / 2))
            size = 1e3 * (shot.truth["stature"] - 0.03) / tall
            mirror = 1.0 if shot.known["arm"] == "right" else -1.0
            for name, (x, y, _) in skeleton.points.items():
                own = name if name == "nose" else ("near " if name[0] == shot.known["arm"][0] else "far ") + name[1:]
                if name in true:
                    offsets.setdefault(own, []).append(
                        np.array([mirror * (x - true[name][0]), true[name][1] - y]) * size
                    )
        for name, found in sorted(offsets.items()):
            mean, sd = np.mean(found, axis=0), np.std(found, axis=0)
            where = f"right {mean[0]:+5.0f} +- {sd[0]:3.0f}   up {mean[1]:+5.0f} +- {sd[1]:3.0f}"
            print(f"{view:5s} {name:16s} n {len(found):3d}  {where}")


def failing(all_shots: Sequence[Shot], find: Find) -> None:
    """What is said of pictures that must be refused."""
    print("\npictures that must be refused")
    for shot in all_shots:
        name = shot.path.stem.removeprefix("fail_")
        try:
            skeleton = find(shot)
            expected = prior(Told(height_m=1.77, sex="man"))
            if name == "no_sheet":
                sheet_scale(shot, skeleton)
            scale = HeightScale.of(skeleton, expected, "front")
            values = ", ".join(
                f"{o.measure} {o.value:.3f}" for o in observe(skeleton, "front", scale, expected).observations
            )
            print(f"  {name}: MEASURED {values}")
        except (ArmspanError, ValueError) as error:
            print(f"  {name}: {error}")


def report(folder: Path, find: Find, name: str, kind: str) -> None:
    good = [shot for shot in shots(folder) if not shot.path.stem.startswith("fail")]
    columns, fails, why = single_views(good, find, kind)
    table(f"=== {name}: single pictures, truth from the {kind}", columns)
    print("refused:", dict(fails) or "none", *why[:12], sep="\n  ")
    columns, rejected = fused(good, find, kind)
    table(f"=== {name}: fused with the prior, truth from the {kind}", columns)
    print("rejected beyond 3 SD:", dict(rejected) or "none")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--weights", type=Path, default=weights_folder())
    parser.add_argument("--clothes", action="store_true", help="draw loose clothes, hair and shoes")
    parser.add_argument("--no-networks", action="store_true", help="only with the true points")
    parser.add_argument("--pivot", choices=("pivot", "joint", "sum"), default="pivot")
    asked = parser.parse_args()
    if not (asked.folder / "truth.json").exists():
        if importlib.util.find_spec("anny") is None:
            sys.exit(f"{asked.folder} holds no pictures, and drawing them needs anny: pip install anny==0.6.2")
        draw_all(asked.folder, asked.clothes)
    report(asked.folder, true_points, "true points", asked.pivot)
    if asked.no_networks:
        return
    if not any(asked.weights.glob("*.tflite")):
        sys.exit(f"{asked.weights} holds no networks: armspan body --set-up fetches them, or see --no-networks")
    find = found_by(asked.weights)
    every = shots(asked.folder)
    report(asked.folder, find, "BlazePose", asked.pivot)
    point_errors([shot for shot in every if not shot.path.stem.startswith("fail")], find)
    failing([shot for shot in every if shot.path.stem.startswith("fail")], find)


if __name__ == "__main__":
    main()
