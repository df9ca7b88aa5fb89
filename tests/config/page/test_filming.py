import io
import zipfile
import zlib
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from armspan.config.page import filming
from armspan.config.page.filming import Trouble, main, opening, recalled, seconds_of, write_frames
from armspan.errors import LogError
from armspan.log import read
from armspan.records import Pointed
from armspan.web.film import Opening, Second

GOLDEN = Path(__file__).parents[2] / "sessions" / "small.mcap"


@pytest.fixture(scope="module")
def log():
    return read(GOLDEN)


@pytest.fixture(scope="module")
def seconds(log):
    return list(seconds_of(log))


def messages(data):
    """The parts of a stream in which each stands behind its length."""
    stream, found = io.BytesIO(data), []
    while length := stream.read(4):
        found.append(stream.read(int.from_bytes(length, "little")))
    return found


def test_every_second_of_a_log_has_its_twenty_frames(log, seconds):
    assert len(seconds) == int(log.arrivals[-1]) + 1
    assert {len(second.frames) for second in seconds[:-1]} == {20}
    assert [second.frames[10]["t"] for second in seconds[1:]] == pytest.approx(
        [k + 0.55 for k in range(1, len(seconds))], abs=0.06
    )


def test_frames_show_what_the_log_says_was_decided(log, seconds):
    told = [record for record in log.records if isinstance(record, Pointed) and record.robot is not None]
    shown = seconds[int(told[-1].t)].frames[-1]["at"]
    assert shown["robot"] == told[-1].robot
    assert seconds[0].room["robots"] == ["ash", "elm"]
    assert seconds[-1].frames[-1]["arms"]


def test_a_longer_log_is_cut_and_that_is_said(log, monkeypatch):
    monkeypatch.setattr(filming, "LONGEST", 3)
    assert len(list(seconds_of(log))) == 3
    assert opening(log) == Opening(3.0, True, "The log lasts 0 minutes; the first 0 are shown.")
    assert "cut off" in opening(replace(log, complete=False)).note


def test_settings_of_another_version_are_refused_in_words(log):
    with pytest.raises(LogError, match=r"small\.mcap has settings that this version"):
        recalled(replace(log, header={"settings": {"colour": "red"}}))


def test_the_stream_holds_an_opening_and_then_the_seconds(monkeypatch):
    monkeypatch.setattr(filming, "LONGEST", 4)
    out = io.BytesIO()
    write_frames(GOLDEN, out)
    first, *rest = messages(out.getvalue())
    assert msgspec.json.decode(first, type=Opening).seconds == 4.0
    assert len(rest) == 4
    assert len(msgspec.json.decode(zlib.decompress(rest[3]), type=Second).frames) == 20


def test_what_goes_wrong_is_one_message(tmp_path, capfdbinary):
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"no log at all")
    main(["frames", str(broken)])
    (said,) = messages(capfdbinary.readouterr().out)
    assert "is not an MCAP file" in msgspec.json.decode(said, type=Trouble).trouble


def test_tables_are_zipped(tmp_path):
    main(["tables", str(GOLDEN), str(tmp_path / "small.zip")])
    with zipfile.ZipFile(tmp_path / "small.zip") as tables:
        assert {"ImuSample.csv", "Selected.csv"} <= set(tables.namelist())
        assert tables.read("Selected.csv").startswith(b"order,arrived,t,source,robot")
