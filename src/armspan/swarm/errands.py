"""Single robots sent to places, round the others: a step of the way at each refresh."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from armspan.records import GoTo, RobotState, Sheet, Vec2
from armspan.swarm.limits import Limits
from armspan.swarm.paths import next_point

REFRESH = 0.1
"""Seconds between two commands for a robot under way; a third of a lease."""

_LEAST = 0.02  # a corner of the way is aimed past: Cellulo does not drive an axis that is nearer than 2.5 mm
_SPARE = 0.002  # so that the last filter has nothing to hold back

ARRIVED = 0.006
"""Distance [m] at which a robot has arrived: Cellulo stops up to 2.5 mm short on each axis."""


@dataclass(slots=True)
class Errands:
    """Where robots have been sent, and the commands that bring them there."""

    limits: Limits
    sheet: Sheet
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
        """A point within the lead, on the shortest way to the goal that keeps clear of the others."""
        here, limits = np.array(state.xy), self.limits
        others = np.array([s.xy for s in states.values() if s.robot != state.robot]).reshape(-1, 2)
        clear = 2 * limits.body_radius_m + limits.gap_m + _SPARE
        point = next_point(here, np.array(goal), others, self.sheet, limits.body_radius_m, clear)
        if point is None:
            return state.xy  # nowhere to go until somebody moves
        way = point - here
        reach = max(float(np.linalg.norm(way)), 1e-9)
        far = reach if np.array_equal(point, goal) else max(reach, _LEAST)
        step = here + way / reach * min(far, limits.lead_m)
        return float(step[0]), float(step[1])


def _distance(a: Vec2, b: Vec2) -> float:
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))
