"""What every behaviour of the swarm is: a state machine without a clock, from states to wishes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from armspan.frames import Array
from armspan.records import Drive, GoTo, RobotState, Sheet, Vec2, Zone
from armspan.swarm.limits import Limits


@dataclass(frozen=True, slots=True)
class Stage:
    """Where a behaviour plays: what it may know besides the robots' states.

    ``zones`` lie on the ``sheet``; ``user`` is where the user stands in ``sheet`` [m], off the paper as a rule, None
    before the set-up. ``rng`` is the behaviour's own dice.
    """

    sheet: Sheet
    limits: Limits
    rng: np.random.Generator
    zones: tuple[Zone, ...] = ()
    user: Vec2 | None = None

    @property
    def margin(self) -> float:
        """How far inside the sheet's edge a robot's centre stays [m]."""
        return self.limits.body_radius_m

    @property
    def spacing(self) -> float:
        """The least distance between two robots' centres [m] at which neither needs to give way to the other."""
        return self.limits.spacing_m

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The lowest and the highest place (2,) [m] for a robot's centre; its middle where the sheet is too small."""
        size = np.array([self.sheet.width_m, self.sheet.height_m])
        return np.minimum(self.margin, size / 2), np.maximum(size - self.margin, size / 2)


class Behaviour(Protocol):
    """What several robots do together.

    Made by ``Behaviour(stage, states)`` with the robots that take part. Whoever runs it calls ``step`` at every tick
    with those of them that can drive now (heard of, on the sheet, not stopped): robots come and go between two calls.
    """

    @property
    def done(self) -> bool:
        """Whether there is nothing left to do; robots that arrived still hold their places while it goes on."""

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[GoTo | Drive]:
        """The wish of each robot at ``t`` [s]: at most one each, with a lease of ``stage.limits.lease_s``.

        ``pointed`` [m] is the spot in ``sheet`` where the user points now, None without one. Wishes are where to go in
        the end: gaps between moving robots, ways round others, caps and leads are the last filter's. A robot that is
        to stay where it is wishes for its place (it then gives way and comes back); one without a wish is left to
        rest, and the others must go round it.
        """
