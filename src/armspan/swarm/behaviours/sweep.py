"""Coverage by sweeping: every spot of an area comes under a robot, in lanes, each robot in a part of its own."""

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from armspan.frames import Array
from armspan.records import Drive, GoTo, RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.strips import COVER, area_on, closest, plan, way_lengths

REACH = 0.01
"""A waypoint this near [m] is passed by a robot that slows down before it: a Cellulo stops up to 2.5 mm short."""

THERE = 0.0025
"""A waypoint this near [m] is passed at any speed."""

SLOW = 1 / 3
"""A robot slows down when it comes nearer at less than this share of the speed cap."""

AHEAD = 0.1
"""How far ahead [m] along its lane a robot wishes to be: far enough to drive at full speed, and to keep to the lane."""

STEP = 0.02
"""Distance [m] between the points of a lane that are ticked off."""

ASIDE = 0.25
"""How far from a point of its lane, as a share of the disc's width, a robot may pass and still have swept it."""

GONE = 3.0
"""The lanes of a robot that was not heard of for so long [s] are free for others."""

STUCK = 4.0
"""A robot that came no nearer to the end of its lane for so long [s] leaves it for later."""

TRIES = 2
"""How often a robot drives at a point before it leaves it to the others: something stands in its way."""

Stretch: TypeAlias = tuple[int, int]
"""A piece of a lane: the numbers of its first and its last point, in the order of driving."""


@dataclass(slots=True)
class _Worker:
    """A robot at work: how often it tried each point, what it has to sweep, when it was heard of, how it gets on."""

    tries: NDArray[np.int8]
    todo: deque[Stretch] = field(default_factory=deque)
    heard: float = -math.inf
    entered: bool = False
    nearest: float = math.inf
    since: float = -math.inf
    last: tuple[float, float] = (0.0, math.inf)
    place: Vec2 | None = None

    def turn_to_next(self) -> None:
        """Forget how the last waypoint was reached."""
        self.entered, self.nearest, self.since, self.last = False, math.inf, -math.inf, (0.0, math.inf)

    def may_take(self, stretch: Stretch) -> bool:
        """Whether it has not tried a stretch often enough."""
        return int(self.tries[min(stretch) : max(stretch) + 1].max()) < TRIES

    def passes(self, t: float, away: float, speed: float) -> bool:
        """Whether a waypoint so far ``away`` [m] at ``t`` [s] is passed by a robot that can drive at ``speed``."""
        before, was_away = self.last
        if t > before:
            self.last = t, away
        return away < THERE or (away < REACH and was_away - away < SLOW * speed * max(t - before, 1e-3))


class Sweep:
    """Sweep an area (the whole sheet without one) boustrophedon, each robot in a part of equal size.

    ``area`` are the corners [m] of a polygon in ``sheet``, ``cover`` [m] is the width of the disc that a robot sweeps
    with. Robots sweep in step where that keeps them apart. What a robot leaves out (since it drops out, or has to go
    round another) is swept by those that are done first. See Choset 2001, Coverage for robotics: a survey.

    Raises:
        ConfigError: of an area that crosses itself, or has none on the sheet.

    """

    def __init__(
        self,
        stage: Stage,
        states: Mapping[str, RobotState],
        area: Sequence[Vec2] | None = None,
        *,
        cover: float = COVER,
    ) -> None:
        self._stage = stage
        self._names = sorted(states)
        here = np.array([states[name].xy for name in self._names], dtype=float).reshape(-1, 2)
        ways, wait = _shared(stage, here, area, cover)
        stretches, self._points = _ticked(ways)
        self._tree = KDTree(self._points)
        self._aside = ASIDE * cover
        self._swept: NDArray[np.bool_] = np.zeros(len(self._points), dtype=bool)
        self._workers = {name: self._worker(way) for name, way in zip(self._names, stretches, strict=False)}
        self._free: list[Stretch] = [] if self._workers else [stretch for way in stretches for stretch in way]
        self._wait, self._began, self._now, self._waiting = wait, math.nan, math.nan, wait > 0

    def _worker(self, way: Iterable[Stretch] = ()) -> _Worker:
        return _Worker(np.zeros(len(self._points), dtype=np.int8), deque(way))

    @property
    def done(self) -> bool:
        """Whether all lanes are swept, but for what each robot there tried in vain."""
        if any(worker.todo for worker in self._workers.values()):
            return False
        there = [worker for worker in self._workers.values() if worker.heard == self._now]
        if not there:
            return not self._free
        return not any(worker.may_take(stretch) for stretch in self._free for worker in there)

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[GoTo | Drive]:
        """Along its lanes with each; the wish lies ahead on the lane, or is where a robot waits or has ended."""
        self._now, self._began = t, t if math.isnan(self._began) else self._began
        self._hear(t, states)
        self._tick_off(states)
        self._waiting = self._waiting and t - self._began < self._wait and not self._all_at_start(states)
        return [self._wish(t, states[name]) for name in sorted(states)]

    def _hear(self, t: float, states: Mapping[str, RobotState]) -> None:
        for name in sorted(states):
            self._workers[name] = worker = self._workers.get(name) or self._worker()
            if t - worker.heard > STUCK / 4:
                worker.nearest = math.inf  # it did not stand still before something, it was away
            worker.heard = t
        for worker in self._workers.values():
            worker.heard = max(worker.heard, self._began)
            if t - worker.heard > GONE and worker.todo:
                self._leave(worker.todo)
                worker.todo.clear()
                worker.turn_to_next()

    def _tick_off(self, states: Mapping[str, RobotState]) -> None:
        if states:
            here = [states[name].xy for name in sorted(states)]
            for near in self._tree.query_ball_point(here, self._aside):
                self._swept[near] = True

    def _leave(self, stretches: Iterable[Stretch]) -> None:
        """Free what of these is not swept yet for whoever has time."""
        for first, last in stretches:
            way = np.arange(first, last + 1) if first <= last else np.arange(first, last - 1, -1)
            swept = self._swept[way]
            runs = np.split(way, np.flatnonzero(np.diff(swept)) + 1)
            self._free += [(int(run[0]), int(run[-1])) for run in runs if not self._swept[run[0]]]

    def _all_at_start(self, states: Mapping[str, RobotState]) -> bool:
        firsts = [(self._workers[name].todo, states[name].xy) for name in self._names if name in states]
        return all(not todo or math.dist(self._points[todo[0][0]], xy) < REACH for todo, xy in firsts)

    def _wish(self, t: float, state: RobotState) -> GoTo:
        worker, here = self._workers[state.robot], np.array(state.xy)
        goal = self._goal(t, worker, here)
        while goal is None:
            stretch = worker.todo.popleft()
            low, high = min(stretch), max(stretch)
            worker.tries[low : high + 1] += 1
            self._leave([stretch])
            worker.turn_to_next()
            goal = self._goal(t, worker, here)
        limits = self._stage.limits
        low_xy, high_xy = self._stage.bounds
        x, y = np.clip(goal, low_xy, high_xy)
        return GoTo(t, state.robot, (float(x), float(y)), limits.speed_m_s, t + limits.lease_s)

    def _goal(self, t: float, worker: _Worker, here: Array) -> Array | None:
        """Where to go on the stretch that is next, None where it ends here."""
        if not worker.todo:
            self._take(worker, here)
        if not worker.todo:
            worker.place = worker.place or (float(here[0]), float(here[1]))
            return np.array(worker.place)
        worker.place, speed = None, self._stage.limits.speed_m_s
        start, end = self._points[list(worker.todo[0])]
        if not worker.entered and not self._waiting and worker.passes(t, math.dist(here, start), speed):
            worker.turn_to_next()
            worker.entered = True
        away = math.dist(here, end if worker.entered else start)
        if self._is_stuck(t, worker, away) or (worker.entered and worker.passes(t, away, speed)):
            return None
        return _ahead(here, start, end) if worker.entered else start

    def _is_stuck(self, t: float, worker: _Worker, away: float) -> bool:
        if away < worker.nearest - REACH or self._waiting:
            worker.nearest, worker.since = away, t
        return t - worker.since > STUCK

    def _take(self, worker: _Worker, here: Array) -> None:
        """Take the free stretch with the nearest end, from that end."""
        open_ = [stretch for stretch in self._free if worker.may_take(stretch)]
        if open_:
            away = np.linalg.norm(self._points[np.array(open_)] - here, axis=2)
            number, end = divmod(int(np.argmin(away)), 2)
            self._free.remove(open_[number])
            worker.todo.append(open_[number] if end == 0 else open_[number][::-1])


def _ahead(here: Array, start: Array, end: Array) -> Array:
    """The point of a lane that lies `AHEAD` of the robot's foot on it, its end at most."""
    length = math.dist(start, end)
    along = (end - start) / max(length, 1e-12)
    foot = float((here - start) @ along)
    return np.asarray(start + along * min(max(foot, 0.0) + AHEAD, length))


def _shared(stage: Stage, here: Array, area: Sequence[Vec2] | None, cover: float) -> tuple[list[Array], float]:
    """The lanes (k, 2, 2) [m] of each robot, and how long [s] all wait at most until the last is at its start."""
    shape = area_on(stage.sheet, area)
    layouts = plan(shape, stage.bounds, max(1, len(here)), cover, stage.spacing)
    ways = [list(layout.lanes) for layout in layouts]
    ways += [[lanes[::-1, ::-1] for lanes in layout.lanes] for layout in layouts]
    if not len(here):
        return ways[0], 0.0
    best = (True, math.inf, 0.0), ways[0], 0.0
    for lanes in ways:
        cost = cdist(here, [way[0, 0] for way in lanes])
        _, taken = linear_sum_assignment(cost)
        mine, travel = [lanes[part] for part in taken], cost[np.arange(len(here)), taken]
        lengths = np.array([way_lengths(way)[-1] for way in mine])
        in_step = closest(mine) >= stage.spacing
        wait = in_step and closest(mine, travel) < stage.spacing
        length = float(travel.max() + lengths.max()) if wait else float((travel + lengths).max())
        worth = (not in_step, length, float(travel.sum()))
        if worth < best[0]:
            best = worth, mine, (1.5 * float(travel.max()) / stage.limits.speed_m_s + 2.0 if wait else 0.0)
    return best[1], best[2]


def _ticked(ways: list[Array]) -> tuple[list[list[Stretch]], Array]:
    """The points (m, 2) [m] of all lanes that are ticked off, and the stretches of each robot among them."""
    points, stretches, count = [], [], 0
    for lanes in ways:
        mine = []
        for start, end in lanes:
            steps = max(1, math.ceil(math.dist(start, end) / STEP))
            points.append(np.linspace(start, end, steps + 1))
            mine.append((count, count + steps))
            count += steps + 1
        stretches.append(mine)
    return stretches, np.concatenate(points)
