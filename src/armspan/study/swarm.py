"""The account of a swarm's run: coverage, paths, gaps, collisions, deadlocks, violations; from the true places."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from armspan.errors import DataError, DeviceNotFound, known_names
from armspan.frames import Array
from armspan.records import Drive, GoTo, Record, Sheet
from armspan.study.coverage import Area, Coverage, closeness, cluster_size, locational_cost
from armspan.study.safety import BODY, SafetyWatch
from armspan.swarm.limits import Limits

ARRIVED = 0.01
"""Nearer than this to its goal a robot has fulfilled it [m]."""

PROGRESS, PATIENCE = 0.02, 10.0
"""A robot that came less than this nearer [m] to its goal within so long [s] is in a deadlock."""

COVER = 0.0375
"""Half of Cellulo's width across its flats [m]: what it covers whatever its heading."""

_NOWHERE = (np.nan, np.nan)


class SwarmAccount:
    """What ``names`` did on a ``sheet``: fed the truth by `take`, all records by `hear`, and wishes by `want`.

    ``body`` [m] is a robot's radius, ``cover_radius`` [m] what it covers of ``area`` (of the whole sheet); its
    middle can be where ``limits`` let it. Times in the account count from the first `take`.
    """

    def __init__(
        self,
        names: Sequence[str],
        sheet: Sheet,
        limits: Limits,
        *,
        body: float = BODY,
        cover_radius: float = COVER,
        area: Area | None = None,
    ) -> None:
        self.names, self.sheet, self.limits = tuple(names), sheet, limits
        self.coverage = Coverage(sheet if area is None else area, cover_radius)
        self.gaps = Gaps(body)
        self.safety = SafetyWatch(limits, sheet, body=body)
        self._number = {name: i for i, name in enumerate(names)}
        self._times: list[float] = []
        self._places: list[Array] = []
        self._goals: Array = np.full((len(names), 2), np.nan)
        self._goal_before: Array = self._goals.copy()
        self._goal_since: Array = np.zeros(len(names))
        self._wished = False

    def take(self, t: float, xy: ArrayLike) -> None:
        """Take the true places (n, 2) [m] at ``t`` [s], not a number for a robot that is lifted; often, as 20 a second.

        Raises:
            DataError: where ``t`` does not rise, or there are not as many places as robots.

        """
        here = np.array(xy, dtype=float)
        if here.shape != (len(self.names), 2):
            raise DataError(f"{len(self.names)} robots need places ({len(self.names)}, 2), not of shape {here.shape}")
        self.coverage.take(t, here)
        self._times.append(t)
        self.gaps.take(t - self._times[0], here)
        self._places.append(here)

    def hear(self, record: Record) -> None:
        """Hear a record: a command that was sent, a state that was told, a stop, a press."""
        self.safety.take(record)

    def want(self, t: float, wishes: Iterable[GoTo | Drive]) -> None:
        """Hear what the behaviour wishes at ``t`` [s] for every robot; one without a wish to go somewhere has no goal.

        Raises:
            DeviceNotFound: for a robot that does not take part.

        """
        goals: Array = np.full(self._goals.shape, np.nan)
        for wish in wishes:
            if wish.robot not in self._number:
                raise DeviceNotFound(known_names("robot", wish.robot, self.names))
            goals[self._number[wish.robot]] = wish.xy if isinstance(wish, GoTo) else _NOWHERE
        moved = ~(np.hypot(*(goals - self._goal_before).T) < PROGRESS)  # a goal may creep without being a new one
        self._goal_before[moved], self._goal_since[moved] = goals[moved], t
        self._goals, self._wished = goals, True

    @property
    def times(self) -> Array:
        """When the places were taken (k,) [s], from zero."""
        return self.coverage.taken

    @property
    def places(self) -> Array:
        """The places (k, n, 2) [m]."""
        return np.array(self._places).reshape(-1, len(self.names), 2)

    @property
    def paths(self) -> Array:
        """How far each robot went (n,) [m]."""
        return path_lengths(self.places)

    def deadlocks(self) -> int | None:
        """How many robots are stuck, as `deadlocks` has it; None where no wish was told or the run is too short.

        A goal that is younger than the patience does not count: who got it just now had no time to make progress.
        """
        if not self._wished or not self._times:
            return None
        young = self._goal_since > max(self._times[0], self._times[-1] - PATIENCE) + 1e-9
        return deadlocks(np.where(young[:, None], np.nan, self._goals), self.times, self.places)

    def document(self) -> dict[str, object]:
        """The account as JSON-able values; None where a number cannot be had.

        ``locational_cost`` (of the whole area, normalised), ``cs`` and ``z_m`` are those of the robots' last places.
        """
        return {
            "seconds": round(float(self.times[-1]), 3) if self._times else 0.0,
            "robots": len(self.names),
            "coverage": self._coverage(),
            **self._deployment(),
            "path_m": self._path(),
            **self.gaps.document(),
            "deadlocks": self.deadlocks(),
            "violations": dict(self.safety.violations),
        }

    def _coverage(self) -> dict[str, object]:
        swept, margin = self.coverage, self.limits.body_radius_m
        reachable = swept.reachable(margin, self.sheet)
        return {
            **_rounded(swept.times()),
            "share_end": round(swept.share(), 4),
            "overlap": round(swept.overlap, 4),
            "coverable": round(swept.coverable(margin, self.sheet), 4),
            "of_coverable": {**_rounded(swept.times(only=reachable)), "share_end": round(swept.share(reachable), 4)},
        }

    def _deployment(self) -> dict[str, float | None]:
        here = self._places[-1] if self._places else np.zeros((0, 2))
        here = here[np.isfinite(here).all(axis=1)]
        if not len(here):
            return {"locational_cost": None, "cs": None, "z_m": None}
        return {
            "locational_cost": round(locational_cost(here, self.coverage.area, normalised=True), 6),
            "cs": round(cluster_size(here), 4),
            "z_m": round(closeness(here), 4) if len(here) > 1 else None,
        }

    def _path(self) -> dict[str, object]:
        paths = self.paths.tolist()
        each = {name: round(path, 4) for name, path in zip(self.names, paths, strict=True)}
        return {"total": round(sum(paths), 4), "robots": each}


def path_lengths(places: Array) -> Array:
    """How far each robot went (n,) [m] through places (k, n, 2) [m]; where they are not a number it was carried."""
    steps = np.linalg.norm(np.diff(places, axis=0), axis=2)
    paths: Array = np.nansum(steps, axis=0)
    return paths


def deadlocks(
    goals: ArrayLike,
    times: ArrayLike,
    places: ArrayLike,
    *,
    near: float = ARRIVED,
    progress: float = PROGRESS,
    patience: float = PATIENCE,
) -> int | None:
    """How many robots are farther than ``near`` [m] from their goals, and came hardly nearer in the last while.

    ``goals`` (n, 2) [m], not a number for a robot without one; ``times`` (k,) [s]; ``places`` (k, n, 2) [m]. Hardly is
    less than ``progress`` [m] in ``patience`` [s]. None for a history shorter than that, unless all have arrived.
    """
    when, where, wanted = (np.asarray(values, dtype=float) for values in (times, places, goals))
    left = np.linalg.norm(where[-1] - wanted, axis=1)
    unfulfilled = left > near
    if not unfulfilled.any():
        return 0
    since = int(np.searchsorted(when, when[-1] - patience + 1e-9, side="right")) - 1
    if since < 0:
        return None
    stuck = np.linalg.norm(where[since] - wanted, axis=1) - left < progress
    return int(np.count_nonzero(unfulfilled & stuck))


@dataclass(frozen=True, slots=True)
class Gap:
    """What was free between the two nearest bodies [m], at ``t`` [s]; negative where they overlapped."""

    t: float
    gap: float


class Gaps:
    """The gaps between bodies of one radius ``body`` [m] over time, and how often a pair came to overlap."""

    def __init__(self, body: float) -> None:
        self.collisions = 0
        self.series: list[Gap] = []
        self.body, self._robots = body, 0
        self._before: Array | None = None
        self._inside: NDArray[np.intp] = np.zeros(0, dtype=np.intp)

    @property
    def least(self) -> Gap | None:
        """The smallest gap and when it was; None where there never were two robots."""
        return min(self.series, key=lambda each: each.gap, default=None)

    def take(self, t: float, xy: Array) -> None:
        """Take places (n, 2) [m] at ``t`` [s]; what counts is the nearest that a pair came on the straight way there.

        A pair that overlaps counts once until it is apart again; so does one that overlaps from the start.
        """
        self._robots = len(xy)
        before = xy if self._before is None else np.where(np.isfinite(self._before), self._before, xy)
        self._before = xy
        on = np.flatnonzero(np.isfinite(xy).all(axis=1))
        if len(on) < 2:
            self._inside = self._inside[:0]
            return
        first, second, distance = _approaches(before[on], xy[on], 2.0 * self.body)
        self.series.append(Gap(t, float(distance.min()) - 2.0 * self.body))
        hit = distance < 2.0 * self.body
        inside = on[first[hit]] * self._robots + on[second[hit]]
        self.collisions += int(np.isin(inside, self._inside, invert=True).sum())
        self._inside = inside

    def document(self) -> dict[str, object]:
        """The smallest gap and when it was, None where there never were two robots; and the collisions."""
        least = self.least
        return {
            "min_gap_mm": None if least is None else round(1000 * least.gap, 2),
            "min_gap_t": None if least is None else round(least.t, 3),
            "collisions": self.collisions,
        }


def _approaches(before: Array, here: Array, reach: float) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """How near (p,) [m] pairs came on straight ways: the nearest pair, and all that may have come within ``reach``."""
    tree = cKDTree(here)
    nearest = float(tree.query(here, k=2)[0][:, 1].min())
    stride = float(np.linalg.norm(here - before, axis=1).max())
    first, second = tree.query_pairs(max(nearest, reach) + 2.0 * stride + 1e-9, output_type="ndarray").T
    start = before[first] - before[second]
    way = here[first] - here[second] - start
    along = -np.einsum("pi,pi->p", start, way) / np.maximum(np.einsum("pi,pi->p", way, way), 1e-30)
    distance: Array = np.linalg.norm(start + np.clip(along, 0.0, 1.0)[:, None] * way, axis=1)
    return first, second, distance


def _rounded(times: dict[str, float | None]) -> dict[str, float | None]:
    return {name: None if t is None else round(t, 2) for name, t in times.items()}
