"""Rooms in which takes are recorded: only the bands matter."""

import pytest

from armspan.conductor.recorder_plan import Recording
from armspan.config.record_room import open_record_house, read_record_room, wrists_of
from armspan.config.room_file import parse_room
from armspan.errors import ConfigError
from armspan.log import LogWriter
from armspan.records import ImuSample, Press, Tick
from command_line import written_room

BODY = {"eye_height_m": 1.6, "shoulder_to_eye_m": [0.06, 0.15, 0.22], "shoulder_to_fingertip_m": 0.72}
RIGHT, LEFT = {"kind": "simulated", "name": "r"}, {"kind": "simulated", "name": "l", "arm": "left"}
STOP = Recording(("stop",), 1, wrists=("left",))


def room(folder, *bands, **more):
    return read_record_room(written_room(folder / "room.toml", {"bands": list(bands)} | more))


@pytest.mark.parametrize(
    ("bands", "body", "worn"),
    [
        ((RIGHT,), None, ("right",)),
        ((LEFT,), None, ("left",)),
        ((RIGHT, LEFT), None, ("right", "left")),
        ((LEFT,), BODY, ("left",)),
        ((RIGHT, LEFT | {"arm": "right"}), {"arm": "left"}, ("right", "left")),
        ((LEFT, RIGHT | {"segment": "upperarm"}), None, ("left",)),
    ],
)
def test_the_wrists_that_wear_a_band(tmp_path, bands, body, worn):
    assert wrists_of(room(tmp_path, *bands, **({"body": body} if body else {}))) == worn


def test_robots_are_left_away(tmp_path):
    robots = [{"kind": "replay", "name": "ash", "log": "gone.mcap"}]
    found = room(tmp_path, RIGHT, LEFT, robots=robots)
    assert found.robots == ()
    assert open_record_house(found, STOP).logs == {}


def test_a_person_with_one_band_still_has_two_arms(tmp_path):
    house = open_record_house(room(tmp_path, LEFT), STOP)
    assert sorted(band.name for band in house.world.bands) == ["l", "other_right"]
    assert house.recorder.recording.wrists == ("left",)
    assert house.simulated
    assert house.header["simulated"] is True
    assert house.header["recording"]["gestures"] == ("stop",)


def replayed(folder, header, *records):
    with LogWriter(folder / "a.mcap", header) as log:
        for record in records:
            log(record)
    return room(folder, {"kind": "replay", "name": "l", "arm": "left", "log": "a.mcap"})


SAMPLES = [ImuSample(0.05 * k, "l", (0.0, 0.0, 9.8), (0.0, 0.0, 0.0), None, (1.0, 0.0, 0.0, 0.0)) for k in range(20)]


@pytest.mark.parametrize(
    ("header", "simulated"),
    [
        ({"epoch_ns": 0}, True),
        ({"epoch_ns": 17e17}, False),
        ({"epoch_ns": 0, "simulated": False}, False),
        ({"epoch_ns": 17e17, "simulated": True}, True),
    ],
)
def test_takes_of_a_log_are_simulated_where_the_log_is(tmp_path, header, simulated):
    house = open_record_house(replayed(tmp_path, header, *SAMPLES), STOP, tmp_path)
    assert house.simulated is simulated


def test_a_log_without_set_up_is_led_into_one(tmp_path):
    events = [event for sample in SAMPLES for event in (sample, Tick(sample.t))]
    house = open_record_house(replayed(tmp_path, {}, *events), STOP, tmp_path)
    [log] = house.logs.values()
    [place] = [k for k, record in enumerate(log.records) if isinstance(record, Press)]
    assert log.records[place] == Press(0.5, "setup")
    assert all(record.t < 0.5 for record in log.records[:place])
    assert log.records[place + 1].t >= 0.5
    assert len(log.records) == len(events) + 1


def test_a_log_with_a_set_up_is_played_as_it_is(tmp_path):
    events = [*SAMPLES[:5], Press(0.22, "setup"), *SAMPLES[5:]]
    house = open_record_house(replayed(tmp_path, {}, *events), STOP, tmp_path)
    assert next(iter(house.logs.values())).records == events


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({}, r"has no \[\[bands\]\]"),
        ({"bands": []}, r"has no \[\[bands\]\]"),
        ({"bands": 3}, r"has no \[\[bands\]\]"),
        ({"bands": ["x"]}, r"at bands\[0\]: expected `object`"),
        ({"bands": [RIGHT | {"segment": "upperarm"}]}, "has no band on a wrist"),
        ({"bands": [LEFT, LEFT | {"name": "k"}]}, "has two bands on the left wrist"),
        ({"bands": [LEFT | {"arm": "middle"}]}, r"at bands\[0\].arm: invalid enum value 'middle'"),
        ({"bands": [RIGHT, LEFT | {"name": "r"}]}, "band 'r' is named twice"),
        ({"bands": [RIGHT], "body": 5}, "at body: expected `object"),
        ({"bands": [RIGHT], "colour": "red"}, "unknown field `colour`"),
    ],
)
def test_rooms_that_cannot_be_recorded_in(tmp_path, entries, words):
    path = written_room(tmp_path / "room.toml", entries)
    with pytest.raises(ConfigError, match=words) as caught:
        read_record_room(path)
    assert "\n" not in str(caught.value)
    assert "room.toml" in str(caught.value)


def test_elsewhere_a_room_needs_robots(tmp_path):
    raw = {"sheet": {"width_m": 1, "height_m": 1}, "bands": [RIGHT], "robots": []}
    assert parse_room(raw, robots=False).robots == ()
    with pytest.raises(ConfigError, match=r"one in \[\[robots\]\]"):
        parse_room(raw)


def test_a_left_handed_users_other_band_is_on_the_right(tmp_path):
    found = room(tmp_path, RIGHT | {"arm": "right"}, {"kind": "simulated", "name": "l"}, body=BODY | {"arm": "left"})
    assert [band.arm for band in found.bands] == ["right", None]
    assert wrists_of(found) == ("right", "left")
