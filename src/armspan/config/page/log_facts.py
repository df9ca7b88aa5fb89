"""What a log holds, without reading every record."""

import datetime
import re
import struct
from collections import Counter
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import msgspec
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel
from mcap.writer import MCAP0_MAGIC

from armspan.errors import LogError
from armspan.log import read
from armspan.web.sessions import SessionLog

_NAMED = re.compile(r"(\d{4})-(\d\d)-(\d\d)_(\d\d)(\d\d)(\d\d)_(.*)")
_TOPICS = "/armspan/"
_HEADER = "armspan"
_CUT = "It was cut off: its end is missing"
_HEAD, _MESSAGE = struct.Struct("<BQ"), struct.Struct("<HIQ")  # opcode, length; channel, number, log time [ns]


def looked_into(path: Path) -> SessionLog:
    """What a log holds: from its summary where it is whole, else by reading it."""
    facts = path.stat()
    log = named(path, facts.st_mtime, facts.st_size)
    try:
        return _summed(path, log) or _walked(path, log) or _counted(path, log)
    except LogError as error:
        return msgspec.structs.replace(log, trouble=short(str(error), path), readable=False)


def _summed(path: Path, log: SessionLog) -> SessionLog | None:
    """The log with what its summary at the end tells, None where there is none."""
    try:
        with path.open("rb") as stream:
            summary = make_reader(stream).get_summary()
    except (McapError, OSError, ValueError, EOFError):
        return None
    if summary is None or summary.statistics is None:
        return None
    if not any(index.name == _HEADER for index in summary.metadata_indexes):
        raise LogError(f"{path.name} is an MCAP file, but not a session of Armspan")
    told = summary.statistics
    topics = {number: channel.topic.removeprefix(_TOPICS) for number, channel in summary.channels.items()}
    counts = {topics[number]: count for number, count in told.channel_message_counts.items()}
    return msgspec.structs.replace(log, seconds=told.message_end_time / 1e9, counts=counts)


def _counted(path: Path, log: SessionLog) -> SessionLog:
    """The log as it is read, record by record (LogError for what is none)."""
    found = read(path)
    seconds = found.arrivals[-1] if found.arrivals else 0.0
    return msgspec.structs.replace(log, seconds=seconds, counts=found.counts(), trouble="" if found.complete else _CUT)


def _walked(path: Path, log: SessionLog) -> SessionLog | None:
    """A cut log with its whole records counted and not read, None where there is no record of ours."""
    counts: Counter[int] = Counter()
    topics: dict[int, str] = {}
    last = 0
    for opcode, body in _parts(path):
        if opcode == Opcode.MESSAGE:
            channel, _, log_time = _MESSAGE.unpack_from(body)
            counts[channel] += 1
            last = max(last, log_time)
        elif opcode == Opcode.CHANNEL:
            told = Channel.read(ReadDataStream(BytesIO(body)))
            topics[told.id] = told.topic
    if not topics or set(counts) - set(topics) or not all(topic.startswith(_TOPICS) for topic in topics.values()):
        return None
    named = {topics[channel].removeprefix(_TOPICS): count for channel, count in counts.items()}
    return msgspec.structs.replace(log, seconds=last / 1e9, counts=named, trouble=_CUT)


def _parts(path: Path) -> Iterator[tuple[int, bytes]]:
    """Opcodes and bodies of an MCAP file's whole records; of a message only its beginning."""
    with path.open("rb") as stream:
        if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            return
        size = path.stat().st_size
        while len(head := stream.read(_HEAD.size)) == _HEAD.size:
            opcode, length = _HEAD.unpack(head)
            end = stream.tell() + length
            if end > size:
                return
            body = stream.read(_MESSAGE.size if opcode == Opcode.MESSAGE else length)
            if opcode == Opcode.MESSAGE and length < _MESSAGE.size:
                return
            yield opcode, body
            stream.seek(end)


def named(path: Path, changed: float, size: int) -> SessionLog:
    """A log by what its name says: when it began, and its room."""
    parts = _NAMED.fullmatch(path.stem)
    if parts is not None:
        year, month, day, hour, minute, second, room = parts.groups()
        return SessionLog(path.name, f"{year}-{month}-{day} {hour}:{minute}:{second}", room, size)
    return SessionLog(path.name, f"{datetime.datetime.fromtimestamp(changed):%Y-%m-%d %H:%M:%S}", path.stem, size)


def short(words: str, path: Path) -> str:
    """Words about a log, without the folder that it lies in."""
    return words.replace(str(path), path.name)
