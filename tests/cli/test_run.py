import json

import pytest

from armspan.devices.simulated import SimulatedSwarm
from armspan.log import read
from armspan.records import GoTo, ImuSample, Press, RobotState, Stop, Tick
from armspan.swarm.errands import Errands
from command_line import code_of, refused, toml, written_room
from small_rooms import ROOM, played

ROBOTS, BANDS = ROOM["robots"], ROOM["bands"]
BODY = {"eye_height_m": 1.6, "shoulder_to_eye_m": [0.06, 0.15, 0.22], "shoulder_to_fingertip_m": 0.72}


def replayed(log="old.mcap", names=("ash", "elm"), band="wrist"):
    """The small room with all devices from a log."""
    bands = [{"kind": "replay", "log": log, "name": band}]
    return ROOM | {
        "body": BODY,
        "bands": bands,
        "robots": [{"kind": "replay", "log": log, "name": name} for name in names],
    }


def test_a_room_runs_and_tells_what_happened(tmp_path, capsys):
    room = written_room(tmp_path / "room.toml", ROOM)
    log = tmp_path / "deep" / "down" / "a.mcap"
    assert code_of("run", room, "--pace", "fast", "--seconds", "4", "--log", log, "--json") == 0
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert (document["seconds"], document["dropped"], document["not_finite"]) == (4.0, 0, 0)
    assert document["calibration"]["found"] is False
    assert document["log"] == str(log)
    assert "Stretch your arm" in err
    assert sum(isinstance(r, Tick) for r in read(log).records) == 80


def test_the_log_has_the_rooms_name_and_a_person_reads_a_table(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written_room(tmp_path / "lab.toml", ROOM)
    assert code_of("run", "lab.toml", "--pace", "fast", "--seconds", "1") == 0
    assert "What the session showed" in capsys.readouterr().out
    [log] = (tmp_path / "sessions").iterdir()
    assert log.name.endswith("_lab.mcap")


def test_live_pace_takes_its_time(tmp_path, monkeypatch):
    slept = []

    async def sleep(seconds):
        slept.append(seconds)

    monkeypatch.setattr("armspan.session.asyncio.sleep", sleep)
    room = written_room(tmp_path / "room.toml", ROOM)
    assert code_of("run", room, "--seconds", "1", "--log", tmp_path / "a.mcap") == 0
    assert len(slept) == 21  # twenty steps and the last wait
    assert max(slept) > 0.04


def test_seconds_end_a_replayed_room_too(tmp_path):
    (tmp_path / "old.mcap").write_bytes(played().data)
    room = written_room(tmp_path / "room.toml", replayed())
    assert code_of("run", room, "--pace", "fast", "--seconds", "3", "--log", tmp_path / "a.mcap") == 0
    new = read(tmp_path / "a.mcap").records
    assert 2.9 < new[-1].t <= 3.0
    assert new[:-2] == [r for r in played().log.records if r.t <= 3.0][: len(new) - 2]


def test_a_replayed_band_beside_simulated_robots_ends_with_the_log(tmp_path):
    (tmp_path / "old.mcap").write_bytes(played().data)
    room = written_room(tmp_path / "room.toml", replayed() | {"robots": ROBOTS})
    assert code_of("run", room, "--pace", "fast", "--log", tmp_path / "a.mcap") == 0
    new, old = read(tmp_path / "a.mcap").records, played().log.records
    assert [r for r in new if isinstance(r, ImuSample)] == [r for r in old if isinstance(r, ImuSample)]
    assert any(isinstance(r, GoTo) for r in new)
    assert any(isinstance(r, RobotState) for r in new)
    assert new[-1].t == pytest.approx(old[-1].t, abs=0.11)


def test_a_cut_log_is_replayed_and_told(tmp_path, capsys):
    (tmp_path / "old.mcap").write_bytes(played().data[:300_000])
    room = written_room(tmp_path / "room.toml", replayed())
    assert code_of("run", room, "--pace", "fast", "--log", tmp_path / "a.mcap") == 0
    count = len(read(tmp_path / "old.mcap").records)
    assert f"old.mcap was cut off; its {count} whole records are used" in capsys.readouterr().err
    new = read(tmp_path / "a.mcap").records[:-2]
    assert new == played().log.records[: len(new)]
    assert len(new) >= count


def test_a_behaviour_that_fails_stops_the_robots_and_closes_the_log(tmp_path, monkeypatch):
    sent, send = [], SimulatedSwarm.send

    def fail(errands, t, states):
        if t > 1.0:
            raise RuntimeError("a mistake in a behaviour")
        return []

    async def spy(swarm, command):
        sent.append(command)
        await send(swarm, command)

    monkeypatch.setattr(Errands, "step", fail)
    monkeypatch.setattr(SimulatedSwarm, "send", spy)
    room = written_room(tmp_path / "room.toml", ROOM)
    with pytest.raises(RuntimeError, match="a mistake in a behaviour"):
        code_of("run", room, "--pace", "fast", "--log", tmp_path / "a.mcap")
    assert sent[-1] == Stop(sent[-1].t, None, "quit")
    log = read(tmp_path / "a.mcap")
    assert log.complete
    assert log.records[-2:] == [Press(sent[-1].t, "quit"), sent[-1]]
    assert 1.0 < sent[-1].t < 1.2


def refused_room(capsys, folder, room, *more):
    path = folder / "room.toml"
    path.write_text(room, encoding="utf-8") if isinstance(room, str) else written_room(path, room)
    message = refused(capsys, folder, "run", path, "--pace", "fast", "--seconds", "1", *more)
    return message.removeprefix("armspan run: ")


def test_a_room_file_that_cannot_be_read(tmp_path, capsys):
    missing = tmp_path / "none.toml"
    message = refused(capsys, tmp_path, "run", missing)
    assert f"{missing} cannot be read: No such file or directory." in message
    assert f"`armspan init {missing}` writes one" in message
    assert "cannot be read: Is a directory" in refused(capsys, tmp_path, "run", tmp_path)
    assert "is not TOML: " in refused_room(capsys, tmp_path, "[sheet\nwidth = 1")
    (tmp_path / "room.toml").write_bytes(b"\xff\xfe")
    assert "is not TOML: " in refused(capsys, tmp_path, "run", tmp_path / "room.toml")


CROSSED = [{"name": "bow", "polygon_m": [[0.1, 0.1], [0.3, 0.3], [0.3, 0.1], [0.1, 0.3]]}]
OUTSIDE = [{"name": "far", "polygon_m": [[0.5, 0.1], [0.61, 0.1], [0.5, 0.3]]}]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"colour": "red"}, "at the top of the file: object contains unknown field `colour`"),
        ({"bands": [BANDS[0] | {"rate": 50}]}, "at bands[0]: object contains unknown field `rate`"),
        ({"zones": CROSSED}, "zone 'bow' crosses itself"),
        ({"zones": OUTSIDE}, "zone 'far' reaches outside the sheet of 0.6 x 0.45 m"),
        ({"robots": [ROBOTS[0], ROBOTS[0]]}, "robot 'ash' is named twice"),
        ({"bands": [BANDS[0] | {"segment": "upperarm"}]}, "pointing needs one band on the forearm"),
        ({"robots": [ROBOTS[0] | {"start_m": [0.7, 0.1]}]}, "the start of robot 'ash', (0.7, 0.1) lies off the sheet"),
        ({"simulation": {"seed": -1}}, "seed = -1"),
    ],
)
def test_a_room_that_cannot_be_is_one_sentence_with_the_file(tmp_path, capsys, change, told):
    message = refused_room(capsys, tmp_path, ROOM | change)
    assert message.startswith(f"{tmp_path / 'room.toml'}: ")
    assert told in message


def test_replayed_logs_that_are_missing_or_no_logs(tmp_path, capsys):
    message = refused_room(capsys, tmp_path, replayed())
    assert f"{tmp_path / 'old.mcap'} does not exist" in message
    (tmp_path / "old.mcap").write_text("t,x,y\n")
    assert "is not an MCAP file: it begins with b't,x,y" in refused_room(capsys, tmp_path, replayed())
    (tmp_path / "old.mcap").write_bytes(b"")
    assert "is empty" in refused_room(capsys, tmp_path, replayed())
    (tmp_path / "old.mcap").write_bytes(played().data[:60])
    assert "ends before its header is whole" in refused_room(capsys, tmp_path, replayed())


def test_devices_that_a_log_does_not_hold(tmp_path, capsys):
    (tmp_path / "old.mcap").write_bytes(played().data)
    message = refused_room(capsys, tmp_path, replayed(names=("ash", "oak")))
    assert "old.mcap: device 'oak' does not exist; there are: ash, elm, wrist" in message
    assert "Did you mean 'wrist'?" in refused_room(capsys, tmp_path, replayed(band="wrists"))


def test_a_simulated_person_cannot_point_at_replayed_robots(tmp_path, capsys):
    (tmp_path / "old.mcap").write_bytes(played().data)
    message = refused_room(capsys, tmp_path, replayed() | {"bands": BANDS})
    assert "robot 'ash' is replayed, but a simulated person can only point at simulated robots" in message


def test_logs_are_kept(tmp_path, capsys):
    log = tmp_path / "old.mcap"
    log.write_bytes(played().data)
    assert f"{log} exists already" in refused_room(capsys, tmp_path, ROOM, "--log", log)
    message = refused_room(capsys, tmp_path, replayed(), "--overwrite", "--log", log)
    assert "is a log that the room replays, and is kept" in message
    assert "cannot be a folder" in refused_room(capsys, tmp_path, ROOM, "--log", log / "a.mcap")
    assert "cannot be created" in refused_room(capsys, tmp_path, ROOM, "--overwrite", "--log", tmp_path)


@pytest.mark.parametrize("seconds", ["0", "-3", "inf", "ten"])
def test_seconds_must_be_a_number_above_zero(tmp_path, capsys, seconds):
    room = written_room(tmp_path / "room.toml", ROOM)
    assert "is not a number of seconds above zero" in refused(capsys, tmp_path, "run", room, f"--seconds={seconds}")


def test_an_error_shows_its_traceback_only_when_asked(tmp_path):
    with pytest.raises(ValueError, match="cannot be read"):
        code_of("--debug", "run", tmp_path / "none.toml")


def test_the_rooms_of_these_tests_are_toml():
    assert toml({"a": [0.1, "x"], "b": {"c": True}}) == '{a = [0.1, "x"], b = {c = true}}'
