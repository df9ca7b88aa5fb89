"""Pictures of rendered bodies on disk, what is true of them, and what a measurement sees in them."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from armspan.body.anthropometry import Prior
from armspan.body.scale import HeightScale
from armspan.body.skeleton import Skeleton
from armspan.body.told import Told
from armspan.body.views import Seen, observe

SCALES = ("height", "height and lens", "sheet")
SEEN = ("eye", "ear", "sh", "el", "wr", "hip", "kn", "an", "heel", "toe", "idxknuckle", "idxtip")
"""What BlazePose and its hand network find beside the nose; the true points are cut down to the same."""

Find: TypeAlias = Callable[["Shot"], Skeleton]


@dataclass(frozen=True)
class Shot:
    """A picture's file, and what is true of it."""

    path: Path
    known: Mapping[str, Any]

    @property
    def truth(self) -> dict[str, float]:
        """The measures [m] by name."""
        return dict(self.known["truth"])

    def pixels(self) -> Any:
        """The picture (h, w, 3), RGB."""
        import cv2

        return np.ascontiguousarray(cv2.imread(str(self.path))[..., ::-1])

    def told(self) -> Told:
        """What the person types: height, sex, soles, the arm and its own eye."""
        arm, sole = self.known["arm"], self.truth.get("sole", 0.0)
        return Told(height_m=self.truth["stature"], sex=self.known["sex"], arm=arm, eye=arm, sole_m=sole)


def draw_all(folder: Path, clothes: bool = False) -> None:
    """All pictures and ``truth.json``; about six minutes."""
    from scenes import PEOPLE, Scene, Studio, png

    folder.mkdir(parents=True, exist_ok=True)
    studio, known = Studio(clothes=clothes), {}

    def keep(scene: Scene) -> None:
        (folder / f"{scene.name}.png").write_bytes(png(scene.pixels))
        known[scene.name] = {
            "view": scene.view,
            "person": scene.person,
            "arm": scene.arm,
            "sheet": scene.sheet,
            "sex": PEOPLE[max(scene.person, 0)][0],
            "focal_px": scene.camera.focal,
            "truth": scene.truth,
            "pixels": {k: scene.camera.project(v)[0].round(3).tolist() for k, v in scene.landmarks.items()},
        }
        (folder / "truth.json").write_text(json.dumps(known, indent=0))

    for scene in studio.failing():
        keep(scene)
    for person in range(len(PEOPLE)):
        arm = "left" if person % 4 == 3 else "right"
        for near in (False, True):
            keep(studio.front(person, near, arm))
            keep(studio.side(person, near, arm))


def shots(folder: Path) -> list[Shot]:
    """All pictures of a folder, the same person's beside each other."""
    known = json.loads((folder / "truth.json").read_text())
    return [Shot(folder / f"{name}.png", about) for name, about in sorted(known.items())]


def true_points(shot: Shot) -> Skeleton:
    """What a network without any error would find."""
    points = {name: (*xy, 1.0) for name, xy in shot.known["pixels"].items() if name == "nose" or name[1:] in SEEN}
    return Skeleton(points, (1280, 960), "true points")


def found_by(weights: Path) -> Find:
    """BlazePose, each picture once."""
    from armspan.body.picture.pose import find_people

    known: dict[Path, list[Skeleton]] = {}

    def find(shot: Shot) -> Skeleton:
        if shot.path not in known:
            known[shot.path] = find_people(shot.pixels(), weights)
        people = known[shot.path]
        if len(people) != 1:
            raise ValueError(f"{len(people)} people are seen")
        return people[0]

    return find


def seen(shot: Shot, find: Find, scale_from: str, expected: Prior) -> Seen:
    """What one picture tells."""
    skeleton, view = find(shot), shot.known["view"]
    if scale_from == "sheet":
        return observe(skeleton, view, sheet_scale(shot, skeleton), expected)
    focal = shot.known["focal_px"] if "lens" in scale_from else None
    return observe(skeleton, view, HeightScale.of(skeleton, expected, view, focal_px=focal), expected)


def sheet_scale(shot: Shot, skeleton: Skeleton) -> Any:
    """The scale of the sheet on the floor, the focal length known as from EXIF."""
    from armspan.body.picture.marker import find_marker, marker_scale

    pixels = shot.pixels()
    marker = find_marker(pixels, shot.path.name)
    return marker_scale(
        marker, skeleton, (pixels.shape[1], pixels.shape[0]), shot.known["focal_px"], sole=shot.truth.get("sole", 0.0)
    )
