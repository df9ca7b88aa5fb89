"""Takes as they lie in a folder: listed, deleted, trimmed, relabelled; what is taken away is kept in ``.deleted``."""

import csv
import io
import re
import shutil
from decimal import Decimal
from pathlib import Path

import msgspec

from armspan.config.take_files import TIME, Sidecar, next_number, read_columns, read_sidecar, read_take, write_whole
from armspan.errors import ConfigError, DataError
from armspan.gesture.channels import prefix_of
from armspan.gesture.takes import NULL

DELETED = ".deleted"
"""The folder beside the labels' folders that keeps what was deleted or trimmed."""

FEWEST = 8
"""Samples that a take needs at least."""


class ListedTake(msgspec.Struct, frozen=True, kw_only=True):
    """A take as it is listed: ``gesture_s`` on the take's own clock, ``bands`` by the prefix of their columns."""

    path: str
    label: str
    person: str
    number: int
    seconds: float
    rate_hz: float | None
    practice: bool
    gesture_s: tuple[float, float] | None
    bands: tuple[str, ...]
    simulated: bool
    note: str


def list_takes(folder: Path) -> list[ListedTake]:
    """All takes of a folder by label, person and number (DataError: no folder, or a take that cannot be read)."""
    if not folder.is_dir():
        raise DataError(f"{folder} is not a folder: takes lie in DIR/LABEL/PERSON_NN.csv; `armspan record` makes some")
    paths = (path for path in folder.glob("*/*.csv") if not path.name.startswith("."))
    return sorted(map(listed, paths), key=lambda take: (take.label, take.person, take.number, take.path))


def listed(path: Path) -> ListedTake:
    """What a list says of one take (DataError)."""
    take, side = read_take(path), read_sidecar(path)
    return ListedTake(
        path=str(path),
        label=take.label,
        person=take.person,
        number=take.number,
        seconds=round(take.seconds, 3),
        rate_hz=round(take.rate, 2) if len(take.times) > 1 else None,
        practice=take.practice,
        gesture_s=take.gesture,
        bands=tuple(dict.fromkeys(map(prefix_of, take.columns))),
        simulated=side.simulated if side else False,
        note=side.note if side else "",
    )


def checked_label(label: str, folder: Path) -> str:
    """A label that can be a folder's name in ``folder`` (ConfigError)."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", label):
        raise ConfigError(
            f"label {label!r} cannot be a folder's name: use letters, digits, _ and -, as in arms_to_ground"
        )
    names = [path.name for path in folder.iterdir() if path.is_dir()] if folder.is_dir() else []
    for name in names:
        if name != label and name.lower() == label.lower():
            raise ConfigError(f"label {label!r} differs by case only from {name!r} in {folder}: use {name!r}")
    return label


def delete_take(path: Path) -> Path:
    """Move a take and its sidecar to ``DIR/.deleted``; returns its new place (DataError)."""
    if not path.stem.rpartition("_")[2].isdecimal():
        raise DataError(f"{path} is not named as a take is, DIR/LABEL/PERSON_NN.csv: it is left where it is")
    target = _kept(checked_take(path))
    target.parent.mkdir(parents=True, exist_ok=True)
    sidecar = path.with_suffix(".json")
    if sidecar.exists():
        sidecar.rename(target.with_suffix(".json"))
    path.rename(target)
    _remove_if_empty(path.parent)
    return target


def trim_take(path: Path, start: float, end: float) -> ListedTake:
    """Keep a take's rows from ``start`` to ``end`` [s] and let its clock begin at 0; the whole one is kept.

    Raises:
        DataError: the take cannot be read, or nothing would remain of it.

    """
    _, times, _ = read_columns(checked_take(path))
    kept = (times >= start) & (times <= end)
    if not start < end or int(kept.sum()) < FEWEST:
        raise DataError(
            f"{path} lasts from {times[0]:g} to {times[-1]:g} s, and from {start:g} to {end:g} s there are "
            f"{int(kept.sum())} samples; a take needs {FEWEST}: trim less"
        )
    side, first = read_sidecar(path), float(times[kept][0])
    table = _rows_between(path, start, end)
    _keep_copy(path)
    if side is not None:
        span = _shifted(side.gesture_s, first, float(times[kept][-1]))
        write_sidecar(path, msgspec.structs.replace(side, gesture_s=span))
    write_whole(path, table)
    return listed(path)


def relabel_take(path: Path, label: str) -> Path:
    """Give a take and its sidecar another label and the next free number there; returns its new place.

    Raises:
        ConfigError: the label cannot be a folder's name.
        DataError: there is no such take, or it has that label already.

    """
    folder = checked_take(path).parent.parent
    if checked_label(label, folder) == path.parent.name:
        raise DataError(f"{path} is labelled {label!r} already")
    side = read_sidecar(path)
    person, _, number = path.stem.rpartition("_")
    person = person if number.isdecimal() else path.stem
    number_there = next_number(folder, label, person)
    target = folder / label / f"{person}_{number_there:02d}.csv"
    target.parent.mkdir(exist_ok=True)
    if side is not None:
        span = None if label == NULL else side.gesture_s
        write_sidecar(target, msgspec.structs.replace(side, label=label, number=number_there, gesture_s=span))
    path.rename(target)
    path.with_suffix(".json").unlink(missing_ok=True)
    _remove_if_empty(path.parent)
    return target


def write_sidecar(path: Path, side: Sidecar) -> None:
    """Write the sidecar of the take at ``path``, in place of an old one."""
    write_whole(path.with_suffix(".json"), msgspec.json.format(msgspec.json.encode(side)) + b"\n")


def checked_take(path: Path) -> Path:
    """The path of a take that is there (DataError)."""
    if not path.is_file():
        raise DataError(f"{path} does not exist: `armspan takes list DIR` shows what there is")
    if path.suffix != ".csv":
        raise DataError(f"{path} is not a take: name its table, DIR/LABEL/PERSON_NN.csv")
    return path


def _kept(path: Path) -> Path:
    """A free place for a take in ``.deleted``."""
    home = path.parent.parent / DELETED / path.parent.name
    names = (home / f"{path.stem}{more}.csv" for more in ("", *(f"_{k}" for k in range(2, 1000))))
    return next(name for name in names if not name.exists() and not name.with_suffix(".json").exists())


def _keep_copy(path: Path) -> None:
    target = _kept(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    for suffix in (".csv", ".json"):
        if path.with_suffix(suffix).exists():
            shutil.copyfile(path.with_suffix(suffix), target.with_suffix(suffix))


def _rows_between(path: Path, start: float, end: float) -> bytes:
    """A table's rows from ``start`` to ``end`` [s], digit for digit but for the time, which begins at 0."""
    header, *rows = [row for row in csv.reader(io.StringIO(path.read_text(encoding="utf-8-sig"))) if row]
    at = [name.strip() for name in header].index(TIME)
    kept = [row for row in rows if start <= float(row[at]) <= end]
    first = Decimal(kept[0][at].strip())
    moved = [[*row[:at], format(Decimal(row[at].strip()) - first, "f"), *row[at + 1 :]] for row in kept]
    table = io.StringIO()
    csv.writer(table, lineterminator="\n").writerows([header, *moved])
    return table.getvalue().encode()


def _shifted(span: tuple[float, float] | None, first: float, last: float) -> tuple[float, float] | None:
    """What is left of a gesture between two times, on a clock that begins at the first; None where nothing is."""
    if span is None or span[1] <= first or span[0] >= last:
        return None
    return round(max(span[0], first) - first, 4), round(min(span[1], last) - first, 4)


def _remove_if_empty(folder: Path) -> None:
    if not any(folder.iterdir()):
        folder.rmdir()
