"""Single robots sent to places, round the others: a step of the way at each refresh."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from armspan.frames import Array
from armspan.records import GoTo, RobotState, Vec2
from armspan.swarm.limits import Limits

REFRESH = 0.1
"""Seconds between two commands for a robot under way; a third of a lease."""

ARRIVED = 0.006
"""Distance [m] at which a robot has arrived: Cellulo stops up to 2.5 mm short on each axis."""

_TURNS = np.radians([0, 20, -20, 40, -40, 60, -60, 80, -80, 100, -100, 120, -120])
_LOOK = 0.12


@dataclass(slots=True)
class Errands:
    """Where robots have been sent, and the commands that bring them there."""

    limits: Limits
    goals: dict[str, Vec2] = field(default_factory=dict)
    _sent: dict[str, float] = field(default_factory=dict)

    def send(self, robot: str, xy: Vec2) -> None:
        """Send a robot to a place [m] in ``sheet``."""
        self.goals[robot] = xy
        self._sent.pop(robot, None)

    def cancel(self) -> None:
        """Forget all errands."""
        self.goals.clear()

    def arrived(self, robot: str, states: Mapping[str, RobotState]) -> bool:
        """Whether a robot is where it was sent."""
        goal, state = self.goals.get(robot), states.get(robot)
        return goal is None or (state is not None and _distance(state.xy, goal) < ARRIVED)

    def step(self, t: float, states: Mapping[str, RobotState]) -> list[GoTo]:
        """The commands due at ``t`` [s]: one for each robot under way, ten a second."""
        commands: list[GoTo] = []
        for robot, goal in list(self.goals.items()):
            state = states.get(robot)
            if state is None or t - self._sent.get(robot, -np.inf) < REFRESH - 1e-6:
                continue
            self._sent[robot] = t
            if _distance(state.xy, goal) < ARRIVED:
                del self.goals[robot]  # it rests at its last goal by itself
                continue
            step = self._step_toward(state, goal, states)
            commands.append(GoTo(t, robot, step, self.limits.speed_m_s, t + self.limits.lease_s))
        return commands

    def _step_toward(self, state: RobotState, goal: Vec2, states: Mapping[str, RobotState]) -> Vec2:
        """A point within the lead toward the goal, on the least detour that keeps clear of the others."""
        here, way = np.array(state.xy), np.array(goal) - np.array(state.xy)
        others = np.array([s.xy for s in states.values() if s.robot != state.robot]).reshape(-1, 2)
        reach = float(np.linalg.norm(way))
        clear = 2 * self.limits.body_radius_m + 2 * self.limits.gap_m
        for turn in _TURNS:
            ahead = _turned(way, turn) * min(1.0, _LOOK / reach)
            if _nearest(here, here + ahead, others) >= clear or len(others) == 0:
                way = _turned(way, turn)
                break
        step = here + way * min(1.0, self.limits.lead_m / reach)
        return float(step[0]), float(step[1])


def _turned(vector: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def _nearest(start: Array, end: Array, others: Array) -> float:
    """Least distance [m] of the others (n, 2) to a segment, not counting those it moves away from."""
    way = end - start
    share = np.clip((others - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    gaps = np.linalg.norm(start + share[:, None] * way - others, axis=1)
    leaving = ((others - start) @ way) <= 0
    return float(np.min(np.where(leaving, np.inf, gaps), initial=np.inf))


def _distance(a: Vec2, b: Vec2) -> float:
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))
