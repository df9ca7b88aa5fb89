"""Changing takes: nothing is ever lost, and nothing that exists is ever replaced."""

import os
import re
from pathlib import Path

import msgspec
import numpy as np

from armspan.config.take_files import Sidecar, next_number, read_sidecar, read_take, write_take, write_whole
from armspan.errors import DataError
from armspan.gesture.takes import Take

DELETED = ".deleted"
_NAME = re.compile(r"[A-Za-z0-9_-]+")
_LEAST = 0.1


def check_label(label: str) -> str:
    """A label that can be a folder's name (DataError)."""
    if not _NAME.fullmatch(label) or label.startswith("-"):
        raise DataError(f"label {label!r} cannot name a folder: use letters, digits, _ and -, such as wave_left")
    return label


def check_person(person: str) -> str:
    """A person's code that can begin a file's name (DataError)."""
    if not _NAME.fullmatch(person) or person.startswith("-"):
        raise DataError(f"person code {person!r} cannot name a file: use letters, digits, _ and -, such as p01")
    return person


def check_folder(folder: Path, labels: list[str]) -> None:
    """Refuse a folder that is a file, and labels that differ by case only from each other or from those there."""
    if folder.exists() and not folder.is_dir():
        raise DataError(f"{folder} is a file: name the folder in which takes are to be kept")
    there = [path.name for path in folder.iterdir() if path.is_dir()] if folder.is_dir() else []
    by_lower = {name.lower(): name for name in there}
    for label in labels:
        other = by_lower.setdefault(label.lower(), label)
        if other != label:
            raise DataError(f"labels {label!r} and {other!r} differ by case only: use {other!r}, or another name")


def sidecar_of(path: Path, take: Take) -> Sidecar:
    """A take's sidecar, or what it would say where there is none."""
    return read_sidecar(path) or Sidecar(
        label=take.label,
        person=take.person,
        number=take.number,
        practice=take.practice,
        rate_hz=round(take.rate, 2) if len(take.times) > 1 else None,
        gesture_s=take.gesture,
    )


def delete_take(path: Path) -> Path:
    """Move a take and its sidecar to DIR/.deleted/LABEL; returns where it lies now (DataError)."""
    _check_take_file(path)
    kept = path.parent.parent / DELETED / path.parent.name
    kept.mkdir(parents=True, exist_ok=True)
    target = _free(kept / path.name)
    _move(path, target)
    return target


def trim_take(path: Path, start: float, end: float) -> Take:
    """Keep ``start`` to ``end`` [s] of a take, with its time from 0; the whole one is kept in DIR/.deleted.

    Raises:
        DataError: nothing to speak of would remain, or times that are not in the take.

    """
    _check_take_file(path)
    take = read_take(path)
    side = sidecar_of(path, take)
    if not (np.isfinite(start) and np.isfinite(end)) or end - start < _LEAST:
        raise DataError(f"from {start:g} to {end:g} s: expected an end that is {_LEAST:g} s or more after the start")
    if end <= take.times[0] or start >= take.times[-1]:
        raise DataError(f"{path} lasts from {take.times[0]:g} to {take.times[-1]:g} s: nothing of it lies in between")
    part = take.between(start - 1e-9, end + 1e-9)
    if len(part.times) < 2:
        raise DataError(f"{path} has {len(part.times)} samples from {start:g} to {end:g} s: expected two or more")
    gesture = _moved(take.gesture, float(part.times[0]), float(part.times[-1]))
    trimmed = msgspec.structs.replace(side, gesture_s=gesture)
    kept = Take(
        take.label, take.person, take.number, take.columns, part.times - part.times[0], part.values, take.practice, gesture
    )
    delete_take(path)
    _write_as(path, kept, trimmed)
    return kept


def _moved(gesture: tuple[float, float] | None, first: float, last: float) -> tuple[float, float] | None:
    """A gesture's span on the clock of the part from ``first`` to ``last`` [s]; None where it lies outside."""
    if gesture is None:
        return None
    start, end = max(gesture[0], first) - first, min(gesture[1], last) - first
    return (round(start, 4), round(end, 4)) if end > start else None


def relabel_take(path: Path, label: str) -> Path:
    """Give a take another label, under the next number that is free there; returns its new place (DataError)."""
    _check_take_file(path)
    folder = path.parent.parent
    check_label(label)
    check_folder(folder, [label])
    if label == path.parent.name:
        raise DataError(f"{path} has the label {label!r} already: name another one")
    take = read_take(path)
    number = next_number(folder, label, take.person)
    side = msgspec.structs.replace(sidecar_of(path, take), label=label, number=number)
    target = folder / label / f"{take.person}_{number:02d}.csv"
    target.parent.mkdir(exist_ok=True)
    _write_sidecar(target, side)
    os.rename(path, target)
    path.with_suffix(".json").unlink(missing_ok=True)
    return target


def _check_take_file(path: Path) -> None:
    if not path.is_file() or path.suffix != ".csv":
        raise DataError(f"{path} is no take: expected DIR/LABEL/PERSON_NN.csv; `armspan takes list DIR` names them")


def _free(path: Path) -> Path:
    """A name that is not taken: the path's own, or with a number behind it."""
    names = (path.with_name(f"{path.stem}{more}{path.suffix}") for more in ("", *(f"-{k}" for k in range(2, 10_000))))
    return next(name for name in names if not name.exists() and not name.with_suffix(".json").exists())


def _move(path: Path, target: Path) -> None:
    sidecar = path.with_suffix(".json")
    if sidecar.exists():
        os.rename(sidecar, target.with_suffix(".json"))
    os.rename(path, target)


def _write_sidecar(path: Path, side: Sidecar) -> None:
    write_whole(path.with_suffix(".json"), msgspec.json.format(msgspec.json.encode(side)) + b"\n")
