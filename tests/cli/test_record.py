import json
import signal
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from armspan.config.recalled import settings_of
from armspan.config.record_room import recorder_of
from armspan.config.take_files import COLUMNS, read_sidecar, read_takes
from armspan.errors import ConfigError
from armspan.gesture.takes import SEVEN, check_takes
from armspan.log import LogFile, read
from armspan.records import EVENTS, Press, TakeEnded
from command_line import code_of, contents, fresh, refused, written_room
from small_rooms import ROOM


class Recorded(NamedTuple):
    folder: Path
    log: LogFile
    out: str
    err: str


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> Recorded:
    """Two gestures, two takes of each and five seconds of everyday motion, by a virtual person."""
    home = tmp_path_factory.mktemp("recorded")
    words = ("--gestures", "stop,x_left_high", "--takes", "2", "--null", "5", "--person", "ann", "--json")
    process = fresh("-m", "armspan", "record", *words, "--log", home / "log.mcap", home / "takes")
    out, err = process.communicate(timeout=100)
    assert process.returncode == 0, err
    return Recorded(home / "takes", read(home / "log.mcap"), out, err)


def truths(log):
    """What the virtual person truly did: label, start and end [s]."""
    told = [record for record in log.records if isinstance(record, Press) and record.name == "truth"]
    return [(began.value, began.t, ended.t) for began, ended in zip(told[::2], told[1::2], strict=True)]


def test_the_takes_lie_in_folders_and_are_accounted_for(recorded):
    names = [f"{label}/ann_{number:02d}" for label in ("stop", "x_left_high") for number in (1, 2, 3)]
    files = [str(path.relative_to(recorded.folder)) for path in contents(recorded.folder) if path.is_file()]
    assert files == sorted(f"{name}.{kind}" for name in (*names, "null/ann_01") for kind in ("csv", "json"))
    document = json.loads(recorded.out)
    assert document["takes"] == {
        "stop": {"takes": 2, "practice": 1, "spoilt": 0},
        "x_left_high": {"takes": 2, "practice": 1, "spoilt": 0},
        "null": {"takes": 1, "practice": 0, "spoilt": 0},
    }
    assert document["simulated"] is True
    assert document["bands"] == ["right", "left"]
    assert [Path(name).exists() for name in document["files"]] == [True] * 7


def test_the_takes_can_be_learnt_from(recorded):
    takes = read_takes(recorded.folder)
    assert {take.columns for take in takes} == {COLUMNS}
    assert len(check_takes(takes)) == 5
    for take in takes:
        assert take.times == pytest.approx(np.arange(len(take.times)) / 100)
        assert take.practice == (take.label != "null" and take.number == 1)


def test_the_gestures_are_found_where_they_truly_were(recorded):
    ended = {(r.label, r.number): r for r in recorded.log.records if isinstance(r, TakeEnded)}
    labels = ["stop"] * 3 + ["x_left_high"] * 3
    assert [label for label, _, _ in truths(recorded.log)] == labels
    for (label, start, end), number in zip(truths(recorded.log), (1, 2, 3) * 2, strict=True):
        take = next(t for t in read_takes(recorded.folder) if (t.label, t.number) == (label, number))
        offset = ended[label, number].started - take.gesture[0]
        assert offset + take.gesture[0] == pytest.approx(start, abs=0.3)
        assert offset + take.gesture[1] == pytest.approx(end, abs=0.3)
        assert 1.0 <= take.gesture[0] <= 2.0
        assert 1.0 <= take.seconds - take.gesture[1] <= 2.0


def test_the_arms_hang_at_rest_and_gravity_is_taken_away(recorded):
    for take in read_takes(recorded.folder):
        if take.label == "null":
            continue
        rest = take.values[take.times < 0.8]
        for side in (rest[:, :10], rest[:, 10:]):
            x, y, z, w = side[:, :4].mean(axis=0)
            assert 2 * (x * z - w * y) < -0.9  # the forearm's x, seen in z: it points down
            assert np.linalg.norm(side[:, 4:7].mean(axis=0)) < 0.6
            assert np.abs(side[:, 7:]).mean() < 0.2


def test_sidecars_say_that_it_was_a_virtual_person(recorded):
    sides = [read_sidecar(path) for path in sorted(recorded.folder.glob("*/*.csv"))]
    assert all(side.simulated and side.rate_hz == 100.0 and side.person == "ann" for side in sides)
    assert "virtual person" in recorded.err.splitlines()[0]
    assert "Now: stop" in recorded.err


def test_the_log_replays_to_the_same_takes(recorded):
    presses = [r for r in recorded.log.records if isinstance(r, Press)]
    assert presses[0].name == "setup"
    recorder = recorder_of(recorded.log, settings_of(recorded.log))
    again = [output for r in recorded.log.records if isinstance(r, EVENTS) for output in recorder.step(r)]
    assert again == [r for r in recorded.log.records if not isinstance(r, EVENTS)]
    assert len(recorder.finished) == 7


def test_numbers_go_on_and_nothing_is_overwritten(tmp_path, capsys):
    words = ("record", "--gestures", "raise_both", "--takes", "1", "--bands", "left")
    before = {}
    for number in (1, 3):
        assert code_of(*words, "--log", tmp_path / f"{number}.mcap", tmp_path / "takes") == 0
        now = contents(tmp_path / "takes")
        assert {path: now[path] for path in before} == before
        before = now
    assert sorted(path.name for path in before if path.suffix == ".csv") == [f"p01_{k:02d}.csv" for k in (1, 2, 3, 4)]
    assert {take.columns for take in read_takes(tmp_path / "takes")} == {COLUMNS[10:]}
    out, _ = capsys.readouterr()
    assert "raise_both: 1 (and 1 for practice)" in out


def test_a_room_needs_only_bands(tmp_path, capsys):
    bands = [{"kind": "simulated", "name": "w", "fusion": "raw"}]
    room = written_room(tmp_path / "room.toml", {"bands": bands})
    words = ("--gestures", "x_right_high", "--takes", "1", "--pace", "fast", "--room", room)
    assert code_of("record", *words, "--log", tmp_path / "log.mcap", tmp_path / "takes") == 0
    takes = read_takes(tmp_path / "takes")
    assert {take.columns for take in takes} == {COLUMNS[:10]}
    assert all(take.gesture is not None for take in takes)
    assert "Rest both arms" in capsys.readouterr().err


def test_a_recorded_session_can_be_cut_again(recorded, tmp_path, capsys):
    bands = [{"kind": "replay", "name": s, "arm": s, "log": str(recorded.log.path)} for s in ("right", "left")]
    room = written_room(tmp_path / "room.toml", {"bands": bands})
    words = ("--gestures", "stop,x_left_high", "--takes", "2", "--null", "5", "--person", "ann", "--pace", "fast")
    assert code_of("record", *words, "--room", room, "--log", tmp_path / "log.mcap", tmp_path / "takes") == 0
    one, other = (
        {str(path.relative_to(folder)): data for path, data in contents(folder).items() if path.suffix == ".csv"}
        for folder in (recorded.folder, tmp_path / "takes")
    )
    assert one == other


def test_after_ctrl_c_every_finished_take_is_on_disk(tmp_path):
    words = ("--gestures", "stop", "--takes", "500", "--log", tmp_path / "log.mcap")
    process = fresh("-m", "armspan", "record", *words, tmp_path / "takes")
    deadline = time.monotonic() + 60
    while len(list((tmp_path / "takes").glob("stop/*.csv"))) < 2:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    files = [path for path in contents(tmp_path / "takes") if path.is_file()]
    assert {path.suffix for path in files} == {".csv", ".json"}
    log = read(tmp_path / "log.mcap")
    assert log.complete
    ended = [record for record in log.records if isinstance(record, TakeEnded)]
    assert len(read_takes(tmp_path / "takes")) == len(ended) == len(files) / 2
    assert f"{len(ended)} finished takes are in" in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--gestures", "my wave"), "'my wave'"),
        (("--gestures", "../up"), "'../up'"),
        (("--gestures", ""), "''"),
        (("--gestures", "Mixing,mixing"), "differ by case only"),
        (("--gestures", "stop,stop"), "'stop' is asked for twice"),
        (("--gestures", "stop,seven"), "'stop' is asked for twice"),
        (("--gestures", "null"), "--null"),
        (("--gestures", "wave"), "'wave' does not exist"),
        (("--takes", "0"), "0 takes"),
        (("--person", "a/b"), "'a/b'"),
        (("--person", ""), "''"),
        (("--null", "0"), "above zero"),
        (("--bands", "middle"), "'middle'"),
        (("--taps",), "no button"),
        (("--room", "missing.toml"), "missing.toml"),
        (("--seed", "-1"), "'-1'"),
    ],
)
def test_what_cannot_be_recorded_is_one_sentence(words, said, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said in refused(capsys, tmp_path, "record", *words, "takes")


def test_folders_that_do_not_fit(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("x")
    assert "file is a file" in refused(capsys, tmp_path, "record", "file")
    (tmp_path / "takes" / "STOP").mkdir(parents=True)
    assert "'STOP'" in refused(capsys, tmp_path, "record", "--gestures", "stop", "takes")


def test_rooms_that_do_not_fit(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written_room(tmp_path / "none.toml", {key: value for key, value in ROOM.items() if key != "bands"})
    assert "has no [[bands]]" in refused(capsys, tmp_path, "record", "--room", "none.toml", "takes")
    (tmp_path / "odd.toml").write_text("bands = [")
    assert "is not TOML" in refused(capsys, tmp_path, "record", "--room", "odd.toml", "takes")
    written_room(tmp_path / "one.toml", ROOM)
    assert "'left'" in refused(capsys, tmp_path, "record", "--room", "one.toml", "--bands", "left", "takes")
    (tmp_path / "log.mcap").write_bytes(b"x")
    assert "exists already" in refused(capsys, tmp_path, "record", "--log", "log.mcap", "takes")


@pytest.mark.parametrize(
    ("words", "gestures", "null_s"),
    [
        ((), SEVEN, 0.0),
        (("--gestures", "seven,initial"), (*SEVEN, "initial"), 0.0),
        (("--null", "600"), (), 600.0),
        (("--gestures", "stop, mixing", "--null", "9"), ("stop", "mixing"), 9.0),
    ],
)
def test_what_is_asked_for(words, gestures, null_s, monkeypatch, tmp_path):
    asked = []

    def open_none(room, recording, folder):
        asked.append(recording)
        raise ConfigError("there is no house")

    monkeypatch.setattr("armspan.cli.record.open_record_house", open_none)
    assert code_of("record", *words, "--takes", "3", "--shuffle", tmp_path / "takes") == 2
    [recording] = asked
    assert (recording.gestures, recording.takes, recording.null_s) == (gestures, 3, null_s)
    assert recording.wrists == ("right", "left")
    assert recording.shuffle
