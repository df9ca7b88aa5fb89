"""Gather: everybody comes together."""

from collections.abc import Mapping

from armspan.frames import Array
from armspan.records import RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import Slots, Wish, check_room, gathered, matched, spot


class Gather:
    """A ring, of many robots a filled disc, round the spot that is pointed at when it begins.

    Without a spot, round the robots' centroid; near an edge, shifted on to the sheet.

    Raises:
        ConfigError: where not so many robots fit.

    """

    def __init__(self, stage: Stage, states: Mapping[str, RobotState]) -> None:
        check_room(len(states), stage)
        self._stage = stage
        self._centre: Array | None = None
        self._slots = Slots(stage, self._plan, swap=True)

    @property
    def done(self) -> bool:
        """Whether all robots are in their slots."""
        return self._slots.done

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[Wish]:
        """The wish of each robot for its slot."""
        if self._centre is None and states:
            self._centre = spot(pointed)
        return self._slots.step(t, states)

    def _plan(self, here: Array) -> Array:
        if self._centre is None:
            self._centre = here.mean(axis=0)
        return matched(here, gathered(len(here), self._stage, self._centre))
