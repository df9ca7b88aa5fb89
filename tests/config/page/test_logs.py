import asyncio
import os
import zipfile
from pathlib import Path

import pytest

from armspan.config.page import logs
from armspan.config.page.host import PageHost
from armspan.errors import LogError
from armspan.log import read
from small_rooms import small_room

GOLDEN = Path(__file__).parents[2] / "sessions" / "small.mcap"


@pytest.fixture
def host(tmp_path):
    folder = tmp_path / "sessions"
    folder.mkdir()
    found = PageHost(small_room(), "small", folder=tmp_path, sessions=folder)
    yield found
    found.logs.close()


def put(host, name, change=lambda data: data, at=1_000_000_000):
    path = host.sessions / name
    path.write_bytes(change(GOLDEN.read_bytes()))
    os.utime(path, (at, at))
    return path


def damaged(data):
    return data[:100_000] + b"\xff" * 10 + data[100_010:]


async def until(what, seconds=20.0):
    async with asyncio.timeout(seconds):
        while not what():
            await asyncio.sleep(0.01)


def test_the_latest_is_first_and_a_file_is_looked_into_once(host, monkeypatch):
    put(host, "2026-11-01_101500_a.mcap")
    put(host, "2026-11-02_101500_b.mcap")
    assert [log.room for log in host.logs.look()] == ["b", "a"]
    asked = []
    monkeypatch.setattr(
        logs, "looked_into", lambda path: asked.append(path.name) or (_ for _ in ()).throw(LogError(""))
    )
    assert [log.room for log in host.logs.look()] == ["b", "a"]
    assert asked == []
    (host.sessions / "2026-11-01_101500_a.mcap").unlink()
    assert [log.room for log in host.logs.look()] == ["b"]


@pytest.mark.parametrize("name", ["../secret.mcap", "nothing.mcap", "/etc/passwd", "list.json"])
def test_only_logs_of_the_folder_are_given_out(host, name):
    put(host, "a.mcap")
    (host.sessions / "list.json").write_text("[]")
    (host.sessions.parent / "secret.mcap").write_bytes(b"")
    with pytest.raises(LogError, match=r"a\.mcap"):
        host.logs.path(name)


def test_tables_come_as_a_zip_file_made_once(host):
    put(host, "a.mcap")
    made = asyncio.run(host.logs.tables("a.mcap"))
    with zipfile.ZipFile(made) as tables:
        assert "RobotState.csv" in tables.namelist()
    before = made.stat().st_mtime_ns
    assert asyncio.run(host.logs.tables("a.mcap")).stat().st_mtime_ns == before


def test_tables_of_a_damaged_log_are_refused_with_the_reason_and_what_is_whole_can_be_saved(host):
    put(host, "bad.mcap", damaged)
    with pytest.raises(LogError, match=r"^bad\.mcap: record \d+ on /armspan/\w+ does not decode"):
        asyncio.run(host.logs.tables("bad.mcap"))
    assert asyncio.run(host.logs.save("bad.mcap")) == "bad_recovered.mcap"
    assert read(host.sessions / "bad_recovered.mcap").complete


def test_a_log_is_shown_again_through_the_live_line_and_the_room_opens_after_it(host):
    put(host, "a.mcap")

    async def scene():
        try:
            await host.logs.replay("a.mcap")
            await until(lambda: host.shown.film is not None and host.shown.film.whole)
            film, seen = host.shown.film, host.shown.version
            film.seek(20.0)
            await until(lambda: host.shown.version > seen)
            frame = host.shown.frame()
            assert (frame["room"], host.shown.room()["robots"]) == (host.shown.room()["number"], ["ash", "elm"])
            assert 19.5 < frame["t"] < 21.5
            await host.press("stop")
            assert host.status.activity == "replaying"
            number = host.shown.room_number
            await host.steer()
            await until(lambda: host.status.activity == "steering" and host.shown.t > 0.1)
            assert host.shown.film is None
            assert host.shown.room()["number"] > number
        finally:
            await host.close()

    asyncio.run(scene())


def test_a_damaged_log_is_refused_before_what_runs_is_ended_and_told_in_the_list(host):
    put(host, "bad.mcap", damaged)

    async def scene():
        try:
            await host.steer()
            await until(lambda: host.session is not None)
            assert [log.readable for log in await host.logs.listed() if not log.open] == [True]
            with pytest.raises(LogError, match="does not decode"):
                await host.logs.replay("bad.mcap")
            with pytest.raises(LogError, match="is being written"):
                await host.logs.replay(Path(host.status.log).name)
            assert host.session is not None
            return await host.logs.listed()
        finally:
            await host.close()

    latest, bad = asyncio.run(scene())
    assert latest.open
    assert (bad.readable, "does not decode" in bad.trouble) == (False, True)
