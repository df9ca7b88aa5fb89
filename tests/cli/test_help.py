import os
import re

import pytest

import armspan
from armspan.cli import main, parser
from command_line import code_of, fresh

VERBS = (
    "demo",
    "run",
    "swarm",
    "init",
    "body",
    "calibrate",
    "record",
    "takes",
    "train",
    "evaluate",
    "spot",
    "study",
    "replay",
    "check",
    "emulate",
    "wire",
)


def printed(capsys, *words):
    assert code_of(*words) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def test_help_lists_each_verb_with_a_line(capsys):
    out = printed(capsys, "--help")
    verbs = re.findall(r"^    (\w+)\s+(\S.{10,})$", out, re.MULTILINE)
    assert [name for name, _ in verbs] == list(VERBS)


@pytest.mark.parametrize("verb", VERBS)
def test_each_verb_tells_its_options(verb, capsys):
    out = printed(capsys, verb, "--help")
    assert out.startswith(f"usage: armspan {verb} ")
    actions = next(a for a in parser()._actions if a.dest == "verb").choices[verb]._actions
    for action in actions:
        named = action.option_strings[-1] if action.option_strings else action.metavar
        assert named in out
    options = [a for a in actions if a.option_strings]
    assert all(a.help for a in options), [a.option_strings for a in options if not a.help]


def test_version(capsys):
    assert printed(capsys, "--version") == f"armspan {armspan.__version__}\n"


@pytest.mark.parametrize("words", [(), ("fly",), ("--fly",), ("demo", "--fly"), ("replay",), ("calibrate", "a.csv")])
def test_wrong_command_lines_are_one_sentence(words, capsys):
    assert code_of(*words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert re.match(r"armspan( \w+)?: ", err)
    assert "--help`" in err


def test_a_reader_that_has_seen_enough_is_no_error(tmp_path):
    process = fresh("-m", "armspan", "check", "--json")
    process.stdout.close()
    process.stdout = open(os.devnull)  # noqa: SIM115 - communicate closes it
    _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")


def test_ctrl_c_is_130(monkeypatch, capsys):
    def interrupt(args):
        raise KeyboardInterrupt

    monkeypatch.setattr("armspan.cli.check.run", interrupt)
    assert main(["check"]) == 130
    assert capsys.readouterr().err == "armspan check: interrupted\n"
