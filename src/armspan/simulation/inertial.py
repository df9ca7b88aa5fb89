"""What an ideal inertial sensor on a moving arm feels, by the kinematics of a rigid body."""

from dataclasses import dataclass
from typing import Literal, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from armspan.errors import DataError
from armspan.frames import Array
from armspan.simulation.figure import Pose

Segment: TypeAlias = Literal["forearm", "upperarm", "other_forearm", "other_upperarm"]
"""What a band is worn on; the other arm is the one that does not point."""

GRAVITY = 9.80665
_UP: Array = np.array([0.0, 0.0, GRAVITY])
STEP = 0.002
"""Half the span [s] over which the motion is differentiated; so far does a band look ahead."""


class Wearer(Protocol):
    """Whoever has arms."""

    def pose(self, times: ArrayLike) -> Pose:
        """The joints at ``times`` (m,) [s]."""


@runtime_checkable
class TwoArmedWearer(Wearer, Protocol):
    """Whoever has two arms."""

    def other_pose(self, times: ArrayLike) -> Pose:
        """As `pose`, with the joints of the other arm."""


@dataclass(frozen=True, slots=True)
class Motion:
    """A sensor's motion at m times.

    ``force`` (m, 3) is the specific force [m/s²] and ``rate`` (m, 3) the angular rate [rad/s], in
    ``sensor``; ``acceleration`` (m, 3) [m/s²] and ``room_from_sensor`` (m, 3, 3) are told in ``room``.
    """

    force: Array
    rate: Array
    acceleration: Array
    room_from_sensor: Array


def motion(wearer: Wearer, segment: Segment, times: Array, segment_from_sensor: Array, lever: Array) -> Motion:
    """The motion of a sensor that sits ``lever`` (3,) [m] from the segment's far end, in the segment's frame.

    The far end is the wrist or the elbow. Central differences of the sensor's own path, so that centripetal
    and tangential accelerations are in it; the error is of second order in `STEP`.

    Raises:
        DataError: where the segment is of an arm that the wearer does not have.

    """
    m = len(times)
    pose = _worn_by(wearer, segment, np.concatenate([times - STEP, times, times + STEP]))
    forearm = segment.endswith("forearm")
    end = pose.wrist if forearm else pose.elbow
    turns = pose.room_from_forearm if forearm else pose.room_from_upperarm
    place = end + turns @ lever
    acceleration = (place[2 * m :] - 2.0 * place[m : 2 * m] + place[:m]) / STEP**2
    room_from_sensor = turns[m : 2 * m] @ segment_from_sensor
    force = ((acceleration + _UP)[:, None] @ room_from_sensor)[:, 0]
    return Motion(force, _rate(turns[:m], turns[2 * m :]) @ segment_from_sensor, acceleration, room_from_sensor)


def _worn_by(wearer: Wearer, segment: Segment, times: Array) -> Pose:
    if not segment.startswith("other_"):
        return wearer.pose(times)
    if not isinstance(wearer, TwoArmedWearer):
        raise DataError(f"a band on {segment!r} needs a person with two arms: make it a TwoArmedPerson")
    return wearer.other_pose(times)


def _rate(before: Array, after: Array) -> Array:
    """Angular rates (m, 3) [rad/s] in the body, from rotations (m, 3, 3) that are two steps apart."""
    turn = before.swapaxes(-1, -2) @ after
    axis = np.stack(
        [
            turn[:, 2, 1] - turn[:, 1, 2],
            turn[:, 0, 2] - turn[:, 2, 0],
            turn[:, 1, 0] - turn[:, 0, 1],
        ],
        axis=1,
    )
    sine = 0.5 * np.sqrt((axis * axis).sum(axis=1, keepdims=True)) + 1e-30
    return np.asarray(axis * (np.arcsin(np.minimum(sine, 1.0)) / sine / (4.0 * STEP)))
