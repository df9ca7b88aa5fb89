"""What crashes, other tools, newer versions and wrong files do to a session, and what is read even so."""

import json
import os
import signal
import subprocess
import sys
import time
from itertools import count

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import CompressionType, Writer

from armspan import log
from armspan.errors import LogError
from armspan.records import Link, Press, Stop, Tick
from record_strategies import records
from session_examples import HEADER, SESSION, written

EXACT = settings(derandomize=True, database=None, deadline=None, max_examples=60)
SHORT = [SESSION[0], SESSION[3], SESSION[1], Tick(t=0.1), Link(t=0.2, source="b", up=False)]


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """Paths that do not exist yet."""
    folder, number = tmp_path_factory.mktemp("logs"), count()
    return lambda: folder / f"{next(number)}.mcap"


def ends(data):
    """Where each record of an MCAP file ends, by its opcode, after the format's own description."""
    position, found = 8, []
    while position < len(data) - 8:
        opcode, length = data[position], int.from_bytes(data[position + 1 : position + 9], "little")
        position += 9 + length
        found.append((opcode, position))
    assert found[-1] == (0x02, len(data) - 8)
    return found


def whole(data, cut):
    """How many messages of a file are whole in its first ``cut`` bytes, and whether its metadata is."""
    before = [opcode for opcode, end in ends(data) if end <= cut]
    return before.count(0x05), 0x0C in before


def rewritten(source, target, compression, order=lambda message: 0):
    """A log as another tool writes it: in chunks, compressed, maybe sorted."""
    with source.open("rb") as file:
        messages = list(NonSeekingReader(file).iter_messages(log_time_order=False))
    with source.open("rb") as file:
        (metadata,) = make_reader(file).iter_metadata()
    with target.open("wb") as file:
        writer = Writer(file, chunk_size=512, compression=compression)
        writer.start()
        writer.add_metadata(metadata.name, dict(sorted(metadata.metadata.items())))
        channels = {}
        for schema, channel, message in sorted(messages, key=lambda found: order(found[2])):
            if channel.topic not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "json", number)
            writer.add_message(
                channels[channel.topic],
                message.log_time,
                message.data,
                message.publish_time,
                message.sequence,
            )
        writer.finish()
    return target


def foreign(path, topic, data, encoding="json", metadata="armspan"):
    """An MCAP file with one message that another program, or a newer Armspan, has written."""
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start()
        writer.add_metadata(metadata, {"armspan": '"9.0"'})
        channel = writer.register_channel(topic, encoding, 0)
        writer.add_message(channel, log_time=0, data=data, publish_time=0, sequence=7)
        writer.finish()
    return path


# --- cut in mid-write ------------------------------------------------------------------------------------


def test_a_file_cut_at_any_byte_gives_the_records_that_are_whole(fresh):
    data, path = written(fresh(), SHORT).read_bytes(), fresh()
    for cut in range(len(data)):
        path.write_bytes(data[:cut])
        number, header = whole(data, cut)
        if header:
            found = log.read(path)
            assert found.records == SHORT[:number]
            assert found.header == HEADER
            assert not found.complete
        else:
            told = "is empty" if cut == 0 else "ends before its header is whole"
            with pytest.raises(LogError, match=told):
                log.read(path)


@EXACT
@given(st.lists(records(t=st.floats(0.0, 1e6)), max_size=6), st.floats(0.0, 1.0), st.sampled_from([0, 1, 4096]))
def test_what_is_whole_is_recovered_into_a_proper_file(fresh, session, share, zeros):
    data, path, target = written(fresh(), session).read_bytes(), fresh(), fresh()
    first = next(end for opcode, end in ends(data) if opcode == 0x0C)
    cut = first + round(share * (len(data) - first))
    path.write_bytes(data[:cut] + bytes(zeros))  # a power failure may leave zeros where nothing was written
    number, _ = whole(data, cut)
    assert log.recover(path, target) == number
    assert target.read_bytes() == written(fresh(), session[:number]).read_bytes()
    with target.open("rb") as file:
        assert make_reader(file).get_summary().statistics.message_count == number
    with target.open("rb") as file:
        assert len(list(NonSeekingReader(file, validate_crcs=True).iter_messages())) == number


def test_a_recovered_file_does_not_replace_another(fresh):
    path, target = written(fresh(), SESSION), written(fresh(), SHORT)
    with pytest.raises(LogError, match="exists already"):
        log.recover(path, target)
    assert log.read(target).records == SHORT


def test_records_reach_the_disk_every_quarter_second_and_at_each_stop(fresh):
    path = fresh()
    with log.LogWriter(path, HEADER) as writer:
        on_disk = []
        for record in [*(Tick(t=k / 20) for k in range(1, 12)), Press(t=0.56, name="pause"), Stop(t=0.57)]:
            writer(record)
            on_disk.append(len(log.read(path).records))
        writer(Tick(t=0.6))
        assert len(log.read(path).records) == 13
    assert on_disk == [0, 0, 0, 0, 5, 5, 5, 5, 5, 10, 10, 10, 13]
    assert len(log.read(path).records) == 14


WRITE_FOR_EVER = """
import sys
from itertools import count
from armspan.log import LogWriter
from armspan.records import Tick
writer = LogWriter(sys.argv[1], {"armspan": "0.1.0"})
for number in count():
    writer(Tick(t=number / 100))
"""


def test_a_killed_session_is_read_and_recovered(fresh):
    path, target = fresh(), fresh()
    child = subprocess.Popen([sys.executable, "-c", WRITE_FOR_EVER, str(path)], env=dict(os.environ))
    try:
        patience = time.monotonic() + 60.0
        while not (path.exists() and path.stat().st_size > 200_000):
            assert child.poll() is None
            assert time.monotonic() < patience
            time.sleep(0.005)
    finally:
        child.send_signal(signal.SIGKILL)
        child.wait()
    found = log.read(path)
    assert not found.complete
    assert len(found.records) > 2000
    assert found.records == [Tick(t=number / 100) for number in range(len(found.records))]
    assert log.recover(path, target) == len(found.records)
    assert log.read(target).complete


def test_a_disk_that_fills_up_leaves_what_fitted(fresh):
    resource = pytest.importorskip("resource", reason="limits on file sizes are Unix's")
    path, soft_hard = fresh(), resource.getrlimit(resource.RLIMIT_FSIZE)
    writer, session = log.LogWriter(path, HEADER), [Tick(t=number / 100) for number in range(5000)]
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, soft_hard[1]))
    try:
        with pytest.raises(LogError, match=r"cannot be written any more \(File too large\): make room"):
            list(map(writer, session))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, soft_hard)
    writer.close()
    found = log.read(path)
    assert not found.complete
    assert len(found.records) > 1000
    assert found.records == session[: len(found.records)]


# --- rewritten by other tools ----------------------------------------------------------------------------


@pytest.mark.parametrize("compression", CompressionType)
@pytest.mark.parametrize(
    "order", [lambda m: 0, lambda m: m.channel_id, lambda m: -m.log_time], ids=["kept", "channel", "reversed"]
)
def test_chunks_compression_and_other_orders_change_nothing(fresh, compression, order):
    session = [*SESSION, *(Tick(t=1.0 + k / 20) for k in range(40))]
    path = rewritten(written(fresh(), session), fresh(), compression, order)
    found = log.read(path)
    assert found.records == session
    assert found.header == HEADER
    assert found.complete


@pytest.mark.parametrize("compression", CompressionType)
def test_a_cut_file_of_chunks_gives_the_chunks_that_are_whole(fresh, compression):
    session, path = [Tick(t=k / 20) for k in range(60)], fresh()
    data = rewritten(written(fresh(), session), fresh(), compression).read_bytes()
    numbers = set()
    for cut in range(1000, len(data), 97):
        path.write_bytes(data[:cut])
        found = log.read(path)
        assert found.records == session[: len(found.records)]
        assert not found.complete
        numbers.add(len(found.records))
    assert len(numbers) > 3
    assert max(numbers) == 60


@pytest.mark.parametrize("compression", CompressionType)
def test_a_changed_byte_in_a_chunk_is_found(fresh, compression):
    path = rewritten(written(fresh(), [Tick(t=k / 20) for k in range(60)]), fresh(), compression)
    data = bytearray(path.read_bytes())
    first = next(end for opcode, end in ends(data) if opcode == 0x06)
    data[first - 20] ^= 0x01
    path.write_bytes(data)
    with pytest.raises(LogError, match=r"is damaged at byte \d+ \(.+\): recover what is whole"):
        log.read(path)


# --- newer, foreign, damaged -----------------------------------------------------------------------------


def test_what_this_version_does_not_know_is_skipped_and_counted(fresh):
    data = b'{"type":"Blink","t":0.1}'
    assert log.read(foreign(fresh(), "/armspan/Blink", data)).skipped == {"/armspan/Blink": 1}
    assert log.read(foreign(fresh(), "/camera", b"\xff\xd8")).skipped == {"/camera": 1}
    assert log.read(foreign(fresh(), "Tick", b'{"type":"Tick","t":0.1}')).skipped == {"Tick": 1}
    assert log.read(foreign(fresh(), "/armspan/Tick", b"\x08", "protobuf")).skipped == {"/armspan/Tick": 1}
    path = foreign(fresh(), "/armspan/Blink", data)
    assert log.read(path).records == []
    with pytest.raises(LogError, match=r"would lose \(/armspan/Blink\): recover it with the version"):
        log.recover(path, fresh())


def test_a_field_that_a_newer_version_has_added_is_left_out(fresh):
    path = foreign(fresh(), "/armspan/Tick", b'{"type":"Tick","t":0.1,"mood":"fine"}')
    assert log.read(path).records == [Tick(t=0.1)]
    assert log.read(path).header == {"armspan": "9.0"}


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b'{"type":"Tick"}', "Object missing required field `t`"),
        (b'{"type":"Tick","t":"0.1"}', "Expected `float`, got `str`"),
        (b'{"type":"Stop","t":0.1}', "Invalid value 'Stop'"),
        (b'{"type":"Tick","t":', "Input data was truncated"),
        (b'{"type":"\xff","t":0.1}', "invalid start byte"),
    ],
)
def test_a_record_that_does_not_decode_is_told_with_its_number_and_topic(fresh, data, told):
    path = foreign(fresh(), "/armspan/Tick", data)
    with pytest.raises(LogError, match=rf"{path.name}: record 7 on /armspan/Tick does not decode \(.*({told})"):
        log.read(path)
    assert log.recover(path, fresh()) == 0


def test_other_files_are_told_apart(fresh, tmp_path):
    path = fresh()
    with pytest.raises(LogError, match=r"a\.mcap does not exist; most like it are: none"):
        log.read(tmp_path / "a.mcap")
    with pytest.raises(LogError, match=r"cannot be read \(Is a directory\)"):
        log.read(tmp_path)
    path.write_bytes(b"")
    with pytest.raises(LogError, match="is empty: nothing was recorded in it"):
        log.read(path)
    path.write_bytes(json.dumps(HEADER).encode())
    with pytest.raises(LogError, match="is not an MCAP file: it begins with"):
        log.read(path)
    path.write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(LogError, match="is not an MCAP file"):
        log.read(path)
    foreign(path, "/armspan/Tick", b'{"type":"Tick","t":0.1}', metadata="rosbag2")
    with pytest.raises(LogError, match="is an MCAP file, but not a session of Armspan"):
        log.read(path)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(LogError, match="is an MCAP file, but not a session of Armspan"):
        log.read(path)


def test_names_that_are_nearly_right_are_told(tmp_path):
    for name in ("monday", "tuesday", "wednesday"):
        written(tmp_path / f"{name}.mcap", [])
    with pytest.raises(LogError, match=r"mondy\.mcap does not exist; most like it are: monday\.mcap, tuesday"):
        log.read(tmp_path / "mondy.mcap")


def test_no_changed_byte_makes_up_a_record(fresh):
    data, path = written(fresh(), SHORT).read_bytes(), fresh()
    last_of_data = [end for opcode, end in ends(data) if opcode == 0x05][-1]
    for place in range(len(data)):
        changed = bytearray(data)
        changed[place] ^= (0x01, 0x07, 0x80)[place % 3]
        path.write_bytes(changed)
        try:
            found = log.read(path)
        except LogError:
            continue
        assert found.records == SHORT[: len(found.records)]
        assert not (found.complete and place < last_of_data), place


def test_what_stands_before_the_damage_is_recovered(fresh):
    data, path, target = bytearray(written(fresh(), SHORT).read_bytes()), fresh(), fresh()
    third = [end for opcode, end in ends(data) if opcode == 0x05][2]
    data[third - 1] = 0
    path.write_bytes(data)
    with pytest.raises(LogError, match="record 2 on /armspan/ImuSample does not decode"):
        log.read(path)
    assert log.recover(path, target) == 2
    assert log.read(target).records == SHORT[:2]
