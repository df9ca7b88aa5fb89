"""ROOM.toml: what stands in the room. Every number says its unit in its name."""

import math
import re
import tomllib
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, Literal

import msgspec

from armspan.conductor import BandSettings, Settings
from armspan.conductor.places import check_place, check_zone
from armspan.config.body_file import body_from_table
from armspan.config.recordings import UNIT_TOLERANCE
from armspan.config.virtual_entries import ReplayedBand, ReplayedRobot, SimulatedBand, SimulatedRobot, Simulation
from armspan.devices.cellulo.entry import CelluloEntry
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.phone.entry import PhoneEntry
from armspan.devices.receptor.entry import ReceptorEntry, robots_of
from armspan.devices.toio.entry import ToioEntry
from armspan.errors import ConfigError, known_names
from armspan.pointing.laser import LaserSettings
from armspan.pointing.selection import SelectionSettings
from armspan.records import Body, Model, Sheet, Vec2, Zone
from armspan.swarm.director import DICTIONARY, STOP, order_name
from armspan.swarm.limits import Limits

_ANYBODY = Body(1.6, (0.06, 0.15, 0.22), 0.72)

BandEntry = SimulatedBand | ReplayedBand | MetaWearEntry | PhoneEntry
RobotEntry = SimulatedRobot | ReplayedRobot | CelluloEntry | ToioEntry


KINDS = {
    "bands": ("simulated", "replay", "metawear", "phone"),
    "robots": ("simulated", "replay", "cellulo", "toio"),
    "receptors": ("serial", "udp", "http"),
}
"""What an entry can be, by its table."""


class ZoneEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A named polygon on the sheet."""

    name: str
    polygon_m: tuple[Vec2, ...]


class GestureEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Arm gestures: the ``model`` of `armspan train` that knows them, and which behaviour each begins.

    A gesture commands the robots that were chosen by pointing in the ``choice_s`` before it, or else all.
    """

    model: str | None = None
    choice_s: float = 8.0
    behaviours: dict[str, str] = msgspec.field(default_factory=DICTIONARY.copy)


class RoomFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A whole room. ``body`` may be left out where the person is simulated: it is then measured by virtual tape."""

    sheet: Sheet
    bands: tuple[BandEntry, ...]
    robots: tuple[RobotEntry, ...]
    body: dict[str, Any] | None = None
    zones: tuple[ZoneEntry, ...] = ()
    stops_m: tuple[Vec2, ...] = ()
    model: Model | None = None
    posture: Literal["straight", "natural"] = "straight"
    table_height_m: float | None = None
    light_height_m: float = 0.045
    led_zero_deg: float = 0.0
    feedback: bool = False
    radio: str | None = None
    limits: Limits = Limits()
    selection: SelectionSettings = SelectionSettings()
    gestures: GestureEntry = GestureEntry()
    laser: LaserSettings | None = None
    receptors: tuple[ReceptorEntry, ...] = ()
    simulation: Simulation = Simulation()

    def settings(self, body: Body) -> Settings:
        """What the conductor needs of it."""
        bands = tuple(
            BandSettings(
                band.name,
                band.segment,
                getattr(band, "rate_hz", 100.0),
                band.wrist_from_sensor,
                band.arm,
                getattr(band, "stale_s", 0.2),
            )
            for band in self.bands
        )
        return Settings(
            body=body,
            sheet=self.sheet,
            bands=bands,
            robots=tuple(robot.name for robot in self.robots),
            zones=tuple(Zone(zone.name, zone.polygon_m) for zone in self.zones),
            stops=self.stops_m or default_stops(self.sheet),
            model=self.model,
            posture=self.posture,
            table_height_m=self.table_height_m,
            light_height_m=self.light_height_m,
            led_zero_deg=self.led_zero_deg or self._first_light_deg(),
            limits=self.limits,
            selection=self.selection,
            feedback=self.feedback,
            gestures={label: order_name(order) for label, order in self.gestures.behaviours.items()},
            dice=self.simulation.seed,
            choice_s=self.gestures.choice_s,
            laser=self._laser(),
        )

    def _first_light_deg(self) -> float:
        """Where the first light at or after straight ahead sits on the robots: one answer for all (ConfigError)."""
        cellulos = [robot for robot in self.robots if isinstance(robot, CelluloEntry)]
        first = {round(robot.traits.ring.first_deg, 6): robot.name for robot in cellulos}
        if len(first) > 1:
            (a, one), (b, other) = list(first.items())[:2]
            raise ConfigError(
                f"the lights of {one!r} and {other!r} sit at {a:g} and {b:g} degrees; the cursor needs robots whose "
                "led_zero_deg differ by whole sixths of a turn"
            )
        return next(iter(first), 0.0)

    def _laser(self) -> LaserSettings | None:
        """The laser with all robots that have a receptor; with receptors alone it is where it usually is."""
        names = tuple(robot.name for robot in self.robots)
        spoken = [robot for entry in self.receptors for robot in robots_of(entry, names)]
        virtual = [robot.name for robot in self.robots if getattr(robot, "receptor", False)]
        fitted = tuple(dict.fromkeys((*(self.laser.receptors if self.laser else ()), *spoken, *virtual)))
        if self.laser is None and not fitted:
            return None
        return msgspec.structs.replace(self.laser or LaserSettings(), receptors=fitted)


def default_stops(sheet: Sheet, inset: float = 0.08) -> tuple[Vec2, ...]:
    """Four stops [m] near the sheet's corners, in the order of a drive round it."""
    x0, x1, y0, y1 = inset, sheet.width_m - inset, inset, sheet.height_m - inset
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def read_room(path: Path) -> RoomFile:
    """A room file, checked.

    Raises:
        ConfigError: one sentence with the file, the place in it and what was expected.

    """
    try:
        raw = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(
            f"{path} cannot be read: {error.strerror}. `armspan init {path}` writes one to start from"
        ) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} is not TOML: {error}") from None
    try:
        room = parse_room(raw)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None
    return room


def parse_room(raw: dict[str, Any], *, robots: bool = True) -> RoomFile:
    """A room from parsed TOML; one without ``robots`` will do where takes are recorded.

    Raises:
        ConfigError: what is wrong, where, and what was expected.

    """
    for place, number in _numbers(raw):
        if not math.isfinite(number):
            raise ConfigError(f"at {place}: {number} is not a finite number")
    try:
        room = msgspec.convert(raw, RoomFile)
    except msgspec.ValidationError as error:
        cause = error.__cause__
        raise ConfigError(str(cause) if isinstance(cause, ConfigError) else _in_words(str(error))) from None
    _check(room, robots)
    return room


def _in_words(text: str) -> str:
    """A validation error as a sentence: the place in the file first."""
    what, _, place = text.partition(" - at `")
    place = place.rstrip("`").removeprefix("$").removeprefix(".") or "the top of the file"
    wrong = re.fullmatch(r"Invalid value '(.*)'", what)
    if wrong and place.endswith(".kind"):
        return f"at {place}: {known_names('kind', wrong[1], KINDS.get(place.partition('[')[0], ()))}"
    return f"at {place}: {what[:1].lower()}{what[1:]}; see the comments of a file written by `armspan init`"


def _numbers(value: object, place: str = "") -> Iterator[tuple[str, float]]:
    """Every float with its place in the file."""
    if isinstance(value, float):
        yield place, value
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _numbers(item, f"{place}.{key}".removeprefix("."))
    elif isinstance(value, list):
        for number, item in enumerate(value):
            yield from _numbers(item, f"{place}[{number}]")


def _check(room: RoomFile, robots: bool) -> None:
    if not room.bands or (robots and not room.robots):
        raise ConfigError("the room needs at least one entry in [[bands]] and one in [[robots]]")
    for size, name in ((room.sheet.width_m, "width_m"), (room.sheet.height_m, "height_m")):
        if not 0.05 <= size <= 20:
            raise ConfigError(f"sheet.{name} is {size}; expected metres between 0.05 and 20")
    for name, height, most in (
        ("table_height_m", room.table_height_m or 0.0, 2.0),
        ("simulation.table_height_m", room.simulation.table_height_m, 2.0),
        ("light_height_m", room.light_height_m, 0.5),
    ):
        if not 0 <= height <= most:
            raise ConfigError(f"{name} is {height}; expected metres between 0 and {most:g}")
    for zone in room.zones:
        check_zone(Zone(zone.name, zone.polygon_m), room.sheet)
    for stop in room.stops_m:
        check_place("the stop", stop, room.sheet)
    for robot in room.robots:
        if isinstance(robot, SimulatedRobot):
            check_place(f"the start of robot {robot.name!r},", robot.start_m, room.sheet)
    for band in room.bands:
        _check_band(band)
    _check_addresses(room)
    _check_simulation(room)
    _check_gestures(room.gestures, {zone.name for zone in room.zones})
    if room.stops_m and len(room.stops_m) < 3:
        raise ConfigError(
            f"stops_m has {len(room.stops_m)} stops; the set-up needs three that are not on one line, better four"
        )
    if room.body is None and not any(isinstance(band, SimulatedBand) for band in room.bands):
        raise ConfigError("[body] is missing: a real person's measures are needed")
    # Names, segments and the model are checked there.
    room.settings(_ANYBODY if room.body is None else body_from_table(room.body, "the room"))


def _check_gestures(gestures: GestureEntry, zones: Collection[str]) -> None:
    named = {}
    for label, behaviour in gestures.behaviours.items():
        zone = behaviour.partition("@")[2].strip()
        try:
            named[label] = order_name(behaviour)
        except ConfigError as error:
            raise ConfigError(f"gestures.behaviours.{label}: {error}") from None
        if "@" in behaviour and zone not in zones:
            raise ConfigError(f"gestures.behaviours.{label}: {known_names('zone', zone, zones)}")
    if STOP not in named.values():
        raise ConfigError(
            f"gestures.behaviours maps no gesture to {STOP!r}; one must always stop the robots: add stop = {STOP!r}"
        )


def _check_band(band: BandEntry) -> None:
    rate, turn = getattr(band, "rate_hz", 100.0), band.wrist_from_sensor
    if not 1 <= rate <= 2000:
        raise ConfigError(f"band {band.name!r} has rate_hz = {rate}; expected 1 to 2000 samples a second")
    if turn is not None and abs(math.hypot(*turn) - 1.0) > UNIT_TOLERANCE:
        raise ConfigError(
            f"band {band.name!r} has wrist_from_sensor = {list(turn)} of length {math.hypot(*turn):.3f}; a unit "
            "quaternion (w, x, y, z) has length 1"
        )


def _check_addresses(room: RoomFile) -> None:
    """No two bands, and no two robots on one radio, are the same device."""
    first: dict[str, str] = {}
    for device in (*room.bands, *(robot for robot in room.robots if isinstance(robot, ToioEntry))):
        address = getattr(device, "address", None)
        if isinstance(address, str) and address in first:
            raise ConfigError(
                f"{first[address]!r} and {device.name!r} both have the address {address}; each device has its own"
            )
        if isinstance(address, str):
            first[address] = device.name


def _check_simulation(room: RoomFile) -> None:
    wanted = room.simulation
    if wanted.seed < 0 or wanted.person.trials < 0:
        raise ConfigError(
            f"simulation has seed = {wanted.seed} and person.trials = {wanted.person.trials}; expected whole numbers "
            "from 0"
        )
    simulated = any(isinstance(band, SimulatedBand) for band in room.bands)
    strange = [robot for robot in room.robots if not isinstance(robot, SimulatedRobot)]
    if simulated and strange:
        kind = "replayed" if isinstance(strange[0], ReplayedRobot) else "real"
        raise ConfigError(
            f"robot {strange[0].name!r} is {kind}, but a simulated person can only point at simulated robots: let the "
            "bands be of its kind too, or simulate the robot"
        )
