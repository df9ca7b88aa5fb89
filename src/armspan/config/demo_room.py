"""The demo's room: a table, four robots, four zones, one virtual person; drawn anew for every seed."""

import math
from collections.abc import Sequence
from typing import Literal, TypeAlias

import msgspec
import numpy as np

from armspan.config.room_file import GestureEntry, RoomFile, ZoneEntry
from armspan.config.virtual_entries import SimulatedBand, SimulatedPerson, SimulatedRobot, Simulation
from armspan.pointing.laser import LaserSettings
from armspan.records import Arm, Sheet, Vec2

Posture: TypeAlias = Literal["straight", "natural"]

SHEET = Sheet(0.9, 0.6)
ZONES = ("garden", "harbour", "market", "tower")
ROBOTS = ("amber", "birch", "cobalt", "dune")
TABLE = 0.75
_RADIUS = 0.06
_APART = 0.10
_STOP_LANE = 0.15


def demo_room(
    seed: int,
    *,
    posture: Posture = "straight",
    bands: int = 1,
    trials: int = 20,
    feedback: Literal["off", "on", "both"] = "both",
    model: str | None = None,
    gestures: tuple[str, ...] = (),
    laser: LaserSettings | None = None,
) -> RoomFile:
    """A room for the demo: robots stand 10 cm apart or more, from each other and from the zones' rims.

    With the file of a gesture ``model`` there is a band on the other wrist too, and after the trials the person makes
    ``gestures``. With a ``laser`` the person wears one, and every robot has a receptor.
    """
    rng = np.random.default_rng([seed, 1])
    places = _places(rng, len(ROBOTS), len(ZONES))
    robots = tuple(
        SimulatedRobot(name, (float(x), float(y)), float(rng.uniform(-180, 180)), laser is not None)
        for name, (x, y) in zip(ROBOTS, places, strict=False)
    )
    zones = tuple(ZoneEntry(name, _hexagon(x, y)) for name, (x, y) in zip(ZONES, places[len(ROBOTS) :], strict=True))
    worn: list[SimulatedBand] = [SimulatedBand("wrist")]
    if bands == 2:
        worn.append(SimulatedBand("upperarm", "upperarm"))
    if model is not None:
        worn.append(SimulatedBand("other", arm="left"))
    at = (
        float(SHEET.width_m / 2 + rng.uniform(-0.15, 0.15)),
        float(SHEET.height_m + rng.uniform(0.15, 0.35)),
    )
    person = SimulatedPerson(at, float(rng.uniform(-15, 15)), trials=trials, feedback=feedback, gestures=gestures)
    return RoomFile(
        sheet=SHEET,
        bands=tuple(worn),
        robots=robots,
        zones=zones,
        posture=posture,
        table_height_m=round(TABLE + float(rng.normal(0.0, 0.005)), 3),  # what a tape says
        gestures=GestureEntry(model),
        laser=laser,
        simulation=Simulation(seed, TABLE, person),
    )


def gesture_room(seed: int, *, bands: Sequence[Arm] = ("right", "left"), posture: Posture = "straight") -> RoomFile:
    """The demo's room as it serves for recording gestures: the same person, a band on either wrist, one robot."""
    room = demo_room(seed, posture=posture, trials=0, feedback="off")
    worn = tuple(SimulatedBand(arm, arm=arm) for arm in bands)
    return msgspec.structs.replace(room, bands=worn, robots=room.robots[:1])


def page_room(seed: int, model: str | None = None) -> RoomFile:
    """The demo's room for the page: the person wears a band on either wrist and waits for what the page asks."""
    room = demo_room(seed, trials=0, feedback="on")
    worn = (SimulatedBand("right wrist", arm="right"), SimulatedBand("left wrist", arm="left"))
    return msgspec.structs.replace(room, bands=worn, feedback=True, gestures=GestureEntry(model))


def _places(rng: np.random.Generator, robots: int, zones: int) -> list[Vec2]:
    """Places (robots first) at least as far apart as two neighbours may be; drawn by rejection."""
    clear = [0.0] * robots + [_RADIUS] * zones
    while True:
        places: list[Vec2] = []
        for own in clear:
            for _ in range(200):
                x = rng.uniform(_STOP_LANE, SHEET.width_m - _STOP_LANE)
                y = rng.uniform(_STOP_LANE, SHEET.height_m - _STOP_LANE)
                gaps = [np.hypot(x - a, y - b) - own - other for (a, b), other in zip(places, clear, strict=False)]
                if min(gaps, default=1.0) >= _APART:
                    places.append((float(x), float(y)))
                    break
        if len(places) == len(clear):
            return places


def _hexagon(x: float, y: float) -> tuple[Vec2, ...]:
    angles = [k * math.pi / 3 for k in range(6)]
    return tuple((round(x + _RADIUS * math.cos(a), 4), round(y + _RADIUS * math.sin(a), 4)) for a in angles)
