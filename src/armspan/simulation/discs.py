"""Ideal discs on a sheet: the literature's plant, for the numbers that its bounds and anchors are told for.

They drive at exactly the told speed, straight to the goal, and rest there; nothing is noisy and nobody is pushed.
Between two commands a disc's motion is known in closed form, so that what it does depends on no step of time.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from heapq import heappop, heappush
from itertools import count

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from armspan.errors import DataError
from armspan.frames import Array
from armspan.records import Command, Drive, GoTo, RobotState, Sheet, Stop, Vec2, is_finite
from armspan.simulation.addresses import addressed
from armspan.simulation.contacts import Mask

LOOK = 0.010
"""How often it is looked who overlaps [s], at least."""

SKIN = 0.04
"""How much farther than touching a pair is watched [m], so that the search for pairs is rare."""

JUST = 1e-9
"""So that a moment counts as in time in spite of rounding [s]."""


class IdealDiscs:
    """n holonomic discs that take commands and tell their states exactly, each ``latency`` [s] late.

    ``xy`` (n, 2) [m] is in ``sheet``; ``radius`` [m] is only for counting `contacts`; ``speed`` [m/s] caps what is
    told, None does not; every ``period`` [s] each tells its state. Like the robots they know no lease: a `Drive`
    holds until the next command. A told heading is taken at once. A disc that is lifted, or off the sheet, tells
    ``held`` once with the last pose that it saw, and nothing more until it is back. Lights and haptics do nothing.

    Raises:
        DataError: where names and places do not fit together, or a number makes no sense.

    """

    def __init__(
        self,
        names: Sequence[str],
        xy: ArrayLike,
        sheet: Sheet,
        latency: float = 0.0,
        radius: float = 0.0375,
        speed: float | None = None,
        period: float = 0.020,
    ) -> None:
        _check_scene(names, xy, latency, radius, speed, period)
        self.names = tuple(names)
        self.latency, self._cap = latency, math.inf if speed is None else speed
        self._size: Array = np.array([sheet.width_m, sheet.height_m])
        self._number = {name: i for i, name in enumerate(names)}
        self._legs = Legs(np.array(xy, dtype=float))
        self._tasks: list[GoTo | Drive | None] = [None] * len(names)
        self._pending: list[tuple[float, int, Callable[[float], None]]] = []
        self._order = count()
        self._air: deque[tuple[float, RobotState]] = deque()
        self._lifted, self._blind = np.zeros(len(names), dtype=bool), np.zeros(len(names), dtype=bool)
        self._seen: Array = np.column_stack((xy, np.zeros(len(names))))
        self._overlaps = Overlaps(radius)
        self._looks = math.ceil(period / LOOK - JUST)  # a period has as many looks
        self._look, self._ticks, self._now = period / self._looks, 0, 0.0

    @property
    def contacts(self) -> int:
        """How often two discs came to overlap; a pair that stays so counts once."""
        return self._overlaps.contacts

    def command(self, t: float, command: Command) -> None:
        """Send a command at session time ``t`` [s]; for a time that is over it counts from now.

        Raises:
            DeviceNotFound: for a robot that does not exist.
            DataError: for a number that is not finite.

        """
        if not is_finite(command):
            raise DataError(f"{command} has a number that is not finite; send one whose numbers all are")
        for robot in addressed(command.robot, self._number):
            self._schedule(t + self.latency, partial(self._obey, robot, command))

    def lift(self, t: float, robot: str) -> None:
        """Take a disc off the sheet at ``t`` [s]."""
        (i,) = addressed(robot, self._number)
        self._schedule(t, lambda at: self._lift(i, at))

    def put_down(self, t: float, robot: str, xy: Vec2, heading: float) -> None:
        """Put a disc on the sheet at ``t`` [s], at ``xy`` [m] and ``heading`` [rad]; it resumes its goal."""
        (i,) = addressed(robot, self._number)
        self._schedule(t, lambda at: self._put_down(i, xy, heading, at))

    def advance(self, t: float) -> list[tuple[float, RobotState]]:
        """Run to session time ``t`` [s]: what arrived since the last call, as (arrival, state), in order."""
        while (tick := self._ticks * self._look) <= t + JUST:
            self._act(tick)
            places = self._legs.places(tick)
            self._overlaps.look(places, ~self._lifted, self._legs.fastest() * self._look)
            if self._ticks % self._looks == 0:
                self._tell(tick, places)
            self._ticks += 1
        self._act(t)
        self._now = max(self._now, t)
        told = []
        while self._air and self._air[0][0] <= t + JUST:
            told.append(self._air.popleft())
        return told

    def truth(self) -> tuple[Array, Array, Array]:
        """Real xy (n, 2) [m], heading (n,) [rad], velocity (n, 2) [m/s] in ``sheet`` at the last advance's time."""
        legs = self._legs
        return legs.places(self._now), legs.headings(self._now) % (2.0 * math.pi), legs.velocities(self._now)

    def _act(self, t: float) -> None:
        """Let what was sent act until ``t``, each at its own time."""
        while self._pending and self._pending[0][0] <= t + JUST:
            at, _, act = heappop(self._pending)
            act(at)

    def _tell(self, t: float, places: Array) -> None:
        seen = ((places >= 0.0) & (places <= self._size)).all(axis=1) & ~self._lifted
        tells = seen | ~self._blind
        self._blind = ~seen
        headings = self._legs.headings(t) % (2.0 * math.pi)
        np.copyto(self._seen, np.column_stack((places, headings)), where=seen[:, None])
        arrival, held = t + self.latency, self._blind.tolist()
        poses = self._seen.tolist()
        for i in np.flatnonzero(tells).tolist():
            x, y, heading = poses[i]
            self._air.append((arrival, RobotState(t, self.names[i], (x, y), heading, held[i])))

    # --- commands --------------------------------------------------------------------------------------

    def _schedule(self, t: float, act: Callable[[float], None]) -> None:
        heappush(self._pending, (max(t, self._now), next(self._order), act))

    def _obey(self, robot: int, command: Command, at: float) -> None:
        if isinstance(command, GoTo | Drive | Stop):
            self._tasks[robot] = None if isinstance(command, Stop) else command
            self._resume(robot, at)

    def _resume(self, robot: int, at: float) -> None:
        task, legs = self._tasks[robot], self._legs
        if task is None or self._lifted[robot]:
            legs.rest(robot, at)
        elif isinstance(task, GoTo):
            legs.go(robot, at, task.xy, min(max(task.speed, 0.0), self._cap), task.heading)
        else:
            (vx, vy), told = task.velocity, math.hypot(*task.velocity)
            share = min(1.0, self._cap / told) if told > 0.0 else 0.0
            legs.drive(robot, at, (vx * share, vy * share), task.turn)

    def _lift(self, robot: int, at: float) -> None:
        self._lifted[robot] = True
        self._resume(robot, at)

    def _put_down(self, robot: int, xy: Vec2, heading: float, at: float) -> None:
        self._lifted[robot] = False
        self._legs.put(robot, at, xy, heading)
        self._overlaps.disturb()
        self._resume(robot, at)


class Legs:
    """What each of n discs does now: from a place, since a time, at a velocity, for so long; then it rests."""

    def __init__(self, xy: Array) -> None:
        n = len(xy)
        self._xy, self._velocity = xy, np.zeros((n, 2))
        self._heading, self._turn = np.zeros(n), np.zeros(n)
        self._since, self._lasts = np.zeros(n), np.zeros(n)
        self._peak = 0.0

    def fastest(self) -> float:
        """The speed [m/s] that no disc exceeded since this was asked last."""
        peak = self._peak
        self._peak = float(np.sqrt(np.einsum("ij,ij->i", self._velocity, self._velocity).max(initial=0.0)))
        return peak

    def places(self, t: float) -> Array:
        """Where they are (n, 2) [m] at ``t`` [s], not before their legs began."""
        return self._xy + self._velocity * np.minimum(t - self._since, self._lasts)[:, None]

    def headings(self, t: float) -> Array:
        """Their headings (n,) [rad], not wrapped."""
        return self._heading + self._turn * (t - self._since)

    def velocities(self, t: float) -> Array:
        """How they move (n, 2) [m/s] just after ``t``."""
        return self._velocity * (t - self._since < self._lasts - JUST)[:, None]

    def rest(self, i: int, t: float) -> None:
        """Stay where it is."""
        self._begin(i, t, (0.0, 0.0), 0.0, math.inf)

    def drive(self, i: int, t: float, velocity: Vec2, turn: float) -> None:
        """Go on and on."""
        self._begin(i, t, velocity, turn, math.inf)

    def go(self, i: int, t: float, goal: Vec2, speed: float, heading: float | None) -> None:
        """Go straight to a goal; at no speed it stays."""
        x, y = self._here(i, t)
        dx, dy = goal[0] - x, goal[1] - y
        far = math.hypot(dx, dy)
        if far > 0.0 and speed > 0.0:
            self._begin(i, t, (dx / far * speed, dy / far * speed), 0.0, far / speed)
        else:
            self.rest(i, t)
        if heading is not None:
            self._heading[i] = heading

    def put(self, i: int, t: float, xy: Vec2, heading: float) -> None:
        """Be elsewhere, at rest."""
        self.rest(i, t)
        self._xy[i], self._heading[i] = xy, heading

    def _here(self, i: int, t: float) -> Vec2:
        gone = min(t - float(self._since[i]), float(self._lasts[i]))
        (x, y), (vx, vy) = self._xy[i].tolist(), self._velocity[i].tolist()
        return x + vx * gone, y + vy * gone

    def _begin(self, i: int, t: float, velocity: Vec2, turn: float, lasts: float) -> None:
        self._heading[i] += self._turn[i] * (t - self._since[i])
        self._xy[i] = self._here(i, t)
        self._velocity[i] = velocity
        self._turn[i], self._since[i], self._lasts[i] = turn, t, lasts
        self._peak = max(self._peak, math.hypot(*velocity))


class Overlaps:
    """Counts the pairs of discs that come to overlap; those that do so at the first look count too."""

    def __init__(self, radius: float) -> None:
        self.contacts = 0
        self._reach = 2.0 * radius
        self._watched: NDArray[np.intp] = np.zeros((2, 0), dtype=np.intp)
        self._inside: NDArray[np.intp] = np.zeros(0, dtype=np.intp)
        self._slack = 0.0

    def disturb(self) -> None:
        """A disc was put elsewhere: look at all pairs anew."""
        self._slack = 0.0

    def look(self, places: Array, solid: Mask, stride: float) -> None:
        """Look at ``places`` (n, 2) [m], no disc farther than ``stride`` [m] from where it was at the last look."""
        self._slack -= 2.0 * stride  # a pair that was not watched may have come so much nearer
        if self._slack <= 0.0:
            self._watched = cKDTree(places).query_pairs(self._reach + SKIN, output_type="ndarray").T
            self._slack = SKIN
        a, b = self._watched
        gap = places[a] - places[b]
        near = np.einsum("ij,ij->i", gap, gap) < self._reach**2
        near &= solid[a] & solid[b]
        inside = a[near] * len(places) + b[near]
        if inside.size:
            self.contacts += int(np.isin(inside, self._inside, invert=True).sum())
        self._inside = inside


def _check_scene(
    names: Sequence[str], xy: ArrayLike, latency: float, radius: float, speed: float | None, period: float
) -> None:
    n, shape = len(names), np.shape(xy)
    if len(set(names)) != n:
        raise DataError(f"robots' names are not all different: {', '.join(names)}; rename one")
    if shape != (n, 2) or not np.isfinite(np.asarray(xy, dtype=float)).all():
        raise DataError(f"{n} robots need finite xy ({n}, 2), not an array of shape {shape}")
    for what, value in (("latency", latency), ("radius", radius), ("speed", speed or 0.0)):
        if not (math.isfinite(value) and value >= 0.0):
            raise DataError(f"{what} is {value}; expected a finite number of at least 0")
    if not (math.isfinite(period) and period > 0.0):
        raise DataError(f"period is {period} s; expected more than 0, such as 0.02")
