"""Takes recorded from the page: checked, led by the recorder, each written as soon as it is finished."""

import datetime
from collections.abc import Sequence
from pathlib import Path

from armspan.conductor.recorder_plan import Recording, asks_of
from armspan.config.record_room import (
    RecordHouse,
    TakeWriter,
    check_labels,
    check_person,
    is_simulated,
    open_record_house,
    wrists_of,
)
from armspan.config.room_file import RoomFile
from armspan.config.take_files import next_number
from armspan.errors import ConfigError, DataError
from armspan.gesture.takes import NULL
from armspan.records import Record
from armspan.session import Session
from armspan.web.views.gestures_host import Asked

HURRY = 10.0
"""How many times faster than a person a virtual one in a hurry is."""

MOST_TAKES, LONGEST_NULL = 50, 3600.0


class Recorded:
    """A recording that is ready to run: its house, and the sink that writes its takes."""

    def __init__(self, house: RecordHouse, takes: Path, *, hurried: bool = False) -> None:
        self.house, self.hurried = house, hurried and house.simulated and not house.doors
        today = f"{datetime.date.today():%Y-%m-%d}" if house.doors else None
        self._writer = TakeWriter(takes, house.recorder, simulated=house.simulated, recorded=today)
        self._asked = len(asks_of(house.recorder.recording))

    @property
    def progress(self) -> tuple[int, int]:
        """Takes finished (spoilt ones are asked for again) and asked for."""
        return sum(not side.note for _, side in self._writer.written), self._asked

    def __call__(self, record: Record) -> None:
        """Write the take that ended (DataError: it cannot be written)."""
        try:
            self._writer(record)
        except OSError as error:
            folder = self._writer.folder
            raise DataError(f"the take cannot be written to {folder} ({error}): make room for it") from None

    async def run(self, session: Session) -> None:
        """Record until all is done, or the recording is ended."""
        await self.house.run(session, live=True, times=HURRY if self.hurried else 1.0)


def ready(room: RoomFile, folder: Path, takes: Path, asked: Asked) -> Recorded:
    """Check what is asked for, and make the house that records it.

    Raises:
        ConfigError: what is asked for cannot be, or the room's bands cannot serve it.
        DataError: the folder of takes is a file.
        LogError: a replayed log cannot be read.

    """
    person = check_person(asked.person.strip())
    labels = _checked(asked)
    named = [*labels, *([NULL] if asked.null_s else [])]
    check_labels(takes, named)
    wrists = wrists_of(room)
    if not wrists:
        raise ConfigError("no band is worn on a wrist in this room: gestures need one, better one on either")
    first = {label: next_number(takes, label, person) for label in named}
    recording = Recording(labels, asked.takes, person, asked.null_s, wrists, asked.taps, first=first)
    house = open_record_house(room, recording, folder)
    return Recorded(house, takes, hurried=asked.hurried and is_simulated(room))


def _checked(asked: Asked) -> tuple[str, ...]:
    """The gestures, each once, with numbers that can be meant (ConfigError)."""
    labels: Sequence[str] = [label.strip() for label in asked.gestures]
    if not labels and not asked.null_s:
        raise ConfigError("nothing is to be recorded: choose a gesture, or enter seconds of everyday motion")
    if NULL in labels:
        raise ConfigError(f"{NULL!r} stands for everyday motion and is no gesture: enter its seconds instead")
    if twice := [label for k, label in enumerate(labels) if label in labels[:k]]:
        raise ConfigError(f"gesture {twice[0]!r} is asked for twice: name each once")
    if not 1 <= asked.takes <= MOST_TAKES:
        raise ConfigError(f"{asked.takes} takes of each gesture: expected 1 to {MOST_TAKES}, best 5")
    if not 0 <= asked.null_s <= LONGEST_NULL:
        raise ConfigError(f"{asked.null_s:g} s of everyday motion: expected 0 to {LONGEST_NULL:g}, best 600")
    return tuple(labels)
