"""An area shared out among robots in parts of equal size, and the lanes in which each sweeps its part.

The area is cut into columns across the lanes, each column is swept boustrophedon, and its lanes, in the order of
sweeping, are cut where the next robot's share begins. One column is the long snake cut into equal pieces; as many
columns as robots are strips; what lies between are blocks. All parts are swept in the same sense from the same
corner, so that neighbours keep their distance while they keep in step.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import shapely
from scipy.optimize import brentq
from shapely.affinity import affine_transform
from shapely.geometry.base import BaseGeometry

from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import Sheet, Vec2

COVER = 0.075
"""Width [m] of the disc that a robot sweeps with: a Cellulo's own."""

MISSED = 0.0075
"""Share of the area that a plan may leave between the ends of its lanes, where the disc is round."""

MISSED_COSTS = 20.0
"""What is left out beyond that is made up for so many times as slowly as the rest was swept, one spot at a time."""

CLOSE_COSTS = 0.5
"""Robots that meet in step lose this share of their time to giving way."""

REACHES = (0.0, 0.5, 0.8, 1.0)
"""How much of a lane's width is swept right to its ends: none (only the disc's front touches) to all of it."""

MANY = 24
"""Of more robots than these only the likeliest layouts are tried, since each takes long to make."""

LEAST_AREA = 1e-4
"""An area below this [m²] has no room for a robot's way."""

Bounds: TypeAlias = tuple[Array, Array]
Cell: TypeAlias = tuple[BaseGeometry, float, bool]
"""A piece of a lane: its polygon, the height of the lane's middle, and whether it is swept to the right."""


def area_on(sheet: Sheet, polygon: Sequence[Vec2] | None) -> BaseGeometry:
    """What of a polygon (n, 2) [m] lies on the sheet; the whole sheet without one.

    Raises:
        ConfigError: of a polygon that crosses itself, or has no area on the sheet.

    """
    paper = shapely.box(0.0, 0.0, sheet.width_m, sheet.height_m)
    if polygon is None:
        return paper
    corners = np.asarray(polygon, dtype=float)
    if corners.ndim != 2 or corners.shape[1:] != (2,) or len(corners) < 3 or not np.isfinite(corners).all():
        raise ConfigError(
            f"an area of corners {_listed(polygon)} is no polygon; expected three or more corners of two finite "
            "numbers [m]: list its corners in order"
        )
    area = shapely.Polygon(corners)
    if shapely.convex_hull(area).area < LEAST_AREA:
        area = shapely.Polygon()  # a line or a point, which shapely takes for one that crosses itself
    if not area.is_valid:
        raise ConfigError(
            f"the area {_listed(polygon)} crosses itself; expected corners in order along its edge: swap two of them"
        )
    inside = shapely.union_all([part for part in shapely.get_parts(area.intersection(paper)) if part.area > 0])
    if inside.area < LEAST_AREA:
        raise ConfigError(
            f"the area {_listed(polygon)} has {inside.area * 1e4:.2g} cm² on the sheet; expected a polygon inside "
            f"{sheet.width_m:g} x {sheet.height_m:g} m and of 1 cm² or more: check its unit, metres"
        )
    return inside


def _listed(polygon: object) -> str:
    text = str(polygon)
    return text if len(text) <= 120 else text[:117] + "..."


@dataclass(frozen=True, slots=True)
class Style:
    """How an area is shared out: ``turn`` (2, 2) from ``sheet`` to axes with the lanes along x; how many columns."""

    turn: Array
    columns: int


@dataclass(frozen=True, slots=True)
class Layout:
    """Each robot's lanes (k, 2, 2) [m] in ``sheet``, from and to, in the order of sweeping, and the cells they sweep.

    ``cells`` are in axes turned by ``turn``, with the lanes along x.
    """

    lanes: tuple[Array, ...]
    cells: tuple[list[Cell], ...]
    turn: Array

    @property
    def parts(self) -> list[BaseGeometry]:
        """Each robot's part of the area, in ``sheet``."""
        return [_turned(shapely.union_all([cell[0] for cell in cells]), self.turn.T) for cells in self.cells]

    @property
    def lengths(self) -> Array:
        """Each robot's way (n,) [m] from the start of its first lane to the end of its last."""
        return np.array([way_lengths(lanes)[-1] for lanes in self.lanes])


def way_lengths(lanes: Array) -> Array:
    """How far (2k,) [m] each end of the lanes (k, 2, 2) lies along the way through them."""
    corners = lanes.reshape(-1, 2)
    steps = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def plan(area: BaseGeometry, bounds: Bounds, count: int, cover: float, spacing: float) -> list[Layout]:
    """The layout for ``count`` robots whose slowest is done first, and the same begun from the other three corners.

    What is left out beyond `MISSED`, and robots in step closer than ``spacing`` [m], count as time lost.
    """
    made = [
        (style, reach, layout)
        for turn in _turns(area)
        for style in _styles(area, turn, count)
        for reach, layout in zip(REACHES, _layouts(area, bounds, count, style, cover, REACHES), strict=True)
    ]
    made.sort(key=lambda entry: float(entry[2].lengths.max()))
    least, (style, reach, _) = math.inf, made[0]
    for entry in made:
        length = float(entry[2].lengths.max())
        if length >= least:
            break
        close = max(0.0, 1.0 - closest(entry[2].lanes) / spacing)
        left_out = max(0.0, missed(entry[2], area, bounds, cover) - MISSED)
        cost = length * (1.0 + CLOSE_COSTS * close) * (1.0 + MISSED_COSTS * left_out)
        if cost < least:
            least, (style, reach, _) = cost, entry
    flips = [np.diag(signs) for signs in ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))]
    return [_layouts(area, bounds, count, Style(flip @ style.turn, style.columns), cover, [reach])[0] for flip in flips]


def closest(lanes: Sequence[Array], delays: Array | None = None, step: float = 0.02) -> float:
    """The least distance [m] between two robots that sweep at one speed, begun ``delays`` (n,) [m] late."""
    late = np.zeros(len(lanes)) if delays is None else delays
    ends = late + [way_lengths(way)[-1] for way in lanes]
    if len(lanes) < 2:
        return math.inf
    walked = np.arange(0.0, float(ends.max()) + step, step)
    places = np.stack([_places(way, walked - begun) for way, begun in zip(lanes, late, strict=True)])
    least = math.inf
    for robot in range(1, len(lanes)):
        gaps = np.linalg.norm(places[:robot] - places[robot], axis=2)
        least = min(least, float(gaps.min()))
    return least


def _places(lanes: Array, walked: Array) -> Array:
    """Where (m, 2) [m] a robot is that has walked so far [m] through the lanes (k, 2, 2)."""
    at, corners = way_lengths(lanes), lanes.reshape(-1, 2)
    return np.stack([np.interp(walked, at, corners[:, axis]) for axis in (0, 1)], axis=1)


def missed(layout: Layout, area: BaseGeometry, bounds: Bounds, cover: float) -> float:
    """The share of what discs of ``cover`` [m] can reach within ``bounds`` that the lanes leave out."""
    low, high = bounds
    reachable = area.intersection(shapely.box(*low, *high).buffer(cover / 2))
    ways = [shapely.LineString(lanes.reshape(-1, 2)) for lanes in layout.lanes]
    swept = shapely.union_all(shapely.buffer(ways, cover / 2, quad_segs=16))
    return 1.0 - float(reachable.intersection(swept).area) / max(float(reachable.area), 1e-12)


def _turns(area: BaseGeometry) -> Iterator[Array]:
    """Rotations (2, 2) to try: along the sheet's axes, and along those of the area's narrowest box."""
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(area))
    along = corners[1] - corners[0]
    slant = math.atan2(along[1], along[0]) % (math.pi / 2)
    angles = [0.0, math.pi / 2]
    if min(slant, math.pi / 2 - slant) > math.radians(2):
        angles += [slant, slant + math.pi / 2]
    for angle in angles:
        c, s = math.cos(angle), math.sin(angle)
        yield np.array([[c, s], [-s, c]])


def _styles(area: BaseGeometry, turn: Array, count: int) -> Iterator[Style]:
    """Columns to try: as many as make the parts about square, also in equal rows; for a few robots others too."""
    x0, y0, x1, y1 = _turned(area, turn).bounds
    square = math.sqrt(count * (x1 - x0) / max(y1 - y0, 1e-9))
    equal = min((n for n in range(1, count + 1) if count % n == 0), key=lambda n: abs(math.log(n / square)))
    tried = {max(1, min(count, round(square))), equal}
    if count <= MANY:
        tried |= {n for n in (1, 2, 3, math.floor(square), math.ceil(square), count) if 1 <= n <= count}
    return (Style(turn, columns) for columns in sorted(tried))


def _turned(shape: BaseGeometry, turn: Array) -> BaseGeometry:
    return affine_transform(shape, [*turn.ravel(), 0.0, 0.0])


def _layouts(
    area: BaseGeometry, bounds: Bounds, count: int, style: Style, cover: float, reaches: Sequence[float]
) -> list[Layout]:
    """The area shared out in a style, with lanes of each reach."""
    turned = _turned(area, style.turn)
    shares = np.array([len(part) for part in np.array_split(np.arange(count), style.columns)])
    columns = _cut(turned, np.cumsum(shares)[:-1] / count)
    robots = [
        cells
        for column, share in zip(columns, shares, strict=True)
        for cells in _shared_out(_snake(column, cover), int(share))
    ]
    every, ends = [cell for cells in robots for cell in cells], np.cumsum([len(cells) for cells in robots])[:-1]
    return [
        Layout(
            tuple(np.split(np.clip(_lanes(every, cover / 2, reach) @ style.turn, *bounds), ends)),
            tuple(robots),
            style.turn,
        )
        for reach in reaches
    ]


def _snake(column: BaseGeometry, cover: float) -> list[Cell]:
    """The pieces of a column's lanes in the order of sweeping: from its lowest corner, ever to the nearest end."""
    low, high = column.bounds[1], column.bounds[3]
    pitch = (high - low) / max(1, math.ceil((high - low) / cover - 1e-9))
    pieces = [
        (piece, low + (lane + 0.5) * pitch)
        for lane in range(round((high - low) / pitch))
        for piece in _slab(column, low + lane * pitch, low + (lane + 1) * pitch)
    ]
    ends = np.array([[[piece.bounds[0], y], [piece.bounds[2], y]] for piece, y in pieces])
    left, here, cells = list(range(len(pieces))), np.array([column.bounds[0], low]), []
    while left:
        away = np.linalg.norm(ends[left] - here, axis=2)
        at, end = divmod(int(np.argmin(away)), 2)
        piece = left.pop(at)
        cells.append((*pieces[piece], end == 0))
        here = ends[piece, 1 - end]
    return cells


def _slab(shape: BaseGeometry, low: float, high: float) -> list[BaseGeometry]:
    """What lies between two heights, in pieces that hang together."""
    slab = shape.intersection(shapely.box(shape.bounds[0] - 1.0, low, shape.bounds[2] + 1.0, high))
    return [piece for piece in shapely.get_parts(slab) if piece.area > 1e-9]


def _shared_out(cells: list[Cell], count: int) -> list[list[Cell]]:
    """The cells, in order, in ``count`` shares of equal area, cut across their lanes where a share ends."""
    sizes = np.array([cell[0].area for cell in cells])
    share = float(sizes.sum()) / count
    rest, shares = list(cells), list[list[Cell]]()
    for robot in range(1, count):
        taken: list[Cell] = []
        due = robot * share - sum(cell[0].area for part in shares for cell in part)
        while rest and due > 0.004 * share:  # no cut for a sliver: parts are equal to 1 %
            cell = rest.pop(0)
            if cell[0].area > due + 0.004 * share:
                cell, remaining = _halves(cell, due / cell[0].area)
                rest.insert(0, remaining)
            taken.append(cell)
            due -= cell[0].area
        shares.append(taken)
    return [*shares, rest]


def _halves(cell: Cell, share: float) -> tuple[Cell, Cell]:
    shape, y, rightward = cell
    first, second = _cut(shape, np.array([share if rightward else 1.0 - share]))
    pair = (first, y, rightward), (second, y, rightward)
    return pair if rightward else pair[::-1]


def _cut(shape: BaseGeometry, shares: Array) -> list[BaseGeometry]:
    """A shape cut by upright lines that leave these shares (n,) of its area, rising, on their left."""
    x0, y0, x1, y1 = shape.bounds

    def excess(x: float, share: float) -> float:
        return float(shapely.clip_by_rect(shape, x0 - 1.0, y0 - 1.0, x, y1 + 1.0).area - share * shape.area)

    lines = [x0 - 1.0, *(brentq(excess, x0, x1, (share,), xtol=1e-7) for share in shares), x1 + 1.0]
    boxes = [shapely.box(a, y0 - 1.0, b, y1 + 1.0) for a, b in pairwise(lines)]
    return [_flat(shape.intersection(box)) for box in boxes]


def _flat(shape: BaseGeometry) -> BaseGeometry:
    """Only the polygons of a shape: a cut may leave lines and points behind."""
    return shapely.MultiPolygon([part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"])


def _lanes(cells: list[Cell], radius: float, reach: float) -> Array:
    """From where to where (k, 2, 2) [m] a disc's centre sweeps cells: to their outermost corners, as far as `reach`."""
    heights, rightward = np.array([cell[1] for cell in cells]), np.array([cell[2] for cell in cells])
    corners, owners = shapely.get_coordinates([cell[0] for cell in cells], return_index=True)
    ahead = np.sqrt(np.maximum(radius**2 - ((corners[:, 1] - heights[owners]) * reach) ** 2, 0.0))
    first = np.searchsorted(owners, np.arange(len(cells)))
    left = np.minimum.reduceat(corners[:, 0] + ahead, first)
    right = np.maximum.reduceat(corners[:, 0] - ahead, first)
    left, right = np.where(left > right, (left + right) / 2, (left, right))
    ends = np.stack([np.stack([left, heights], axis=1), np.stack([right, heights], axis=1)], axis=1)
    return np.where(rightward[:, None, None], ends, ends[:, ::-1])
