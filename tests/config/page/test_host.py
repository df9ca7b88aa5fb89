import asyncio

import msgspec

from armspan.config.demo_room import page_room
from armspan.config.page.host import PageHost
from armspan.errors import DeviceError
from armspan.log import read
from armspan.records import Press, Stop


async def until(what, seconds=10.0):
    """Wait for something to become true."""
    async with asyncio.timeout(seconds):
        while not what():
            await asyncio.sleep(0.01)


def played(tmp_path, scene, room=None):
    """Let a host run a scene; what the scene gives back."""
    host = PageHost(room or page_room(1), "small", folder=tmp_path, sessions=tmp_path / "sessions")

    async def run():
        try:
            return await scene(host)
        finally:
            await host.close()

    return host, asyncio.run(run())


def test_a_room_opens_and_closes_with_its_robots_stopped_and_its_log_whole(tmp_path):
    async def scene(host):
        await host.steer()
        await until(lambda: host.status.activity == "steering" and host.shown.t > 0.3)
        assert host.status.simulated
        return host.status.log, [device.name for device in host.devices()]

    host, (path, names) = played(tmp_path, scene)
    log = read(path)
    assert (host.status.activity, host.status.trouble, log.complete) == ("idle", "", True)
    assert names[:2] == ["right wrist", "left wrist"]
    assert log.records[-1] == Stop(log.records[-1].t, None, "quit")


def test_presses_reach_the_session_and_its_log(tmp_path):
    async def scene(host):
        await host.press("stop")  # nothing runs: nothing happens
        await host.steer()
        await until(lambda: host.session is not None and host.shown.t > 0.2)
        await host.press("behaviour", "gather")
        await until(lambda: bool(host.shown.mind.sight().running))
        await host.press("stop")
        await until(lambda: host.shown.mind.sight().stopped)
        return host.status.log

    _, path = played(tmp_path, scene)
    pressed = [record.name for record in read(path).records if isinstance(record, Press)]
    assert pressed == ["behaviour", "stop", "quit"]


def test_a_room_that_cannot_open_says_why_and_the_next_one_opens(tmp_path):
    wrong = msgspec.structs.replace(
        page_room(1), gestures=msgspec.structs.replace(page_room(1).gestures, model="no.model")
    )

    async def scene(host):
        await host.steer()
        await until(lambda: host.status.activity == "idle")
        trouble = host.status.trouble
        host.room = page_room(1)
        await host.steer()
        await until(lambda: host.status.activity == "steering")
        return trouble, host.status.trouble

    _, (trouble, after) = played(tmp_path, scene, wrong)
    assert "no.model" in trouble
    assert after == ""


def test_a_device_that_fails_is_told_and_the_log_is_whole(tmp_path, monkeypatch):
    async def scene(host):
        await host.steer()
        await until(lambda: host.session is not None and host.shown.t > 0.2)

        def fails(event):
            raise DeviceError("the battery is empty: charge it")

        monkeypatch.setattr(host.session.conductor, "step", fails)
        await until(lambda: host.status.activity == "idle")
        return host.status.log

    host, path = played(tmp_path, scene)
    assert host.status.trouble == "the battery is empty: charge it"
    assert read(path).complete


def test_a_mistake_of_ours_is_told_too(tmp_path, monkeypatch):
    def fails(*_, **__):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("armspan.config.page.host.open_house", fails)

    async def scene(host):
        await host.steer()
        await until(lambda: host.status.activity == "idle")

    host, _ = played(tmp_path, scene)
    assert "ZeroDivisionError" in host.status.trouble


def test_opening_anew_ends_what_ran(tmp_path):
    async def scene(host):
        await host.steer()
        await until(lambda: host.session is not None)
        first = host.session
        await host.steer()
        await until(lambda: host.session is not None)
        return first is host.session

    _, same = played(tmp_path, scene)
    assert not same
    assert len(list((tmp_path / "sessions").iterdir())) == 2


def test_a_folder_of_sessions_that_cannot_be_is_said_in_a_sentence(tmp_path):
    (tmp_path / "sessions").write_text("a file")

    async def scene(host):
        await host.steer()
        await until(lambda: host.status.activity == "idle")

    host, _ = played(tmp_path, scene)
    assert "sessions cannot be a folder" in host.status.trouble
