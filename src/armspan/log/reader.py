"""Reading a session, also one that was cut or that another MCAP tool has rewritten."""

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from io import BytesIO
from operator import itemgetter
from pathlib import Path
from typing import TypeAlias

import msgspec
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Metadata
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC

from armspan.errors import LogError
from armspan.log.layout import HEADER, TOPICS, TYPES
from armspan.log.writer import LogWriter
from armspan.records import Record

_Decoder: TypeAlias = "msgspec.json.Decoder[Record]"

# Records of an MCAP file: opcode and length, then the body; a message's body begins with channel, sequence,
# log time, publish time (https://mcap.dev/spec). Messages are taken apart here because they are nearly all
# of a file; everything else is left to the mcap package, which by itself would hand out a record that the
# file's end has cut short as if it were whole.
_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_OP_MESSAGE, _OP_FOOTER = int(Opcode.MESSAGE), int(Opcode.FOOTER)


@dataclass(frozen=True, slots=True)
class LogFile:
    """A session as it was read.

    ``records`` stand in the order in which they were written and ``arrivals`` [s] beside them. ``complete``
    is False where the file was cut: then these are the records up to the last whole one. ``skipped`` counts
    the messages by topic that this version of Armspan does not know.
    """

    path: Path
    header: dict[str, object]
    records: list[Record]
    arrivals: list[float]
    complete: bool
    skipped: dict[str, int]

    def __iter__(self) -> Iterator[Record]:
        return iter(self.records)

    def counts(self) -> dict[str, int]:
        """How many records of each type, the most frequent first."""
        return dict(Counter(type(record).__name__ for record in self.records).most_common())


def read(path: str | Path) -> LogFile:
    """Read a session's file, whole or cut.

    Raises:
        LogError: no such file, not an MCAP file, one without a session's header, a damaged one, or a record
            that does not decode.

    """
    scan = _Scan(Path(path))
    damage = scan.run()
    if damage is not None:
        raise damage
    return scan.log()


def recover(path: str | Path, target: str | Path) -> int:
    """Write what is whole in a cut or damaged file to ``target``, a proper file; the number of records saved.

    Raises:
        LogError: ``target`` exists, nothing can be saved, or records of a type unknown to this version of
            Armspan would get lost.

    """
    scan = _Scan(Path(path))
    scan.run()
    log = scan.log()
    if log.skipped:
        raise LogError(
            f"{path} holds what this version of Armspan does not know and would lose"
            f" ({', '.join(sorted(log.skipped))}): recover it with the version that wrote it"
        )
    with LogWriter(target, log.header) as writer:
        for record, arrived in zip(log.records, log.arrivals, strict=True):
            writer.write(record, arrived)
    return len(log.records)


class _Scan:
    """What has been found so far on the way through a file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._data = _contents(path)
        self._header: dict[str, object] | None = None
        self._topics: dict[int, str] = {}
        self._decoders: dict[int, _Decoder] = {}
        self._rows: list[tuple[int, int, Record]] = []
        self._skipped: Counter[str] = Counter()
        self._complete = False

    def run(self) -> LogError | None:
        """Go to the file's end or to the first damage, which is returned."""
        try:
            self._walk()
        except LogError as damage:
            return damage
        return None

    def log(self) -> LogFile:
        """What was found, in the order of the session."""
        if self._header is None and (self._complete or self._topics):
            raise LogError(f"{self.path} is an MCAP file, but not a session of Armspan: it has no metadata {HEADER!r}")
        if self._header is None:
            raise LogError(f"{self.path} ends before its header is whole: there is nothing to save in it")
        self._rows.sort(key=itemgetter(0))  # other tools may have sorted by log time or by channel
        return LogFile(
            path=self.path,
            header=self._header,
            records=[record for _, _, record in self._rows],
            arrivals=[log_time / 1e9 for _, log_time, _ in self._rows],
            complete=self._complete,
            skipped=dict(self._skipped),
        )

    def _walk(self) -> None:
        view, size = memoryview(self._data), len(self._data)
        position = len(MCAP0_MAGIC)
        while position + _HEAD.size <= size:
            opcode, length = _HEAD.unpack_from(view, position)
            start = position + _HEAD.size
            if start + length > size:
                return  # cut here
            if opcode == _OP_FOOTER:
                self._complete = view[start + length :] == MCAP0_MAGIC
                return
            self._take(opcode, view[start : start + length], position)
            position = start + length

    def _take(self, opcode: int, body: memoryview, position: int) -> None:
        try:
            if opcode == _OP_MESSAGE:
                channel, sequence, log_time, _ = _MESSAGE.unpack_from(body)
                self._message(channel, sequence, log_time, body[_MESSAGE.size :])
            elif opcode == Opcode.CHANNEL:
                self._channel(Channel.read(_stream(body)))
            elif opcode == Opcode.METADATA:
                self._metadata(Metadata.read(_stream(body)))
            elif opcode == Opcode.CHUNK:
                self._chunk(Chunk.read(_stream(body)))
            elif opcode == Opcode.DATA_END:
                self._check(int.from_bytes(body[:4], "little"), position)
        except LogError:
            raise
        except Exception as error:  # the package and its decompressors have no common error
            what = f"{error}" or type(error).__name__
            raise LogError(f"{self.path} is damaged at byte {position} ({what}): recover what is whole") from error

    def _check(self, checksum: int, position: int) -> None:
        if checksum not in (0, zlib.crc32(memoryview(self._data)[:position])):
            raise LogError(f"{self.path} was changed after it was written: its checksum does not fit")

    def _metadata(self, metadata: Metadata) -> None:
        if metadata.name == HEADER:
            self._header = {name: msgspec.json.decode(text) for name, text in metadata.metadata.items()}

    def _channel(self, channel: Channel) -> None:
        self._topics[channel.id] = channel.topic
        kind = TYPES.get(channel.topic.removeprefix(TOPICS))
        known = kind is not None and channel.topic.startswith(TOPICS) and channel.message_encoding == "json"
        if kind is not None and known:
            self._decoders[channel.id] = msgspec.json.Decoder(kind)

    def _chunk(self, chunk: Chunk) -> None:
        for record in breakup_chunk(chunk, validate_crc=True):
            if isinstance(record, Channel):
                self._channel(record)
            elif isinstance(record, Message):
                self._message(record.channel_id, record.sequence, record.log_time, record.data)

    def _message(self, channel: int, sequence: int, log_time: int, data: bytes | memoryview) -> None:
        decoder = self._decoders.get(channel)
        if channel not in self._topics:  # as where a power failure left zeros behind a message's beginning
            raise LogError(f"{self.path}: record {sequence} is on channel {channel}, which was never declared")
        if decoder is None:
            self._skipped[self._topics[channel]] += 1
            return
        try:
            self._rows.append((sequence, log_time, decoder.decode(data)))
        except ValueError as error:  # DecodeError, ValidationError, text that is not UTF-8
            raise LogError(
                f"{self.path}: record {sequence} on {self._topics[channel]} does not decode ({error})"
            ) from error


def _stream(body: memoryview) -> ReadDataStream:
    return ReadDataStream(BytesIO(body))


def _contents(path: Path) -> bytes:
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        there = sorted(found.name for found in path.parent.glob("*.mcap"))
        near = get_close_matches(path.name, there, n=5, cutoff=0.0)
        raise LogError(f"{path} does not exist; most like it are: {', '.join(near) or 'none'}") from error
    except OSError as error:
        raise LogError(f"{path} cannot be read ({error.strerror}): expected a session's file") from error
    if not data:
        raise LogError(f"{path} is empty: nothing was recorded in it")
    if not data.startswith(MCAP0_MAGIC[: len(data)]):
        raise LogError(f"{path} is not an MCAP file: it begins with {data[:8]!r}")
    return data
