"""Many thousands of calibrations at once: how far from its target a gesture is taken to point, and what makes it so.

Every set-up is a new person with a new band at the same sheet: stops are pointed at, the place is fitted by least
squares, and other places of the sheet are pointed at. Axes are the true user's: z up, the floor below the eye.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from armspan.frames import Array, plane_hit
from armspan.pointing.batch import calibrate_many
from armspan.pointing.rays import unit
from armspan.records import Body
from armspan.study.pointing_error.sources import NAMES, USUAL, Wrongs, draw_wrongs

CHUNK = 2500
"""Set-ups that are computed together: enough to pay for numpy's calls, few enough for the caches."""

FEWEST = 250
"""Set-ups from which one line of a budget, or one number of stops, can be read."""

TARGETS = 8
"""Places of the sheet that each set-up is asked to point at."""

_EYE, _FORWARD, _LEFT, _UP, _ARM = USUAL.mean.tolist()
BELIEVED = Body(_EYE, (_FORWARD, _LEFT, _UP), _ARM)
"""A man of 1.75 m in shoes."""

_FAR_M = 50.0
"""A ray that meets the sheet beyond this [m], or not at all, counts as this far off."""


@dataclass(frozen=True, slots=True)
class Layout:
    """A square sheet before the user: its ``side``, its ``height`` and the ``distance`` of its middle [m]."""

    name: str
    height: float
    distance: float
    side: float

    def places(self, shares: Array) -> Array:
        """Points (..., 3) [m] in the user's axes; ``shares`` (..., 2) run from -1 to 1 across the sheet."""
        level = np.full((*shares.shape[:-1], 1), self.height)
        return np.concatenate([shares * self.side / 2.0 + [self.distance, 0.0], level], axis=-1)


TABLE = Layout("table at 1 m", 0.75, 1.0, 0.4)
"""The report's square, on a table."""

FLOOR = Layout("floor at 1.5 m", 0.0, 1.5, 1.0)


def stop_shares(count: int) -> Array:
    """Where (count, 2) the stops are, as `Layout.places` takes them: a triangle, corners, a ring or a full grid."""
    if count == 3:
        return np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, 0.0]])
    corners = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]])
    if count in (4, 5):
        return np.concatenate([corners, np.zeros((count - 4, 2))])
    side = np.linspace(-1.0, 1.0, 3 if count == 8 else round(count**0.5))
    grid = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2)
    return grid[np.abs(grid).max(axis=1) > 0.5] if count == 8 else grid


@dataclass(frozen=True, slots=True)
class Task:
    """A chunk of set-ups: what it holds is all that its result depends on, so that any process may compute it."""

    layout: Layout
    seed: int
    number: int
    count: int
    stops: int = 4
    gestures: int = 1
    sources: tuple[str, ...] = NAMES


def chunk_errors(task: Task) -> Array:
    """Distances (count, `TARGETS`) [m] between the targets and where the gestures are taken to point."""
    rng = np.random.default_rng([task.seed, task.number])
    layout, stops = task.layout, task.stops
    wrongs = draw_wrongs(rng, task.count, stops, TARGETS, task.sources, task.gestures)
    shares = np.broadcast_to(stop_shares(stops), (task.count, stops, 2))
    told = layout.places(np.concatenate([shares, rng.uniform(-1.0, 1.0, (task.count, TARGETS, 2))], axis=1))
    true = told.copy()
    true[:, :stops, 2] += wrongs.light[:, None]
    origins, directions = believed_rays(BELIEVED, wrongs, true)
    hits = _hits(origins, directions, told[:, :stops], layout.height)
    errors = np.linalg.norm(hits - told[:, stops:, :2], axis=-1)
    return np.asarray(np.where(errors < _FAR_M, errors, _FAR_M))


def believed_rays(believed: Body, wrongs: Wrongs, places: Array) -> tuple[Array, Array]:
    """Origins and unit directions (m, n, 3) that a band and the believed measures make of gestures at ``places``."""
    sd = wrongs.body[:, None]
    eye = np.concatenate([np.zeros((len(sd), 1, 2)), believed.eye_height_m + sd[..., :1]], axis=-1) + wrongs.sway
    shoulder = eye - (believed.shoulder_to_eye_m + sd[..., 1:4])
    sight = _turned(unit(places - eye), wrongs.aim)
    across = eye - shoulder
    along = (across * sight).sum(axis=-1, keepdims=True)
    reach = believed.shoulder_to_fingertip_m + sd[..., 4:]
    fingertip = eye + sight * (np.sqrt(along**2 - (across**2).sum(axis=-1, keepdims=True) + reach**2) - along)
    forearm = _turned(unit(fingertip - shoulder), wrongs.elbow)
    forearm = _banded(forearm, wrongs.yaw, wrongs.pitch)
    offset = believed.shoulder_to_fingertip_m * forearm - believed.shoulder_to_eye_m
    return np.broadcast_to([0.0, 0.0, believed.eye_height_m], offset.shape), unit(offset)


def _hits(origins: Array, directions: Array, points: Array, height: float) -> Array:
    """Where (m, targets, 2) the rays after the stops' meet the sheet when the stops' place the user."""
    stops = points.shape[1]
    found = calibrate_many(origins[:, :stops], directions[:, :stops], points, z_up=True)
    cosine, sine = np.cos(found.yaw), np.sin(found.yaw)
    transposed = np.zeros((len(points), 3, 3))  # of row vectors
    transposed[:, 0, 0] = transposed[:, 1, 1] = cosine
    transposed[:, 0, 1], transposed[:, 1, 0], transposed[:, 2, 2] = sine, -sine, 1.0
    start, along = origins[:, stops:] @ transposed + found.xyz[:, None], directions[:, stops:] @ transposed
    return plane_hit(start, along, height)[..., :2]


def _turned(directions: Array, angles: Array) -> Array:
    """Unit ``directions`` (..., 3) turned to the left and up by small ``angles`` (..., 2) [rad]."""
    x, y, z = np.moveaxis(directions, -1, 0)
    level = np.hypot(x, y)
    left = np.stack([-y / level, x / level, np.zeros_like(x)], axis=-1)
    up = np.stack([-z * x / level, -z * y / level, level], axis=-1)
    return unit(directions + np.tan(angles[..., :1]) * left + np.tan(angles[..., 1:]) * up)


def _banded(forearm: Array, yaw: Array, pitch: Array) -> Array:
    """What a band says of the forearm (m, n, 3) that sits ``pitch`` off and whose heading is ``yaw`` off."""
    x, y, z = np.moveaxis(forearm, -1, 0)
    azimuth, elevation = np.arctan2(y, x) + yaw, np.arctan2(z, np.hypot(x, y)) + pitch
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)


@dataclass(frozen=True, slots=True)
class Budget:
    """One source's part: the errors [m] with it ``alone`` and ``without`` it, as (median, 90th percentile).

    ``share`` is its part of the sum of all sources' mean squares, each alone.
    """

    source: str
    share: float
    alone: tuple[float, float]
    without: tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class MonteCarlo:
    """Simulated set-ups at one layout: all errors (n,) [m] in rising order, and what each source adds."""

    layout: Layout
    count: int
    stops: int
    errors: Array
    budget: tuple[Budget, ...]

    def percentile(self, share: float) -> float:
        """The error [m] that ``share`` percent of all gestures stay below."""
        return float(np.percentile(self.errors, share))

    def document(self) -> dict[str, object]:
        """For JSON, in millimetres."""
        return {
            "layout": self.layout.name,
            "calibrations": self.count,
            "stops": self.stops,
            **{f"{name}_mm": 1000.0 * self.percentile(p) for name, p in (("median", 50), ("p90", 90), ("p99", 99))},
            "budget": [
                {
                    "source": part.source,
                    "share": part.share,
                    "alone_median_mm": 1000.0 * part.alone[0],
                    "alone_p90_mm": 1000.0 * part.alone[1],
                    "without_median_mm": 1000.0 * part.without[0],
                    "without_p90_mm": 1000.0 * part.without[1],
                }
                for part in self.budget
            ],
        }


Progress = Callable[[int, int], None]
"""Told how many of how many calibrations are done."""

Mapper = Callable[[Callable[[Task], Array], Iterable[Task]], Iterable[Array]]
"""``map``, or a process pool's."""


def chunks(
    layout: Layout, count: int, seed: int, stops: int = 4, gestures: int = 1, sources: tuple[str, ...] = NAMES
) -> list[Task]:
    """``count`` set-ups in chunks whose dice do not depend on who computes them."""
    sizes = [CHUNK] * (count // CHUNK) + [count % CHUNK] * (count % CHUNK > 0)
    return [Task(layout, seed, number, size, stops, gestures, sources) for number, size in enumerate(sizes)]


def run(
    layout: Layout,
    count: int = 100_000,
    seed: int = 0,
    progress: Progress = lambda done, total: None,
    mapper: Mapper = map,
) -> MonteCarlo:
    """Draw ``count`` set-ups with everything wrong at once, and a fortieth (`FEWEST` at least) for each budget line."""
    whole = chunks(layout, count, seed)
    part = chunks(layout, max(FEWEST, count // 40), seed)
    alone = [replace(task, sources=(name,)) for name in NAMES for task in part]
    without = [replace(task, sources=all_but(name)) for name in NAMES for task in part]
    tasks = whole + alone + without
    total, done, found = sum(task.count for task in tasks), 0, []
    for task, errors in zip(tasks, mapper(chunk_errors, tasks), strict=True):
        found.append(errors)
        done += task.count
        progress(done, total)
    rest = found[len(whole) :]
    groups = [np.concatenate(rest[k : k + len(part)]).ravel() for k in range(0, len(rest), len(part))]
    budget = _budget(groups[: len(NAMES)], groups[len(NAMES) :])
    return MonteCarlo(layout, count, 4, np.sort(np.concatenate(found[: len(whole)]).ravel()), budget)


def all_but(name: str) -> tuple[str, ...]:
    """All sources of error but one."""
    return tuple(other for other in NAMES if other != name)


def _budget(alone: list[Array], without: list[Array]) -> tuple[Budget, ...]:
    squares = np.array([np.mean(errors**2) for errors in alone])
    shares = squares / squares.sum()
    return tuple(
        Budget(name, float(share), _middle(one), _middle(rest))
        for name, share, one, rest in zip(NAMES, shares, alone, without, strict=True)
    )


def _middle(errors: Array) -> tuple[float, float]:
    median, high = np.percentile(errors, (50, 90))
    return float(median), float(high)
