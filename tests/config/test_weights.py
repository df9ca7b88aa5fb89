import hashlib
import io
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from armspan.config import weights
from armspan.config.weights import TARBALL, WHEEL, Weight, fetch_weights, missing_weights, weights_folder
from armspan.errors import ConfigError, DeviceError


def content(name: str) -> bytes:
    return f"the network {name}".encode() * 50


def made(package):
    """A package whose files have other contents, which the checksums fit."""
    return replace(
        package,
        weights={
            name: Weight(each.member, hashlib.sha256(content(name)).hexdigest())
            for name, each in package.weights.items()
        },
    )


class Tools:
    """pip and npm as far as they are needed: each puts an archive where it is told to."""

    def __init__(self) -> None:
        self.orders: list[list[str]] = []
        self.fails: dict[str, str] = {}
        self.spoiled: set[str] = set()
        self.lacking: set[str] = set()

    def members(self, package):
        for name, each in package.weights.items():
            if name not in self.lacking:
                yield each.member, content(name) + (b"!" if name in self.spoiled else b"")

    def run(self, order, **_):
        self.orders.append(order)
        tool = "pip" if "pip" in order else "npm"
        if tool in self.fails:
            return subprocess.CompletedProcess(order, 1, "", self.fails[tool])
        into = Path(order[1 + order.index("--dest" if tool == "pip" else "--pack-destination")])
        if tool == "pip":
            with zipfile.ZipFile(into / "mediapipe-0.10.21-cp312-cp312-any.whl", "w") as wheel:
                for member, data in self.members(WHEEL):
                    wheel.writestr(member, data)
        else:
            with tarfile.open(into / "mediapipe-pose.tgz", "w:gz") as tarball:
                for member, data in self.members(TARBALL):
                    told = tarfile.TarInfo(member)
                    told.size = len(data)
                    tarball.addfile(told, io.BytesIO(data))
        return subprocess.CompletedProcess(order, 0, "", "")


@pytest.fixture
def tools(monkeypatch):
    made_up = Tools()
    monkeypatch.setattr(weights, "WHEEL", made(WHEEL))
    monkeypatch.setattr(weights, "TARBALL", made(TARBALL))
    monkeypatch.setattr(weights.subprocess, "run", made_up.run)
    monkeypatch.setattr(weights.shutil, "which", lambda name: f"/bin/{name}")
    return made_up


def quiet(_: str) -> None:
    pass


def test_the_weights_are_fetched_and_told(tools, tmp_path):
    said: list[str] = []
    folder = tmp_path / "data" / "weights"
    assert fetch_weights(folder, said.append) == folder
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {
        name: content(name) for name in (*WHEEL.weights, *TARBALL.weights)
    }
    assert missing_weights(folder, weights.WHEEL) == []
    assert any("mediapipe==0.10.21" in each and "36 MB" in each for each in said)
    assert sum(each.startswith("Wrote") for each in said) == 4


def test_pip_is_asked_for_the_same_wheel_on_every_system(tools, tmp_path):
    fetch_weights(tmp_path, quiet)
    order = tools.orders[0]
    assert order[:5] == [sys.executable, "-m", "pip", "download", "mediapipe==0.10.21"]
    assert order[order.index("--python-version") + 1] == "3.12"
    assert "manylinux_2_28_x86_64" in order
    assert "--no-deps" in order
    assert not any("://" in each for each in order)  # where packages come from is pip's own setting


def test_what_is_there_is_not_fetched_again(tools, tmp_path):
    fetch_weights(tmp_path, quiet)
    fetch_weights(tmp_path, quiet)
    assert len(tools.orders) == 2


def test_a_spoiled_file_is_fetched_again(tools, tmp_path):
    fetch_weights(tmp_path, quiet)
    spoiled = tmp_path / next(iter(WHEEL.weights))
    spoiled.write_bytes(b"half of it")
    fetch_weights(tmp_path, quiet)
    assert spoiled.read_bytes() == content(spoiled.name)
    assert len(tools.orders) == 3


def test_another_content_than_was_published_is_not_used(tools, tmp_path):
    tools.spoiled = {"pose_detection.tflite"}
    with pytest.raises(DeviceError, match=r"pose_detection.tflite in mediapipe.*whl has the checksum \w{12}\.{3}, not"):
        fetch_weights(tmp_path, quiet)
    assert list(tmp_path.iterdir()) == []


def test_a_package_without_the_weights(tools, tmp_path):
    tools.lacking = {"hand_landmark_full.tflite"}
    with pytest.raises(DeviceError, match="lacks mediapipe/modules/hand_landmark"):
        fetch_weights(tmp_path, quiet)


def test_no_network_is_one_sentence(tools, tmp_path):
    tools.fails["pip"] = "WARNING: Retrying\n\nERROR: No matching distribution found for mediapipe==0.10.21.\nnotice\n"
    with pytest.raises(DeviceError, match="look at the network") as told:
        fetch_weights(tmp_path, quiet)
    assert "(No matching distribution found for mediapipe==0.10.21)" in str(told.value)
    assert "\n" not in str(told.value)
    assert "ARMSPAN_WEIGHTS" in str(told.value)


def test_a_tool_that_cannot_start_or_hangs(tools, tmp_path, monkeypatch):
    def hangs(order, **_):
        raise subprocess.TimeoutExpired(order, 900)

    monkeypatch.setattr(weights.subprocess, "run", hangs)
    with pytest.raises(DeviceError, match="TimeoutExpired"):
        fetch_weights(tmp_path, quiet)


@pytest.mark.parametrize("trouble", ["no npm", "npm fails", "another content"])
def test_without_the_finer_network_the_other_does(tools, tmp_path, monkeypatch, trouble):
    said: list[str] = []
    if trouble == "no npm":
        monkeypatch.setattr(weights.shutil, "which", lambda _: None)
    elif trouble == "npm fails":
        tools.fails["npm"] = "npm error code ENOTFOUND"
    else:
        tools.spoiled = set(TARBALL.weights)
    fetch_weights(tmp_path, said.append)
    assert {path.name for path in tmp_path.iterdir()} == set(WHEEL.weights)
    assert said[-1].startswith("The finer network for the body is left out, the other does: ")


def test_a_place_that_is_no_folder(tools, tmp_path):
    (tmp_path / "file").write_text("here")
    with pytest.raises(ConfigError, match=r"cannot be written to .*file.*set ARMSPAN_WEIGHTS"):
        fetch_weights(tmp_path / "file", quiet)
    assert tools.orders == []  # found out before the download


def test_a_full_disk_leaves_no_half_of_a_file(tools, tmp_path, monkeypatch):
    def full(path, data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(weights, "write_whole", full)
    with pytest.raises(ConfigError, match=r"No space left on device.*make room"):
        fetch_weights(tmp_path, quiet)
    assert list(tmp_path.iterdir()) == []


def test_where_the_weights_are_kept(monkeypatch, tmp_path):
    monkeypatch.setenv("ARMSPAN_WEIGHTS", str(tmp_path / "mine"))
    assert weights_folder() == tmp_path / "mine"
    monkeypatch.delenv("ARMSPAN_WEIGHTS")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    assert weights_folder() == tmp_path / "data" / "armspan" / "weights"
    for relative in ("", "share"):
        monkeypatch.setenv("XDG_DATA_HOME", relative)
        assert weights_folder() == Path.home() / ".local" / "share" / "armspan" / "weights"
