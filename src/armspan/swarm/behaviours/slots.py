"""Slots for robots: where each of them goes, apart from all others and inside the sheet, and how they get there.

Every place here is in ``sheet`` [m], for a robot's centre.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import Drive, GoTo, RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage

Wish: TypeAlias = GoTo | Drive
Box: TypeAlias = tuple[Array, Array]
"""The lowest and the highest place (2,) of a rectangle."""

ARRIVED = 0.008
"""Distance [m] at which a robot is in its slot: Cellulo stops up to 2.5 mm short on each axis."""

EASE = 1.2
"""How much wider than need be slots lie where there is room: robots then find into them past each other."""

SWAP_S = 0.5
"""How often robots take each other's slots."""

CRUISE = 0.6
"""Share of the highest speed at which a formation moves: what is left lets one that fell behind catch up."""

_SPARE = 0.003  # between slots, beyond the spacing at which nobody gives way
_RING = 8  # a larger ring takes more room than a filled disc is worth
_PUSHES = 200
_FIRM = 100  # after so many pushes a fixed place gives way as well: it may have pinned others into a corner
_TILT = (30, 0.1)  # after so many pushes each turns by so much [rad]: a row that is pressed together then buckles
_GOLDEN = 2.399963  # [rad] between directions of which no two are alike
_LONGEST = 0.1  # a longer pause between two steps counts as this [s], so that nothing jumps after it


# --- going there ----------------------------------------------------------------------------------------


@dataclass(slots=True)
class Slots:
    """Robots on their way to their slots, and holding them.

    ``plan`` finds a slot for each robot, (n, 2), from their places (n, 2) in the order of their names; it is asked
    at the first step, and again when robots come or go. Robots that may ``swap`` take each other's slots where that is
    shorter now: who is already in a blocked slot's way moves on into it, and leaves its own.
    """

    stage: Stage
    plan: Callable[[Array], Array]
    swap: bool = False
    done: bool = False
    _swapped: float = -np.inf
    _names: list[str] = field(default_factory=list)
    _slots: Array = field(default_factory=lambda: np.empty((0, 2)))

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None = None) -> list[Wish]:
        """A wish of each robot at ``t`` for its slot, wherever is pointed; ``done`` while all are there."""
        names, here = places(states)
        if names != self._names:
            self._names, self._slots = names, self.plan(here) if names else here
        elif self.swap and not self.done and t - self._swapped >= SWAP_S:
            self._swapped, self._slots = t, matched(here, self._slots)
        self.done = bool(names) and farthest(here, self._slots) < ARRIVED
        return wishes(t, self.stage, names, self._slots)


@dataclass(slots=True)
class Pace:
    """How much time counts between two steps [s]."""

    _last: float | None = None

    def elapsed(self, t: float) -> float:
        """Time since the last call; none at the first one, and little after a pause."""
        last, self._last = self._last, t
        return 0.0 if last is None else min(max(t - last, 0.0), _LONGEST)


def wishes(t: float, stage: Stage, names: Sequence[str], slots: Array) -> list[Wish]:
    """The wish of each named robot for its slot (n, 2)."""
    speed, until = stage.limits.speed_m_s, t + stage.limits.lease_s
    return [GoTo(t, name, (x, y), speed, until) for name, (x, y) in zip(names, slots.tolist(), strict=True)]


def places(states: Mapping[str, RobotState]) -> tuple[list[str], Array]:
    """The robots' names in order, and where they are (n, 2)."""
    names = sorted(states)
    return names, np.array([states[name].xy for name in names], dtype=float).reshape(-1, 2)


def spot(pointed: Vec2 | None) -> Array | None:
    """A pointed place (2,), None where there is none that can be driven to."""
    return None if pointed is None or not np.isfinite(pointed).all() else np.array(pointed, dtype=float)


def glided(start: Array, target: Array, reach: float) -> Array:
    """The place (2,) on the way from ``start`` to ``target``, at most ``reach`` [m] on."""
    way = target - start
    length = float(np.hypot(*way))
    return target if length <= reach else start + way * (reach / length)


# --- which slot for whom --------------------------------------------------------------------------------


def matched(here: Array, slots: Array) -> Array:
    """The slots (n, 2) in the order of the robots at ``here`` (n, 2), as `assigned` says."""
    return np.asarray(slots[assigned(here, slots)])


def assigned(here: Array, slots: Array) -> NDArray[np.intp]:
    """The number of the slot (n, 2) of each robot at ``here`` (n, 2), the least squared ways in all (Kuhn 1955).

    Squares, since two straight ways of which the sum of squares is least never cross.
    """
    away = ((here[:, None] - slots) ** 2).sum(axis=2)
    return np.asarray(linear_sum_assignment(away)[1])


def farthest(here: Array, slots: Array) -> float:
    """The distance between robot and slot, of the robot that has farthest to go."""
    return float(np.hypot(*(here - slots).T).max(initial=0.0))


def least_distance(points: Array) -> float:
    """The distance between the two nearest of ``points`` (n, 2); infinite for fewer than two."""
    if len(points) < 2:
        return np.inf
    return float(cKDTree(points).query(points, k=2)[0][:, 1].min())


# --- shapes ---------------------------------------------------------------------------------------------


def pitch(stage: Stage) -> float:
    """The distance between neighbouring slots."""
    return stage.spacing + _SPARE


def check_room(n: int, stage: Stage, box: Box | None = None) -> None:
    """Refuse more robots than fit.

    Raises:
        ConfigError: where no lattice in the box, or else on the sheet, has ``n`` slots.

    """
    shape(n, stage, stage.bounds if box is None else box)


def fits(n: int, stage: Stage, box: Box) -> bool:
    """Whether a lattice in the box has ``n`` slots."""
    return n <= max(map(len, lattices(pitch(stage), box[1] - box[0])))


def gathered(n: int, stage: Stage, centre: Array, box: Box | None = None) -> Array:
    """Slots (n, 2) close together, round ``centre`` (2,) as near as the box, or else the sheet, allows."""
    box = stage.bounds if box is None else box
    return placed(shape(n, stage, box), centre, box)


def shape(n: int, stage: Stage, box: Box) -> Array:
    """The slots (n, 2) of a ring, of a filled disc, or of the most compact lattice in the box, about their middle.

    Raises:
        ConfigError: where no lattice in the box has ``n`` slots.

    """
    if n == 0:
        return np.empty((0, 2))
    gap, size = pitch(stage), box[1] - box[0]
    for roomy in (EASE * gap, gap):
        disc = filled_disc(n, roomy)
        for slots in ([ring(n, roomy)] if n <= _RING else []) + [disc, disc[:, ::-1]]:
            if np.all(np.ptp(slots, axis=0) <= size + 1e-9):
                return slots
    found = list(lattices(gap, size))
    fitting = [_innermost(lattice - size / 2, n) for lattice in found if len(lattice) >= n]
    if not fitting:
        raise ConfigError(_no_room(n, max(map(len, found)), stage, size))
    return min((slots - slots.mean(axis=0) for slots in fitting), key=lambda slots: float((slots**2).sum()))


def _no_room(n: int, most: int, stage: Stage, size: Array) -> str:
    room = f"{size[0]:.2f} × {size[1]:.2f} m of the {stage.sheet.width_m:g} × {stage.sheet.height_m:g} m sheet"
    return (
        f"{n} robots, {pitch(stage) * 1000:.0f} mm from centre to centre, were to share {room} and at most {most} "
        "fit: try fewer robots, a larger sheet or a smaller limits.gap_m"
    )


def ring(n: int, gap: float) -> Array:
    """Slots (n, 2) on a circle about the origin, neighbours ``gap`` apart; one slot lies at the origin itself."""
    radius = 0.0 if n < 2 else gap / 2 / np.sin(np.pi / n)
    angles = 2 * np.pi * np.arange(n) / max(n, 1)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def filled_disc(n: int, gap: float) -> Array:
    """The ``n`` sites (n, 2) of a hexagonal lattice that lie closest together, about their centroid."""
    found = [disc - disc.mean(axis=0) for disc in discs(n, gap)]
    return min(found, key=lambda disc: round(float((disc**2).sum()), 9))


def discs(n: int, gap: float) -> list[Array]:
    """The ``n`` innermost sites (n, 2) of hexagonal lattices, about a site, a point between two, and between three."""
    reach = np.arange(-int(np.sqrt(n)) - 2, int(np.sqrt(n)) + 3)
    i, j = (grid.ravel() for grid in np.meshgrid(reach, reach))
    sites = gap * np.stack([i + j / 2, j * np.sqrt(0.75)], axis=1)
    return [_innermost(sites - gap * np.array(middle), n) for middle in ((0, 0), (0.5, 0), (0.5, np.sqrt(1 / 12)))]


def _innermost(sites: Array, n: int) -> Array:
    return np.asarray(sites[np.argsort((sites**2).sum(axis=1).round(9), kind="stable")[:n]])


def rows(n: int, stage: Stage, foot: Array, across: int, inward: int) -> Array:
    """Slots (n, 2) in rows along an edge of the sheet, the first one on the edge, each centred at ``foot`` (2,).

    ``across`` is the axis that leads away from the edge, ``inward`` its sign. Where rows behind each other do not
    fit, the most compact lattice stands next to ``foot`` instead.
    """
    (low, high), gap = stage.bounds, EASE * pitch(stage)
    most = int((high - low)[1 - across] / gap + 1e-9) + 1
    if (-(-n // most) - 1) * gap > (high - low)[across] + 1e-9:
        return gathered(n, stage, foot)
    slots = np.empty((n, 2))
    for row, first in enumerate(range(0, n, most)):
        line = np.zeros((min(most, n - first), 2))
        line[:, 1 - across] = gap * (np.arange(len(line)) - (len(line) - 1) / 2)
        line[:, across] = inward * row * gap
        slots[first : first + most] = placed(line, foot, stage.bounds)
    return slots


# --- lattices -------------------------------------------------------------------------------------------


def lattices(gap: float, size: Array) -> Iterator[Array]:
    """Grids and staggered rows (m, 2), sites at least ``gap`` apart, spread over [0, size]; both ways round."""
    for wide, deep, order in ((size[0], size[1], 1), (size[1], size[0], -1)):
        columns, lines = (int(length / gap + 1e-9) + 1 for length in (wide, deep))
        yield _lines(lines, deep, _even(columns, wide), _even(columns, wide))[:, ::order]
        for k in range(1, columns + 1):
            for odd, step in ((k - 1, wide / max(k - 1, 1)), (k, wide / (k - 0.5))):
                if odd == 0 or (k > 1 and step < gap * (1 - 1e-9)):
                    continue
                height = max(
                    np.sqrt(max(gap**2 - step**2 / 4, 0.0)), gap / 2
                )  # at least half, as every other row stands above itself
                lines = int(deep / height + 1e-9) + 1
                yield _lines(lines, deep, step * np.arange(k), step * (np.arange(odd) + 0.5))[:, ::order]


def _even(n: int, length: float) -> Array:
    return np.array([length / 2]) if n == 1 else np.linspace(0.0, length, n)


def _lines(n: int, deep: float, even: Array, odd: Array) -> Array:
    heights = _even(n, deep)
    return np.concatenate(
        [np.stack([x, np.full(len(x), y)], axis=1) for x, y in zip([even, odd] * n, heights, strict=False)]
    )


# --- into the sheet, and apart --------------------------------------------------------------------------


def placed(slots: Array, centre: Array, box: Box) -> Array:
    """Slots (n, 2) about ``centre`` (2,), shifted together into the box; they must not be wider than it."""
    if len(slots) == 0:
        return slots
    low, high = box
    at = slots + centre
    shift = np.maximum(low - at.min(axis=0), 0.0) + np.minimum(high - at.max(axis=0), 0.0)
    return np.asarray(np.clip(at + shift, low, high))


def spaced(wanted: Array, stage: Stage, fixed: int | None = None) -> Array:
    """The places (n, 2) next to those wanted, on the sheet and apart by the spacing at least.

    The one with the number ``fixed`` keeps its place where it can. Where pushing neighbours apart finds no room, each
    takes a slot of a lattice near by.

    Raises:
        ConfigError: where not so many fit.

    """
    low, high = stage.bounds
    at = np.clip(wanted, low, high)
    for push in range(_PUSHES):
        pairs = cKDTree(at).query_pairs(stage.spacing, output_type="ndarray") if len(at) > 1 else np.empty((0, 2))
        if len(pairs) == 0:
            return np.asarray(at)
        at = np.clip(at + _pushes(at, pairs, pitch(stage), push, fixed if push < _FIRM else None), low, high)
    return matched(wanted, gathered(len(wanted), stage, wanted.mean(axis=0)))


def _pushes(at: Array, pairs: Array, gap: float, push: int, fixed: int | None) -> Array:
    """How far each moves (n, 2) so that each of the pairs (m, 2) alone would be ``gap`` apart."""
    first, second = pairs.T
    away = at[first] - at[second]
    length = np.hypot(*away.T)
    turn = _GOLDEN * (first + second + push)  # for two on one spot: another way at every push, as an edge may be in one
    alike = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    away = np.where(length[:, None] > 1e-6, away / np.maximum(length, 1e-6)[:, None], alike)
    if push >= _TILT[0]:
        c, s = np.cos(_TILT[1]), np.sin(_TILT[1])
        away = away @ np.array([[c, s], [-s, c]])
    way = away * ((gap - length) / 2)[:, None]
    moves = np.zeros_like(at)
    np.add.at(moves, first, np.where((second == fixed)[:, None], 2, 1) * way)
    np.add.at(moves, second, -np.where((first == fixed)[:, None], 2, 1) * way)
    if fixed is not None:
        moves[fixed] = 0.0
    return moves
