import json
import math

import pytest

from armspan.cli.swarm_report import print_run
from armspan.log import read
from armspan.records import GoTo, Press, Stop
from armspan.swarm.director import BEHAVIOURS, DICTIONARY
from command_line import code_of, fresh, refused, written_room
from small_rooms import ROOM


def document(capsys, *words):
    assert code_of("swarm", *words, "--json") == 0
    out, err = capsys.readouterr()
    assert words[0] == "stop" or "asked for" in err
    return json.loads(out)


def test_the_document_tells_the_run_and_its_account(capsys):
    words = (
        "random_walk",
        "--robots",
        "3",
        "--seconds",
        "4",
        "--seed",
        "7",
        "--latency-ms",
        "50",
        "--sheet",
        "0.9x0.7",
    )
    found = document(capsys, *words)
    assert found["behaviour"] == "random-walk"
    assert (found["robots"], found["seconds"], found["seed"], found["latency_ms"]) == (3, 4.0, 7, 50.0)
    assert (found["plant"], found["sheet_m"], found["simulated"]) == ("cellulo", [0.9, 0.7], True)
    assert found["limits"]["latency_s"] == pytest.approx(0.08)
    assert set(found["coverage"]) >= {"t50", "t90", "t95", "t99", "share_end", "of_coverable"}
    assert found["finished_s"] is None
    assert found["collisions"] == 0
    assert found["min_gap_mm"] > 0
    # three robots drive 4 s at most at 0.15 m/s, of which they begin a little late
    assert 0.3 < found["path_m"]["total"] < 3 * 4 * 0.165
    area = 0.9 * 0.7
    assert 3 * math.pi * 0.0375**2 / area < found["coverage"]["share_end"] < (3 * 0.6 * 0.075 + 0.02) / area


def test_one_disc_sweeps_a_square_in_the_time_that_it_takes(capsys):
    found = document(capsys, "sweep", "--plant", "disc", "--robots", "1", "--sheet", "0.4x0.4", "--seconds", "22")
    bound = (
        0.9 * 0.16 / (0.15 * 0.075)
    )  # 12.8 s to pass over nine tenths, by nobody to be beaten but by the disc's ends
    assert bound - 1.0 < found["coverage"]["t90"] < bound + 6.0
    assert found["finished_s"] < 20
    assert found["violations"] == {}
    assert found["min_gap_mm"] is None


def test_deployed_discs_reach_the_optimum(capsys):
    found = document(capsys, "deploy", "--plant", "disc", "--robots", "4", "--seconds", "20", "--seed", "3")
    assert found["locational_cost"] == pytest.approx(1 / 24, rel=0.02)
    assert found["deadlocks"] == 0


def test_a_zone_is_the_area_that_counts(capsys):
    zone = "0.1,0.1 0.5,0.1 0.5,0.5 0.1,0.5"
    found = document(capsys, "sweep", "--zone", zone, "--robots", "1", "--seconds", "30", "--plant", "disc")
    assert found["behaviour"] == "sweep@zone-1"
    assert found["coverage"]["share_end"] > 0.95
    assert found["path_m"]["total"] < 3.5  # of the whole sheet 13 m


def test_a_person_reads_a_table_and_a_verdict(capsys):
    assert code_of("swarm", "gather", "--robots", "2", "--seconds", "8") == 0
    out, err = capsys.readouterr()
    assert out.startswith("gather: 2 virtual Cellulos on 1 x 1 m for 8 s, seed 0, simulated")
    for row in ("Covered", "Locational cost", "Paths", "Least gap", "Stuck robots", "Collisions", "Violations"):
        assert row in out
    assert " ".join(out.split()).endswith("without a collision, a violation or a stuck robot.")
    assert "asked for: come together" in err


def test_picture_and_log_are_written(capsys, tmp_path):
    picture, log = tmp_path / "new" / "a.png", tmp_path / "a.mcap"
    words = ("come", "--user=-0.3,0.5", "--robots", "2", "--seconds", "2", "--picture", picture, "--log", log)
    found = document(capsys, *words)
    assert (found["picture"], found["log"]) == (str(picture), str(log))
    assert picture.read_bytes().startswith(b"\x89PNG")
    file = read(log)
    assert file.complete
    assert file.header["behaviour"] == "come"
    presses = [(record.name, record.value) for record in file.records if isinstance(record, Press)]
    assert presses == [("user", "-0.300000 0.500000"), ("behaviour", "come"), ("quit", "")]
    assert any(isinstance(record, GoTo) for record in file.records)
    assert isinstance(file.records[-1], Stop)
    assert "exists" in refused(capsys, tmp_path, *("swarm", *words))
    assert code_of("swarm", *words, "--overwrite", "--json") == 0


def test_a_room_brings_its_robots(capsys, tmp_path):
    room = written_room(tmp_path / "room.toml", ROOM)
    found = document(capsys, "patrol", "--room", room, "--seconds", "2")
    assert list(found["path_m"]["robots"]) == ["ash", "elm"]
    assert found["sheet_m"] == [0.6, 0.45]
    for option in (("--robots", "3"), ("--sheet", "1x1"), ("--zone", "0,0 1,0 0,1"), ("--start", "line")):
        told = refused(capsys, tmp_path, "swarm", "patrol", "--room", room, *option)
        assert f"--room and {option[0]} do not go together" in told


def test_stop_stops(capsys):
    found = document(capsys, "stop", "--seconds", "2")
    assert found["path_m"]["total"] < 0.001
    assert found["violations"] == {}


def test_all_behaviours_and_the_dictionary_are_listed(capsys):
    assert code_of("swarm", "--list") == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert all(name in out for name in (*BEHAVIOURS, *DICTIONARY))
    assert code_of("swarm", "--list", "--json") == 0
    listed = json.loads(capsys.readouterr().out)
    assert set(listed["behaviours"]) == set(BEHAVIOURS)
    assert listed["gestures"] == DICTIONARY
    assert all(len(line) > 20 for line in listed["behaviours"].values())


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "no behaviour is named; `armspan swarm --list` tells them"),
        (("dance",), "behaviour 'dance' does not exist; there are: come, deploy, deploy-field,"),
        (("gather", "--robots", "many"), "'many' is not a whole number from 1"),
        (("gather", "--robots", "200"), "200 robots do not fit on a sheet of 1 x 1 m"),
        (("gather", "--seconds", "-1"), "'-1' is not a number of seconds above zero"),
        (("gather", "--latency-ms", "nan"), "'nan' is not a latency from 0 to 450 milliseconds"),
        (("gather", "--sheet", "1"), "'1' is not a size in metres such as 0.8x0.6"),
        (("gather", "--sheet", "0x1"), "'0x1' is not a size between 0.05 and 20 metres"),
        (("gather", "--point", "1;2"), "'1;2' is not a place in metres such as 0.2,0.5"),
        (("gather", "--point", "inf,0"), "'inf,0' is not a place"),
        (("gather", "--point", "2,2"), "the pointed spot (2.0, 2.0) lies off the sheet"),
        (("sweep", "--zone", "0.1,0.1 0.5"), "'0.5' is not a place"),
        (("sweep", "--zone", "0.1,0.1 0.5,0.5"), "zone 'zone-1' has 2 corners"),
        (("sweep", "--zone", "0.1,0.1 0.5,0.5 0.5,0.1 0.1,0.5"), "zone 'zone-1' crosses itself"),
        (("sweep", "--zone", "0.1,0.1 1.5,0.5 0.5,0.1"), "zone 'zone-1' reaches outside the sheet"),
        (("sweep@lake",), "zone 'lake' does not exist; there are: none"),
        (("come",), "come goes to the user"),
        (("gather", "--room", "none.toml"), "none.toml cannot be read"),
        (("gather", "--relay", "here"), "'here' is not a relay such as 127.0.0.1:2556"),
        (("gather", "--relay", "h:1", "--plant", "disc"), "--relay and --plant do not go together"),
        (("gather", "--macs", "a"), "--macs are addresses behind a relay"),
        (("gather", "--relay", "h:1", "--macs", "a,b", "--robots", "3"), "--macs has 2 addresses for 3 robots"),
        (("gather", "--relay", "h:1", "--macs", "a,b"), "robot 'r1' has the address 'a'"),
        (("gather", "--log", "a", "--picture", "a"), "a would be both the log and the picture"),
        (("gather", "--picture", "."), ". is a folder"),
    ],
)
def test_bad_input_is_refused_in_words(capsys, tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    assert told in refused(capsys, tmp_path, "swarm", *words)


def test_a_run_behind_a_relay(capsys, tmp_path):
    what = ("cellulo", "--robots", "2", "--port", "0", "--seed", "1")
    emulator = fresh("-m", "armspan", "emulate", *what)
    try:
        where = emulator.stdout.readline().split()[-1]
        found = document(capsys, "disperse", "--relay", where, "--robots", "2", "--seconds", "2.5")
    finally:
        emulator.terminate()
        emulator.communicate()
    assert (found["plant"], found["simulated"], found["sheet_m"]) == ("relay", False, [0.8, 0.6])
    assert found["seconds"] == pytest.approx(2.5, abs=0.3)
    assert found["path_m"]["total"] > 0.1
    assert found["collisions"] == 0


def test_robots_that_were_stopped_are_told(capsys):
    what = ("cellulo", "--robots", "2", "--port", "0", "--seed", "1", "--link-loss-at", "2.5")
    emulator = fresh("-m", "armspan", "emulate", *what)
    try:
        where = emulator.stdout.readline().split()[-1]
        found = document(capsys, "random-walk", "--relay", where, "--robots", "2", "--seconds", "3.5")
    finally:
        emulator.terminate()
        emulator.communicate()
    assert found["stopped"] == {"r1": "its link is down", "r2": "its link is down"}
    print_run(found)
    assert "with 2 robots stopped." in " ".join(capsys.readouterr().out.split())


def test_a_runs_log_replays_to_itself(tmp_path, capsys):
    path = tmp_path / "swarm.mcap"
    document(capsys, "gather", "--robots", "3", "--seconds", "4", "--log", str(path))
    assert code_of("replay", str(path), "--check") == 0
    assert capsys.readouterr().out.startswith("equal: ")


def test_a_run_that_never_begins_leaves_an_older_log(tmp_path, capsys, monkeypatch):
    path = tmp_path / "old.mcap"
    path.write_text("mine\n")
    monkeypatch.setattr("armspan.config.swarm_act.HEARD", 0.2)
    words = ("gather", "--log", path, "--overwrite", "--relay", "127.0.0.1:9")
    assert code_of("swarm", *words) == 2
    assert "not heard" in capsys.readouterr().err
    assert path.read_text() == "mine\n"
    assert [found.name for found in tmp_path.iterdir()] == ["old.mcap"]


def test_the_emulator_keeps_a_truth_that_was_told_before(tmp_path, capsys):
    path = tmp_path / "truth.jsonl"
    path.write_text("mine\n")
    assert "exists and is kept" in refused(capsys, tmp_path, "emulate", "cellulo", "--port", 0, "--truth", path)
    assert path.read_text() == "mine\n"
