"""Writing a session: every record at once, flushed often enough that a crash costs a quarter of a second."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, cast

import msgspec
from mcap.writer import CompressionType, IndexType, Writer

from armspan.errors import LogError, known_names
from armspan.log.layout import HEADER, TOPICS, TYPES, schema_of
from armspan.records import Record, Stop, is_finite

FLUSH_NS = 250_000_000
"""A crash costs at most the records of this much session time [ns]."""

LATEST_NS = 2**63 - 1
"""Viewers keep times in signed 64 bits [ns]."""


class LogWriter:
    """A session's file, open for writing; call it with a record: it is a ``Sink``.

    ``header`` holds what a person wants to know of the session later (settings, version, wall-clock start
    [ns], 0 for a seeded simulation); its values are what JSON can hold. The file is proper MCAP once closed.

    Raises:
        LogError: the file exists and ``overwrite`` is not set; it cannot be written; a header or a record
            that JSON cannot hold exactly (NaN and infinity among them); a record after the end.

    """

    def __init__(self, path: str | Path, header: Mapping[str, object], *, overwrite: bool = False) -> None:
        metadata = {name: _json_text(name, value) for name, value in header.items()}
        self.path = Path(path)
        self._stream = create(self.path, overwrite=overwrite)
        self._writer = Writer(
            self._stream,
            compression=CompressionType.NONE,
            index_types=IndexType.METADATA,
            use_chunking=False,
            enable_data_crcs=True,
        )
        self._channels: dict[type[Record], int] = {}
        self._sequence = 0
        self._log_time = 0
        self._flushed = 0
        with self._told():
            self._writer.start(library="armspan")
            self._writer.add_metadata(HEADER, metadata)
            self._stream.flush()

    def __call__(self, record: Record) -> None:
        """Append a record, as a sink."""
        self.write(record)

    def write(self, record: Record, arrived: float | None = None) -> None:
        """Append a record that ``arrived`` at that session time [s], at its own ``t`` where not told."""
        if self._stream.closed:
            raise LogError(f"{self.path} is closed and takes no {_name(record)} any more: open another file")
        data = _encoded(record)
        self._log_time = max(self._log_time, _nanoseconds(record.t if arrived is None else arrived))
        with self._told():
            self._writer.add_message(
                channel_id=self._channels.get(type(record)) or self._register(type(record)),
                log_time=self._log_time,
                data=data,
                publish_time=_nanoseconds(record.t),
                sequence=self._sequence & 0xFFFFFFFF,
            )
            if self._log_time - self._flushed >= FLUSH_NS or isinstance(record, Stop):
                self._stream.flush()
                self._flushed = self._log_time
        self._sequence += 1

    def close(self) -> None:
        """End the file properly: statistics, channels, footer. A second time does nothing."""
        if self._stream.closed:
            return
        with self._told():
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.close()

    def __enter__(self) -> "LogWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _register(self, kind: type[Record]) -> int:
        name = kind.__name__
        if TYPES.get(name) is not kind:
            raise LogError(known_names("The record type", name, TYPES))
        schema = self._writer.register_schema(name, "jsonschema", schema_of(kind))
        self._channels[kind] = self._writer.register_channel(TOPICS + name, "json", schema)
        return self._channels[kind]

    @contextmanager
    def _told(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            with suppress(OSError):  # what is half written must stay the file's end
                self._stream.close()
            raise LogError(
                f"{self.path} cannot be written any more ({error.strerror}): make room, or log elsewhere"
            ) from error


def create(path: Path, *, overwrite: bool) -> BinaryIO:
    """Open a new file for writing; one that exists only where ``overwrite`` says so (LogError)."""
    try:
        return cast(BinaryIO, path.open("wb" if overwrite else "xb"))
    except FileExistsError as error:
        raise LogError(f"{path} exists already: choose another name, or ask to overwrite it") from error
    except OSError as error:
        raise LogError(f"{path} cannot be created ({error.strerror}): choose another place") from error


def _nanoseconds(seconds: float) -> int:
    return round(min(max(0.0, seconds * 1e9), LATEST_NS))


def _encoded(record: Record) -> bytes:
    if not is_finite(record):
        raise LogError(f"{record} is not finite and JSON cannot hold it: leave it out before the log")
    try:
        return msgspec.json.encode(record)
    except (TypeError, ValueError, OverflowError) as error:
        raise LogError(f"{record} cannot be logged ({error}): use plain floats, texts and tuples") from error


def _json_text(name: str, value: object) -> str:
    try:
        text = json.dumps(msgspec.to_builtins(value, str_keys=True), allow_nan=False, ensure_ascii=False)
        text.encode()
    except (TypeError, ValueError) as error:
        raise LogError(
            f"the log's header has {name} = {value!r} ({error}):"
            " use what JSON can hold, which is texts, finite numbers, lists and tables"
        ) from error
    return text


def _name(record: Record) -> str:
    return type(record).__name__
