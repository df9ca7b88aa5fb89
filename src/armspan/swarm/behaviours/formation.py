"""Go to a place in formation: everybody moves by the same way."""

from collections.abc import Mapping

from armspan.frames import Array
from armspan.records import RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import Slots, Wish, check_room, placed, spaced, spot


class FormationAt:
    """The robots' present shape, its centroid brought to the spot that is pointed at when it begins.

    Robots that stand too close together are set apart first; near an edge the shape is shifted on to the sheet.
    Without a spot nothing moves and it is done at once.

    Raises:
        ConfigError: where not so many robots fit.

    """

    def __init__(self, stage: Stage, states: Mapping[str, RobotState]) -> None:
        check_room(len(states), stage)
        self._stage = stage
        self._begun = False
        self._centre: Array | None = None
        self._slots = Slots(stage, self._plan)

    @property
    def done(self) -> bool:
        """Whether all robots are in their slots, or there never was a place to go to."""
        return self._slots.done or (self._begun and self._centre is None)

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[Wish]:
        """The wish of each robot for its slot."""
        if not self._begun and states:
            self._begun, self._centre = True, spot(pointed)
        return [] if self._centre is None else self._slots.step(t, states)

    def _plan(self, here: Array) -> Array:
        apart = spaced(here, self._stage)
        return apart if self._centre is None else placed(apart - apart.mean(axis=0), self._centre, self._stage.bounds)
