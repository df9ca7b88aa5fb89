"""How well robots cover an area: what they swept and when, how near they are to every spot of it, how they cluster.

"Coverage" has two meanings in the field: sweeping (`Coverage`, every spot is driven over once) and deployment
(`locational_cost`, every spot has a robot near by). Both are measured here.
"""

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

from armspan.errors import DataError
from armspan.frames import Array
from armspan.records import Sheet

Area: TypeAlias = Sheet | ArrayLike | shapely.Polygon
"""A sheet, the corners (n, 2) [m] of a polygon, or a polygon with holes."""

Mask: TypeAlias = NDArray[np.bool_]
Cells: TypeAlias = NDArray[np.intp]

SHARES = (0.5, 0.9, 0.95, 0.99)
LINK = 0.2
"""Nearer than this two robots are in one cluster [m]: the range of the lab's simulated sensors."""

_BLOCK = 64  # pieces of ways that are marked at once, so that their windows stay in the cache
_GOLDEN = (5**0.5 - 1) / 2  # its multiples are spread evenly, however many there are
_ROUND = 32  # corners to a quarter of a circle
_FINEST = 8  # decimals [m]: places that are nearer are one, as a Voronoi diagram needs room for its vertices


def outline(area: Area) -> shapely.Polygon:
    """The area as a polygon [m] in ``sheet``.

    Raises:
        DataError: for a polygon that crosses itself or is empty.

    """
    if isinstance(area, Sheet):
        area = shapely.box(0.0, 0.0, area.width_m, area.height_m)
    shape = area if isinstance(area, shapely.Polygon) else _polygon(area)
    if not (shape.is_valid and shape.area > 0.0):
        raise DataError(f"an area is {shapely.is_valid_reason(shape)} of {shape.area:g} m²; give it a simple outline")
    return shape


def _polygon(corners: ArrayLike) -> shapely.Polygon:
    xy = np.asarray(corners, dtype=float)
    if xy.ndim != 2 or xy.shape[1:] != (2,) or len(xy) < 3 or not np.isfinite(xy).all():
        raise DataError(f"an area's corners have shape {xy.shape}; expected finite corners (n, 2), at least 3")
    return shapely.Polygon(xy)


class Coverage:
    """What discs of ``cover_radius`` [m] swept of an area, on a raster of about ``cell`` [m], fed by `take`.

    ``first`` (rows, columns) [s] is when each cell was covered first, infinite where it never was; ``inside``
    (rows, columns) tells which belong to the area. Rows follow y, columns x; ``extent`` is (left, right, top, bottom)
    [m]. Times count from the first `take`.
    """

    def __init__(self, area: Area, cover_radius: float, cell: float = 0.005) -> None:
        if not (0.0 < cell <= cover_radius < np.inf):
            raise DataError(f"a cell of {cell} m and a radius of {cover_radius} m; expected 0 < cell <= radius")
        self.area, self.radius = outline(area), cover_radius
        left, top, right, bottom = self.area.bounds
        self._low: Array = np.array([left, top])
        self._counts = np.ceil(np.array([right - left, bottom - top]) / cell - 1e-9).astype(np.intp)
        self._cell: Array = np.array([right - left, bottom - top]) / self._counts
        self.extent = (left, right, top, bottom)
        self.inside = self._within(self.area)
        shape = self.inside.shape
        self.first: Array = np.full(shape, np.inf)
        self._last, self._passes = np.full(shape, -2, dtype=np.int32), np.zeros(shape, dtype=np.int32)
        self._times: list[float] = []
        self._before: Array | None = None

    def take(self, t: float, xy: ArrayLike) -> None:
        """Take the discs' places (n, 2) [m] at ``t`` [s]: each swept the straight way from its last one.

        A disc whose place is not a number (lifted) covers nothing, and begins anew where it is next.

        Raises:
            DataError: where ``t`` does not rise or the number of discs changes.

        """
        here = np.array(xy, dtype=float).reshape(-1, 2)
        before = here if self._before is None else self._before
        if len(before) != len(here) or (self._times and t <= self._times[-1]):
            raise DataError(f"{len(here)} places at {t} s after {len(before)}; expected as many, and later each time")
        self._times.append(t)
        self._before = here
        start = np.where(np.isfinite(before), before, here)
        on = np.isfinite(here).all(axis=1)
        for cells in self._swept(start[on], here[on]):
            self._mark(cells)

    @property
    def taken(self) -> Array:
        """The times (k,) [s] of what was taken, from zero."""
        return np.array(self._times) - self._times[0] if self._times else np.zeros(0)

    @property
    def overlap(self) -> float:
        """The share of the area that was swept more than once, having been left in between."""
        return self._share(self._passes > 1, self.inside)

    def share(self, only: Mask | None = None) -> float:
        """The share covered so far, of the area or only of some of its cells."""
        return self._share(np.isfinite(self.first), self.inside if only is None else only)

    def shares(self, only: Mask | None = None) -> Array:
        """The share (k,) covered at each of `taken`."""
        cells = self.inside if only is None else only
        firsts = np.sort(self.first[cells])
        return np.searchsorted(firsts, self.taken, side="right") / max(1, len(firsts))

    def times(self, shares: Sequence[float] = SHARES, only: Mask | None = None) -> dict[str, float | None]:
        """When each share was covered [s], as ``t50`` and so on, linear between two takes; None where it never was."""
        covered = self.shares(only)
        return {f"t{100 * share:g}": self._time(share, covered) for share in shares}

    def reachable(self, margin: float, within: Area | None = None) -> Mask:
        """What a disc can cover (rows, columns) whose middle stays ``margin`` [m] inside ``within`` (the area)."""
        room = (self.area if within is None else outline(within)).buffer(-margin, quad_segs=_ROUND)
        return self._within(room.buffer(self.radius, quad_segs=_ROUND)) & self.inside

    def coverable(self, margin: float, within: Area | None = None) -> float:
        """The share of the area that a disc can cover whose middle stays ``margin`` [m] inside ``within``."""
        return self._share(self.reachable(margin, within), self.inside)

    # --- the raster ------------------------------------------------------------------------------------

    def _spots(self, rows: Cells, columns: Cells) -> tuple[Array, Array]:
        """The spot x, y [m] by which each cell is judged, from ``rows`` and ``columns`` that broadcast.

        They lie evenly at all offsets in their cells: with all of them in the middle, a strip along an axis would be
        taken as whole cells wide.
        """
        x = self._low[0] + (columns + (0.5 + rows * _GOLDEN) % 1.0) * self._cell[0]
        y = self._low[1] + (rows + (0.5 + columns * _GOLDEN) % 1.0) * self._cell[1]
        return x, y

    def _within(self, shape: shapely.Geometry) -> Mask:
        """Which cells' spots (rows, columns) lie in a shape."""
        shapely.prepare(shape)
        columns, rows = np.arange(self._counts[0]), np.arange(self._counts[1])
        found: Mask = shapely.contains_xy(shape, *self._spots(rows[:, None], columns))
        return found

    @staticmethod
    def _share(marked: Mask, cells: Mask) -> float:
        return int((marked & cells).sum()) / max(1, int(cells.sum()))

    def _time(self, share: float, shares: Array) -> float | None:
        k = int(np.searchsorted(shares, share - 1e-12))
        taken = self.taken
        if k >= len(shares):
            return None
        if k == 0:
            return 0.0
        return float(np.interp(share, shares[k - 1 : k + 1], taken[k - 1 : k + 1]))

    def _mark(self, cells: Cells) -> None:
        k, first, last = len(self._times) - 1, self.first.reshape(-1), self._last.reshape(-1)
        anew = np.unique(cells[last[cells] < k - 1])
        self._passes.reshape(-1)[anew] += 1
        first[anew] = np.minimum(first[anew], self._times[-1] - self._times[0])
        last[cells] = k

    def _swept(self, start: Array, end: Array) -> Iterator[Cells]:
        """The numbers of the cells within the radius of each way, some of them twice, block by block."""
        start, way = _pieces(start, end - start, self.radius)
        reach = self.radius + 0.5 * np.abs(way).max(axis=0, initial=0.0)
        window = np.ceil(2.0 * reach / self._cell).astype(np.intp) + 1
        corner = np.floor((start + 0.5 * way - reach - self._low) / self._cell).astype(np.intp)
        for k in range(0, len(start), _BLOCK):
            block = slice(k, k + _BLOCK)
            yield self._capsules(start[block], way[block], corner[block], window)

    def _capsules(self, start: Array, way: Array, corner: Cells, window: Cells) -> Cells:
        """The cells within the radius of (m, 2) ways, looked for in a window at each way's ``corner``."""
        columns = (corner[:, 0, None] + np.arange(window[0]))[:, None, :]
        rows = (corner[:, 1, None] + np.arange(window[1]))[:, :, None]
        x, y = self._spots(rows, columns)
        x -= start[:, 0, None, None]
        y -= start[:, 1, None, None]
        long = np.maximum(np.einsum("mi,mi->m", way, way), 1e-30)[:, None, None]
        along = x * way[:, 0, None, None] + y * way[:, 1, None, None]
        on = np.clip(along / long, 0.0, 1.0)
        near = x * x + y * y - on * (2.0 * along - on * long) <= self.radius**2
        near &= (rows >= 0) & (rows < self._counts[1]) & (columns >= 0) & (columns < self._counts[0])
        cells: Cells = (rows * self._counts[0] + columns)[near]
        return cells


def _pieces(start: Array, way: Array, longest: float) -> tuple[Array, Array]:
    """Ways (m, 2) cut into pieces of at most ``longest``, so that a long one needs no large window."""
    parts = np.maximum(1, np.ceil(np.hypot(way[:, 0], way[:, 1]) / longest)).astype(np.intp)
    which = np.repeat(np.arange(len(way)), parts)
    number = np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts)
    piece = way[which] / parts[which, None]
    return start[which] + number[:, None] * piece, piece


def locational_cost(xy: ArrayLike, area: Area, *, normalised: bool = False) -> float:
    """H = integral over the area of min_i |q - p_i|² [m⁴], exact (Cortés et al. 2004, IEEE TRA 20(2), uniform density).

    ``xy`` (n, 2) [m]. Normalised it is H / area², without a unit and the same at every scale: at best 1/6 in a square
    for one robot, 1/24 for four and 1/54 for nine.
    """
    places = np.unique(np.round(np.asarray(xy, dtype=float).reshape(-1, 2), _FINEST), axis=0)
    if not len(places) or not np.isfinite(places).all():
        raise DataError(f"a locational cost needs finite places (n, 2), at least one, not {np.asarray(xy).tolist()}")
    whole = outline(area)
    cost = sum(_second_moment(cell, place) for cell, place in zip(_cells(places, whole), places, strict=True))
    return cost / whole.area**2 if normalised else cost


def _cells(places: Array, whole: shapely.Polygon) -> list[shapely.Geometry]:
    """The part of the area that is nearest to each place."""
    if len(places) == 1:
        return [whole]
    cells = shapely.voronoi_polygons(shapely.MultiPoint(places), extend_to=whole.envelope.buffer(1.0), ordered=True)
    return list(shapely.intersection(np.array(cells.geoms), whole))


def _second_moment(shape: shapely.Geometry, about: Array) -> float:
    """The integral of |q - about|² over a shape, ring by ring (Green)."""
    parts = shapely.get_parts(shape)
    polygons = parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON]
    return sum(
        _ring_moment(np.array(polygon.exterior.coords) - about)
        - sum(_ring_moment(np.array(hole.coords) - about) for hole in polygon.interiors)
        for polygon in polygons
    )


def _ring_moment(ring: Array) -> float:
    here, following = ring[:-1], ring[1:]
    cross = here[:, 0] * following[:, 1] - following[:, 0] * here[:, 1]
    squares = (here * here + here * following + following * following).sum(axis=1)
    return abs(float(cross @ squares)) / 12.0


def cluster_size(xy: ArrayLike, link: float = LINK) -> float:
    """Cs = (1/n) sum over clusters of (robots in it)²: the size of an average robot's cluster, 1 to n.

    ``xy`` (n, 2) [m]; robots nearer than ``link`` [m] are linked, and a cluster is what links connect. Source: EPFL
    CHILI's course "swarm robotics with Cellulo", hand-out on aggregation.
    """
    places = np.asarray(xy, dtype=float).reshape(-1, 2)
    pairs = cKDTree(places).query_pairs(link, output_type="ndarray")
    pairs = pairs[np.hypot(*(places[pairs[:, 0]] - places[pairs[:, 1]]).T) < link]
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(places), len(places)))
    _, labels = connected_components(graph, directed=False)
    sizes = np.bincount(labels)
    return float((sizes**2).sum() / len(places))


def closeness(xy: ArrayLike) -> float:
    """Z = -(sum of all pairs' distances) [m]: nearer to zero is closer together. Source: as `cluster_size`."""
    places = np.asarray(xy, dtype=float).reshape(-1, 2)
    return -float(pdist(places).sum())
