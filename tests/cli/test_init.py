import re
import tomllib

import pytest

from armspan.cli.room_texts import ROOMS
from armspan.config.house import open_house
from armspan.config.room_file import RoomFile, read_room
from armspan.pointing.selection import SelectionSettings
from armspan.swarm.director import DICTIONARY
from armspan.swarm.limits import Limits
from command_line import code_of, refused


def test_the_room_it_writes_can_be_opened(tmp_path, capsys):
    path = tmp_path / "mine.toml"
    assert code_of("init", path) == 0
    out, err = capsys.readouterr()
    assert out == f"{path} is written; open it with: armspan run {path}\n"
    assert err == ""
    room = read_room(path)
    assert [robot.name for robot in room.robots] == ["amber", "birch", "cobalt"]
    assert open_house(room).world is not None


def test_without_a_name_it_is_room_toml(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert code_of("init") == 0
    assert [path.name for path in tmp_path.iterdir()] == ["room.toml"]


def test_what_it_calls_defaults_are_the_defaults():
    raw = tomllib.loads(ROOMS["simulated"])
    assert Limits(**raw["limits"]) == Limits()
    assert SelectionSettings(**raw["selection"]) == SelectionSettings()


def test_what_is_commented_out_can_be_commented_in(tmp_path):
    path = tmp_path / "room.toml"
    setting = r"^# (\[\[?[\w.]+\]?\]|\w+ = (?:\"[\w.-]+\"|[\d.]+|\[[^\]]*\]|\{.*\}))(?:  # (?:made|or).*)?$"
    path.write_text(re.sub(setting, r"\1", ROOMS["simulated"], flags=re.MULTILINE), encoding="utf-8")
    room = read_room(path)
    assert [(band.segment, band.arm) for band in room.bands] == [
        ("forearm", None),
        ("upperarm", None),
        ("forearm", "left"),
    ]
    assert room.gestures.model == "gestures.model"
    assert room.gestures.behaviours == DICTIONARY
    assert room.simulation.person.gestures == ("mixing", "everyday:10", "stop")
    assert room.body["eye_height_m"] == 1.60


def test_an_existing_file_is_kept(tmp_path, capsys):
    path = tmp_path / "room.toml"
    path.write_text("mine")
    assert f"{path} exists and is kept" in refused(capsys, tmp_path, "init", path)
    assert "exists and is kept" in refused(capsys, tmp_path, "init", tmp_path)
    assert "cannot be written: No such file" in refused(capsys, tmp_path, "init", tmp_path / "no" / "room.toml")
    assert "cannot be written: Not a directory" in refused(capsys, tmp_path, "init", path / "room.toml")
    assert "unrecognized arguments: more" in refused(capsys, tmp_path, "init", path, "more")


def test_every_top_level_key_of_the_file_exists():
    assert set(tomllib.loads(ROOMS["simulated"])) <= set(RoomFile.__struct_fields__)


@pytest.mark.parametrize(
    ("devices", "kinds"),
    [
        ("simulated", {"SimulatedBand", "SimulatedRobot"}),
        ("lab", {"MetaWearEntry", "CelluloEntry"}),
        ("phone", {"PhoneEntry", "SimulatedRobot"}),
    ],
)
def test_every_room_can_be_opened(tmp_path, devices, kinds):
    path = tmp_path / "room.toml"
    assert code_of("init", "--devices", devices, path) == 0
    room = read_room(path)
    assert {type(entry).__name__ for entry in (*room.bands, *room.robots)} == kinds
    assert open_house(room, tmp_path).lasts is (devices != "simulated")


def test_what_is_commented_out_in_a_lab_can_be_commented_in(tmp_path):
    path = tmp_path / "room.toml"
    devices, limits, rest = ROOMS["lab"].partition("# What robots may do at most")
    text = re.sub(r"^# (\[\[?\w+\]?\]|\w+ = \S.*)$", r"\1", devices, flags=re.MULTILINE)
    path.write_text(text + limits + rest, encoding="utf-8")
    room = read_room(path)
    assert [band.arm for band in room.bands] == [None, None, "left"]
    assert room.bands[0].strap == "hand-at-minus-y"
    assert [type(robot).__name__ for robot in room.robots] == ["CelluloEntry"] * 3 + ["ToioEntry"]
    assert [type(entry).__name__ for entry in room.receptors] == ["SerialReceptor", "UdpReceptor", "HttpReceptor"]
    assert room.laser.direction_deg == (0.0, -12.0)
