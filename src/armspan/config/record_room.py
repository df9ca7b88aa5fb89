"""The room in which takes are recorded: bands and a person, no robots."""

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec

from armspan.conductor.recorder import Recorder
from armspan.conductor.recorder_plan import Recording
from armspan.config.demo_room import gesture_room
from armspan.config.house import House, open_house
from armspan.config.room_file import (
    GestureEntry,
    ReplayedBand,
    RoomFile,
    SimulatedBand,
    parse_room,
)
from armspan.config.take_files import Sidecar, write_take
from armspan.devices import replay, simulated
from armspan.errors import ConfigError, known_names
from armspan.log import LogFile
from armspan.ports import Sink, Swarm
from armspan.records import Arm, Press, Record, TakeEnded
from armspan.session import Session
from armspan.simulation.gesture_script import GestureScript
from armspan.simulation.gesture_styles import LABELS

_BEGIN = 0.5
"""When [s] the set-up begins: by then every band has been heard, and has shown whether it sends raw samples."""

_SHEET = {"width_m": 1.0, "height_m": 1.0}
_BODY = {
    "eye_height_m": 1.6,
    "shoulder_to_eye_m": [0.06, 0.15, 0.22],
    "shoulder_to_fingertip_m": 0.72,
}


@dataclass(slots=True)
class RecordHouse(House):
    """A house whose mind is a recorder."""

    recorder: Recorder = field(kw_only=True)

    @property
    def header(self) -> dict[str, object]:
        """What a log keeps of the room and of the recording."""
        recording: dict[str, object] = {"recording": msgspec.to_builtins(self.recorder.recording)}
        return House.header.__get__(self) | recording

    def session(self, sinks: Sequence[Sink]) -> Session:
        """The session of this house; the world hears everything too."""
        swarm: Swarm = simulated.SimulatedSwarm(self.world) if self.world else replay.NoSwarm()
        heard: list[Sink] = [self._hear] if self.world else []
        return Session(self.recorder, swarm, [*sinks, *heard])


class TakeWriter:
    """A sink that writes every take as soon as it is finished; ``written`` are the files, in order."""

    def __init__(self, folder: Path, recorder: Recorder, *, simulated: bool, recorded: str | None) -> None:
        self.folder, self.recorder = folder, recorder
        self.simulated, self.recorded = simulated, recorded
        self.written: list[tuple[Path, Sidecar]] = []

    def __call__(self, record: Record) -> None:
        """Write the take that ended."""
        if not isinstance(record, TakeEnded):
            return
        done = self.recorder.finished.popleft()
        take = done.take
        side = Sidecar(
            label=take.label,
            person=take.person,
            number=take.number,
            practice=take.practice,
            rate_hz=round(take.rate, 2),
            gesture_s=take.gesture,
            simulated=self.simulated,
            recorded=self.recorded,
            note=done.note,
        )
        self.written.append((write_take(self.folder, take, side), side))


def read_record_room(path: Path) -> RoomFile:
    """A room file of which only the bands matter: sheet, robots and body may be missing (ConfigError)."""
    try:
        raw: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror}. `armspan init {path}` writes one") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} is not TOML: {error}") from None
    if not raw.get("bands"):
        raise ConfigError(f"{path} has no [[bands]]: a recording needs one band on a wrist, better one on either")
    given = {"sheet": _SHEET, "robots": []} | raw
    if not any(isinstance(band, dict) and band.get("kind") == "simulated" for band in raw["bands"]):
        given.setdefault("body", _BODY)
    try:
        return parse_room(given)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None


def virtual_room(seed: int) -> RoomFile:
    """A room with a virtual person who wears a band on either wrist."""
    return gesture_room(seed)


def wrists_of(room: RoomFile) -> tuple[Arm, ...]:
    """The wrists that wear a band."""
    points: Arm = (room.body or {}).get("arm", "right")
    worn = {band.arm or points for band in room.bands if band.segment == "forearm"}
    return tuple(wrist for wrist in _WRISTS if wrist in worn)


_WRISTS: tuple[Arm, Arm] = ("right", "left")


def is_simulated(room: RoomFile) -> bool:
    """Whether a virtual person wears the bands."""
    return any(isinstance(band, SimulatedBand) for band in room.bands)


def open_record_house(room: RoomFile, recording: Recording, folder: Path = Path()) -> RecordHouse:
    """Make a room's bands and the recorder that listens to them; its robots stay away.

    Raises:
        ConfigError: the bands cannot serve the recording, or the virtual person knows no such gesture.
        LogError: a replayed log cannot be read.

    """
    if is_simulated(room):
        _check_virtual(recording)
    house = open_house(_bands_only(room), folder)
    recorder = Recorder(house.settings, recording)
    if house.world is not None and is_simulated(room):
        house.world.script = GestureScript("setup", _BEGIN)
    else:
        _lead(house)
    return RecordHouse(house.settings, house.world, house.logs, house.replayed, recorder=recorder)


def _check_virtual(recording: Recording) -> None:
    for label in recording.gestures:
        if label not in LABELS:
            raise ConfigError(f"the virtual person: {known_names('gesture', label, LABELS)}")
    if recording.taps:
        raise ConfigError("virtual bands have no button: leave --taps out, or name a room with real bands")


def _bands_only(room: RoomFile) -> RoomFile:
    """The room without robots, zones and trials; a virtual person always has both arms."""
    asks = msgspec.structs.replace(room.simulation.person, trials=0, gestures=())
    bands = room.bands
    if is_simulated(room) and len(wrists_of(room)) == 1:
        other: Arm = "left" if wrists_of(room) == ("right",) else "right"
        bands = (*bands, SimulatedBand(f"other_{other}", arm=other))
    return msgspec.structs.replace(
        room,
        bands=bands,
        robots=(),
        zones=(),
        gestures=GestureEntry(),
        simulation=msgspec.structs.replace(room.simulation, person=asks),
    )


def _lead(house: House) -> None:
    """Begin the set-up in a replayed log that does not do so itself."""
    for name, log in list(house.logs.items())[:1]:
        if not any(isinstance(record, Press) and record.name == "setup" for record in log.records):
            house.logs[name] = _with_setup(log)


def _with_setup(log: LogFile) -> LogFile:
    place = next((k for k, t in enumerate(log.arrivals) if t >= _BEGIN), len(log.records))
    press: list[Record] = [Press(_BEGIN, "setup")]
    records = [*log.records[:place], *press, *log.records[place:]]
    return replace(log, records=records, arrivals=[*log.arrivals[:place], _BEGIN, *log.arrivals[place:]])
