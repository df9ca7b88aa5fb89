import json
from functools import cache

import msgspec
import pytest

from armspan.log import LogWriter, read
from armspan.records import EVENTS, Pointed, Say, Selected
from command_line import code_of, refused
from small_rooms import played


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "a.mcap"
    path.write_bytes(played().data)
    return path


@cache
def decisions():
    return [record for record in played().log.records if not isinstance(record, EVENTS)]


def rewritten(path, change):
    """A log like that of the small room, with its records changed."""
    with LogWriter(path, played().log.header) as writer:
        for record in change(played().log.records):
            writer(record)
    return path


def test_decisions_as_json_a_line_each(log, capsys):
    assert code_of("replay", log, "--json") == 0
    out, err = capsys.readouterr()
    lines = [json.loads(line) for line in out.splitlines()]
    assert lines == [json.loads(msgspec.json.encode(record)) for record in decisions()]
    assert err == ""


def test_decisions_for_people(log, capsys):
    assert code_of("replay", log) == 0
    out = capsys.readouterr().out.splitlines()
    assert out == [str(record) for record in decisions()]


def test_check_tells_that_all_are_equal(log, capsys):
    assert code_of("replay", log, "--check") == 0
    events = len(played().log.records) - len(decisions())
    assert capsys.readouterr().out == f"equal: {len(decisions())} decisions from {events} events\n"
    assert code_of("replay", log, "--check", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["equal"], answer["decisions"], answer["differs_at"]) == (True, len(decisions()), None)


def test_check_finds_a_forged_decision(tmp_path, capsys):
    def forge(records):
        return [msgspec.structs.replace(r, robot="elm") if isinstance(r, Selected) else r for r in records]

    log = rewritten(tmp_path / "forged.mcap", forge)
    assert code_of("replay", log, "--check") == 1
    number = next(n for n, r in enumerate(decisions()) if isinstance(r, Selected))
    out = capsys.readouterr().out
    assert f"decision {number} differs" in out
    assert "robot='elm'" in out
    assert code_of("replay", log, "--check", "--json") == 1
    answer = json.loads(capsys.readouterr().out)
    assert (answer["equal"], answer["differs_at"]) == (False, number)
    assert (answer["logged"]["robot"], answer["replayed"]["robot"]) == ("elm", "ash")


def test_check_finds_decisions_too_many_and_too_few(tmp_path, capsys):
    more = rewritten(tmp_path / "more.mcap", lambda records: [*records, Say(99.0, "and then?")])
    assert code_of("replay", more, "--check") == 1
    assert "replayed: None" in capsys.readouterr().out
    fewer = rewritten(tmp_path / "fewer.mcap", lambda records: records[:-1])
    assert code_of("replay", fewer, "--check") == 1
    assert "logged:   None" in capsys.readouterr().out
    last = [r for r in decisions() if isinstance(r, Pointed)][-1]
    lost = rewritten(tmp_path / "lost.mcap", lambda records: [r for r in records if r is not last])
    assert code_of("replay", lost, "--check") == 1


def test_a_cut_log_is_used_as_far_as_it_goes(tmp_path, capsys):
    log = tmp_path / "cut.mcap"
    log.write_bytes(played().data[:400_000])
    assert code_of("replay", log, "--check") == 0
    out, err = capsys.readouterr()
    assert out.startswith("equal: ")
    assert err == f"{log} was cut off; its {len(read(log).records)} whole records are used\n"


def test_what_is_no_log_is_refused(tmp_path, capsys):
    log = tmp_path / "no.mcap"
    assert f"{log} does not exist; most like it are: none" in refused(capsys, tmp_path, "replay", log)
    log.write_text("hello")
    assert "is not an MCAP file" in refused(capsys, tmp_path, "replay", log)
    log.write_bytes(played().data[:60])
    assert "ends before its header is whole" in refused(capsys, tmp_path, "replay", log)
    assert "cannot be read (Is a directory)" in refused(capsys, tmp_path, "replay", tmp_path)
    damaged = bytearray(played().data)
    damaged[len(damaged) // 2] ^= 0xFF
    log.write_bytes(damaged)
    refused(capsys, tmp_path, "replay", log)


@pytest.mark.parametrize("header", [{}, {"settings": None}, {"settings": {"body": 3}}])
def test_a_log_with_other_settings_names_its_version(tmp_path, capsys, header):
    log = tmp_path / "old.mcap"
    with LogWriter(log, {"armspan": "9.9"} | header):
        pass
    message = refused(capsys, tmp_path, "replay", log, "--check")
    assert "has settings that this version of Armspan does not know" in message
    assert "replay it with version 9.9" in message


def test_settings_that_contradict_themselves_are_refused(tmp_path, capsys):
    log, header = tmp_path / "old.mcap", msgspec.to_builtins(played().log.header)
    header["settings"]["robots"] = ["ash", "ash"]
    with LogWriter(log, header):
        pass
    assert "robot 'ash' is named twice" in refused(capsys, tmp_path, "replay", log)
