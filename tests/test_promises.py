"""The two promises: a log replays to itself, and one seed is one session, byte for byte."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from armspan.cli.replay import first_difference
from armspan.conductor import Conductor
from armspan.config.recalled import settings_of
from armspan.log import read
from armspan.records import EVENTS, Calibrated, Pointed, Press, RobotState, Selected, Stop
from command_line import code_of, fresh, written_room
from small_rooms import KINDS, ROOM, play_anew, played


def replayed(log):
    """A whole session anew from the events of a log, with the settings that its header keeps."""
    conductor = Conductor(settings_of(log))
    records = []
    for event in log.records:
        if isinstance(event, EVENTS):
            records += [event, *conductor.step(event)]
    return records


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_a_log_replays_to_itself(kind):
    log = played(*kind).log
    assert {Calibrated, Pointed, Selected, Stop} <= {type(record) for record in log}
    assert replayed(log) == log.records
    assert first_difference(log, settings_of(log)) is None


def test_a_log_that_was_cut_replays_as_far_as_it_goes(tmp_path):
    whole, path = played(*KINDS[1]), tmp_path / "cut.mcap"
    for share in (0.3, 0.7, 0.999):
        path.write_bytes(whole.data[: int(share * len(whole.data))])
        log = read(path)
        count = len(log.records)
        assert log.records == whole.log.records[:count]
        assert replayed(log)[:count] == log.records
        assert first_difference(log, settings_of(log)) is None
    assert not log.complete


def test_cut_between_an_event_and_its_decisions():
    log = played().log
    last = next(n for n, r in enumerate(log.records) if isinstance(r, Calibrated))
    cut = replace(log, records=log.records[:last], complete=False)
    assert len(replayed(cut)) > last
    assert first_difference(cut, settings_of(log)) is None
    assert first_difference(replace(cut, complete=True), settings_of(log)) is not None


def test_a_changed_decision_and_a_changed_event_are_found():
    log = played().log
    settings = settings_of(log)
    at = next(n for n, r in enumerate(log.records) if isinstance(r, Selected))
    forged = log.records.copy()
    forged[at] = msgspec.structs.replace(forged[at], probability=np.nextafter(forged[at].probability, 1.0))
    number, old, new = first_difference(replace(log, records=forged), settings)
    assert (old, new) == (forged[at], log.records[at])
    assert number == sum(not isinstance(r, EVENTS) for r in log.records[:at])
    at = next(n for n, r in enumerate(log.records) if isinstance(r, RobotState) and r.t > 12.0)
    moved = log.records.copy()
    moved[at:] = [msgspec.structs.replace(r, xy=(0.5, 0.4)) if isinstance(r, RobotState) else r for r in moved[at:]]
    assert first_difference(replace(log, records=moved), settings) is not None


def test_one_seed_is_one_session_byte_for_byte():
    assert play_anew(*KINDS[1]).data == played(*KINDS[1]).data


def test_another_seed_is_another_session():
    one, other = played().log.records, play_anew(seed=6).log.records
    assert one[:200] != other[:200]


def test_a_fresh_interpreter_with_other_hashes_gives_the_same_bytes(tmp_path):
    room = written_room(tmp_path / "room.toml", ROOM)
    command = ["-m", "armspan", "run", room, "--pace", "fast", "--seconds", "90", "--log", tmp_path / "again.mcap"]
    process = fresh(*command, PYTHONHASHSEED="4711")
    _, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert (tmp_path / "again.mcap").read_bytes() == played().data


@pytest.mark.parametrize("kind", KINDS[:2], ids=str)
def test_a_room_replayed_from_a_log_decides_the_same(kind, tmp_path, capsys):
    whole = played(*kind)
    (tmp_path / "old.mcap").write_bytes(whole.data)
    settings = whole.house.settings
    assert settings.body.covariance is None  # TOML has no null, and another name for it
    body = {k: v for k, v in msgspec.to_builtins(settings.body).items() if v is not None}
    room = ROOM | {
        "posture": kind[0],
        "body": body,
        "bands": [
            {"kind": "replay", "log": "old.mcap", "name": band.name, "segment": band.segment} for band in settings.bands
        ],
        "robots": [{"kind": "replay", "log": "old.mcap", "name": name} for name in settings.robots],
    }
    command = ["run", written_room(tmp_path / "room.toml", room), "--pace", "fast", "--log", tmp_path / "new.mcap"]
    assert code_of(*command) == 0
    new = read(tmp_path / "new.mcap")
    assert settings_of(new) == settings
    assert new.records == whole.log.records
    assert [type(r) for r in new.records[-2:]] == [Press, Stop]
    assert (tmp_path / "new.mcap").read_bytes() == whole.data
