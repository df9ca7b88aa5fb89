"""Follow: everybody goes with the spot that is pointed at."""

from collections.abc import Mapping

import numpy as np

from armspan.frames import Array
from armspan.records import RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import (
    Pace,
    Slots,
    Wish,
    check_room,
    glided,
    matched,
    placed,
    places,
    shape,
    spaced,
    spot,
    wishes,
)


class Follow:
    """A ring, of many robots a filled disc, whose centre glides after the pointed spot, at a robot's highest speed.

    It starts from the robots' centroid, so nothing jumps, wherever the spot jumps to. Who has which slot changes only
    when robots come or go. Until there is a spot robots hold their places; when it is lost, their slots.

    Raises:
        ConfigError: where not so many robots fit.

    """

    done = False

    def __init__(self, stage: Stage, states: Mapping[str, RobotState]) -> None:
        check_room(len(states), stage)
        self._stage = stage
        self._waiting = Slots(stage, lambda here: spaced(here, stage))
        self._pace = Pace()
        self._centre: Array | None = None
        self._names: list[str] = []
        self._offsets: Array = np.empty((0, 2))

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[Wish]:
        """The wish of each robot for its slot round the gliding centre."""
        reach = self._stage.limits.speed_m_s * self._pace.elapsed(t)
        names, here = places(states)
        target = spot(pointed)
        if self._centre is None:
            if target is None or not names:
                return self._waiting.step(t, states)
            self._centre = here.mean(axis=0)
        if target is not None:
            self._centre = glided(self._centre, np.clip(target, *self._stage.bounds), reach)
        if names != self._names:
            self._names, self._offsets = names, self._assign(here, self._centre)
        return wishes(t, self._stage, names, placed(self._offsets, self._centre, self._stage.bounds))

    def _assign(self, here: Array, centre: Array) -> Array:
        offsets = shape(len(here), self._stage, self._stage.bounds)
        return matched(here, offsets + centre) - centre
