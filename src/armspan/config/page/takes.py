"""The folder of takes as the page lists it: quickly, since a session runs in the same process."""

import csv
import datetime
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from armspan.config.take_edits import delete_take
from armspan.config.take_files import TIME, Sidecar, read_sidecar, read_take
from armspan.errors import DataError
from armspan.frames import Array
from armspan.web.views.gestures_host import Curves, TakeRow

POINTS = 300
"""Points of a curve at most."""

_TAIL = 4096


class TakeFolder:
    """The takes in ``folder``, which need not be there yet."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @property
    def stamp(self) -> int:
        """Another number whenever a take was added or taken away."""
        return hash(tuple(_changed(path) for path in (self.folder, *self._labels())))

    def rows(self) -> list[TakeRow]:
        """All takes by label, person and number; only their sidecars and ends are read."""
        rows = [_row(path) for label in self._labels() for path in label.glob("*.csv") if path.name[0] != "."]
        return sorted(rows, key=lambda row: (row.label, row.person, row.number, row.key))

    def curves(self, key: str) -> Curves:
        """A take's signals (DataError)."""
        take = read_take(self._path(key))
        kept = np.linspace(0, len(take.times) - 1, min(POINTS, len(take.times))).round().astype(int)
        columns = {name: _plain(take.values[kept, k]) for k, name in enumerate(take.columns)}
        return Curves([round(t, 3) for t in take.times[kept].tolist()], columns, take.gesture)

    def delete(self, key: str) -> Path:
        """Move a take aside, into ``.deleted``; returns its new place (DataError)."""
        return delete_take(self._path(key))

    def _labels(self) -> Iterator[Path]:
        if self.folder.is_dir():
            yield from sorted(path for path in self.folder.iterdir() if path.is_dir() and path.name[0] != ".")

    def _path(self, key: str) -> Path:
        """A take's path; nothing outside of the folder has one (DataError)."""
        if not re.fullmatch(r"[^./\\][^/\\]*/[^./\\][^/\\]*\.csv", key):
            raise DataError(f"{key!r} is no take of this folder: choose one of the list")
        return self.folder / key


def _row(path: Path) -> TakeRow:
    person, _, number = path.stem.rpartition("_")
    if not number.isdecimal():
        person, number = path.stem, "0"
    side, note, seconds = None, "", None
    try:
        side = read_sidecar(path)
        seconds = _seconds(path)
    except (DataError, OSError, ValueError) as error:
        note = f"cannot be read ({error})"
    side = side or Sidecar(label=path.parent.name, person=person, number=int(number))
    return TakeRow(
        f"{path.parent.name}/{path.name}",
        path.parent.name,
        person,
        int(number),
        side.recorded or f"{datetime.date.fromtimestamp(_changed(path) / 1e9)}",
        seconds,
        side.practice,
        side.simulated,
        side.note or note,
    )


def _seconds(path: Path) -> float:
    """How long a take is, from its first and its last line (ValueError: these are no lines of a take)."""
    with path.open("rb") as file:
        header, first = (next(csv.reader([file.readline().decode("utf-8-sig")]), []) for _ in range(2))
        file.seek(max(0, path.stat().st_size - _TAIL))
        last = next(csv.reader(file.read().decode().splitlines()[-1:]), [])
    at = [name.strip() for name in header].index(TIME)
    if not len(first) == len(last) == len(header):
        raise ValueError("it has no whole rows")
    return round(float(last[at]) - float(first[at]), 2)


def _changed(path: Path) -> int:
    """When a file or folder changed last [ns], 0 where it is not there."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def _plain(column: Array) -> list[float | None]:
    return [None if value != value else round(value, 3) for value in column.tolist()]
