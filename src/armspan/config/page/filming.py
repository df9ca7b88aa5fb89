"""A log worked through in a process of its own, so that a page goes on meanwhile: its frames, or its tables.

``python -m armspan.config.page.filming frames LOG`` writes to stdout, each behind its length in four bytes: an
`Opening` or a `Trouble` as JSON, then one `packed` second of frames after the other. ``tables LOG ZIP`` writes a ZIP
file and to stdout nothing, or a `Trouble`.
"""

import os
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import msgspec

from armspan.conductor import Settings
from armspan.conductor.robots_only import RobotsOnly
from armspan.conductor.sight import Sight
from armspan.config.recalled import mind_of, settings_of
from armspan.errors import ArmspanError
from armspan.log import LogFile, export_csv, read
from armspan.records import EVENTS
from armspan.session import Mind
from armspan.web.film import LONGEST, RATE_HZ, Opening, Second, packed
from armspan.web.shown import Shown


class Trouble(msgspec.Struct, frozen=True):
    """Why a log cannot be worked through."""

    trouble: str


class Recalled:
    """What decided in a session that was logged, decided anew; what it did decide is in the log beside."""

    def __init__(self, mind: Mind, settings: Settings) -> None:
        self.mind, self._settings = mind, settings

    @property
    def settings(self) -> Settings:
        """The room at this place of the log."""
        return getattr(self.mind, "settings", self._settings)

    def sight(self) -> Sight | None:
        """What is believed at this place of the log; nothing for a mind without an arm."""
        return None if isinstance(self.mind, RobotsOnly) else self.mind.sight()  # type: ignore[attr-defined]


def recalled(log: LogFile) -> Recalled:
    """The mind of a log, that nothing was told yet.

    Raises:
        LogError: settings or a recording that this version of Armspan does not know.
        ModelError: a model that it does not know.

    """
    settings = settings_of(log)
    return Recalled(mind_of(log, settings), settings)


def opening(log: LogFile) -> Opening:
    """What is to be known of a log before its frames."""
    seconds = log.arrivals[-1] if log.arrivals else 0.0
    notes = []
    if not log.complete:
        notes.append("The log was cut off; what is whole of it is shown.")
    if seconds > LONGEST:
        notes.append(f"The log lasts {seconds / 60:.0f} minutes; the first {LONGEST // 60} are shown.")
    return Opening(min(seconds, float(LONGEST)), bool(log.header.get("epoch_ns") == 0), " ".join(notes))


def seconds_of(log: LogFile) -> Iterator[Second]:
    """A log's frames at `RATE_HZ`, second by second: the logged records, and the arms as they are believed anew."""
    mind = recalled(log)
    shown = Shown()
    shown.clear(mind, simulated=opening(log).simulated)  # type: ignore[arg-type]
    frames: list[dict[str, object]] = []
    count = 0
    for record, arrived in zip(log.records, log.arrivals, strict=True):
        while arrived >= (count + 1) / RATE_HZ:
            frames.append(shown.frame())
            count += 1
            if len(frames) == RATE_HZ:
                yield Second(shown.room(), frames)
                frames = []
            if count >= LONGEST * RATE_HZ:
                return
        if isinstance(record, EVENTS):
            mind.mind.step(record)  # type: ignore[arg-type]
        shown(record)
    yield Second(shown.room(), [*frames, shown.frame()])


def write_frames(path: Path, out: BinaryIO) -> None:
    """Write a log's frames as they are made."""
    log = read(path)
    _put(out, msgspec.json.encode(opening(log)))
    for second in seconds_of(log):
        _put(out, packed(second))


def write_tables(path: Path, target: Path) -> None:
    """Write a log's tables into a ZIP file."""
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as packed_tables:
        for table in export_csv(path, folder):
            packed_tables.write(table, table.name)


def _put(out: BinaryIO, data: bytes) -> None:
    out.write(len(data).to_bytes(4, "little") + data)
    out.flush()


def main(words: list[str]) -> None:
    """Do what the command line says."""
    try:
        if words[0] == "frames":
            write_frames(Path(words[1]), sys.stdout.buffer)
        else:
            write_tables(Path(words[1]), Path(words[2]))
    except ArmspanError as error:
        _put(sys.stdout.buffer, msgspec.json.encode(Trouble(str(error))))
    except BrokenPipeError:  # nobody looks any more
        sys.stderr.close()


if __name__ == "__main__":
    if hasattr(os, "nice"):
        os.nice(10)  # a session that runs meanwhile comes first
    main(sys.argv[1:])
