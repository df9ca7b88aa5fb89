"""The red dot as the person sees it, and how the arm is turned to bring it where it is wanted.

Nothing but the dot is used: who sees it 10 degrees too far to the left of the shoulder turns the arm 10 degrees to the
right, as well as a person can (`Feedback`). And who has turned the arm like this before takes most of it along to the
next reach, since the dot lies beside the line of sight in the same way everywhere.
"""

from collections import deque

import numpy as np

from armspan.frames import Array

EYE_DELAY = 0.2
"""Seconds from a light to the hand's answer."""

JUST = 1e-9  # [s] so that rounding does not make anybody see later

FARTHEST_M = 4.0
"""How far away [m] there is something for a beam to fall on."""

TAKEN_ALONG = 0.7
"""Share of the turns that the last gesture needed with which the next one begins (assumed)."""


class Dot:
    """What a person knows of the dot: ``look`` at it, ``shifted`` the aim of a new gesture, ``missed`` by how much."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Array, Array]] = deque()
        self._turned: Array = np.zeros(3)
        self._began: Array = np.zeros(3)

    def look(self, t: float, origin: Array, direction: Array) -> None:
        """The beam (3,), (3,) in ``room`` at ``t`` [s]; its dot is known to the hand `EYE_DELAY` later."""
        self._seen.append((t, origin, direction))
        while len(self._seen) > 1 and self._seen[1][0] <= t - EYE_DELAY + JUST:
            self._seen.popleft()

    def begin(self) -> None:
        """A new gesture begins, with what was learnt in the one before."""
        self._began = TAKEN_ALONG * self._turned
        self._turned = self._began

    def shifted(self, eye: Array, target: Array) -> Array:
        """Where to aim (3,) [m] from an ``eye`` so that the dot comes near a ``target`` (3,), all in ``room``."""
        return np.asarray(target + np.cross(self._began, target - eye))

    def beside(self, eye: Array, shoulder: Array, target: Array) -> Array:
        """How far (3,) [m] beside its ``target`` the aim of an ``eye`` seems to lie, going by where the dot was.

        The arm turns about the ``shoulder``. A beam that goes over everything is seen far away.
        """
        _, origin, direction = self._seen[0]
        fall = (target[2] - origin[2]) / direction[2] if direction[2] < 0.0 else np.inf
        dot = origin + min(fall, FARTHEST_M) * direction - shoulder
        wanted = target - shoulder
        turn = np.cross(wanted, dot) / (np.linalg.norm(wanted) * np.linalg.norm(dot))
        return np.asarray(np.cross(turn, target - eye))

    def turn(self, eye: Array, target: Array, step: Array) -> None:
        """Remember that the aim at a ``target`` was moved by about ``step`` (3,) [m]."""
        sight = target - eye
        self._turned = self._turned + np.cross(sight, step) / (sight @ sight)
