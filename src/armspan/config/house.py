"""An open house: the room's devices made, its conductor ready, its doors in step."""

import time
from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import AsyncExitStack, aclosing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import msgspec
import numpy as np

from armspan import __version__
from armspan.conductor import Conductor, Settings
from armspan.config.doors import Doors, make_doors
from armspan.config.emulated import BandKind, Emulation, RobotKind
from armspan.config.fleet import Fleet
from armspan.config.live import Lead, led
from armspan.config.model_files import in_header, read_model
from armspan.config.room_file import RoomFile
from armspan.config.virtual_entries import ReplayedBand, ReplayedRobot, SimulatedBand, SimulatedRobot
from armspan.config.virtual_world import body_of, draw_wearer, virtual_world
from armspan.devices import replay, simulated
from armspan.errors import ConfigError, known_names
from armspan.gesture.model import GestureModel
from armspan.log import LogFile, read
from armspan.ports import Pace, Sink, Source, Swarm
from armspan.records import COMMANDS, EVENTS, Event, ImuSample, Press, Record, RobotState, Tick
from armspan.session import FastPace, LivePace, Mind, Session, Stopwatch
from armspan.simulation.world import World
from armspan.swarm.director import DICTIONARY, STOP


@dataclass(slots=True)
class House:
    """A room with its doors made and not yet opened; ``run`` opens them."""

    settings: Settings
    world: World | None
    logs: dict[str, LogFile]
    replayed: dict[str, set[str]]
    seconds: float | None = None
    model: GestureModel | None = None
    doors: Doors = field(default_factory=Doors)
    emulation: Emulation | None = None
    now: Stopwatch = field(default_factory=Stopwatch)
    lead: Lead = field(init=False)
    reports: dict[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.lead = Lead(self.now, [band.name for band in self.settings.bands], self.seconds)

    @property
    def lasts(self) -> bool:
        """Whether something here lives by the wall's clock: real or emulated devices."""
        return bool(self.doors) or self.emulation is not None

    @property
    def header(self) -> dict[str, object]:
        """What a log keeps of the room; epoch 0 where time is simulated or replayed, and starts at zero."""
        header: dict[str, object] = {
            "armspan": __version__,
            "epoch_ns": time.time_ns() - round(1e9 * self.now()) if self.lasts else 0,
            "settings": msgspec.to_builtins(self.settings),
        }
        return header | (in_header(self.model) if self.model is not None else {})

    def session(self, sinks: Sequence[Sink]) -> Session:
        """The session of this house; the world hears everything too."""
        heard: list[Sink] = [*([self._hear] if self.world else []), *([self.lead.hear] if self.lasts else [])]
        return Session(self.mind(), Fleet(self._commanded()), [*sinks, *heard])

    def _commanded(self) -> dict[str, Swarm]:
        """Who takes commands for whom: virtual and replayed robots, and those of the devices."""
        virtual: Swarm = simulated.SimulatedSwarm(self.world) if self.world else replay.NoSwarm()
        return {robot: virtual for robot in self.settings.robots} | self.doors.commanded

    def mind(self) -> Mind:
        """What decides in this house."""
        return Conductor(self.settings, self.model)

    async def run(self, session: Session, *, live: bool, times: float = 1.0) -> None:
        """Open all doors together and go on until every source that can end has ended.

        Live, a virtual room goes so many ``times`` as fast as the wall's clock.

        Raises:
            ConfigError: for devices that live by the wall's clock, faster than it.

        """
        if self.lasts:
            if not live:
                raise ConfigError("real and emulated devices live by the clock: leave --pace fast out")
            if times != 1.0:
                raise ConfigError("real and emulated devices live by the clock: leave --speed out")
            await self._run_devices(session)
            return
        fast = FastPace(session)
        sources: list[Source] = []
        for make in self._makers():
            if live:
                sources.append(make(LivePace(times=times)))
            else:
                door = fast.door()
                sources.append(door.through(make(door)))
        await session.run(sources)

    async def _run_devices(self, session: Session) -> None:
        """Real or emulated devices, and whatever is simulated or replayed beside them, on one clock."""
        async with AsyncExitStack() as stack:
            if self.emulation is not None:
                doors = await stack.enter_async_context(self.emulation.opened(self.now))
                if isinstance(session.swarm, Fleet):
                    session.swarm.add(doors.commanded)
                leading, beside = self.emulation.source(self.now, self.seconds), []
            else:
                doors, leading = self.doors, self.lead.source()
                beside = [led(make(LivePace(self.now))) for make in self._makers()]
            leading = self._noted(leading, doors)
            await session.run([leading], [*(driver.source() for driver in doors.drivers), *beside])

    async def _noted(self, leading: Source, doors: Doors) -> AsyncGenerator[Event, None]:
        """The leading source; what the devices went through is noted when it ends, before they are closed."""
        async with aclosing(leading):
            async for event in leading:
                yield event
        self.reports = doors.reports()

    def _makers(self) -> list[Callable[[Pace], Source]]:
        """One maker for each source; the first one also brings the ticks and the presses."""
        makers: list[Callable[[Pace], Source]] = []
        if self.world is not None:
            makers.append(partial(simulated.source, self.world, seconds=self._world_seconds()))
        for name, log in self.logs.items():
            records = events_of(self.replayed[name], log, leading=not makers)
            makers.append(partial(replay.source, records, seconds=self.seconds))
        return makers

    def _world_seconds(self) -> float | None:
        """How long the virtual world goes on: without a person only as long as there is something to replay."""
        if self.seconds is not None or self.world is None or self.world.person is not None or self.lasts:
            return self.seconds
        return max((record.t for log in self.logs.values() for record in log.records), default=0.0)

    def _hear(self, record: Record) -> None:
        if self.world is not None and not isinstance(record, COMMANDS):
            self.world.take(record)


def open_house(room: RoomFile, folder: Path = Path(), seconds: float | None = None, *, guided: bool = False) -> House:
    """Make a room's devices; relative names of logs are looked for in ``folder``; is a virtual person led by others?

    Raises:
        ConfigError: when the room asks for what cannot be had.
        LogError: when a replayed log cannot be read.
        ModelError: when the gesture model cannot be read.

    """
    rng = np.random.default_rng(room.simulation.seed)
    bands = [band for band in room.bands if isinstance(band, SimulatedBand)]
    robots = [robot for robot in room.robots if isinstance(robot, SimulatedRobot)]
    person = draw_wearer(room.simulation.person, room, rng) if bands else None
    body = body_of(room, person, rng)
    settings = room.settings(body)
    world = None
    if bands or robots:
        world = virtual_world(room, settings, person, bands, robots, rng, guided=guided)
    model = read_model(folder / room.gestures.model) if room.gestures.model else None
    if model is not None:
        _check_labels(settings.gestures, model.facts.labels)
    house = House(settings, world, _logs(room, folder), replayed_devices(room), seconds, model)
    house.doors = make_doors(room, house.now, folder)
    return house


def open_emulated(
    room: RoomFile, bands: BandKind | None, robots: RobotKind | None, seconds: float | None = None
) -> House:
    """A simulated room whose bands or robots stand behind emulated devices (errors as `open_house`)."""
    house = open_house(room, seconds=seconds)
    if house.world is not None and (bands or robots):
        house.emulation = Emulation(house.world, room, bands, robots)
        house.settings = msgspec.structs.replace(
            house.settings, bands=tuple(house.emulation.felt(band) for band in house.settings.bands)
        )
    return house


def _check_labels(orders: dict[str, str], labels: tuple[str, ...]) -> None:
    """The dictionary and the model must speak of the same gestures; the default one may know more."""
    for label in orders:
        if label not in labels and label not in DICTIONARY:
            raise ConfigError(f"gestures.behaviours: {known_names('gesture', label, labels)}")
    if orders != DICTIONARY and not any(orders.get(label) == STOP for label in labels):
        raise ConfigError(
            f"gestures.behaviours: no gesture that the model knows ({', '.join(labels)}) is mapped to {STOP!r}; one "
            "must always stop the robots"
        )


def _logs(room: RoomFile, folder: Path) -> dict[str, LogFile]:
    logs = {}
    for name, devices in replayed_devices(room).items():
        logs[name] = read(folder / name)
        known = _sources(logs[name])
        for device in sorted(devices - known):
            raise ConfigError(f"{name}: {known_names('device', device, known)}")
    return logs


def replayed_devices(room: RoomFile) -> dict[str, set[str]]:
    """The names of the devices that each log of a room stands in for."""
    devices: dict[str, set[str]] = {}
    for entry in (*room.bands, *room.robots):
        if isinstance(entry, ReplayedBand | ReplayedRobot):
            devices.setdefault(entry.log, set()).add(entry.name)
    return devices


def _sources(log: LogFile) -> set[str]:
    names = {record.source for record in log.records if isinstance(record, ImuSample)}
    return names | {record.robot for record in log.records if isinstance(record, RobotState)}


def events_of(names: set[str], log: LogFile, *, leading: bool) -> list[Record]:
    """The events of a log that come from the named devices; ticks and presses only where the log leads."""
    return [record for record in log.records if _concerns(record, names, leading)]


def _concerns(record: Record, names: set[str], leading: bool) -> bool:
    if isinstance(record, Press):
        return leading and record.name != "quit"
    if isinstance(record, Tick):
        return leading
    return isinstance(record, EVENTS) and (
        getattr(record, "source", None) in names or getattr(record, "robot", None) in names
    )
