"""A person seen from the front or the side: a picture or a skeleton file, read and measured."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeAlias

import msgspec

from armspan.body.anthropometry import Prior
from armspan.body.picture.image import Picture, png, read_image
from armspan.body.picture.marker import Marker, find_marker, marker_scale
from armspan.body.picture.overlay import overlay
from armspan.body.picture.pose import find_people
from armspan.body.scale import HeightScale, Scale
from armspan.body.skeleton import Skeleton
from armspan.body.skeleton_formats import read_skeletons, skeleton_document
from armspan.body.views import Seen, observe
from armspan.errors import ConfigError, DataError
from armspan.records import Arm

Side: TypeAlias = Literal["front", "side"]
Backend: TypeAlias = Callable[[Path, bytes], object]
"""Finds people in a file's picture, which it gets as an upright PNG: the decoded JSON of a format that
`read_skeletons` knows."""


_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""What editors on Windows write before a JSON file."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """How views are to be read: the picture's ``size`` [px] for normalised files, and which ``person``, from 1."""

    weights: Path
    size: tuple[int, int] | None = None
    person: int | None = None
    marker: bool = False
    backend: Backend | None = None


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One person in one view; a skeleton file has no ``picture``."""

    path: Path
    side: Side
    skeleton: Skeleton
    picture: Picture | None = None
    marker: Marker | None = None

    def measured(self, prior: Prior) -> Seen:
        """What the view tells of the five measures, scaled by the marker if there is one, else by the height.

        Raises:
            DataError: if the person does not stand as the view asks.

        """
        try:
            return observe(self.skeleton, self.side, self._scale(prior), prior)
        except DataError as error:
            raise DataError(f"{self.path}: {error}") from None

    def _scale(self, prior: Prior) -> Scale:
        focal = None if self.picture is None else self.picture.focal_px
        if self.marker is None or self.picture is None:
            return HeightScale.of(self.skeleton, prior, self.side, focal_px=focal)
        height, width = self.picture.pixels.shape[:2]
        return marker_scale(self.marker, self.skeleton, (width, height), focal, sole=prior.told.sole_m)

    def keep(self, folder: Path, seen: Seen, arm: Arm) -> list[Path]:
        """Write the points as a skeleton file, which may be edited and read again, and drawn into the picture.

        Raises:
            ConfigError: if the folder cannot be written.

        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
            return self._keep(folder, seen, arm)
        except OSError as error:
            raise ConfigError(
                f"{error.filename or folder} cannot be written ({error.strerror}): name another folder with --keep"
            ) from None

    def _keep(self, folder: Path, seen: Seen, arm: Arm) -> list[Path]:
        points = folder / f"{self.side}.json"
        points.write_bytes(msgspec.json.format(msgspec.json.encode(skeleton_document(self.skeleton))) + b"\n")
        if self.picture is None:
            return [points]
        drawn = folder / f"{self.side}.png"
        drawn.write_bytes(overlay(self.picture.pixels, self.skeleton, marker=self.marker, notes=seen.notes, arm=arm))
        return [points, drawn]


def check_free(folder: Path, sides: Iterable[str]) -> None:
    """See that keeping the points of these sides replaces nothing.

    Raises:
        ConfigError: if a file of theirs is already there.

    """
    for path in (folder / f"{side}{ending}" for side in sides for ending in (".json", ".png")):
        if path.exists():
            raise ConfigError(f"{path} exists and is kept: name another folder with --keep")
    if folder.exists() and not folder.is_dir():
        raise ConfigError(f"{folder} is a file, not a folder: name a folder with --keep")


def read_view(path: Path, side: Side, wanted: Wanted) -> View:
    """One person in a picture or a skeleton file.

    Raises:
        ConfigError: if a marker is asked of a skeleton file, or the person's number does not exist.
        DataError: if the file is neither, or nobody or several people are in it.

    """
    data = _bytes(path).removeprefix(_BYTE_ORDER_MARK)
    if data.lstrip()[:1] in (b"{", b"["):
        if wanted.marker:
            raise ConfigError(f"{path} is a skeleton file, in which no marker can be seen: leave --marker out")
        return View(path, side, _one(_skeletons(data, path, wanted.size), path, wanted.person))
    picture = read_image(data, str(path))
    people = _people(path, picture, wanted)
    marker = find_marker(picture.pixels, str(path)) if wanted.marker else None
    return View(path, side, _one(people, path, wanted.person), picture, marker)


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise DataError(f"{path} does not exist: name a picture, or a skeleton file in JSON") from None
    except OSError as error:
        raise DataError(
            f"{path} cannot be read ({error.strerror}): name a picture, or a skeleton file in JSON"
        ) from None


def _skeletons(data: bytes, path: Path, size: tuple[int, int] | None) -> list[Skeleton]:
    try:
        document = msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise DataError(f"{path} begins like JSON but is none ({error}): save the skeleton file again") from None
    return read_skeletons(document, str(path), size=size)


def _people(path: Path, picture: Picture, wanted: Wanted) -> list[Skeleton]:
    if wanted.backend is None:
        return find_people(picture.pixels, wanted.weights)
    height, width = picture.pixels.shape[:2]
    answer = wanted.backend(path, png(picture.pixels))
    return read_skeletons(answer, f"openpifpaf's answer to {path}", size=(width, height))


def _one(people: list[Skeleton], path: Path, person: int | None) -> Skeleton:
    """The person asked for, numbered from left to right."""
    if not people:
        raise DataError(
            f"{path} shows nobody who can be made out: stand wholly in the picture, before a plain wall, in good light"
        )
    ordered = sorted(people, key=_middle)
    if person is None and len(ordered) > 1:
        raise DataError(
            f"{path} shows {len(ordered)} people: choose one with --person, from 1 on the left to {len(ordered)}, or "
            "take a picture of one alone"
        )
    number = 1 if person is None else person
    if not 1 <= number <= len(ordered):
        raise ConfigError(f"--person {number} does not exist: {path} shows {len(ordered)}, numbered from the left")
    return replace(ordered[number - 1], source=path.name)


def _middle(skeleton: Skeleton) -> float:
    return sum(x for x, _, _ in skeleton.points.values()) / max(1, len(skeleton.points))
