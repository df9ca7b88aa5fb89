"""Writing and reading sessions; for what crashes, other tools and newer versions do, see test_log_rescue."""

import json
import math
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader, make_reader

from armspan import log
from armspan.errors import LogError
from armspan.log.layout import TYPES, schema_of
from armspan.records import Pointed, Record, RobotState, Say, Tick
from record_strategies import records
from session_examples import HEADER, ROOM, SESSION, written

EXACT = settings(derandomize=True, database=None, deadline=None, max_examples=60)


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """Paths that do not exist yet."""
    folder, number = tmp_path_factory.mktemp("logs"), count()
    return lambda: folder / f"{next(number)}.mcap"


def own(path, **how):
    """What the mcap package's own reader finds, in the order of the file."""
    with path.open("rb") as file:
        return list(make_reader(file).iter_messages(log_time_order=False, **how))


# --- there and back --------------------------------------------------------------------------------------


def test_a_session_comes_back_as_it_was_written(fresh):
    found = log.read(str(written(fresh(), SESSION)))
    assert found.records == SESSION
    assert list(map(repr, found)) == list(map(repr, SESSION))
    assert found.header == HEADER
    assert list(found.header) == list(HEADER)
    assert found.complete
    assert found.skipped == {}
    assert list(found.counts().items())[:2] == [("ImuSample", 2), ("Pointed", 2)]
    assert sum(found.counts().values()) == 12


@EXACT
@given(st.lists(records(), max_size=8))
def test_any_finite_records_come_back_to_the_last_bit(fresh, session):
    found = log.read(written(fresh(), session, {}))
    assert found.records == session
    assert list(map(repr, found)) == list(map(repr, session))
    assert found.complete


@EXACT
@given(st.lists(records(), max_size=8))
def test_equal_records_give_equal_bytes(fresh, session):
    assert written(fresh(), session).read_bytes() == written(fresh(), session).read_bytes()


def test_a_session_without_records(fresh):
    found = log.read(written(fresh(), [], {}))
    assert (found.header, found.records, found.arrivals, found.complete) == ({}, [], [], True)


# --- the file as others see it ---------------------------------------------------------------------------


def test_the_mcap_packages_reader_finds_the_same(fresh):
    path = written(fresh(), SESSION)
    for (schema, channel, message), record in zip(own(path), SESSION, strict=True):
        kind = type(record).__name__
        assert (channel.topic, channel.message_encoding) == (f"/armspan/{kind}", "json")
        assert (schema.name, schema.encoding) == (kind, "jsonschema")
        assert message.publish_time == round(record.t * 1e9)
        fields = json.loads(message.data)
        assert fields.pop("type") == kind
        assert list(fields) == list(record.__struct_fields__)
        assert repr(fields["t"]) == repr(record.t)
    assert [message.sequence for _, _, message in own(path)] == list(range(12))


def test_the_summary_is_right_and_the_checksums_fit(fresh):
    path = written(fresh(), SESSION)
    with path.open("rb") as file:
        reader = make_reader(file)
        statistics = reader.get_summary().statistics
        (metadata,) = reader.iter_metadata()
    assert statistics.message_count == 12
    assert (statistics.message_start_time, statistics.message_end_time) == (0, 200_000_000)
    assert statistics.channel_count == statistics.schema_count == 10
    assert (metadata.name, metadata.metadata["epoch"]) == ("armspan", "0")
    assert json.loads(metadata.metadata["room"]) == ROOM
    with path.open("rb") as file:
        assert len(list(NonSeekingReader(file, validate_crcs=True).iter_messages())) == 12


def test_the_metadata_stands_right_behind_the_header(fresh):
    data = written(fresh(), SESSION).read_bytes()
    assert data[:9] == b"\x89MCAP0\r\n\x01"
    length = int.from_bytes(data[9:17], "little")
    assert data[17 + length : 18 + length] == b"\x0c"
    assert data[26 + length : 37 + length] == b"\x07\x00\x00\x00armspan"


def test_log_time_is_the_arrival_and_never_falls(fresh):
    path = fresh()
    with log.LogWriter(path, {}) as writer:
        writer.write(Tick(t=1.0))
        writer.write(Tick(t=0.5))
        writer.write(Tick(t=1.2), arrived=1.25)
        writer.write(Tick(t=1.3), arrived=1.1)
        writer.write(Tick(t=-0.1), arrived=1.5)
        writer.write(Tick(t=1e300))
    times = [(message.log_time, message.publish_time) for _, _, message in own(path)]
    latest = 2**63 - 1
    assert times == [
        (1_000_000_000, 1_000_000_000),
        (1_000_000_000, 500_000_000),
        (1_250_000_000, 1_200_000_000),
        (1_250_000_000, 1_300_000_000),
        (1_500_000_000, 0),
        (latest, latest),
    ]
    assert log.read(path).arrivals[:5] == [1.0, 1.0, 1.25, 1.25, 1.5]


@EXACT
@given(st.lists(st.tuples(records(t=st.floats(0.0, 1e6)), st.none() | st.floats(0.0, 1e6)), max_size=8))
def test_writing_what_was_read_gives_the_same_bytes(fresh, session):
    first, second = fresh(), fresh()
    with log.LogWriter(first, HEADER) as writer:
        for record, arrived in session:
            writer.write(record, arrived)
    found = log.read(first)
    with log.LogWriter(second, found.header) as writer:
        for record, arrived in zip(found, found.arrivals, strict=True):
            writer.write(record, arrived)
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize("kind", TYPES.values(), ids=TYPES)
def test_a_viewer_can_take_the_schema_of_every_record_type(kind):
    # What Foxglove Studio and Lichtblick read: an object of properties with one plain type each, arrays with
    # items of one plain type. Anything else makes them drop the channel.
    schema = json.loads(schema_of(kind))
    assert schema["type"] == "object"
    assert "$ref" not in str(schema)
    for field in schema["properties"].values():
        plain = field["items"] if field["type"] == "array" else field
        assert plain["type"] in {"boolean", "string", "number", "integer"}
    left_out = {*kind.__struct_fields__, "type"} - set(schema["properties"])
    assert left_out == ({"covariance"} if kind is Pointed else set())


def test_a_schema_by_hand():
    schema = json.loads(schema_of(RobotState))
    assert schema["required"] == ["type", "t", "robot", "xy", "heading"]
    assert schema["properties"] == {
        "type": {"type": "string", "enum": ["RobotState"]},
        "t": {"type": "number"},
        "robot": {"type": "string"},
        "xy": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
        "heading": {"type": "number"},
        "held": {"type": "boolean", "default": False},
        "battery": {"type": "number", "nullable": True},
    }
    assert "\n " not in schema["description"]


# --- what is refused -------------------------------------------------------------------------------------


def test_a_file_is_not_overwritten_unasked(fresh):
    path = written(fresh(), SESSION)
    before = path.read_bytes()
    with pytest.raises(LogError, match=rf"{path.name} exists already: choose another name"):
        log.LogWriter(path, {})
    assert path.read_bytes() == before
    log.LogWriter(path, {}, overwrite=True).close()
    assert log.read(path).records == []


@pytest.mark.parametrize("header", [{"speed": math.inf}, {"room": {"a": [math.nan]}}, {"x": object()}, {"x": "\ud800"}])
def test_a_header_that_json_cannot_hold_is_refused_before_there_is_a_file(fresh, header):
    path = fresh()
    with pytest.raises(LogError, match=rf"header has {next(iter(header))} = .*use what JSON can hold"):
        log.LogWriter(path, header)
    assert not path.exists()


class Blink(Record, frozen=True, gc=False):
    source: str = "left_eye"


@pytest.mark.parametrize(
    ("record", "told"),
    [
        (Tick(t=math.nan), r"Tick\(t=nan\) is not finite"),
        (Pointed(t=0.0, source="a", xy=(0.0, math.inf), covariance=None), "is not finite"),
        (Tick(t=np.float64(1.0)), "numpy.float64 is unsupported.*use plain floats"),
        (Say(t=0.0, text="\ud800"), "cannot be logged"),
        (Blink(t=0.0), "The record type 'Blink' does not exist; there are: Calibrated, Drive"),
    ],
)
def test_a_record_that_cannot_be_held_is_refused_and_the_others_are_kept(fresh, record, told):
    path = fresh()
    with log.LogWriter(path, {}) as writer:
        writer.write(Tick(t=0.0))
        with pytest.raises(LogError, match=told):
            writer.write(record)
        writer.write(Tick(t=1.0))
    assert log.read(path).records == [Tick(t=0.0), Tick(t=1.0)]
    assert [message.sequence for _, _, message in own(path)] == [0, 1]


def test_a_closed_log_takes_no_more_and_may_be_closed_again(fresh):
    writer = log.LogWriter(fresh(), {})
    writer.close()
    writer.close()
    with pytest.raises(LogError, match="is closed and takes no Tick any more"):
        writer(Tick(t=0.0))


def test_an_error_inside_the_session_still_ends_the_file_properly(fresh):
    path = fresh()
    with pytest.raises(TypeError, match="Struct"):
        written(path, [Tick(t=0.0), None])
    assert log.read(path).complete
    assert log.read(path).records == [Tick(t=0.0)]


def test_places_where_no_file_can_be(tmp_path):
    with pytest.raises(LogError, match=r"cannot be created \(No such file or directory\): choose another place"):
        log.LogWriter(tmp_path / "missing" / "a.mcap", {})
    with pytest.raises(LogError, match="cannot be created"):
        log.LogWriter(tmp_path, {}, overwrite=True)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full, a disk without room, is Linux's")
def test_a_full_disk_is_told():
    with pytest.raises(LogError, match=r"cannot be written any more \(No space left on device"):
        log.LogWriter("/dev/full", {}, overwrite=True)
