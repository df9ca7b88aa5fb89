"""The last filter before ``swarm.send``: nothing that moves a robot bypasses it.

Motion leaves as a position goal at most ``lead_m`` ahead of the robot, so that a robot whose process or link
dies comes to rest by itself: Cellulo's firmware keeps its last velocity for ever, but stops at a goal. A Stop
for all is latched: after it no motion leaves until an explicit resume.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from armspan.frames import Array
from armspan.records import Command, Drive, GoTo, RobotState, Sheet, Stop, is_finite
from armspan.swarm.limits import Limits

_STALE = 0.5
"""Age [s] of a robot's last state beyond which it is not driven: a lead is measured from where it is."""


@dataclass(slots=True)
class SafetyFilter:
    """Lets through what is safe, made safe where it can be: caps, bounds, gaps, leases, the latch."""

    limits: Limits
    sheet: Sheet
    stopped: bool = False

    def resume(self) -> None:
        """Take the latch off; robots still wait for a new command."""
        self.stopped = False

    def admit(self, command: Command, states: Mapping[str, RobotState]) -> Command | None:
        """The command as it may leave at its time, a Stop in its place, or None when nothing needs to."""
        if isinstance(command, Stop):
            self.stopped = self.stopped or command.robot is None
            return command
        if not is_finite(command):
            return Stop(command.t, command.robot, "a command was not finite")
        if isinstance(command, GoTo | Drive):
            return self._motion(command, states)
        return command

    def _motion(self, command: GoTo | Drive, states: Mapping[str, RobotState]) -> Command | None:
        state = states.get(command.robot)
        if self.stopped or state is None or command.until <= command.t:
            return None
        if command.t - state.t > _STALE:
            return Stop(command.t, command.robot, f"nothing heard of {command.robot} for {_STALE} s")
        if state.held:
            return Stop(command.t, command.robot, f"{command.robot} is off the sheet")
        here = np.array(state.xy)
        speed, goal = self._wanted(command, here)
        goal = self._within_bounds(here + _shortened(goal - here, self.limits.lead_m))
        others = np.array([s.xy for name, s in states.items() if name != command.robot]).reshape(-1, 2)
        goal = here + (goal - here) * self._free_share(here, goal, others)
        until = min(command.until, command.t + self.limits.lease_s)
        heading = command.heading if isinstance(command, GoTo) else None
        return GoTo(command.t, command.robot, (float(goal[0]), float(goal[1])), speed, until, heading)

    def _wanted(self, command: GoTo | Drive, here: Array) -> tuple[float, Array]:
        if isinstance(command, GoTo):
            return float(np.clip(command.speed, 0.0, self.limits.speed_m_s)), np.array(command.xy)
        velocity = _shortened(np.array(command.velocity), self.limits.speed_m_s)
        return float(np.linalg.norm(velocity)), here + velocity * self.limits.lease_s

    def _within_bounds(self, goal: Array) -> Array:
        margin = self.limits.body_radius_m
        most = np.array([self.sheet.width_m - margin, self.sheet.height_m - margin])
        return np.clip(goal, np.minimum(margin, most), most)

    def _free_share(self, here: Array, goal: Array, others: Array) -> float:
        """The largest share of the way to the goal on which every gap is kept, or does not shrink."""
        if len(others) == 0:
            return 1.0
        gap = 2 * self.limits.body_radius_m + self.limits.gap_m
        way, away = goal - here, here - others
        a = float(way @ way)
        if a < 1e-12:
            return 1.0
        b = away @ way
        c = np.sum(away * away, axis=1) - gap**2
        blocked = b < 0  # only what is ahead can come nearer
        root = b * b - a * c
        share = np.where(blocked & (root > 0), (-b - np.sqrt(np.maximum(root, 0.0))) / a, np.inf)
        share = np.where(blocked & (c <= 0), 0.0, share)
        return float(np.clip(share.min(), 0.0, 1.0))


def _shortened(vector: Array, most: float) -> Array:
    length = float(np.linalg.norm(vector))
    return vector if length <= most else vector * (most / length)
