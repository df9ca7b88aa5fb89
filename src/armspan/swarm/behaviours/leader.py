"""Leader: one robot leads, the others keep their places beside it."""

from collections.abc import Mapping

import numpy as np

from armspan.errors import ConfigError, known_names
from armspan.frames import Array
from armspan.records import RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import Pace, Slots, Wish, check_room, glided, places, spaced, spot, wishes


class Leader:
    """The ``leader``, or else the first robot by name, goes to the pointed spot, and the others go with it.

    Each follower keeps the offset from the leader that it had when both were first seen; at the sheet's edge, and
    where two would come too near, it stands as near to that as there is room. Without a spot the leader is left to
    rest, or to be pushed by hand, and is followed all the same. While the leader is not there, the followers hold.

    Raises:
        ConfigError: for a leader that is none of the robots, and where not so many robots fit.

    """

    done = False

    def __init__(self, stage: Stage, states: Mapping[str, RobotState], *, leader: str | None = None) -> None:
        check_room(len(states), stage)
        if leader is not None and leader not in states:
            raise ConfigError(known_names("leader", leader, states))
        self._stage = stage
        self._leader = min(states, default=None) if leader is None else leader
        self._offsets: dict[str, Array] = {}
        self._slots: dict[str, Array] = {}
        self._pace = Pace()
        self._holding = self._hold()

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[Wish]:
        """The wish of each follower for its place, of the leader for a place on its way to the spot."""
        elapsed = self._pace.elapsed(t)
        if self._leader is None or self._leader not in states:
            return self._holding.step(t, states)
        self._holding = self._hold()
        names, here = places(states)
        first, target = names.index(self._leader), spot(pointed)
        for name, xy in zip(names, here, strict=True):
            self._offsets.setdefault(name, xy - here[first])
        wanted = self._ahead(here[first], target) + np.array([self._offsets[name] for name in names])
        slots = self._eased(names, first, wanted, 2 * self._stage.limits.speed_m_s * elapsed)
        found = wishes(t, self._stage, names, slots)
        return found if target is not None else found[:first] + found[first + 1 :]

    def _ahead(self, leader: Array, target: Array | None) -> Array:
        """Where the leader will be soon: followers that looked where it is now would always be late."""
        low, high = self._stage.bounds
        if target is None:
            return np.clip(leader, low, high)
        return np.clip(glided(leader, np.clip(target, low, high), 2 * self._stage.limits.lead_m), low, high)

    def _eased(self, names: list[str], first: int, wanted: Array, reach: float) -> Array:
        """Slots (n, 2) apart, each at most ``reach`` on from the last one: where there is little room, none jumps."""
        eased = [glided(self._slots.get(name, place), place, reach) for name, place in zip(names, wanted, strict=True)]
        eased[first] = wanted[first]
        slots = spaced(np.array(eased), self._stage, first)
        self._slots.update(zip(names, slots, strict=True))
        return slots

    def _hold(self) -> Slots:
        return Slots(self._stage, lambda here: spaced(here, self._stage))
