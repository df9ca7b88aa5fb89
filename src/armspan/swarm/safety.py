"""The last filter before ``swarm.send``: nothing that moves a robot bypasses it.

Motion leaves as a position goal at most ``lead_m`` ahead of the robot, so that a robot whose process or link dies comes
to rest by itself: Cellulo's firmware keeps its last velocity for ever, but stops at a goal. A Stop for all is latched:
after it no motion leaves until an explicit resume. A robot that was stopped by itself (lifted, silent, off the sheet,
battery low) waits until something new is asked of it.
"""

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from armspan.frames import Array
from armspan.records import Command, Drive, GoTo, RobotState, Sheet, Stop, is_finite
from armspan.swarm.answers import TAPER, Answers
from armspan.swarm.avoidance import HORIZON, Avoidance, Crowd, neighbours, ranks, table, wall_lines
from armspan.swarm.cells import cell_lines
from armspan.swarm.courses import Courses
from armspan.swarm.fitness import STALE, unfit
from armspan.swarm.halfplanes import nearest_allowed
from armspan.swarm.limits import Limits
from armspan.swarm.orca import Pairs

LOST = 0.1
"""Seconds beyond the latency for which a goal that was replaced may still be driven to: a packet or two were lost."""

_STRAY = 0.002
_SHORT = 0.010
_BEAT = 0.05
_SOONEST, _LATEST = 0.02, 0.1


class SafetyFilter:
    """Lets through what is safe, made safe where it can be: caps, bounds, gaps, leases, the latch.

    ``waiting`` tells which robots wait for a new command, and why. ``rng`` is for getting out of deadlocks.
    """

    def __init__(self, limits: Limits, sheet: Sheet, rng: np.random.Generator | None = None) -> None:
        self.limits, self.sheet = limits, sheet
        self.stopped = False
        self.waiting: dict[str, str] = {}
        size, margin = np.array([sheet.width_m, sheet.height_m]), limits.body_radius_m
        self._bounds = np.minimum(margin, size / 2), np.maximum(size - margin, size / 2)
        self._clear = 2 * limits.body_radius_m + limits.gap_m
        reach = self._clear + _STRAY + limits.speed_m_s * limits.latency_s
        self._avoidance = Avoidance(reach, self._bounds, rng or np.random.default_rng(0))
        self._keep = limits.latency_s + LOST
        self._courses = Courses(math.ceil((self._keep + STALE) / _BEAT) + 2)
        self._answers = Answers(limits.lead_m, limits.latency_s + _BEAT / 2)

    def resume(self) -> None:
        """Take the latch off; robots still wait for a new command."""
        self.stopped = False

    def release(self, robots: Iterable[str]) -> None:
        """Something new is asked of robots: they wait no longer. What is wrong with them now stops them again."""
        for robot in list(robots):
            self.waiting.pop(robot, None)

    def watch(self, t: float, states: Mapping[str, RobotState]) -> list[Command]:
        """A Stop for each robot that has become unfit to be driven, or whose lease has run out."""
        stops: list[Command] = []
        for robot, state in states.items():
            why = unfit(t, state, self.sheet, self.limits)
            if why is not None and robot not in self.waiting:
                stops.append(self.hold(t, robot, why))
        stops.extend(self._halt(Stop(t, robot, "its lease ended")) for robot in self._courses.lapsed(t))
        return stops

    @property
    def driven(self) -> set[str]:
        """The robots that have a lease."""
        return set(self._courses.lapsed(np.inf))

    def hold(self, t: float, robot: str, why: str) -> Stop:
        """Stop one robot, which then waits for a new command."""
        self.waiting[robot] = why
        return self._halt(Stop(t, robot, why))

    def admit(self, t: float, commands: Sequence[Command], states: Mapping[str, RobotState]) -> list[Command]:
        """The commands as they may leave at ``t`` [s], in order: made safe, a Stop in their place, or left out.

        Motions given together are made safe together, so that robots can give way to each other; of several for one
        robot the last one counts.
        """
        passed: list[Command] = []
        motions: dict[str, GoTo | Drive] = {}
        for command in commands:
            if isinstance(command, Stop):
                passed.append(self._halt(command))
                if command.robot is None:
                    motions.clear()
                else:
                    motions.pop(command.robot, None)
            elif not _finite(command):
                motions.pop(command.robot, None)
                passed.append(self._halt(Stop(t, command.robot, "a command was not finite")))
            elif isinstance(command, GoTo | Drive):
                motions[command.robot] = command
            else:
                passed.append(command)
        return passed + self._motions(t, motions, states)

    def _halt(self, stop: Stop) -> Stop:
        """Note a Stop that leaves."""
        robots = list(self._courses.number) if stop.robot is None else [stop.robot]
        self._courses.stop(self._courses.know(robots), stop.t + self._keep)
        self.stopped = self.stopped or stop.robot is None
        return stop

    def _motions(self, t: float, motions: dict[str, GoTo | Drive], states: Mapping[str, RobotState]) -> list[Command]:
        if self.stopped:
            return []
        stops: list[Command] = []
        drivable: dict[str, GoTo | Drive] = {}
        for robot, motion in motions.items():
            state = states.get(robot)
            if state is None or motion.until <= t or robot in self.waiting:
                continue
            why = unfit(t, state, self.sheet, self.limits)
            if why is None:
                drivable[robot] = motion
            else:
                stops.append(self.hold(t, robot, why))
        return stops + (self._drive(t, drivable, states) if drivable else [])

    def _drive(self, t: float, motions: dict[str, GoTo | Drive], states: Mapping[str, RobotState]) -> list[Command]:
        names = list(states)
        rows = self._courses.know(names)
        self._answers.know(len(self._courses.number))
        crowd = self._crowd(rows, names, motions, states)
        goals, speeds = self._safe(t, rows, crowd)
        moving = np.flatnonzero(crowd.moving)
        until = np.array([min(motions[names[k]].until, t + self.limits.lease_s) for k in moving])
        velocity = goals - crowd.at
        length = np.hypot(velocity[:, 0], velocity[:, 1])
        velocity *= (np.minimum(speeds, TAPER * length) / np.maximum(length, 1e-9))[:, None]
        self._courses.set_out(rows[moving], goals[moving], velocity[moving], t, until, self._keep)
        told = zip(moving.tolist(), goals[moving].tolist(), speeds[moving].tolist(), until.tolist(), strict=True)
        left: list[Command] = []
        for k, (x, y), speed, end in told:
            motion = motions[names[k]]
            heading = motion.heading if isinstance(motion, GoTo) else None
            left.append(GoTo(t, names[k], (x, y), speed, end, heading))
        return left

    def _crowd(
        self,
        rows: NDArray[np.intp],
        names: list[str],
        motions: dict[str, GoTo | Drive],
        states: Mapping[str, RobotState],
    ) -> Crowd:
        at = np.array([states[name].xy for name in names])
        heard = np.array([states[name].t for name in names])
        goal, speed = at.copy(), np.zeros(len(names))
        moving, steady = np.zeros(len(names), dtype=bool), np.ones(len(names), dtype=bool)
        for k, name in enumerate(names):
            motion = motions.get(name)
            if motion is None:
                continue
            moving[k] = True
            if isinstance(motion, GoTo):
                goal[k], speed[k] = motion.xy, min(max(motion.speed, 0.0), self.limits.speed_m_s)
            else:
                steady[k] = False
                wanted = np.array(motion.velocity)
                speed[k] = min(float(np.hypot(*wanted)), self.limits.speed_m_s)
                ahead = speed[k] * self.limits.lease_s + _SHORT * (speed[k] > 0)
                goal[k] = at[k] + wanted * (ahead / max(float(np.hypot(*wanted)), 1e-9))
        low, high = self._bounds
        return Crowd(at, heard, self._courses.velocity[rows], np.clip(goal, low, high), speed, moving, steady)

    def _safe(self, t: float, rows: NDArray[np.intp], crowd: Crowd) -> tuple[Array, Array]:
        """New goals (n, 2) [m] and speeds (n,) [m/s] of the moving robots."""
        ways = self._courses.ways(rows, crowd.at, np.minimum(crowd.heard, t))
        extent = np.hypot(*np.moveaxis(ways - crowd.at[:, None], 2, 0)).max(axis=1)
        extent = np.maximum(extent, self.limits.lead_m * crowd.moving)
        seen = self._avoidance.reach + 2 * self.limits.speed_m_s * HORIZON
        pairs = neighbours(crowd.at, max(seen, self._clear + 2 * float(extent.max())))
        wished, speed = self._wished(t, rows, crowd, pairs)
        gap = crowd.at[pairs[:, 0]] - crowd.at[pairs[:, 1]]
        near = np.hypot(gap[:, 0], gap[:, 1]) < self._clear + extent[pairs[:, 0]] + extent[pairs[:, 1]]
        return crowd.at + self._in_cells(ways, crowd, wished, Pairs(pairs[near, 0], pairs[near, 1])), speed

    def _wished(self, t: float, rows: NDArray[np.intp], crowd: Crowd, pairs: NDArray[np.intp]) -> tuple[Array, Array]:
        """Where to send robots, from their places (n, 2) [m], and at what speed (n,): others avoided, caps kept."""
        step = np.clip(t - self._courses.sent[rows], _SOONEST, _LATEST)
        usual = float(np.median(step[crowd.moving]))
        chosen = self._avoidance.choose(t, rows, crowd, pairs, usual)
        way = crowd.goal - crowd.at
        away = np.hypot(way[:, 0], way[:, 1])
        straight = way * (np.minimum(crowd.speed, away / usual) / np.maximum(away, 1e-9))[:, None]
        change = chosen - crowd.velocity
        size = np.hypot(change[:, 0], change[:, 1])
        most = self.limits.accel_m_s2 * step
        velocity = crowd.velocity + change * np.minimum(1.0, most / np.maximum(size, 1e-9))[:, None]
        # The last bit of a free way is the goal itself: firmware slows down there better than stale states allow to.
        free = np.abs(chosen - straight).max(axis=1) < 1e-6
        lead = self._answers.lead(rows)
        reach = np.minimum(crowd.speed * self.limits.lease_s + _SHORT, lead)
        last = free & ((away <= reach) | (size <= most))
        ahead = way * (np.minimum(away, reach) / np.maximum(away, 1e-9))[:, None]
        further = _lead(velocity, self.limits, lead)
        # Not beyond the goal: what is heard is late, and a robot that is sent past it would turn round it for ever.
        beyond = np.einsum("ni,ni->n", further, way) / np.maximum(away, 1e-9)
        further *= np.where(crowd.steady & (beyond > away), away / np.maximum(beyond, 1e-9), 1.0)[:, None]
        along = np.einsum("ni,ni->n", crowd.velocity, way) / np.maximum(away, 1e-9)
        ramp = np.maximum(along, 0.0) + most
        speed = np.where(last, np.minimum(crowd.speed, ramp), np.hypot(velocity[:, 0], velocity[:, 1]))
        self._answers.learn(rows, np.column_stack([crowd.at, crowd.heard]), speed, last & (away > reach) & crowd.moving)
        return np.where(last[:, None], ahead, further) * crowd.moving[:, None], speed

    def _in_cells(self, ways: Array, crowd: Crowd, wished: Array, close: Pairs) -> Array:
        """The goals, from each place, that are nearest to the wished ones and in each robot's own cell."""
        normals, room = wall_lines(crowd.at, self._bounds)
        if len(close.first):
            normal, ahead, behind = cell_lines(ways, crowd.at, wished, crowd.moving.astype(float), close, self._clear)
            owner = np.concatenate([close.first, close.second])
            order = np.argsort(owner, kind="stable")
            lines = table(
                len(wished),
                owner[order],
                ranks(owner[order], len(wished)),
                np.concatenate([normal, -normal])[order],
                np.concatenate([ahead, behind])[order],
            )
            normals, room = np.concatenate([normals, lines[0]], axis=1), np.concatenate([room, lines[1]], axis=1)
        most = np.full(len(wished), self.limits.lead_m)
        goals, possible = nearest_allowed(wished, normals, room, most)
        # Who is beyond the bounds comes back in; where the others do not leave the way for that, no farther out.
        rest = np.flatnonzero(~possible)
        goals[rest], possible[rest] = nearest_allowed(
            wished[rest], normals[rest], np.maximum(room[rest], 0.0), most[rest]
        )
        return np.where(possible[:, None], goals, 0.0)


def _finite(command: Command) -> bool:
    """Whether all its numbers are finite, also where a behaviour made them of something else than floats."""
    vector = command.xy if isinstance(command, GoTo) else command.velocity if isinstance(command, Drive) else ()
    return is_finite(command) and all(math.isfinite(float(value)) for value in vector)


def _lead(velocity: Array, limits: Limits, most: Array) -> Array:
    """How far ahead (n, 2) [m] the goals for velocities (n, 2) lie: a lease, and what the firmware tapers off."""
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    far = np.minimum(speed * limits.lease_s + _SHORT * np.minimum(speed / limits.speed_m_s, 1.0), most)
    return velocity * (far / np.maximum(speed, 1e-9))[:, None]
