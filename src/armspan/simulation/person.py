"""A virtual person who points, holds, follows and corrects: the truth that the estimators must find.

The frame is ``room``: z up, metres. Inside, everything is computed in the person's own frame, whose origin
is the floor straight below the dominant eye of the upright person, x to the front, y left, z up.
"""

import numpy as np
from numpy.typing import ArrayLike

from armspan.errors import DataError
from armspan.frames import Array
from armspan.records import Vec2
from armspan.simulation.aiming import Aiming
from armspan.simulation.anatomy import Person, measured_body, sideways
from armspan.simulation.arm import tangents
from armspan.simulation.figure import Figure, Pose
from armspan.simulation.population import draw_person
from armspan.simulation.posture import (
    AIM,
    INTENT,
    SWAY,
    Held,
    Pointing,
    hanging_arm,
    resting_arm,
    stretched_arm,
    wavering,
)
from armspan.simulation.staging import Posture, Staging

__all__ = ["Person", "Pose", "VirtualPerson", "draw_person", "measured_body"]

MEMORY = 1.0
"""How long [s] before the last plan a pose can still be asked for."""

_REACTION = (0.25, 0.5)
_SUBMOVEMENT = 0.3
_SEEING = 0.2

# What is left of an arm's waver when no muscle holds it up, and when the hand is supported besides.
_HANGING, _RESTING = 0.3, 0.1


class VirtualPerson:
    """One person in the room, to be told in order of time what to do.

    ``xy`` [m] is the floor below the dominant eye of the upright person, ``facing`` [rad] the yaw of the
    front. The arm hangs until told otherwise. Everything random comes from ``rng``: the same calls give the
    same movements, and `pose` draws nothing. What is told twice in a moment is done one after the other.

    Raises:
        DataError: when told something, or asked for a pose, too long after the fact.

    """

    def __init__(self, person: Person, xy: Vec2, facing: float, rng: np.random.Generator, start: float = 0.0) -> None:
        self.person = person
        self._figure = Figure(person, xy, facing)
        self._rng = rng
        self._waver = wavering(person.steadiness, rng)
        self._staging = Staging(self._hanging(), self._waver, start)
        self._aiming: Aiming | None = None
        self._planned, self._since, self._corrected = start, -np.inf, -np.inf

    def stretch(self, t: float) -> None:
        """Stretch the arm level to the front, palm down, as well as a person can."""
        self._plan(t)
        setup, elbow = self.person.setup, self.person.elbow
        heading, level, roll = self._rng.standard_normal(3) * [setup.heading, setup.level, elbow.roll_repeat]
        straight = np.array(elbow.stretched) * (1.0 + 0.3 * self._rng.standard_normal(2))
        self._begin(t, Held(stretched_arm(self._figure.arm, (heading, level), straight, roll)))

    def hang(self, t: float) -> None:
        """Let the arm hang beside the body."""
        self._plan(t)
        self._begin(t, self._hanging())

    def rest(self, t: float) -> None:
        """Rest the hand before the belly."""
        self._plan(t)
        errors = self.person.setup.hang * self._rng.standard_normal(6)
        self._begin(t, Held(resting_arm(errors, sideways(self.person.arm)), _RESTING))

    def point(self, t: float, target: ArrayLike) -> None:
        """Point at ``target`` (3,) [m] after the time to react, and hold."""
        self._plan(t)
        self._aiming = Aiming(self._figure, self._figure.place_user(target), self._rng)
        self._begin(t, Pointing(self._figure, self._aiming.intent))

    def track(self, t: float, target: ArrayLike) -> None:
        """Follow the target, which moved a little, to (3,) [m]; the aim comes after with the person's lag."""
        pointing = self._staging.posture
        if self._aiming is None or not isinstance(pointing, Pointing):
            self.point(t, target)
            return
        self._plan(t)
        step = self._aiming.follow(self._figure.place_user(target))
        # A minimum-jerk step is half done at half its time: so the aim is late by the lag.
        pointing.intent.move(step, t, 2.0 * self.person.feedback.lag)

    def correct(self, t: float, offset: ArrayLike) -> bool:
        """Shift the aim, from ``t`` on, against a cursor seen ``offset`` (3,) [m] beside the target; was it done?

        ``t`` is when the eye has told the hand, about 0.2 s after the cursor was there. Whoever is still
        reaching, or has not yet seen what the last correction did, or finds the offset small, does nothing.
        """
        pointing, settled = self._staging.posture, self._staging.end + _SEEING
        if not isinstance(pointing, Pointing) or t < max(settled, self._corrected + _SUBMOVEMENT + _SEEING):
            return False
        self._plan(t)
        step = self._correction(pointing.intent.goal[AIM], self._figure.offset_user(offset))
        if step is None:
            return False
        self._corrected = t
        pointing.intent.move(np.concatenate([step, np.zeros(INTENT - 3)]), t, _SUBMOVEMENT)
        return True

    def pose(self, times: ArrayLike) -> Pose:
        """All joints in the room at ``times`` (m,) [s], twice continuously differentiable in time."""
        at = self._kept(times)
        waver = self._waver.at(at)
        return self._figure.pose(self._staging.at(at, waver), waver[SWAY])

    def _kept(self, times: ArrayLike) -> Array:
        at = np.asarray(times, dtype=float)
        if at.min() < self._since:
            raise DataError(
                f"pose at {at.min():.3f} s: the person's plan is kept from {self._since:.3f} s on, "
                f"{MEMORY:g} s before what was told last; ask for poses in order of time"
            )
        return at

    def _plan(self, t: float) -> None:
        if t < self._planned:
            raise DataError(f"the person is told something at {t:g} s, but was told at {self._planned:g} s before")
        self._planned, self._since = t, max(self._since, t - MEMORY)
        for posture in self._staging.forget(self._since):
            if isinstance(posture, Pointing):
                posture.intent.forget(self._since)

    def _begin(self, t: float, posture: Posture) -> None:
        self._staging.begin(t, posture, t + float(self._rng.uniform(*_REACTION)))

    def _hanging(self) -> Held:
        setup = self.person.setup
        tilt = setup.hang * self._rng.standard_normal(2)
        return Held(hanging_arm(tilt, setup.hang_bend, sideways(self.person.arm)), _HANGING)

    def _correction(self, aim: Array, offset: Array) -> Array | None:
        feedback, sight = self.person.feedback, aim - self._figure.eye
        distance = float(np.linalg.norm(sight))
        sight = sight / distance
        angle = float(np.linalg.norm(offset - (offset @ sight) * sight)) / distance
        if angle < feedback.tolerance:
            return None
        left, above = tangents(sight[:, None])
        scatter = (feedback.floor + feedback.noise * angle) * distance * self._rng.standard_normal(2)
        return np.asarray(-feedback.gain * offset + scatter[0] * left[:, 0] + scatter[1] * above[:, 0])
