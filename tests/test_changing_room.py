"""A room that is changed while it is open: what was decided after it is decided again when the log is replayed."""

import asyncio
import json

import pytest

from armspan.cli.replay import first_difference
from armspan.config.house import open_house
from armspan.config.recalled import settings_of
from armspan.devices import simulated
from armspan.log import LogWriter, read
from armspan.records import Body, Calibrated, Press, Say
from armspan.session import FastPace
from small_rooms import small_room

SECONDS = 75.0
MARSH = {"name": "marsh", "polygon": [[0.3, 0.3], [0.4, 0.3], [0.4, 0.4], [0.3, 0.4]]}
BODY = {"eye_height_m": 1.6, "shoulder_to_eye_m": [0.02, 0.15, 0.22], "shoulder_to_fingertip_m": 0.72}
PRESSES = (
    (0.5, "setup", ""),
    (30.0, "stop_again", "2"),
    (31.0, "zones", json.dumps([MARSH])),
    (31.5, "zones", "nonsense"),
    (32.0, "gestures", json.dumps({"stop": "stop", "mixing": "sweep@marsh"})),
    (40.0, "wish", "zone:pond"),
    (45.0, "body", json.dumps(BODY)),
    (46.0, "setup", ""),
)


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    house = open_house(small_room(), guided=True)
    path = tmp_path_factory.mktemp("changing") / "log.mcap"

    async def presses(pace):
        for t, name, value in PRESSES:
            await pace(t)
            yield Press(t, name, value)

    async def run(writer):
        session = house.session([writer])
        fast = FastPace(session)
        world, hand = fast.door(), fast.door()
        sources = [simulated.source(house.world, world, seconds=SECONDS), presses(hand)]
        await session.run([door.through(source) for door, source in zip((world, hand), sources, strict=True)])

    with LogWriter(path, house.header) as writer:
        asyncio.run(run(writer))
    return read(path)


def test_it_was_set_up_three_times_and_changed(log):
    assert sum(isinstance(record, Calibrated) for record in log.records) == 3
    said = [record.text for record in log.records if isinstance(record, Say)]
    assert any(text.startswith("Nothing was changed: zones") for text in said)
    assert "The measures were changed: begin the set-up" in said


def test_the_log_replays_by_itself(log):
    assert first_difference(log, settings_of(log)) is None


def test_the_header_keeps_the_room_as_it_was_opened(log):
    settings = settings_of(log)
    assert [zone.name for zone in settings.zones] == ["pond"]
    assert settings.body != Body(1.6, (0.02, 0.15, 0.22), 0.72)
