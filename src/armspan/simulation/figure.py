"""From a posture's directions to the places of eyes, shoulder, elbow, wrist and fingertip in the room."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armspan.frames import Array, yaw_rotation
from armspan.records import Vec2
from armspan.simulation.anatomy import Person, sideways
from armspan.simulation.arm import unit

# The rows of a posture (20, m), all written in the person's own frame: five directions, of which the last
# two only roughly tell where the back of the hand and the outside of the upper arm's band face; the head's
# turn (left, up) [rad]; the shoulder's shift [m].
UPPER, FOREARM, HAND = slice(0, 3), slice(3, 6), slice(6, 9)
BACK, OUTER = slice(9, 12), slice(12, 15)
HEAD, SHIFT = slice(15, 17), slice(17, 20)
ROWS = 20


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a person's joints are at m times: points (m, 3) [m] and rotations (m, 3, 3), in ``room``.

    ``eye`` is the dominant one. Segment frames have x along the segment to the hand; the forearm's z comes
    out of the back of a palm-down hand and y points left, and so for the upper arm of the stretched arm.
    """

    eye_left: Array
    eye_right: Array
    eye: Array
    shoulder: Array
    elbow: Array
    wrist: Array
    fingertip: Array
    room_from_forearm: Array
    room_from_upperarm: Array


class Figure:
    """A person's unmoving sizes, placed in the room with the floor below the dominant eye at ``xy`` [m]."""

    def __init__(self, person: Person, xy: Vec2, facing: float) -> None:
        self.person = person
        self.arm = person.lengths
        self.xyz: Array = np.array([xy[0], xy[1], 0.0])
        self.room_from_user = yaw_rotation(facing)
        self.eye: Array = np.array([0.0, 0.0, person.eye_height])
        ahead, above = person.trunk.eyes_from_neck
        self._ahead, self._above, self._half = ahead, above, person.eyes_apart / 2.0
        self._neck = self.eye - [ahead, sideways(person.dominant_eye) * self._half, above]
        self.shoulder: Array = self.eye - person.shoulder_to_eye

    def eyes(self, head: Array) -> tuple[Array, Array]:
        """Left and right eye (3, m), without sway, of a ``head`` turned (2, m) [rad] to the left and up."""
        turn, nod = head
        c, s = np.cos(turn), np.sin(turn)
        cn, sn = np.cos(nod), np.sin(nod)
        ahead, above = self._ahead * cn - self._above * sn, self._ahead * sn + self._above * cn
        middle = self._neck[:, None] + np.array([ahead * c, ahead * s, above])
        half = self._half * np.array([-s, c, 0.0 * s])
        return middle + half, middle - half

    def dominant_eye(self, head: Array) -> Array:
        """The eye (3, m) that aims."""
        left, right = self.eyes(head)
        return left if self.person.dominant_eye == "left" else right

    def offset_user(self, offset: ArrayLike) -> Array:
        """An offset (3,) [m] of the room in the person's own frame."""
        return np.asarray(self.room_from_user.T @ np.asarray(offset, dtype=float))

    def place_user(self, place: ArrayLike) -> Array:
        """A place (3,) [m] of the room in the person's own frame."""
        return self.offset_user(np.asarray(place, dtype=float) - self.xyz)

    def pose(self, posture: Array, sway: Array) -> Pose:
        """The joints in the room of a ``posture`` (20, m), the whole body shifted by ``sway`` (3, m) [m]."""
        upper, forearm, hand = unit(posture[: HAND.stop].reshape(3, 3, -1))
        left, right = self.eyes(posture[HEAD])
        shoulder = self.shoulder[:, None] + posture[SHIFT]
        elbow = shoulder + self.arm.upper * upper
        wrist = elbow + self.arm.forearm * forearm
        joints = np.array([left, right, shoulder, elbow, wrist, wrist + self.arm.hand * hand]) + sway
        room = (self.room_from_user @ joints).transpose(0, 2, 1) + self.xyz
        along = np.array([forearm, upper])
        axes = self.room_from_user @ _axes(along, np.array([posture[BACK], posture[OUTER]]))
        frames = axes.transpose(1, 3, 2, 0)  # (axis, segment, component, m) with the axes as columns
        dominant = room[0] if self.person.dominant_eye == "left" else room[1]
        return Pose(room[0], room[1], dominant, *room[2:], *frames)


def _axes(along: Array, hint: Array) -> Array:
    """Right-handed axes (3, n, 3, m): x ``along`` (n, 3, m), z as near to ``hint`` as can be."""
    z = hint - (hint * along).sum(axis=1, keepdims=True) * along
    z = z / np.sqrt((z * z).sum(axis=1, keepdims=True))
    (x0, x1, x2), (z0, z1, z2) = along.swapaxes(0, 1), z.swapaxes(0, 1)
    y = np.array([z1 * x2 - z2 * x1, z2 * x0 - z0 * x2, z0 * x1 - z1 * x0]).swapaxes(0, 1)
    return np.array([along, y, z])
