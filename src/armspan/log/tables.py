"""A session as tables, one CSV file per record type, for spreadsheets and statistics."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import TypeAlias, cast

from msgspec.inspect import (
    Field,
    IntType,
    NoneType,
    StructType,
    TupleType,
    UnionType,
    VarTupleType,
    type_info,
)

from armspan.errors import LogError
from armspan.log.reader import LogFile, read
from armspan.log.writer import create
from armspan.records import Record

_Cell: TypeAlias = float | int | str | bool | None
_Row: TypeAlias = tuple[int, float, Record]

_AXES = {2: "xy", 3: "xyz", 4: "wxyz"}


def export_csv(path: str | Path, folder: str | Path, *, overwrite: bool = False) -> list[Path]:
    """Write a session's records to ``<folder>/<type>.csv`` and return these files.

    Columns: ``order`` (place in the session, over all tables), ``arrived`` [s], then the record's fields.
    Vectors are spread as ``xy_x, xy_y``, tuples of any length as ``labels_0, labels_1``. A cell is empty
    where the value is None. Floats are written so that they read back exactly.

    Raises:
        LogError: the session cannot be read, a table exists already (unless ``overwrite``), or cannot be
            written.

    """
    log, folder = read(path), Path(folder)
    _make(folder)
    return [_write(folder, kind, rows, overwrite) for kind, rows in _sorted(log).items()]


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LogError(f"{folder} cannot be a folder ({error.strerror}): choose another place") from error


def _sorted(log: LogFile) -> dict[type[Record], list[_Row]]:
    tables: dict[type[Record], list[_Row]] = {}
    for order, (record, arrived) in enumerate(zip(log.records, log.arrivals, strict=True)):
        tables.setdefault(type(record), []).append((order, arrived, record))
    return tables


def _write(folder: Path, kind: type[Record], rows: list[_Row], overwrite: bool) -> Path:
    path = folder / f"{kind.__name__}.csv"
    columns = {field.name: _columns(field, rows) for field in _fields(kind)}
    with io.TextIOWrapper(create(path, overwrite=overwrite), encoding="utf-8", newline="") as text:
        writer = csv.writer(text)  # with its own line ends, CR LF: it quotes a text for them only
        writer.writerow(["order", "arrived", *(name for names in columns.values() for name in names)])
        for order, arrived, record in rows:
            writer.writerow([order, arrived, *_cells(record, columns)])
    return path


def _cells(record: Record, columns: dict[str, list[str]]) -> Iterator[_Cell]:
    for field, names in columns.items():
        cells = list(_flat(getattr(record, field)))
        yield from cells
        yield from [None] * (len(names) - len(cells))


def _flat(value: object) -> Iterator[_Cell]:
    if isinstance(value, tuple):
        for item in value:
            yield from _flat(item)
    elif isinstance(value, float | int | str):
        yield value


def _fields(kind: type[Record]) -> tuple[Field, ...]:
    return cast(StructType, type_info(kind)).fields


def _columns(field: Field, rows: list[_Row]) -> list[str]:
    kind = field.type
    if isinstance(kind, UnionType):
        kind = next(k for k in kind.types if not isinstance(k, NoneType))
    if isinstance(kind, VarTupleType):
        longest = max(len(getattr(record, field.name) or ()) for _, _, record in rows)
        return [f"{field.name}_{place}" for place in range(longest)]
    if isinstance(kind, TupleType):
        return [f"{field.name}_{suffix}" for suffix in _suffixes(kind)]
    return [field.name]


def _suffixes(kind: TupleType) -> list[str]:
    first = kind.item_types[0]
    axes = "rgb" if isinstance(first, IntType) else _AXES[len(kind.item_types)]
    rest = _suffixes(first) if isinstance(first, TupleType) else [""]
    return [axis + suffix for axis in axes for suffix in rest]
