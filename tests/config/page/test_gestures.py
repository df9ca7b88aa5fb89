import asyncio

import pytest

from armspan.config.demo_room import page_room
from armspan.config.page.gestures import check_enough, known_orders
from armspan.config.page.host import PageHost
from armspan.config.record_room import recorder_of
from armspan.errors import ConfigError
from armspan.log import read
from armspan.swarm.director import DICTIONARY
from armspan.web.views.gestures_host import Asked, TakeRow


def row(label, number=1, *, practice=False, note="", seconds=4.0):
    return TakeRow(f"{label}/p_{number:02d}.csv", label, "p", number, "2026-01-01", seconds, practice, False, note)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([], "none was recorded yet"),
        ([row("stop", practice=True), row("wave", note="nothing moved"), row("null")], "for practice, spoilt"),
        ([row("stop"), row("stop", 2), row("wave", practice=True)], "all takes are of one gesture, stop"),
        ([row("stop"), row("stop", 2), row("wave")], "one take only of wave"),
    ],
)
def test_what_cannot_be_learnt_from_is_told(rows, words):
    with pytest.raises(ConfigError, match=words):
        check_enough(rows)


def test_two_takes_of_two_gestures_are_enough():
    check_enough([row(label, number) for label in ("stop", "wave") for number in (1, 2)])


def test_a_dictionary_keeps_what_the_new_model_knows():
    own = {"wave": "stop", "clap": "gather"}
    assert known_orders(own, ("wave", "clap"), ("wave", "mixing")) == {"wave": "stop", "mixing": "random-walk"}
    assert known_orders({"stop": "stop"}, ("stop", "mixing"), ("mixing", "stop")) == {"stop": "stop"}
    assert known_orders(own, ("wave", "clap"), ("clap",)) == DICTIONARY


async def until(what, seconds=20.0):
    """Wait for something to become true."""
    async with asyncio.timeout(seconds):
        while not what():
            await asyncio.sleep(0.01)


def test_takes_are_recorded_kept_when_it_is_ended_and_the_room_opens_again(tmp_path):
    host = PageHost(page_room(1), "small", folder=tmp_path, sessions=tmp_path / "sessions")
    gestures = host.gestures

    async def run():
        await gestures.record(Asked(("stop",), 3, "p01", hurried=True))
        await until(lambda: gestures.progress == (1, 4))
        for refused in (gestures.train, gestures.use, gestures.keep, lambda: gestures.record(Asked(("stop",), 1, "p"))):
            with pytest.raises(ConfigError):
                await refused()
        path, sight = host.status.log, host.shown.mind.sight()
        await host.press("stop")
        await until(lambda: host.status.activity == "steering")
        told = gestures.progress, gestures.model, [entry.key for entry in await gestures.takes()]
        await gestures.keep()
        await host.close()
        return path, sight, told

    path, sight, told = asyncio.run(run())
    assert told == (None, None, ["stop/p01_01.csv"])
    assert [limb.side for limb in sight.limbs] == ["right", "left"]
    assert sight.step in ("calm", "count", "move", "after")
    log = read(path)
    assert log.complete
    assert recorder_of(log, host.room.settings(log_body(log))).recording.gestures == ("stop",)


def log_body(log):
    """The body that a log's header tells."""
    from armspan.config.recalled import settings_of

    return settings_of(log).body
