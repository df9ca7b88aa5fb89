"""BODY.toml: a person's measures [m], checked for the unit they are written in."""

import math
import tomllib
from pathlib import Path

import numpy as np

from armspan.errors import ConfigError, known_names
from armspan.records import Arm, Body, Vec3

_RANGES: dict[str, tuple[float, float]] = {
    "eye_height_m": (0.5, 2.3),
    "shoulder_to_fingertip_m": (0.3, 1.2),
    "upper_arm_m": (0.1, 0.6),
    "elbow_to_fingertip_m": (0.1, 0.8),
}
_SHOULDER_TO_EYE = (("forward", -0.3, 0.3), ("left", -0.5, 0.5), ("up", 0.02, 0.6))
_REQUIRED = ("eye_height_m", "shoulder_to_eye_m", "shoulder_to_fingertip_m")
_KEYS = (*_RANGES, "shoulder_to_eye_m", "arm", "covariance_m2")


def read_body(path: Path) -> Body:
    """The body a file describes under ``[body]``.

    Raises:
        ConfigError: if the file cannot be read, a measure is missing, unknown, not a number or not in metres.

    """
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(
            f"{path} does not exist: name a body file, or write one with [body] and its measures"
        ) from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigError(f"{path} cannot be read as TOML: {error}") from None
    table = document.get("body")
    if not isinstance(table, dict):
        raise ConfigError(f"{path} has no table [body]: write the measures under a line `[body]`")
    return body_from_table(table, str(path))


def body_from_table(table: dict[str, object], where: str) -> Body:
    """The body that a table of a TOML file describes; ``where`` names the file in complaints.

    Raises:
        ConfigError: as `read_body`.

    """
    for key in table:
        if key not in _KEYS:
            raise ConfigError(f"{where}: [body] {known_names('key', key, _KEYS)}")
    for key in _REQUIRED:
        if key not in table:
            raise ConfigError(f"{where}: [body] lacks {key}: measure it and write it there in metres")
    measures = {key: _measure(table[key], key, limits, where) for key, limits in _RANGES.items() if key in table}
    return Body(
        eye_height_m=measures["eye_height_m"],
        shoulder_to_eye_m=_shoulder_to_eye(table["shoulder_to_eye_m"], where),
        shoulder_to_fingertip_m=measures["shoulder_to_fingertip_m"],
        arm=_arm(table.get("arm", "right"), where),
        upper_arm_m=measures.get("upper_arm_m"),
        elbow_to_fingertip_m=measures.get("elbow_to_fingertip_m"),
        covariance=_covariance(table.get("covariance_m2"), where),
    )


def _measure(value: object, key: str, limits: tuple[float, float], where: str) -> float:
    metres = _number(value, key, where)
    low, high = limits
    if not low <= metres <= high:
        raise ConfigError(
            f"{where}: [body] {key} = {metres:g}, but it is in metres and lies between {low:g} and {high:g}"
            f"{_other_unit(metres, limits)}"
        )
    return metres


def _other_unit(value: float, limits: tuple[float, float]) -> str:
    """The likely meaning of a number that is out of range as metres."""
    for divisor, unit in ((100.0, "centimetres"), (1000.0, "millimetres")):
        if limits[0] <= value / divisor <= limits[1] and abs(value) > limits[1]:
            return f": that looks like {unit}, did you mean {value / divisor:g}?"
    return ": measure it again"


def _number(value: object, key: str, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ConfigError(f"{where}: [body] {key} = {value!r} is not a finite number: write metres, such as 0.74")
    return float(value)


def _shoulder_to_eye(value: object, where: str) -> Vec3:
    key = "shoulder_to_eye_m"
    if not isinstance(value, list) or len(value) != 3:
        raise ConfigError(
            f"{where}: [body] {key} = {value!r}, but it is three numbers [forward, left, up] in metres, "
            "such as [0.0, 0.18, 0.25]"
        )
    forward, left, up = (
        _measure(item, f"{key} ({name})", (low, high), where)
        for item, (name, low, high) in zip(value, _SHOULDER_TO_EYE, strict=True)
    )
    return forward, left, up


def _arm(value: object, where: str) -> Arm:
    if value == "left":
        return "left"
    if value == "right":
        return "right"
    raise ConfigError(f"{where}: [body] arm = {value!r}, but it is 'left' or 'right'")


_DOUBT_LIMIT_M = 0.3
"""Standard deviation of a measure [m] above which its unit is in doubt; nobody knows so little of a body."""


def _covariance(value: object, where: str) -> tuple[float, ...] | None:
    if value is None:
        return None
    if not isinstance(value, list) or len(value) != 25:
        raise ConfigError(
            f"{where}: [body] covariance_m2 needs 25 numbers [m²], 5 rows of 5 over (eye height, forward, left, up, "
            "arm length): write them in one list, or leave it out"
        )
    numbers = tuple(_number(item, "covariance_m2", where) for item in value)
    matrix = np.reshape(numbers, (5, 5))
    if not np.allclose(matrix, matrix.T, atol=1e-7) or np.linalg.eigvalsh((matrix + matrix.T) / 2.0)[0] < -1e-7:
        raise ConfigError(
            f"{where}: [body] covariance_m2 is no covariance, which is symmetric and has no negative direction: let "
            "`armspan body` write it, or leave it out"
        )
    if matrix.max() > _DOUBT_LIMIT_M**2:
        raise ConfigError(
            f"{where}: [body] covariance_m2 holds {matrix.max():g}, a doubt of {np.sqrt(matrix.max()):.1f} m, but it "
            "is in square metres, 0.000064 for 8 mm: write it so, or leave it out"
        )
    return numbers


def check_new(path: Path) -> None:
    """See, before anything is measured, that a body file can be new there.

    Raises:
        ConfigError: if it exists, or its folder does not.

    """
    if path.exists():
        raise ConfigError(f"{path} exists and is kept: name another file with --out")
    if not path.parent.is_dir():
        raise ConfigError(f"{path} cannot be written, as {path.parent} is no folder: name another file with --out")


def write_body(path: Path, body: Body, note: str) -> None:
    """Write a body file that says under a comment where its measures come from; an existing file is kept.

    Raises:
        ConfigError: if the file exists or cannot be written.

    """
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(body_text(body, note))
    except FileExistsError:
        raise ConfigError(f"{path} exists and is kept: name another file with --out") from None
    except OSError as error:
        raise ConfigError(f"{path} cannot be written ({error.strerror}): name another file with --out") from None


def body_text(body: Body, note: str) -> str:
    """The table ``[body]`` as `read_body` takes it: metres to the tenth of a millimetre, doubts to the square of it."""
    forward, left, up = body.shoulder_to_eye_m
    lines = [*(f"# {line}" for line in note.splitlines()), "[body]", f"eye_height_m = {body.eye_height_m:.4f}"]
    lines += [
        f"shoulder_to_eye_m = [{forward:.4f}, {left:.4f}, {up:.4f}]  # from the shoulder's pivot: forward, left, up",
        f"shoulder_to_fingertip_m = {body.shoulder_to_fingertip_m:.4f}",
    ]
    if body.upper_arm_m is not None and body.elbow_to_fingertip_m is not None:
        lines += [f"upper_arm_m = {body.upper_arm_m:.4f}", f"elbow_to_fingertip_m = {body.elbow_to_fingertip_m:.4f}"]
    lines.append(f'arm = "{body.arm}"')
    if body.covariance is not None:
        rows = np.reshape(body.covariance, (5, 5))
        lines.append("# over eye height, forward, left, up, arm length")
        lines.append("covariance_m2 = [")
        lines += ["    " + ", ".join(f"{value:.8f}" for value in row) + "," for row in rows]
        lines.append("]")
    return "\n".join(lines) + "\n"
