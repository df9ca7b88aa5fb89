import errno
import io
import json
import os
import re
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from armspan.cli import study as verb
from armspan.study.pointing_error import readings, reproduction
from armspan.study.pointing_error.monte_carlo import TABLE, chunk_errors, chunks
from armspan.study.pointing_error.moving import RealRow
from armspan.study.pointing_error.reproduction import Reproduction
from armspan.study.pointing_error.sources import NAMES
from armspan.study.pointing_error.value import Values
from command_line import code_of, refused

DOCS = Path(__file__).parents[2] / "docs"
WORDS = ("study", "pointing-error")


@dataclass
class Run:
    """What one small run wrote, and what it had found."""

    code: int
    out: str
    err: str
    pictures: Path
    found: Reproduction
    values: Values


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """The verb, whole but small: fewer sizes, 100 calibrations, one virtual person, no other processes."""
    pictures = tmp_path_factory.mktemp("study") / "deep" / "pictures"
    out, err, found = io.TextIOWrapper(io.BytesIO(), encoding="utf-8"), io.StringIO(), []

    def kept(function):
        def call(*words, **options):
            found.append(function(*words, **options))
            return found[-1]

        return call

    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(reproduction, "FIGURE_SIZES", (-9, 9))
        patch.setattr(reproduction, "TABLE_SIZES", (5,))
        patch.setattr(readings, "DRAWS", 3)
        patch.setattr(os, "cpu_count", lambda: 1)
        patch.setattr(verb, "reproduction", kept(verb.reproduction))
        patch.setattr(verb, "study", kept(verb.study))
        code = code_of(*WORDS, "--json", "--count", "100", "--people", "1", "--seed", "3", "--picture", pictures)
    return Run(code, out.buffer.getvalue().decode(), err.getvalue(), pictures, *found)


@pytest.fixture
def found_already(small, monkeypatch):
    """What a run finds is what the small one found, at once."""
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    monkeypatch.setattr(verb, "reproduction", lambda: small.found)
    monkeypatch.setattr(verb, "study", lambda *words, **options: small.values)


@pytest.fixture
def nothing_is_computed(monkeypatch):
    """Bad input is to be found before minutes are spent."""
    monkeypatch.setattr(verb, "reproduction", lambda: pytest.fail("it was computed first"))


# --- results ------------------------------------------------------------------------------------------------


def test_json_is_one_object_with_every_part(small):
    assert small.code == 0
    assert small.out.count("\n") == 1
    document = json.loads(small.out)
    assert {part: set(document[part]) for part in document} == {
        "reproduction": {"figures", "curves", "optimised", "published", "maps", "unabsorbed"},
        "values": {"sources", "monte_carlo", "stops", "bands", "feedback", "moving", "miss_by_speed"},
    }
    values = document["values"]
    assert [part["calibrations"] for part in values["monte_carlo"]] == [100, 100]
    for part in values["monte_carlo"]:
        assert 0.0 < part["median_mm"] < part["p90_mm"] < part["p99_mm"]
        assert [line["source"] for line in part["budget"]] == [source["name"] for source in values["sources"]]
        assert sum(line["share"] for line in part["budget"]) == pytest.approx(1.0)
    assert all(row["simulated"] for part in ("stops", "bands", "moving") for row in values[part])
    assert values["miss_by_speed"] == []


def test_talk_goes_to_stderr(small):
    drawn, only = small.err.splitlines()
    assert drawn.startswith(f"armspan study: drawn in {small.pictures}: figure-1.3.2a.png, ")
    assert only == "armspan study: simulated only; --recordings DIR adds real people"


def test_the_pictures_are_those_of_the_page(small):
    drawn = {path.name for path in small.pictures.iterdir()}
    page = (DOCS / "where-errors-come-from.md").read_text(encoding="utf-8")
    assert drawn == set(re.findall(r"\]\(errors/([^)]+)\)", page))
    assert drawn == {path.name for path in (DOCS / "errors").iterdir()}
    assert all((small.pictures / name).read_bytes().startswith(b"\x89PNG") for name in drawn)
    assert drawn == set(small.err.splitlines()[0].rpartition(": ")[2].split(", "))


UNIT = re.compile(r"\b(mm|deg|seconds|%)(?=\b|\W|$)")


def test_tables_are_for_people_and_name_units(small, found_already, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "240")
    assert code_of(*WORDS) == 0
    out = capsys.readouterr().out
    told = " ".join(out.split())  # a title wider than its table is broken into lines
    for table in (*verb.tables(small.found), *verb.value_tables(small.values)):
        assert table.title in told
        assert UNIT.search(" ".join((table.title, *table.columns))), table.title
        assert {len(row) for row in table.rows} == {len(table.columns)}, table.title
    median = 1000.0 * small.values.monte_carlo[0].percentile(50)
    assert re.search(rf"table at 1 m\s*│\s*100\s*│\s*{median:.0f}\s*│", out)
    assert all(name in out for name in NAMES)


def test_sessions_that_could_not_be_fitted_are_dashes(small):
    rows = (RealRow("all samples", 5.0, 0, 3, float("nan"), float("nan")), RealRow("some", 5.0, 3, 0, 0.25, 0.02))
    *_, table = verb.value_tables(replace(small.values, followed=rows))
    assert table.title == "Static and moving pairs, real sessions"
    assert table.rows == (("all samples", "5", "0", "3", "-", "-"), ("some", "5", "3", "0", "250", "1.1"))


@pytest.mark.parametrize(("seed", "same"), [(3, True), (4, False)])
def test_one_seed_one_answer_and_another_another(seed, same, small, monkeypatch, capsys):
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    monkeypatch.setattr(verb, "reproduction", lambda: small.found)
    assert code_of(*WORDS, "--json", "--count", "100", "--people", "1", "--seed", seed) == 0
    assert (capsys.readouterr().out == small.out) is same


def test_real_recordings_are_handed_on(found_already, tmp_path, capsys, monkeypatch, small):
    asked = []
    monkeypatch.setattr(verb, "read_error_recordings", lambda folder: ("read from", folder))
    monkeypatch.setattr(verb, "study", lambda recordings, **options: asked.append(recordings) or small.values)
    assert code_of(*WORDS, "--json", "--recordings", tmp_path) == 0
    assert asked == [("read from", tmp_path)]
    assert capsys.readouterr().err == ""


def test_the_progress_is_on_stderr_where_somebody_looks(small, found_already, monkeypatch, capsys):
    def study(recordings, *, progress, **options):
        progress("the virtual part", 1, 2)
        return small.values

    monkeypatch.setattr(verb, "study", study)
    assert code_of(*WORDS, "--json") == 0
    out, err = capsys.readouterr()
    assert "the virtual part" not in err  # nobody looks
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert code_of(*WORDS, "--json") == 0
    watched, err = capsys.readouterr()
    assert watched == out
    assert "the virtual part" in err


# --- bad input ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--count", "0", "'0' is not a number of calibrations from 100 to 10000000"),
        ("--count", "-1", "'-1' is not a number of calibrations"),
        ("--count", "many", "'many' is not a number of calibrations"),
        ("--count", "150.5", "'150.5' is not a number of calibrations"),
        ("--count", "nan", "'nan' is not a number of calibrations"),
        ("--people", "0", "'0' is not a number of people from 1 to 10000"),
        ("--people", "two", "'two' is not a number of people"),
        ("--seed", "-1", "'-1' is not a seed from 0 to 4294967296"),
    ],
)
def test_a_number_out_of_range(option, value, words, capsys):
    assert code_of(*WORDS, option, value) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert err.startswith(f"armspan study pointing-error: argument {option}: {words}")


def test_no_study_named(capsys):
    assert "STUDY; see `armspan study --help`" in refused(capsys, DOCS / "errors", "study")


def test_missing_recordings_leave_no_folder_for_pictures(tmp_path, capsys, nothing_is_computed):
    options = ("--recordings", tmp_path / "nowhere", "--picture", tmp_path / "pictures")
    assert "nowhere is not a folder: name one that holds people/" in refused(capsys, tmp_path, *WORDS, *options)
    (tmp_path / "empty").mkdir()
    words = refused(capsys, tmp_path, *WORDS, "--recordings", tmp_path / "empty", *options[2:])
    assert "gestures.csv does not exist: --recordings names a folder" in words


@pytest.mark.parametrize("place", ["taken", "taken/below"])
def test_a_file_is_no_folder_for_pictures(place, tmp_path, capsys, nothing_is_computed):
    (tmp_path / "taken").write_text("mine")
    words = refused(capsys, tmp_path, *WORDS, "--picture", tmp_path / place)
    assert re.search(r"taken\S* cannot be a folder for pictures \(.+\): name another one with --picture", words)


def test_a_folder_that_may_not_be_written_is_refused_at_once(tmp_path, capsys, monkeypatch, nothing_is_computed):
    def refuse(dir):
        raise OSError(errno.EROFS, "Read-only file system", str(dir))

    monkeypatch.setattr(verb, "TemporaryFile", refuse)  # root may write where others may not
    words = refused(capsys, tmp_path, *WORDS, "--picture", tmp_path)
    assert "cannot be a folder for pictures (Read-only file system)" in words


# --- other processes, and every way out ---------------------------------------------------------------------


def test_other_cores_give_the_same_answer_and_leave_ctrl_c_to_the_command(small, monkeypatch, capsys):
    seen = []
    tasks = chunks(TABLE, 2600, 5)

    def study(recordings, *, mapper, **options):
        seen.extend(mapper(chunk_errors, tasks))
        seen.extend(mapper(signal.getsignal, [signal.SIGINT]))
        return small.values

    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(verb, "reproduction", lambda: small.found)
    monkeypatch.setattr(verb, "study", study)
    before = signal.getsignal(signal.SIGINT)
    assert code_of(*WORDS, "--json") == 0
    assert all(np.array_equal(one, chunk_errors(task)) for one, task in zip(seen[:2], tasks, strict=True))
    assert seen[2] is signal.SIG_IGN
    assert signal.getsignal(signal.SIGINT) is before


def begun():
    """A whole study that has begun, in a process group of its own."""
    process = subprocess.Popen(
        [sys.executable, "-m", "armspan", *WORDS, "--json"],
        env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "FORCE_COLOR": "1", "COLUMNS": "200"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    told = b""
    while b"section 1.3" not in told:
        told += (more := process.stderr.read1())
        assert more, told
    return process


@pytest.mark.skipif(os.name != "posix", reason="this system has no process groups")
def test_ctrl_c_is_told_once():
    process = begun()
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to the workers too, which may just be starting
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert out == b""
    assert err.endswith(b"armspan study: interrupted\n")
    assert b"Traceback" not in err


@pytest.mark.skipif(os.name != "posix", reason="this system has no signals for processes")
def test_a_killed_command_leaves_no_worker_behind():
    process = begun()
    process.kill()
    try:
        process.communicate(timeout=40)  # ends when the last worker has closed stderr
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL


def test_pictures_that_are_there_are_kept(tmp_path, capsys):
    (tmp_path / "bands.png").write_text("mine")
    message = refused(capsys, tmp_path, "study", "pointing-error", "--count", "100", "--picture", tmp_path)
    assert "bands.png exists and is kept" in message
