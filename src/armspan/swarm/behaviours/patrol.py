"""Patrol: a convoy visits the zones in turn, again and again."""

from collections.abc import Mapping

import numpy as np
import shapely
from shapely.ops import substring

from armspan.errors import ConfigError
from armspan.frames import Array, polygon_middle
from armspan.records import RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import (
    CRUISE,
    Box,
    Pace,
    Wish,
    assigned,
    check_room,
    farthest,
    pitch,
    places,
    spaced,
    wishes,
)

_SLACK = 1.6  # a convoy's tour is longer than its robots in a row: two face each other on a circle of π / 2 times that
_POINT = 1e-6  # [m] the tour of a lone robot with one zone has no length


class Patrol:
    """Robots spread evenly over a tour through the zones' middles, in the zones' order, and back to the first.

    The convoy moves at `CRUISE` times the highest speed and waits while a robot is farther behind than
    ``limits.lead_m``. Several robots do not drive to and fro on one line: between two zones they drive along both
    sides of it, round one zone in a circle; a tour that is short for its robots is widened likewise. Where the tour
    crosses itself, robots' places give way to each other.

    Raises:
        ConfigError: without zones, and where not so many robots fit.

    """

    done = False

    def __init__(self, stage: Stage, states: Mapping[str, RobotState]) -> None:
        if not stage.zones:
            raise ConfigError("the room has no zones, and a patrol visits one at least: add [[zones]] to the room file")
        check_room(len(states), stage)
        self._stage = stage
        self._middles = np.clip([polygon_middle(zone.polygon) for zone in stage.zones], *stage.bounds)
        self._pace = Pace()
        self._names: list[str] = []
        self._tour = shapely.LineString()
        self._along: Array = np.empty(0)
        self._slots: Array = np.empty((0, 2))

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[Wish]:
        """The wish of each robot for its place in the convoy."""
        elapsed = self._pace.elapsed(t)
        names, here = places(states)
        if names != self._names:
            self._names = names
            self._join(here)
        elif farthest(here, self._slots) <= self._stage.limits.lead_m:
            self._along = self._along + CRUISE * self._stage.limits.speed_m_s * elapsed
        self._slots = spaced(self._on_tour(), self._stage)
        return wishes(t, self._stage, names, self._slots)

    def _join(self, here: Array) -> None:
        """A tour for so many robots, and the place on it for each of them."""
        n = len(here)
        self._tour = tour(self._middles, n, pitch(self._stage), self._stage.bounds)
        self._along = self._tour.length * np.arange(n) / max(n, 1)
        if n:
            self._along += self._tour.project(shapely.Point(here[0]))
            self._along = self._along[assigned(here, self._on_tour())]

    def _on_tour(self) -> Array:
        points = shapely.line_interpolate_point(self._tour, self._along % max(self._tour.length, _POINT))
        return np.asarray(shapely.get_coordinates(points))


def tour(middles: Array, n: int, gap: float, box: Box) -> shapely.LineString:
    """The closed way of ``n`` robots through the zones' middles (k, 2), within the box.

    A lone robot's way, and a long one of several, runs from middle to middle. Between two zones it is a loop ``gap``
    wide that ends in the middles; round one zone, and where ``n`` times ``gap`` is too long for it, it is widened.
    """
    plain = shapely.LineString([*middles, middles[0]])
    outline = _outline(middles)
    if n < 2 or outline is None:
        return plain
    least = gap / 2 if len(middles) == 2 else 0.0
    wide = max((_SLACK * n * gap - plain.length) / (2 * np.pi), least)
    if wide == 0.0:
        return plain
    if wide == least and plain.length > 4 * gap:
        outline = substring(outline, wide, outline.length - wide)  # the loop's ends then touch the middles
    loop = _inside(outline, wide, box).buffer(wide).intersection(shapely.box(*box[0], *box[1]))
    if not isinstance(loop, shapely.Polygon) or loop.is_empty:
        return plain
    backward = len(middles) > 2 and loop.exterior.is_ccw != shapely.LinearRing(middles).is_ccw
    return shapely.LineString(loop.exterior.coords[:: -1 if backward else 1])


def _outline(middles: Array) -> shapely.Geometry | None:
    """What the way runs round, None where it crosses itself or all middles lie on a line."""
    if len(middles) == 1:
        return shapely.Point(middles[0])
    if len(middles) == 2:
        return shapely.LineString(middles)
    polygon = shapely.Polygon(middles)
    return polygon if polygon.is_valid and polygon.area > 0 else None


def _inside(outline: shapely.Geometry, wide: float, box: Box) -> shapely.Geometry:
    """The outline so far from the box's edges, where it can be, that it can be widened."""
    low, high = box
    middle = (low + high) / 2
    return shapely.transform(
        outline, lambda points: np.clip(points, np.minimum(low + wide, middle), np.maximum(high - wide, middle))
    )
