"""Takes as files: ``DIR/LABEL/PERSON_NN.csv`` with a JSON sidecar beside it."""

import csv
import io
import os
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from armspan.errors import DataError
from armspan.frames import Array
from armspan.gesture.takes import Take

TIME = "t_s"
_BANDS = ("right", "left")
COLUMNS = tuple(
    f"{band}_{kind}{axis}"
    for band in _BANDS
    for kind, axes in (("q", "xyzw"), ("a", "xyz"), ("g", "xyz"))
    for axis in axes
)
"""The columns of a take of two bands, in their order, without the time."""


class Sidecar(msgspec.Struct, kw_only=True):
    """What a take's CSV cannot say; ``gesture_s`` are start and end of the gesture on the take's clock."""

    label: str
    person: str
    number: int
    practice: bool = False
    rate_hz: float | None = None
    gesture_s: tuple[float, float] | None = None
    simulated: bool = False
    recorded: str | None = None
    note: str = ""


def read_takes(folder: Path, *, bands: str | None = None) -> list[Take]:
    """All takes of a folder, in order of their names; of one band where ``bands`` names its prefix.

    Raises:
        DataError: the folder holds none, or a file cannot be read as a take.

    """
    if not folder.is_dir():
        raise DataError(f"{folder} is not a folder: takes lie in DIR/LABEL/PERSON_NN.csv")
    loose = sorted(folder.glob("*.csv"))
    paths = sorted(path for path in folder.glob("*/*.csv") if not path.name.startswith("."))
    if not paths:
        hint = f"; {loose[0].name} lies beside such folders, not in one" if loose else ""
        raise DataError(
            f"{folder} holds no takes: they lie in DIR/LABEL/PERSON_NN.csv{hint}; record some with `armspan record`"
        )
    takes = [read_take(path) for path in paths]
    return [of_band(take, bands) for take in takes] if bands else takes


def of_band(take: Take, band: str) -> Take:
    """A take with the columns of one band only (DataError where it has none)."""
    columns = [name for name in take.columns if name.startswith(f"{band}_")]
    if not columns:
        raise DataError(f"{take.name} has no column of the band {band!r}; it has {', '.join(take.columns[:6])}...")
    return take.picked(columns)


def read_take(path: Path) -> Take:
    """One take; label, person and number come from its name, more from its sidecar where there is one (DataError)."""
    columns, times, values = read_columns(path)
    person, _, number = path.stem.rpartition("_")
    if not number.isdecimal():
        person, number = path.stem, "0"
    side = read_sidecar(path)
    return Take(
        path.parent.name,
        person,
        int(number),
        columns,
        times,
        values,
        side.practice if side else False,
        side.gesture_s if side else None,
        str(path),
    )


def read_sidecar(path: Path) -> Sidecar | None:
    """The sidecar of a take's CSV, None where there is none (DataError)."""
    sidecar = path.with_suffix(".json")
    if not sidecar.exists():
        return None
    try:
        return msgspec.json.decode(sidecar.read_bytes(), type=Sidecar)
    except (OSError, msgspec.DecodeError) as error:
        raise DataError(f"{sidecar} is not a take's sidecar ({error}): mend or delete it") from None


def read_columns(path: Path) -> tuple[tuple[str, ...], Array, Array]:
    """A table of numbers with a first line of names: columns, times (n,) [s], values (n, c) with NaN for empty cells.

    Raises:
        DataError: the file, its line and what was expected.

    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not text"
        raise DataError(f"{path} cannot be read ({reason}): expected a CSV of a take or a stream") from None
    rows = csv.reader(io.StringIO(text))
    columns = tuple(name.strip() for name in next(rows, []))
    _check_header(path, columns)
    table = _numbers(path, rows, len(columns))
    if len(table) == 0:
        raise DataError(f"{path} holds the names of its columns and no rows: record it again, or delete it")
    at = columns.index(TIME)
    missing = np.flatnonzero(~np.isfinite(table[:, at]))
    if len(missing):
        raise DataError(f"{path}, line {missing[0] + 2}: {TIME} is missing; every row needs its time")
    return columns[:at] + columns[at + 1 :], table[:, at], np.delete(table, at, axis=1)


def _check_header(path: Path, columns: tuple[str, ...]) -> None:
    if TIME not in columns:
        raise DataError(
            f"{path}, line 1: no column {TIME} in {','.join(columns)[:80]!r}; expected {TIME},"
            f"{','.join(COLUMNS[:3])},... or other channels, separated by commas"
        )
    if len(columns) < 2 or "" in columns:
        raise DataError(f"{path}, line 1: expected {TIME} and one named column or more, separated by commas")
    if twice := [name for k, name in enumerate(columns) if name in columns[:k]]:
        raise DataError(f"{path}, line 1: column {twice[0]!r} is there twice: keep one of the two")


def _numbers(path: Path, rows: Any, width: int) -> Array:
    table: list[list[float]] = []
    for row in rows:
        if not row:
            continue
        if len(row) != width:
            raise DataError(f"{path}, line {rows.line_num}: {len(row)} fields, but line 1 names {width} columns")
        try:
            table.append([float(cell) if cell.strip() else np.nan for cell in row])
        except ValueError:
            wrong = next(cell for cell in row if not _is_number(cell))
            raise DataError(f"{path}, line {rows.line_num}: {wrong!r} is not a number; leave a gap empty") from None
    values = np.array(table, dtype=float).reshape(-1, width)
    values[~np.isfinite(values)] = np.nan
    return values


def _is_number(cell: str) -> bool:
    try:
        float(cell or "0")
    except ValueError:
        return False
    return True


def sidecar_of(take: Take, *, simulated: bool = False, recorded: str | None = None, note: str = "") -> Sidecar:
    """The sidecar of a take, with what is known of its recording."""
    return Sidecar(
        label=take.label,
        person=take.person,
        number=take.number,
        practice=take.practice,
        rate_hz=round(take.rate, 2),
        gesture_s=take.gesture,
        simulated=simulated,
        recorded=recorded,
        note=note,
    )


def write_take(folder: Path, take: Take, sidecar: Sidecar | None = None) -> Path:
    """Write a take and its sidecar, each whole or not at all; returns the CSV's path (DataError where it exists)."""
    path = folder / take.label / f"{take.person}_{take.number:02d}.csv"
    if path.exists():
        raise DataError(f"{path} exists: takes are never replaced; delete it first, or take the next number")
    path.parent.mkdir(parents=True, exist_ok=True)
    side = sidecar or sidecar_of(take)
    write_whole(path.with_suffix(".json"), msgspec.json.format(msgspec.json.encode(side)) + b"\n")
    write_whole(path, _table(take))
    return path


def _table(take: Take) -> bytes:
    lines = [",".join((TIME, *take.columns))]
    for t, row in zip(take.times.tolist(), take.values.tolist(), strict=True):
        lines.append(",".join((f"{t:.4f}", *("" if value != value else f"{value:.6g}" for value in row))))
    return ("\n".join(lines) + "\n").encode()


def write_whole(path: Path, data: bytes) -> None:
    """Write a file so that it is either whole or not there, and an old one is replaced only by a whole new one."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(data)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def next_number(folder: Path, label: str, person: str) -> int:
    """The number of a person's next take of a gesture."""
    stems = [path.stem.rpartition("_") for path in (folder / label).glob(f"{person}_*.csv")]
    return 1 + max((int(number) for who, _, number in stems if who == person and number.isdecimal()), default=0)
