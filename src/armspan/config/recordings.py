"""Recordings as CSV: PAIRS.csv (an arm and the point it points at) and RAYS.csv (an arm and a plane).

Every complaint names the file, the line, the field, its value and what would be right.
"""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armspan.errors import DataError
from armspan.frames import Array

UNIT_TOLERANCE = 0.02
"""How far a quaternion's length may be from 1: three decimals lose 0.001, a wrong column much more."""

_FOREARM = ("forearm_qw", "forearm_qx", "forearm_qy", "forearm_qz")
_UPPERARM = ("upperarm_qw", "upperarm_qx", "upperarm_qy", "upperarm_qz")
_POINT = ("x_m", "y_m", "z_m")


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """A recorded arm: ``times`` (n,) [s], unit quaternions (n, 4) ``user_from_wrist``, w first.

    ``upperarm`` is None with one band; ``points`` (n, 3) [m] are those pointed at (for rays: NaN, NaN and the
    plane's height); ``stops`` names each row's stop, None for moving data.
    """

    times: Array
    forearm: Array
    upperarm: Array | None
    points: Array
    stops: tuple[str, ...] | None


@dataclass(frozen=True, slots=True)
class _Table:
    path: Path
    columns: tuple[str, ...]
    rows: list[tuple[int, list[str]]]

    def numbers(self, names: tuple[str, ...]) -> Array:
        places = [self.columns.index(name) for name in names]
        return np.array(
            [
                [self._number(line, name, row[place]) for name, place in zip(names, places, strict=True)]
                for line, row in self.rows
            ]
        )

    def texts(self, name: str) -> tuple[str, ...]:
        place = self.columns.index(name)
        for line, row in self.rows:
            if not row[place]:
                raise DataError(
                    f"{self.path}, line {line}: {name} is empty, but every row belongs to a stop: write its number"
                )
        return tuple(row[place] for _, row in self.rows)

    def _number(self, line: int, name: str, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise DataError(
                f"{self.path}, line {line}: {name} is {text!r}, but a finite number is expected: mend the value or "
                "leave the row out"
            )
        return value


def read_pairs(path: Path) -> Recording:
    """The pairs of a calibration: columns ``t_s[,stop],forearm_q*[,upperarm_q*],x_m,y_m,z_m``.

    Raises:
        DataError: if the file does not hold exactly that, in finite numbers, unit quaternions and rising times.

    """
    table = _read(path, ("t_s", *_FOREARM, *_POINT), ("stop", *_UPPERARM))
    points = table.numbers(_POINT)
    return _recording(table, points, table.texts("stop") if "stop" in table.columns else None)


def read_rays(path: Path) -> Recording:
    """Arms to predict for: columns ``t_s,forearm_q*[,upperarm_q*],z_m``.

    Raises:
        DataError: as `read_pairs`.

    """
    table = _read(path, ("t_s", *_FOREARM, "z_m"), _UPPERARM)
    heights = table.numbers(("z_m",))
    points = np.concatenate([np.full((len(heights), 2), np.nan), heights], axis=1)
    return _recording(table, points, None)


def _recording(table: _Table, points: Array, stops: tuple[str, ...] | None) -> Recording:
    times = table.numbers(("t_s",))[:, 0]
    _check_rising(table, times)
    forearm = _quaternions(table, _FOREARM)
    upperarm = _quaternions(table, _UPPERARM) if _UPPERARM[0] in table.columns else None
    return Recording(times, forearm, upperarm, points, stops)


def _read(path: Path, required: tuple[str, ...], optional: tuple[str, ...]) -> _Table:
    lines = _lines(path)
    if not lines:
        raise DataError(f"{path} is empty: its first line names the columns {','.join(required)}")
    columns = tuple(name.strip() for name in lines[0][1])
    if len(columns) == 1 and (";" in columns[0] or "\t" in columns[0]):
        raise DataError(f"{path}, line 1: the columns are not separated by commas: save the table with commas")
    _check_columns(path, columns, required, optional)
    rows = [(line, [text.strip() for text in row]) for line, row in lines[1:]]
    if not rows:
        raise DataError(f"{path} holds the names of its columns and no rows: record some, one a line")
    for line, row in rows:
        if len(row) != len(columns):
            raise DataError(
                f"{path}, line {line}: {len(row)} fields, but the first line names {len(columns)} columns: "
                "mend the row or leave it out"
            )
    return _Table(path, columns, rows)


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            return [(reader.line_num, row) for row in reader if any(text.strip() for text in row)]
    except FileNotFoundError:
        raise DataError(f"{path} does not exist: name a CSV file of recorded arms") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path} cannot be read as CSV text: {error}") from None


def _check_columns(path: Path, columns: tuple[str, ...], required: tuple[str, ...], optional: tuple[str, ...]) -> None:
    """Refuse missing, unknown and doubled columns, and half an upper arm."""
    expected = ",".join(_in_order(required, optional))
    if any(name in columns for name in _UPPERARM):
        required = (*required, *_UPPERARM)
    if missing := [name for name in required if name not in columns]:
        raise DataError(f"{path}, line 1: {_columns(missing)} missing from {','.join(columns)!r}; expected: {expected}")
    if extra := [name for name in columns if name not in (*required, *optional)]:
        raise DataError(f"{path}, line 1: {_columns(extra)} unknown: leave out what is not among {expected}")
    if doubled := [name for i, name in enumerate(columns) if name in columns[:i]]:
        raise DataError(f"{path}, line 1: {_columns(doubled)} there twice: keep one of the two")


def _columns(names: list[str]) -> str:
    listed = ", ".join(repr(name) for name in names)
    return f"column {listed} is" if len(names) == 1 else f"columns {listed} are"


def _in_order(required: tuple[str, ...], optional: tuple[str, ...]) -> list[str]:
    order = ("t_s", "stop", *_FOREARM, *_UPPERARM, *_POINT)
    return [name if name in required else f"[{name}]" for name in order if name in (*required, *optional)]


def _check_rising(table: _Table, times: Array) -> None:
    back = np.flatnonzero(np.diff(times) < 0)
    if len(back):
        row = int(back[0]) + 1
        raise DataError(
            f"{table.path}, line {table.rows[row][0]}: t_s is {times[row]:g} after {times[row - 1]:g}, but time never "
            "runs backwards: sort the rows by t_s, or give two recordings two files"
        )


def _quaternions(table: _Table, names: tuple[str, ...]) -> Array:
    quaternions = table.numbers(names)
    lengths = np.sqrt((quaternions**2).sum(axis=1))
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > UNIT_TOLERANCE)
    if len(wrong):
        row = int(wrong[0])
        value = ", ".join(f"{number:g}" for number in quaternions[row])
        raise DataError(
            f"{table.path}, line {table.rows[row][0]}: {names[0]}..{names[3][-2:]} is ({value}) of length "
            f"{lengths[row]:.3f}, but a unit quaternion (w, x, y, z) has length 1: check the columns and their scale"
        )
    return np.asarray(quaternions / lengths[:, None])
