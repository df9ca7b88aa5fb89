"""What is asked of people, real or virtual: gestures at places of a sheet, and arms that follow a moving robot."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from armspan.frames import Array
from armspan.records import Body

Rows: TypeAlias = NDArray[np.intp]
"""Numbers of rows."""


@dataclass(frozen=True, slots=True, eq=False)
class Gestures:
    """One person's gestures at nine places, three by three, that two bands saw.

    ``forearm`` and ``upperarm`` (n, 3, 3) have x along the limb to the hand; ``targets`` (n, 3) [m] are in axes that
    are z up, x to the front, with the origin on the floor below the eyes; ``places`` (n,) numbers each gesture's
    place row by row: 0, 2, 6 and 8 are the corners, 4 is the middle.
    """

    body: Body
    forearm: Array
    upperarm: Array
    targets: Array
    places: Rows


@dataclass(frozen=True, slots=True, eq=False)
class Following:
    """An arm that follows a moving robot.

    ``times`` (n,) [s]; ``forearm`` (n, 3, 3) with x along it; ``points`` (n, 3) [m] where the robot was and ``head``
    (n, 3) [m] where the person's head was, in one frame with z up.
    """

    body: Body
    times: Array
    forearm: Array
    points: Array
    head: Array


@dataclass(frozen=True, slots=True)
class Recordings:
    """The real people: who ``pointed`` at places that stood still, and who ``followed`` a robot."""

    pointed: tuple[Gestures, ...]
    followed: tuple[Following, ...]


def limb(start: Array, end: Array) -> Array:
    """Attitudes (n, 3, 3) of limbs from ``start`` to ``end`` (n, 3): x along the limb, y level."""
    x = end - start
    y = np.cross([0.0, 0.0, 1.0], x)
    z = np.cross(x, y)
    axes = np.stack([x, y, z], axis=-1)
    return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))


def numbered_places(targets: Array) -> Rows:
    """The numbers (n,) of nine places that targets (n, 3) [m] take, by rising x and then y."""
    _, numbers = np.unique(targets[:, :2].round(3), axis=0, return_inverse=True)
    return np.asarray(numbers.reshape(-1), dtype=np.intp)
