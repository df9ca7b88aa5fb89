"""A behaviour's run: what was asked for, checked, and where the robots begin."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

import msgspec
import numpy as np

from armspan.conductor import Settings
from armspan.conductor.places import check_place, check_zone
from armspan.conductor.robots_only import FAR
from armspan.config.room_file import RoomFile, ZoneEntry
from armspan.config.virtual_entries import ReplayedRobot, SimulatedRobot
from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import Body, RobotState, Sheet, Vec2, Zone
from armspan.study.swarm import SwarmAccount
from armspan.swarm.director import IN_ZONES, POINTED, Director, order_name
from armspan.swarm.limits import Limits

PlantName: TypeAlias = Literal["cellulo", "disc"]
Start: TypeAlias = Literal["random", "line", "ring", "grid"]

PLANTS: tuple[PlantName, ...] = ("cellulo", "disc")
STARTS: tuple[Start, ...] = ("random", "line", "ring", "grid")

RADIO = 0.030
"""The longest latency [s] of Cellulo's radio, each way."""

DISC = 0.0375
"""The radius [m] of the literature's disc."""

DISC_ACCEL = 10.0
"""The most that `Limits` allows [m/s²]: ideal discs have no inertia."""

MOST = 1000
"""Robots in one run."""

TRIES = 500
"""How often a place for one robot is drawn before the sheet counts as full."""

NOBODY = Body(1.6, (0.06, 0.15, 0.22), 0.72)
"""Whose arm is not worn: settings want a body, and robots alone make no use of it."""


class Wanted(msgspec.Struct, frozen=True, kw_only=True):
    """What is asked for, as it comes from a command line: metres and seconds, nothing checked.

    ``points`` are pointed one after the other, ``user`` is where the user stands, ``latency`` [s] is added each way.
    """

    behaviour: str
    robots: int = 4
    seconds: float = 60.0
    seed: int = 0
    plant: PlantName = "cellulo"
    latency: float = 0.0
    sheet: Sheet = Sheet(1.0, 1.0)
    start: Start = "random"
    zones: tuple[ZoneEntry, ...] = ()
    points: tuple[Vec2, ...] = ()
    user: Vec2 | None = None


@dataclass(frozen=True, slots=True)
class SwarmRun:
    """A checked run: ``wanted``, the settings of its mind, and where each robot begins, (n, 2) [m] and (n,) [rad].

    ``body`` [m] is a robot's true radius, None where it is Cellulo's; ``area`` the zone that is to be covered; ``room``
    the one whose real robots are driven, from wherever they stand.
    """

    wanted: Wanted
    settings: Settings
    behaviour: str
    starts: Array
    headings: Array
    area: Zone | None = None
    body: float | None = None
    room: RoomFile | None = None

    def account(self) -> SwarmAccount:
        """An account that has seen nothing yet."""
        area = None if self.area is None else self.area.polygon
        settings = self.settings
        if self.body is None:
            return SwarmAccount(settings.robots, settings.sheet, settings.limits, area=area)
        return SwarmAccount(
            settings.robots, settings.sheet, settings.limits, body=self.body, cover_radius=self.body, area=area
        )


def swarm_run(wanted: Wanted) -> SwarmRun:
    """A run on an empty sheet, checked.

    Raises:
        ConfigError: for a behaviour that does not exist, what lies off the sheet, more robots than fit.

    """
    if not 1 <= wanted.robots <= MOST:
        raise ConfigError(f"{wanted.robots} robots; expected 1 to {MOST}")
    order_name(wanted.behaviour)
    for zone in wanted.zones:
        check_zone(Zone(zone.name, zone.polygon_m), wanted.sheet)
    limits = _limits(wanted)
    dice, turns = np.random.default_rng([wanted.seed, 1]).spawn(2)
    starts = places(wanted.start, wanted.robots, wanted.sheet, limits, dice)
    names = tuple(f"r{k}" for k in range(1, wanted.robots + 1))
    return _run(wanted, limits, names, starts, turns.uniform(0.0, 2.0 * math.pi, wanted.robots))


def run_in_room(wanted: Wanted, room: RoomFile) -> SwarmRun:
    """A run with a room's sheet, zones, limits and robots, virtual or real; those of ``wanted`` do not count.

    Raises:
        ConfigError: where a robot of the room is replayed, or only some are simulated, and as `swarm_run`.

    """
    robots = [robot for robot in room.robots if isinstance(robot, SimulatedRobot)]
    if not robots and not any(isinstance(robot, ReplayedRobot) for robot in room.robots):
        return _run_of_real(wanted, room)
    if len(robots) < len(room.robots):
        strange = next(robot.name for robot in room.robots if not isinstance(robot, SimulatedRobot))
        raise ConfigError(
            f"robot {strange!r} is not simulated like {robots[0].name!r}: a run drives one kind or the other"
            if robots
            else f"robot {strange!r} is replayed, and nobody can drive it: simulate it, or name a real one"
        )
    wanted = msgspec.structs.replace(wanted, sheet=room.sheet, zones=room.zones, robots=len(robots))
    latency = max(room.limits.latency_s, _latency(wanted))
    limits = msgspec.structs.replace(room.limits, latency_s=latency)
    starts = np.array([robot.start_m for robot in robots])
    headings = np.radians([robot.heading_deg for robot in robots])
    return _run(wanted, limits, tuple(robot.name for robot in robots), starts, headings)


def _run_of_real(wanted: Wanted, room: RoomFile) -> SwarmRun:
    names = tuple(robot.name for robot in room.robots)
    wanted = msgspec.structs.replace(wanted, sheet=room.sheet, zones=room.zones, robots=len(names))
    anywhere = places("grid", len(names), room.sheet, room.limits, np.random.default_rng(0))
    run = _run(wanted, room.limits, names, anywhere, np.zeros(len(names)))
    return dataclasses.replace(run, room=msgspec.structs.replace(room, bands=(), receptors=()))


def _run(wanted: Wanted, limits: Limits, names: tuple[str, ...], starts: Array, headings: Array) -> SwarmRun:
    for point in wanted.points:
        check_place("the pointed spot", point, wanted.sheet)
    if wanted.user is not None and not all(abs(value) <= FAR for value in wanted.user):
        raise ConfigError(f"the user stands at {wanted.user}; expected metres from the sheet's corner, at most {FAR:g}")
    zones = tuple(Zone(zone.name, zone.polygon_m) for zone in wanted.zones)
    settings = Settings(
        body=NOBODY, sheet=wanted.sheet, bands=(), robots=names, zones=zones, limits=limits, dice=wanted.seed
    )
    behaviour, area = _in_zone(wanted.behaviour, zones)
    _check_told(behaviour, wanted)
    disc = DISC if wanted.plant == "disc" else None
    run = SwarmRun(wanted, settings, behaviour, starts, headings, area, disc)
    _rehearse(run)
    return run


def _check_told(behaviour: str, wanted: Wanted) -> None:
    for who, told, what in (
        (POINTED, wanted.points, "goes where somebody points: tell a spot with --point x,y"),
        (("come",), wanted.user, "goes to the user: tell where they stand with --user x,y"),
        (("patrol",), wanted.zones, "goes from zone to zone: give one at least with --zone"),
    ):
        if behaviour in who and not told:
            raise ConfigError(f"{behaviour} {what}")


def _rehearse(run: SwarmRun) -> None:
    """Begin the behaviour once with nobody there, so that what cannot be done is refused before anything is opened."""
    settings = run.settings
    states = {
        robot: RobotState(0.0, robot, (float(x), float(y)), 0.0)
        for robot, (x, y) in zip(settings.robots, run.starts, strict=True)
    }
    director = Director(settings.limits, settings.sheet, settings.zones, np.random.default_rng(0))
    director.begin(run.behaviour, states, run.wanted.user)


def _in_zone(asked: str, zones: tuple[Zone, ...]) -> tuple[str, Zone | None]:
    """A behaviour as it is begun, with the zone that it is for: the one that is named, or the only one."""
    order = order_name(asked)
    _, at, wanted = order.partition("@")
    if at:  # a zone that does not exist is refused in rehearsal
        return order, next((zone for zone in zones if zone.name == wanted), None)
    if order in IN_ZONES and len(zones) == 1:
        return f"{order}@{zones[0].name}", zones[0]
    return order, None


def _latency(wanted: Wanted) -> float:
    return wanted.latency + (RADIO if wanted.plant == "cellulo" else 0.0)


def _limits(wanted: Wanted) -> Limits:
    if wanted.plant == "disc":
        return Limits(body_radius_m=DISC, accel_m_s2=DISC_ACCEL, latency_s=_latency(wanted))
    return Limits(latency_s=_latency(wanted))


# --- where robots begin ----------------------------------------------------------------------------------


def places(how: str, n: int, sheet: Sheet, limits: Limits, rng: np.random.Generator) -> Array:
    """Places (n, 2) [m] on a sheet, no two nearer than ``limits.spacing_m``, all a body inside the edge.

    Raises:
        ConfigError: where not so many fit.

    """
    low = np.full(2, limits.body_radius_m)
    size = np.array([sheet.width_m, sheet.height_m]) - 2.0 * low
    where = f"on a sheet of {sheet.width_m:g} x {sheet.height_m:g} m {1000 * limits.spacing_m:.0f} mm apart"
    if size.min() < 0.0:
        raise ConfigError(f"no robot fits {where}: take a larger sheet")
    made = {"random": _random, "line": _line, "ring": _ring, "grid": _grid}[how](n, size, limits.spacing_m, rng)
    if made is None:
        other = "" if how == "grid" else ", or --start grid"
        raise ConfigError(f"{n} robots do not fit {where} ({how}): take fewer, or a larger sheet{other}")
    found: Array = made + low
    return found


def _random(n: int, size: Array, spacing: float, rng: np.random.Generator) -> Array | None:
    found: Array = np.empty((0, 2))
    while len(found) < n:
        drawn = rng.uniform(0.0, 1.0, (TRIES, 2)) * size
        free = (np.linalg.norm(drawn[:, None] - found, axis=2) >= spacing).all(axis=1)
        if not free.any():
            return None
        found = np.vstack([found, drawn[np.argmax(free)]])
    return found


def _line(n: int, size: Array, spacing: float, rng: np.random.Generator) -> Array | None:
    """Along the middle of the longer side."""
    if (n - 1) * spacing > size.max() + 1e-9:
        return None
    found = np.tile(size / 2.0, (n, 1))
    if n > 1:
        found[:, int(np.argmax(size))] = np.linspace(0.0, size.max(), n)
    return found


def _ring(n: int, size: Array, spacing: float, rng: np.random.Generator) -> Array | None:
    """On the largest circle."""
    radius, angle = size.min() / 2.0, 2.0 * math.pi * np.arange(n) / n
    if n > 1 and 2.0 * radius * math.sin(math.pi / n) < spacing:
        return None
    found: Array = size / 2.0 + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return found


def _grid(n: int, size: Array, spacing: float, rng: np.random.Generator) -> Array | None:
    """In rows and columns as far apart as they can be; the last row may have room left."""
    best, found = spacing - 1e-9, None
    for columns in range(1, n + 1):
        counts = np.array([columns, -(-n // columns)])
        apart = np.where(counts > 1, size / np.maximum(counts - 1, 1), np.inf)
        if apart.min() > best:
            best, k = float(apart.min()), np.arange(n)
            at = np.column_stack([k % columns, k // columns])
            found = np.where(counts > 1, at * size / np.maximum(counts - 1, 1), size / 2.0)
        if n == 1:
            return size[None] / 2.0
    return found
