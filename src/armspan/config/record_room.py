"""The room in which takes are recorded: bands and a person, no robots."""

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec

from armspan.conductor import Settings
from armspan.conductor.recorder import Recorder
from armspan.conductor.recorder_plan import Recording
from armspan.config.demo_room import gesture_room
from armspan.config.house import House, open_house
from armspan.config.room_file import GestureEntry, RoomFile, parse_room
from armspan.config.take_edits import checked_label
from armspan.config.take_files import Sidecar, sidecar_of, write_take
from armspan.config.virtual_entries import SimulatedBand
from armspan.errors import ConfigError, DataError, LogError, known_names
from armspan.log import LogFile
from armspan.records import Arm, Press, Record, TakeEnded
from armspan.session import Mind
from armspan.simulation.gesture_script import GestureScript
from armspan.simulation.gesture_styles import LABELS

_BEGIN = 0.5
"""When [s] the set-up begins: by then every band has been heard, and has shown whether it sends raw samples."""

_WRISTS: tuple[Arm, Arm] = ("right", "left")
_SHEET = {"width_m": 1.0, "height_m": 1.0}
_BODY = {
    "eye_height_m": 1.6,
    "shoulder_to_eye_m": [0.06, 0.15, 0.22],
    "shoulder_to_fingertip_m": 0.72,
}


@dataclass
class RecordHouse(House):
    """A house whose mind is a recorder; ``simulated`` tells whether it was a virtual person that moved."""

    recorder: Recorder = field(kw_only=True)
    simulated: bool = False

    @property
    def header(self) -> dict[str, object]:
        """What a log keeps of the room and of the recording."""
        recording: object = msgspec.to_builtins(self.recorder.recording)
        return super().header | {"recording": recording, "simulated": self.simulated}

    def mind(self) -> Mind:
        """The recorder."""
        return self.recorder


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
        side = sidecar_of(take, simulated=self.simulated, recorded=self.recorded, note=done.note)
        self.written.append((write_take(self.folder, take, side), side))


def recorder_of(log: LogFile, settings: Settings) -> Recorder | None:
    """The recorder that a recording's log replays through, None where a conductor wrote the log (LogError)."""
    told = log.header.get("recording")
    if told is None:
        return None
    try:
        return Recorder(settings, msgspec.convert(told, Recording))
    except (msgspec.ValidationError, ConfigError) as error:
        raise LogError(f"{log.path} tells a recording that this version of Armspan does not know ({error})") from None


def check_labels(folder: Path, labels: Sequence[str]) -> None:
    """Refuse a folder that is a file, and labels that cannot be its folders side by side.

    Raises:
        ConfigError: a label that is no folder's name, or differs by case only from another one or from a folder.
        DataError: the folder is a file.

    """
    if folder.exists() and not folder.is_dir():
        raise DataError(f"{folder} is a file: name the folder in which the takes are to be kept")
    by_lower: dict[str, str] = {}
    for label in labels:
        other = by_lower.setdefault(checked_label(label, folder).lower(), label)
        if other != label:
            raise ConfigError(f"labels {other!r} and {label!r} differ by case only: give them different names")


def check_person(code: str) -> str:
    """A person's code that can begin a file's name (ConfigError)."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", code):
        raise ConfigError(f"person code {code!r} cannot begin a file's name: use letters, digits, _ and -, as in p01")
    return code


def read_record_room(path: Path) -> RoomFile:
    """A room file of which only the bands matter: sheet, robots and body may be missing (ConfigError)."""
    try:
        raw: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror}. `armspan init {path}` writes one") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} is not TOML: {error}") from None
    if not isinstance(raw.get("bands"), list) or not raw["bands"]:
        raise ConfigError(f"{path} has no [[bands]]: a recording needs one band on a wrist, better one on either")
    given = {"sheet": _SHEET} | raw | {"robots": [], "zones": []}
    points, worn = _raw_wrists(raw)
    if not worn:
        raise ConfigError(f"{path} has no band on a wrist: a recording needs one, better one on either")
    if twice := [wrist for k, wrist in enumerate(worn) if wrist in worn[:k]]:
        raise ConfigError(f"{path} has two bands on the {twice[0]} wrist: a recording takes one on each")
    if points not in worn:
        given["body"] = _BODY | _table(raw.get("body")) | {"arm": worn[0]}
    elif isinstance(raw.get("body", {}), dict) and ("body" in raw or not _mentions_simulated(raw)):
        given["body"] = _BODY | _table(raw.get("body"))  # measures do not matter here
    try:
        return parse_room(given, robots=False)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None


def _mentions_simulated(raw: dict[str, Any]) -> bool:
    return any(_table(band).get("kind") == "simulated" for band in raw["bands"])


def _raw_wrists(raw: dict[str, Any]) -> tuple[Arm, list[Arm]]:
    """The arm that points, and the wrists that wear a band, in a room file that is not checked yet."""
    points: Arm = _table(raw.get("body")).get("arm", "right")
    bands = [_table(band) for band in raw["bands"]]
    return points, [band.get("arm") or points for band in bands if band.get("segment", "forearm") == "forearm"]


def _table(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def virtual_room(seed: int) -> RoomFile:
    """A room with a virtual person who wears a band on either wrist."""
    return gesture_room(seed)


def wrists_of(room: RoomFile) -> tuple[Arm, ...]:
    """The wrists that wear a band."""
    points: Arm = (room.body or {}).get("arm", "right")
    worn = {band.arm or points for band in room.bands if band.segment == "forearm"}
    return tuple(wrist for wrist in _WRISTS if wrist in worn)


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
    simulated = is_simulated(room) or any(map(_was_simulated, house.logs.values()))
    if house.world is not None and is_simulated(room):
        house.world.script = GestureScript("setup", _BEGIN)
    else:
        _lead(house)
    return RecordHouse(
        house.settings,
        house.world,
        house.logs,
        house.replayed,
        doors=house.doors,
        now=house.now,
        recorder=recorder,
        simulated=simulated,
    )


def _was_simulated(log: LogFile) -> bool:
    """Whether a virtual person moved in a log: older ones say so by an epoch of zero only."""
    return bool(log.header.get("simulated", log.header.get("epoch_ns") == 0))


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
