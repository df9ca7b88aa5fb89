"""Come: everybody lines up before the user."""

from collections.abc import Mapping

import numpy as np

from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import RobotState
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import Slots, check_room, matched, rows


def come(stage: Stage, states: Mapping[str, RobotState]) -> Slots:
    """A row along the sheet's edge that is nearest to the user, centred before the user; more rows behind it.

    Raises:
        ConfigError: where nobody knows yet where the user stands, and where not so many robots fit.

    """
    if stage.user is None:
        raise ConfigError("where the user stands is not known yet, and robots are to come there: set up first")
    check_room(len(states), stage)
    foot, axis, inward = _edge(np.array(stage.user), *stage.bounds)
    return Slots(stage, lambda here: matched(here, rows(len(here), stage, foot, axis, inward)), swap=True)


def _edge(user: Array, low: Array, high: Array) -> tuple[Array, int, int]:
    """The place (2,) nearest to the user on the edge the user stands at; the axis away from it, and its sign.

    Beyond a corner it is the edge that the user is farther out from; inside the sheet, the nearest.
    """
    outward = np.array([low - user, user - high])  # by side and axis
    side, axis = np.unravel_index(int(np.argmax(outward)), outward.shape)
    foot = np.clip(user, low, high)
    foot[axis] = high[axis] if side else low[axis]
    return foot, int(axis), -1 if side else 1
