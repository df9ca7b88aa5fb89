"""The real recordings of the study of pointing errors: a folder with ``people/`` and ``pointing/``."""

import csv
from pathlib import Path

import numpy as np

from armspan.config.body_file import read_body
from armspan.config.recordings import read_pairs
from armspan.errors import DataError
from armspan.frames import Array, rotation_from_quaternion
from armspan.study.pointing_error.moving import REAL_SECONDS
from armspan.study.pointing_error.recordings import Following, Gestures, Recordings, limb, numbered_places

SESSIONS = ("circle_0", "triangle_2", "triangle_3")

LOW_M = 0.49
"""The height [m] of those targets that lie on one level below the eyes."""

_MARKERS = ("eyes", "shoulder", "elbow", "wrist", "target")
_COLUMNS = tuple(f"{marker}_{axis}_m" for marker in _MARKERS for axis in "xyz")


def read_error_recordings(folder: Path) -> Recordings:
    """All people and all sessions of a folder in the layout of ``people/`` and ``pointing/``.

    Raises:
        DataError: if the folder or a file of it is missing or holds something else.
        ConfigError: if a body file cannot be used.

    """
    if not folder.is_dir():
        raise DataError(f"{folder} is not a folder: name one that holds people/gestures.csv and pointing/*.csv")
    return Recordings(read_people(folder / "people"), read_sessions(folder / "pointing"))


def read_people(folder: Path) -> tuple[Gestures, ...]:
    """The gestures at the low targets of ``gestures.csv``, one person each, with the sizes of ``pNN/body.toml``.

    Raises:
        DataError: as `read_error_recordings`.

    """
    path = folder / "gestures.csv"
    names, values = _table(path)
    people = []
    for number, name in enumerate(dict.fromkeys(names), 1):
        own = values[[row == name for row in names]]
        people.append(_person(own, folder / f"p{number:02d}" / "body.toml", path))
    return tuple(people)


def _person(rows: Array, body: Path, path: Path) -> Gestures:
    """One person's gestures; ``rows`` (n, 5, 3) [m] are the markers in the order of `_MARKERS`."""
    eyes, shoulder, elbow, wrist, target = rows.transpose(1, 0, 2)
    floor = eyes.mean(axis=0) * [1.0, 1.0, 0.0]
    low = np.isclose(target[:, 2], LOW_M)
    places = numbered_places(target[low])
    if len(places) == 0 or places.max() != 8:
        raise DataError(
            f"{path}: {len(set(places.tolist()))} targets at {LOW_M:g} m, but nine places are expected there"
        )
    return Gestures(read_body(body), limb(elbow, wrist)[low], limb(shoulder, elbow)[low], target[low] - floor, places)


def read_sessions(folder: Path) -> tuple[Following, ...]:
    """The sessions of a person who follows a robot, with the head's true place.

    Raises:
        DataError: as `read_error_recordings`.

    """
    body = read_body(folder / "body.toml")
    sessions = []
    for name in SESSIONS:
        pairs = read_pairs(folder / f"{name}.csv")
        head = _head(folder / f"{name}_head.csv")
        if len(head) != len(pairs.times):
            raise DataError(
                f"{folder / name}_head.csv has {len(head)} rows, but {name}.csv has {len(pairs.times)}: they belong "
                "together row by row"
            )
        lasted = float(pairs.times[-1] - pairs.times[0])
        if lasted <= max(REAL_SECONDS):
            raise DataError(
                f"{folder / name}.csv lasts {lasted:g} s, but more than {max(REAL_SECONDS):g} s are expected, of which "
                "some are for the calibration and the rest for its test: name a longer recording"
            )
        forearm = rotation_from_quaternion(pairs.forearm)
        sessions.append(Following(body, pairs.times, forearm, pairs.points, head))
    return tuple(sessions)


def _head(path: Path) -> Array:
    rows = _rows(path)
    return _numbers(path, rows, ("x_m", "y_m", "z_m"))


def _table(path: Path) -> tuple[list[str], Array]:
    """Whose each row is, and the markers (n, 5, 3) [m]."""
    rows = _rows(path)
    if "person" not in rows[0]:
        raise DataError(f"{path}, line 1: column 'person' is missing: each row tells whose gesture it is")
    return [row["person"] for row in rows], _numbers(path, rows, _COLUMNS).reshape(-1, len(_MARKERS), 3)


def _rows(path: Path) -> list[dict[str, str]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file))
    except FileNotFoundError:
        raise DataError(
            f"{path} does not exist: --recordings names a folder that holds people/ and pointing/"
        ) from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path} cannot be read as CSV text: {error}") from None
    if not rows:
        raise DataError(f"{path} holds no rows: name a folder with the recordings themselves")
    return rows


def _numbers(path: Path, rows: list[dict[str, str]], columns: tuple[str, ...]) -> Array:
    missing = [name for name in columns if name not in rows[0]]
    if missing:
        raise DataError(f"{path}, line 1: column {missing[0]!r} is missing; expected: {', '.join(columns)}")
    try:
        values = np.array([[float(row[name]) for name in columns] for row in rows])
    except (TypeError, ValueError) as error:
        raise DataError(f"{path}: a field is no number ({error}): mend the row or leave it out") from None
    if not np.isfinite(values).all():
        line = 2 + int(np.flatnonzero(~np.isfinite(values).all(axis=1))[0])
        raise DataError(f"{path}, line {line}: a number is not finite: mend the row or leave it out")
    return values
