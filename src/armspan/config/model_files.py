"""Gesture models and streams as files."""

import base64
import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

from armspan.config.take_files import read_columns, write_whole
from armspan.errors import DataError, ModelError
from armspan.gesture.model import GestureModel, dump, load
from armspan.gesture.scoring import Truth
from armspan.gesture.takes import Take, check_clock

_HEADER = "gesture_model"
_TRUTH = ("start_s", "end_s", "label")


def read_model(path: Path) -> GestureModel:
    """A model from its file (ModelError: what is wrong with it)."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ModelError(f"{path} cannot be read ({error.strerror}): `armspan train` writes a model") from None
    try:
        return load(data)
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from None


def in_header(model: GestureModel) -> dict[str, object]:
    """A model as part of a log's header, so that the log replays by itself."""
    return {_HEADER: base64.b64encode(dump(model)).decode()}


def from_header(header: Mapping[str, object]) -> GestureModel | None:
    """The model in a log's header, None where there was none (ModelError)."""
    text = header.get(_HEADER)
    return load(base64.b64decode(text)) if isinstance(text, str) else None


def write_model(path: Path, model: GestureModel) -> None:
    """Write a model; one that is there is replaced only once the new one is whole."""
    data = dump(model)
    load(data)  # what cannot be read again is not to take a good one's place
    write_whole(path, data)


def check_target(path: Path, what: str = "model", starts: bytes = b"PK") -> None:
    """Refuse, before the work, a place where a model, or ``what`` it is, cannot be written (ModelError).

    A file that is there is replaced only if it ``starts`` as what is to be written.
    """
    if path.is_dir():
        raise ModelError(f"{path} is a folder: name a file for the {what} in it")
    if not path.parent.is_dir():
        raise ModelError(f"{path.parent} is not a folder: make it first, or write the {what} elsewhere")
    if path.is_file() and path.stat().st_size:
        with path.open("rb") as file:
            if file.read(len(starts)) != starts:
                raise ModelError(f"{path} exists and is no {what}: it is kept; name another file")


def check_picture(path: Path) -> None:
    """Refuse, before the work, a place where a picture cannot be written (ModelError)."""
    if path.suffix.lower() != ".png":
        raise ModelError(f"{path}: pictures are PNG files: give it a name that ends in .png")
    check_target(path, "picture", b"\x89PNG")


def read_stream(path: Path) -> Take:
    """A recorded stream from a CSV in the columns of a take (DataError)."""
    columns, times, values = read_columns(path)
    stream = Take("null", "", 0, columns, times, values, source=str(path))
    check_clock(stream)
    return stream


def read_truth(path: Path, labels: Sequence[str]) -> list[Truth]:
    """What was truly made: ``start_s,end_s,label`` (DataError); labels that are none of the model's are kept."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path} cannot be read as CSV ({error}): expected {','.join(_TRUTH)}") from None
    if not rows or [name.strip() for name in rows[0]] != list(_TRUTH):
        raise DataError(f"{path}, line 1: expected the columns {','.join(_TRUTH)}")
    return [_truth(path, line, row) for line, row in enumerate(rows[1:], 2)]


def _truth(path: Path, line: int, row: list[str]) -> Truth:
    try:
        start, end, label = row
        found = Truth(float(start), float(end), label.strip())
    except ValueError:
        raise DataError(f"{path}, line {line}: {','.join(row)!r} is not start_s,end_s,label") from None
    if not (found.start <= found.end and found.label):
        raise DataError(f"{path}, line {line}: {','.join(row)!r}: a gesture ends after it starts, and has a label")
    return found
