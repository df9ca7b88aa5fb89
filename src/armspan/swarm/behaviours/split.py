"""Split and merge: two groups, and one again."""

from collections.abc import Mapping

import numpy as np

from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import RobotState, Vec2
from armspan.swarm.behaviours.gather import Gather
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import Box, Slots, Wish, check_room, fits, gathered, matched, pitch


def split(stage: Stage, states: Mapping[str, RobotState]) -> Slots:
    """Two groups, each in the middle of its half of the sheet along its longer side.

    Each robot goes with the half that it is nearer to, unless it takes another one's slot; of an odd number the one in
    the middle goes to the left, or to the top. Between the groups stays the room of a robot where there is room.

    Raises:
        ConfigError: where not so many robots fit.

    """
    axis = 0 if stage.sheet.width_m >= stage.sheet.height_m else 1
    halves = _halves((len(states) + 1) // 2, stage, axis)

    def plan(here: Array) -> Array:
        order = np.argsort(here[:, axis], kind="stable")
        slots = np.empty_like(here)
        for group, half in zip(np.array_split(order, 2), halves, strict=True):  # the first is the larger
            slots[group] = matched(here[group], gathered(len(group), stage, (half[0] + half[1]) / 2, half))
        return slots

    return Slots(stage, plan, swap=True)


class Merge:
    """All together round their centroid, wherever the arms that say so point.

    Raises:
        ConfigError: where not so many robots fit.

    """

    def __init__(self, stage: Stage, states: Mapping[str, RobotState]) -> None:
        self._gather = Gather(stage, states)

    @property
    def done(self) -> bool:
        """Whether all robots are in their slots."""
        return self._gather.done

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[Wish]:
        """The wish of each robot for its slot."""
        return self._gather.step(t, states, None)


def _halves(n: int, stage: Stage, axis: int) -> tuple[Box, Box]:
    """The two parts of the sheet along ``axis`` for ``n`` robots each, twice the pitch apart or once where it is full.

    Raises:
        ConfigError: where a part has no room for ``n``.

    """
    low, high = stage.bounds
    middle, apart = (low[axis] + high[axis]) / 2, pitch(stage)
    for share in (1.0, 0.5):
        first, second = high.copy(), low.copy()
        first[axis], second[axis] = middle - share * apart, middle + share * apart
        if np.all(first >= low) and (share == 0.5 or fits(n, stage, (low, first))):
            check_room(n, stage, (low, first))
            return (low, first), (second, high)
    sheet = f"{stage.sheet.width_m:g} × {stage.sheet.height_m:g} m"
    raise ConfigError(f"a sheet of {sheet} has no room for two groups: try a larger sheet or a smaller limits.gap_m")
