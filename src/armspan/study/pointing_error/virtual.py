"""Virtual people who do what the real ones did: gestures at nine places, seen by bands that are worn as people do."""

from typing import Literal

import numpy as np

from armspan.frames import Array, yaw_rotation
from armspan.simulation.person import VirtualPerson, draw_person, measured_body
from armspan.study.pointing_error.recordings import Gestures

Posture = Literal["straight", "natural"]

HEADING, MOUNT = float(np.radians(4.0)), float(np.radians(1.0))
"""How far [rad] the front of a set-up is off, common to all bands, and each band besides (assumed)."""

_GESTURE_S, _HELD_S = 3.0, 0.5
"""A gesture takes so long [s] until the arm is still, and the attitude is the middle of the time held."""


def settled(person: VirtualPerson, t: float) -> tuple[Array, Array]:
    """Attitudes (3, 3) of forearm and upper arm [in the room], held from ``t`` [s] on."""
    pose = person.pose(t + np.linspace(0.0, _HELD_S, 5))
    return _middle(pose.room_from_forearm), _middle(pose.room_from_upperarm)


def _middle(attitudes: Array) -> Array:
    left, _, right = np.linalg.svd(attitudes.mean(axis=0))
    return np.asarray(left @ right)


def nine_places(middle: tuple[float, float], pitch: float, height: float) -> Array:
    """Nine places (9, 3) [m] about a ``middle``, ``pitch`` [m] apart, numbered as in `Gestures`."""
    steps = pitch * np.array([-1.0, 0.0, 1.0])
    grid = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2) + middle
    return np.concatenate([grid, np.full((9, 1), height)], axis=1)


def virtual_gestures(rng: np.random.Generator, posture: Posture, places: Array, repeats: int = 5) -> Gestures:
    """A new person who points at nine ``places`` (9, 3) [m], each so many times, in an order of chance."""
    person = draw_person(rng, posture=posture)
    body = measured_body(person, rng)
    someone = VirtualPerson(person, (0.0, 0.0), 0.0, rng)
    heading = HEADING * rng.standard_normal()
    errors = heading + MOUNT * rng.standard_normal(2)
    order = np.concatenate([rng.permutation(9) for _ in range(repeats)])
    forearms, upperarms = [], []
    for number, place in enumerate(order):
        someone.point(number * _GESTURE_S, places[place])
        forearm, upperarm = settled(someone, (number + 1) * _GESTURE_S - _HELD_S)
        forearms.append(yaw_rotation(errors[0]) @ forearm)
        upperarms.append(yaw_rotation(errors[1]) @ upperarm)
    return Gestures(body, np.array(forearms), np.array(upperarms), places[order], order.astype(np.intp))
