"""Coverage by deploying: each robot in the middle of the places to which it is the nearest."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import shapely
from scipy.optimize import linear_sum_assignment
from scipy.spatial import KDTree, Voronoi
from scipy.spatial.distance import cdist
from shapely.geometry.base import BaseGeometry

from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import Drive, GoTo, RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.strips import LEAST_AREA, area_on

NEAR = 0.008
"""A robot this near [m] to its site has arrived: a Cellulo stops up to 2.5 mm short on each axis."""

GONE = 1.0
"""A robot that was not heard of for so long [s] has left, and the others take over its cell."""

RESTARTS = 16
"""From how many beginnings the sites of a few robots are looked for."""

SEARCH = 200
"""Sites in all beginnings together: of more robots than that only the beginning from their own places is taken."""

SAMPLES = 500
"""Points of the area that stand for it while beginnings are compared."""

FAR: Vec2 = (math.inf, math.inf)
"""Where a robot is that was not heard of yet."""

ROUNDS = 400
"""Most Lloyd iterations, one at a step, after which the sites stay where they are."""

STILL = 2e-4
"""The sites are found when none moves farther [m] in an iteration."""


class Lloyd:
    """Deploy over an area (the whole sheet without one) so that the mean squared way to the nearest robot is least.

    Lloyd's algorithm as in Cortes et al. 2004, 10.1109/TRA.2004.824698, for a uniform density: each site moves
    to the centroid of its own Voronoi cell, clipped to the ``area`` (corners [m] of a polygon in ``sheet``). Since it
    finds only a local optimum, a few robots begin at the best of several runs, assigned by the least total way.

    Raises:
        ConfigError: of an area that crosses itself, has none on the sheet, or is too small for the robots.

    """

    def __init__(self, stage: Stage, states: Mapping[str, RobotState], area: Sequence[Vec2] | None = None) -> None:
        self._stage = stage
        self._area = area_on(stage.sheet, area)
        self._room = _room(self._area, *stage.bounds)
        self._lattice = lattice(self._room, stage.spacing)
        if len(states) > len(self._lattice):
            raise ConfigError(
                f"{len(states)} robots do not fit into an area of {self._area.area:.3g} m² at {stage.spacing:g} m from "
                f"each other; expected at most {len(self._lattice)}: take a larger area, or fewer robots"
            )
        self._heard: dict[str, tuple[float, Vec2]] = {}
        self._names: list[str] = sorted(states)
        self._begin(np.array([states[name].xy for name in self._names], dtype=float).reshape(-1, 2))

    @property
    def done(self) -> bool:
        """Whether the sites are found and every robot is at its own."""
        if self._rounds < ROUNDS or not self._names:
            return False
        here = [self._heard.get(name, (0.0, FAR))[1] for name in self._names]
        return all(math.dist(xy, site) < NEAR for xy, site in zip(here, self._sites, strict=True))

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[GoTo | Drive]:
        """To its site with each; the sites are planned anew when robots come or go."""
        self._hear(t, states)
        self._iterate()
        limits = self._stage.limits
        low, high = self._stage.bounds
        goals = np.clip(self._sites, low, high).tolist()
        return [
            GoTo(t, name, (x, y), limits.speed_m_s, t + limits.lease_s)
            for name, (x, y) in zip(self._names, goals, strict=True)
            if name in states
        ]

    def _hear(self, t: float, states: Mapping[str, RobotState]) -> None:
        for name in self._names:  # those who were promised but never came are missed from the first step on
            self._heard.setdefault(name, (t, FAR))
        self._heard |= {name: (t, states[name].xy) for name in states}
        self._heard = {name: heard for name, heard in self._heard.items() if t - heard[0] <= GONE}
        names = sorted(self._heard)
        if names != self._names:
            here = np.array([self._heard[name][1] for name in names], dtype=float).reshape(-1, 2)
            middle = np.mean(self._stage.bounds, axis=0)
            self._names = names
            self._begin(np.where(np.isfinite(here), here, middle))

    def _begin(self, here: Array) -> None:
        """Beginnings for robots at ``here`` (n, 2) [m]: the best of several, each robot with the site that is its."""
        self._rounds, self._sites = 0, _apart(here, self._stage.rng)
        restarts = min(RESTARTS, SEARCH // max(1, len(here)))
        if len(here) and restarts > 1:
            found = best_start(self._room, self._sites, restarts, self._stage.rng)
            _, taken = linear_sum_assignment(cdist(here, found))
            self._sites = found[taken]

    def _iterate(self) -> None:
        """One Lloyd iteration, until the sites stay."""
        if self._rounds >= ROUNDS or not self._names:
            return
        before = self._sites
        middles = np.clip(centroids(self._area, before), *self._stage.bounds)
        self._sites = _spread(middles, self._room, self._stage.spacing)
        self._rounds += 1
        if float(np.abs(self._sites - before).max()) < STILL or self._rounds == ROUNDS:
            self._rounds = ROUNDS
            self._make_room()

    def _make_room(self) -> None:
        """Where the sites could not be kept apart, the nearest places of a lattice that are."""
        if _nearest_pair(self._sites) < self._stage.spacing - 1e-3 and len(self._lattice) >= len(self._sites):
            _, taken = linear_sum_assignment(cdist(self._sites, self._lattice))
            self._sites = self._lattice[taken]


def _room(area: BaseGeometry, low: Array, high: Array) -> BaseGeometry:
    """Where sites may lie: the area within bounds, or, of an area in the sheet's margin, what of them is next to it."""
    inner = area.intersection(shapely.box(*low, *high))
    if inner.area >= LEAST_AREA:
        return inner
    x0, y0, x1, y1 = area.bounds
    return shapely.box(*np.clip([x0, y0], low, high), *np.clip([x1, y1], low, high)).buffer(1e-4)


def centroids(area: BaseGeometry, sites: Array) -> Array:
    """The centroid (n, 2) [m] of each site's Voronoi cell clipped to the area, the nearest point where none is left."""
    cells = shapely.intersection(voronoi_cells(area, sites), area)
    middles = shapely.centroid(cells)
    nearest = shapely.get_point(shapely.shortest_line(area, shapely.points(sites)), 0)
    return np.asarray(shapely.get_coordinates(np.where(shapely.area(cells) > 1e-12, middles, nearest)))


def voronoi_cells(area: BaseGeometry, sites: Array) -> Array:
    """The convex Voronoi cells (n,) of distinct sites (n, 2) [m], as polygons that reach beyond the area."""
    x0, y0, x1, y1 = area.bounds
    middle, far = np.array([x0 + x1, y0 + y1]) / 2, 20 * (float(np.abs(sites).max()) + x1 - x0 + y1 - y0)
    guards = middle + far * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    diagram = Voronoi(np.concatenate([sites, guards]))
    regions = [diagram.regions[region] for region in diagram.point_region[: len(sites)]]
    corners = diagram.vertices[np.concatenate(regions)]
    owners = np.repeat(np.arange(len(sites)), [len(region) for region in regions])
    return np.asarray(shapely.convex_hull(shapely.multipoints(shapely.points(corners), indices=owners)))


def best_start(area: BaseGeometry, sites: Array, restarts: int, rng: np.random.Generator) -> Array:
    """The best (n, 2) [m] of some runs of Lloyd's algorithm on points that stand for the area, one from ``sites``."""
    points, count = _grid(area, SAMPLES), len(sites)
    drawn = [points[rng.choice(len(points), count, replace=len(points) < count)] for _ in range(restarts - 1)]
    runs, squares = np.stack([sites, *drawn]), (points**2).sum(axis=1)
    for _ in range(25):
        ways = (runs**2).sum(axis=2)[:, :, None] + squares - 2 * runs @ points.T
        mine = (ways.argmin(axis=1)[:, None, :] == np.arange(count)[:, None]).astype(float)
        sizes = mine.sum(axis=2, keepdims=True)
        runs = np.where(sizes > 0, mine @ points / np.maximum(sizes, 1.0), runs)
    ways = (runs**2).sum(axis=2)[:, :, None] + squares - 2 * runs @ points.T
    best = runs[int(ways.min(axis=1).sum(axis=1).argmin())]
    return _apart(np.asarray(best), rng)


def _grid(area: BaseGeometry, count: int) -> Array:
    """About so many points (m, 2) [m] on a square grid inside an area."""
    x0, y0, x1, y1 = area.bounds
    step = math.sqrt(area.area / count)
    xs, ys = (np.linspace(a, b, 2 * max(1, math.ceil((b - a) / step)) + 1)[1::2] for a, b in ((x0, x1), (y0, y1)))
    points = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    inside = points[shapely.contains_xy(area, points[:, 0], points[:, 1])]
    return np.asarray(inside if len(inside) else shapely.get_coordinates(area.representative_point()))


def _apart(sites: Array, rng: np.random.Generator) -> Array:
    """The sites, those in the same place moved a little: they would share a cell."""
    if len(sites) > 1 and _nearest_pair(sites) < 1e-5:
        return np.asarray(sites + rng.uniform(-1e-3, 1e-3, sites.shape))
    return sites


def _nearest_pair(sites: Array) -> float:
    if len(sites) < 2:
        return math.inf
    away, _ = KDTree(sites).query(sites, k=2)
    return float(away[:, 1].min())


def _spread(sites: Array, room: BaseGeometry, spacing: float) -> Array:
    """Sites (n, 2) [m] inside the room pushed apart until they keep ``spacing``, as far as it goes in a few pushes."""
    for _ in range(30):
        pairs = KDTree(sites).query_pairs(spacing, output_type="ndarray")
        if not len(pairs):
            break
        apart = sites[pairs[:, 0]] - sites[pairs[:, 1]]
        away = np.linalg.norm(apart, axis=1, keepdims=True)
        push = 0.5 * (spacing + 1e-4 - away) * apart / np.maximum(away, 1e-9)
        sites = sites.copy()
        np.add.at(sites, pairs[:, 0], push)
        np.add.at(sites, pairs[:, 1], -push)
        sites = shapely.get_coordinates(shapely.shortest_line(room, shapely.points(sites)))[::2]
    return sites


def lattice(room: BaseGeometry, spacing: float) -> Array:
    """The most places (m, 2) [m] in a room, one at least, that a square or hexagonal lattice of ``spacing`` [m] has."""
    x0, y0, x1, y1 = room.bounds
    row = spacing * math.sqrt(3) / 2
    best = shapely.get_coordinates(room.representative_point())
    for step, shift in (((spacing, spacing), (0.0, 0.0)), ((spacing, row), (0.5, 0.0)), ((row, spacing), (0.0, 0.5))):
        columns, rows = (math.floor(size / one + 1e-9) + 1 for size, one in zip((x1 - x0, y1 - y0), step, strict=True))
        grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
        places = np.array([x0, y0]) + step * (grid + shift * (grid[:, ::-1] % 2))
        inside = places[shapely.distance(room, shapely.points(places)) < 1e-9]
        best = inside if len(inside) > len(best) else best
    return np.asarray(best)
