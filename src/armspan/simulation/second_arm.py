"""A virtual person with two arms: the second one hangs or does as told, and both perform gestures and everyday life.

What the pointing arm draws by chance is drawn from the same generator, in the same order, as with one arm; all that
is new comes from a generator of its own, so that a second arm changes nothing about a session of pointing.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from armspan.errors import DataError
from armspan.records import Vec2
from armspan.simulation.anatomy import Person, sideways
from armspan.simulation.course import LEFT, RIGHT, Course, Performing
from armspan.simulation.everyday import draw_everyday
from armspan.simulation.figure import Figure, Pose
from armspan.simulation.gesture_styles import GestureStyle, checked_label, draw_style
from armspan.simulation.gestures import Performed, Repertoire
from armspan.simulation.person import VirtualPerson
from armspan.simulation.posture import SWAY, Held, hanging_arm, resting_arm, stretched_arm, wavering
from armspan.simulation.staging import Posture, Staging

_REACTION = (0.25, 0.5)
_ONSETS = 0.08
_HANGING, _RESTING = 0.3, 0.1
_LONGEST = 3600.0


class TwoArmedPerson(VirtualPerson):
    """A `VirtualPerson` with a second arm, for which everything random comes from ``arms_rng``.

    ``style`` is drawn where it is not given. ``performed`` tells the truth about the gestures, in order of time.
    """

    def __init__(
        self,
        person: Person,
        xy: Vec2,
        facing: float,
        rng: np.random.Generator,
        arms_rng: np.random.Generator,
        start: float = 0.0,
        *,
        style: GestureStyle | None = None,
    ) -> None:
        super().__init__(person, xy, facing, rng, start)
        self.style = draw_style(arms_rng) if style is None else style
        self.performed: list[Performed] = []
        self._arms_rng = arms_rng
        self._other = other_side(person)
        self._other_figure = Figure(self._other, xy, facing)
        self._other_waver = wavering(person.steadiness, arms_rng)
        self._other_staging = Staging(self._other_hanging(), self._other_waver, start)
        self._repertoire = Repertoire(self.style, person.lengths, arms_rng)
        self._course = Course(self.style.hang, self.style.noise, arms_rng)
        self._performing = (
            Performing(self._course, self._figure, _number(person)),
            Performing(self._course, self._other_figure, _number(self._other)),
        )

    @property
    def free(self) -> float:
        """From when on [s] no gesture is under way, as far as the person knows now."""
        return self.performed[-1].end if self.performed else -np.inf

    def stretch(self, t: float) -> None:
        """Stretch both arms level to the front, palms down, as well as a person can."""
        super().stretch(t)
        setup, elbow = self.person.setup, self.person.elbow
        heading, level, roll = self._arms_rng.standard_normal(3) * [setup.heading, setup.level, elbow.roll_repeat]
        straight = np.array(elbow.stretched) * [-1.0, 1.0] * (1.0 + 0.3 * self._arms_rng.standard_normal(2))
        self._other_begin(t, Held(stretched_arm(self._figure.arm, (heading, level), straight, roll)))

    def hang(self, t: float) -> None:
        """Let both arms hang beside the body."""
        super().hang(t)
        self._other_begin(t, self._other_hanging())

    def rest(self, t: float) -> None:
        """Rest both hands before the belly."""
        super().rest(t)
        errors = self.person.setup.hang * self._arms_rng.standard_normal(6)
        self._other_begin(t, Held(resting_arm(errors, sideways(self._other.arm)), _RESTING))

    def point(self, t: float, target: ArrayLike) -> None:
        """Point at ``target`` (3,) [m] with the pointing arm; the other hangs."""
        super().point(t, target)
        self._other_begin(t, self._other_hanging())

    def perform(self, t: float, label: str) -> Performed:
        """Make a gesture after the time to react and let the arms hang again; what it was, as planned.

        Whoever is amidst a gesture finishes it first; everyday motion is broken off.

        Raises:
            ConfigError: on a label that is none.

        """
        known = checked_label(label)
        start = self._set_out(t)
        piece, told = self._repertoire.gesture(known, start)
        self._course.add(piece)
        self.performed.append(told)
        return told

    def everyday(self, t: float, seconds: float) -> list[str]:
        """Go about everyday things until ``seconds`` after ``t`` [s]; what they are called.

        Raises:
            DataError: on a time that is not in (0, 3600] s.

        """
        if not 0.0 < seconds <= _LONGEST:
            raise DataError(f"everyday motion for {seconds:g} s: expected above 0 and up to {_LONGEST:g} s")
        start = self._set_out(t)
        pieces = draw_everyday(self.style.hang, start, t + seconds - start, _number(self.person), self._arms_rng)
        for _, piece in pieces:
            self._course.add(piece)
        return [name for name, _ in pieces]

    def relax(self, t: float) -> None:
        """Finish the gesture that is under way; break off everything else and let the arms hang."""
        if t < self.free:
            return
        if self._staging.posture in self._performing:
            self._plan(t)
            self._course.cut(t + float(self._arms_rng.uniform(*_REACTION)))
        else:
            self.hang(t)

    def other_pose(self, times: ArrayLike) -> Pose:
        """As `pose`, with the joints of the other arm."""
        at = self._kept(times)
        waver = self._other_waver.at(at)
        waver[SWAY] = self._waver.at(at)[SWAY]
        return self._other_figure.pose(self._other_staging.at(at, waver), waver[SWAY])

    def _set_out(self, t: float) -> float:
        """When both arms can begin [s], taken from wherever they are to the course."""
        self._plan(t)
        start = max(t + float(self._arms_rng.uniform(*_REACTION)), self.free)
        self._course.cut(start)
        if self._staging.posture not in self._performing:
            first = max(t, self._staging.start)
            self._staging.begin(t, self._performing[0], first)
            self._other_staging.begin(t, self._performing[1], first)
        return start

    def _plan(self, t: float) -> None:
        super()._plan(t)
        self._other_staging.forget(self._since)
        self._course.forget(self._since)

    def _begin(self, t: float, posture: Posture) -> None:
        super()._begin(t, posture)
        self._course.cut(self._staging.start)
        self._interrupt(self._staging.start)

    def _other_begin(self, t: float, posture: Posture) -> None:
        onset = float(self._arms_rng.uniform(-_ONSETS, _ONSETS))
        self._other_staging.begin(t, posture, max(t + 0.1, self._staging.start + onset))

    def _interrupt(self, t: float) -> None:
        """A gesture that is broken off at ``t`` [s] ends then; one that had not begun never was."""
        told = [gesture for gesture in self.performed if gesture.start < t]
        self.performed[:] = [replace(g, end=min(g.end, t), left=min(g.left, t)) for g in told]

    def _other_hanging(self) -> Held:
        setup = self.person.setup
        tilt = setup.hang * self._arms_rng.standard_normal(2)
        return Held(hanging_arm(tilt, setup.hang_bend, sideways(self._other.arm)), _HANGING)


def other_side(person: Person) -> Person:
    """The same person, whose pointing arm is the other one: it sits mirrored about the middle of the eyes."""
    forward, left, up = person.shoulder_to_eye
    mirrored = (forward, left + 2.0 * person.shoulder_offset, up)
    return replace(person, arm="left" if person.arm == "right" else "right", shoulder_to_eye=mirrored)


def _number(person: Person) -> int:
    return LEFT if person.arm == "left" else RIGHT
