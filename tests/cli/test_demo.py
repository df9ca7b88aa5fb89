import json
import signal
import time

import pytest

from armspan.cli.replay import first_difference
from armspan.config.recalled import settings_of
from armspan.log import read
from armspan.records import Press, Selected, Stop
from command_line import code_of, contents, fresh, refused


def test_json_tells_what_the_log_holds(tmp_path):
    process = fresh(
        "-m", "armspan", "demo", "--headless", "--seconds", "60", "--log", "new/a.mcap", "--json", cwd=tmp_path
    )
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    document = json.loads(out)
    assert err == ""
    assert [path.name for path in contents(tmp_path)] == ["new", "a.mcap", "a.png"]
    assert document["picture"] == "new/a.png"
    assert (tmp_path / "new" / "a.png").read_bytes().startswith(b"\x89PNG")
    assert document["simulated"] is True
    assert (document["seed"], document["arm"], document["bands"]) == (1, "straight", 1)
    assert document["calibration"]["found"] is True
    assert document["calibration"]["pairs"] == 4
    assert 0 < document["calibration"]["sheet_rms_mm"] < 500
    assert document["safety"]["violations"] == 0
    assert document["safety"]["least_gap_mm"] > 5
    log = read(tmp_path / document["log"])
    trials = [r for r in log.records if isinstance(r, Press) and r.name == "trial" and not r.value]
    assert document["selection"]["shown"] == len(trials) >= 1
    chosen = sum(isinstance(r, Selected) for r in log.records)
    assert document["selection"]["decided"] + document["selection"]["unasked"] == chosen
    assert 0 < document["step_us"]["p50"] <= document["step_us"]["p99"]
    assert log.complete
    assert log.records[-1].t == pytest.approx(60.0)


def test_by_default_the_log_has_the_date_and_a_person_reads_a_table(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        assert code_of("demo", "--seconds", "2", "--seed", "3", "--bands", "2", "--arm", "natural") == 0
    out, err = capsys.readouterr()
    assert "The demo, seed 3, natural arm, two bands, simulated" in out
    assert "Calibration" in out
    assert "0 violations" in out
    assert "0.5 s  Stretch your arm straight forward" in err
    logs = sorted((tmp_path / "sessions").glob("*_demo*.mcap"))
    assert len(logs) == 2
    assert len(list((tmp_path / "sessions").glob("*.png"))) == 2


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--seed", "x"), "'x' is not a whole number from 0"),
        (("--seed", "-1"), "--seed"),
        (("--seconds", "0"), "'0' is not a number of seconds above zero"),
        (("--seconds", "nan"), "'nan' is not a number of seconds above zero"),
        (("--bands", "3"), "--bands"),
        (("--arm", "bent"), "'bent'"),
        (("--speed", "9"), "--speed"),
    ],
)
def test_wrong_options_are_one_sentence(tmp_path, monkeypatch, capsys, words, told):
    monkeypatch.chdir(tmp_path)
    message = refused(capsys, tmp_path, "demo", "--headless", *words)
    assert told in message
    assert "armspan demo --help" in message


def test_what_exists_is_kept(tmp_path, capsys):
    log, picture = tmp_path / "a.mcap", tmp_path / "a.png"
    log.write_bytes(b"a year of work")
    command = ["demo", "--headless", "--seconds", "1", "--log", log]
    assert f"{log} exists already" in refused(capsys, tmp_path, *command)
    picture.write_bytes(b"another one")
    assert f"{picture} exists" in refused(capsys, tmp_path, *command)
    log.unlink()
    assert f"{picture} exists" in refused(capsys, tmp_path, *command)
    assert code_of(*command, "--overwrite") == 0
    assert read(log).complete
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_an_empty_file_may_be_filled(tmp_path):
    log = tmp_path / "a.mcap"
    log.touch()
    (tmp_path / "a.png").touch()
    assert code_of("demo", "--headless", "--seconds", "1", "--log", log) == 0
    assert read(log).complete


def test_places_where_nothing_can_be_written(tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("x")
    short = ["demo", "--headless", "--seconds", "1"]
    assert "cannot be a folder" in refused(capsys, tmp_path, *short, "--log", file / "a.mcap")
    assert "exists already" in refused(capsys, tmp_path, *short, "--log", tmp_path, "--picture", tmp_path / "p.png")
    assert "cannot be created" in refused(
        capsys, tmp_path, *short, "--overwrite", "--log", tmp_path, "--picture", tmp_path / "p.png"
    )
    log = tmp_path / "a.mcap"
    assert "is a folder" in refused(capsys, tmp_path, *short, "--log", log, "--picture", tmp_path)
    assert "cannot be a folder" in refused(capsys, tmp_path, *short, "--log", log, "--picture", file / "a.png")


def test_a_picture_does_not_replace_the_log(tmp_path, capsys):
    log = tmp_path / "a.png"
    message = refused(capsys, tmp_path, "demo", "--headless", "--seconds", "1", "--overwrite", "--log", log)
    assert "both the log and its picture" in message


# --- every way out stops the robots ------------------------------------------------------------------------


def interrupted(tmp_path, number):
    """A demo in time with the wall, sent a signal a moment in: exit code, stderr and the log."""
    path = tmp_path / "live.mcap"
    process = fresh("-m", "armspan", "demo", "--pace", "live", "--log", path, cwd=tmp_path)
    until = time.monotonic() + 30
    while time.monotonic() < until and (not path.exists() or path.stat().st_size < 50_000):
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    process.send_signal(number)
    out, err = process.communicate(timeout=30)
    assert out == ""
    return process.returncode, err, read(path)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_robots_and_closes_the_log(tmp_path, number):
    code, err, log = interrupted(tmp_path, number)
    assert code == 130
    assert err.splitlines()[-1] == "armspan demo: interrupted"
    assert "Traceback" not in err
    assert log.complete
    assert 0.5 < log.records[-1].t < 30
    quit_, stop = log.records[-2:]
    assert (quit_, stop) == (Press(stop.t, "quit"), Stop(stop.t, None, "quit"))
    assert first_difference(log, settings_of(log)) is None


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system has no SIGKILL")
def test_a_killed_session_leaves_a_log_that_can_be_read(tmp_path):
    code, _, log = interrupted(tmp_path, signal.SIGKILL)
    assert code == -signal.SIGKILL
    assert not log.complete
    assert log.records[-1].t > 0.5
    assert first_difference(log, settings_of(log)) is None
