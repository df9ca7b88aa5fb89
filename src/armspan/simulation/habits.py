"""What one person does differently from the geometry of an ideal arm. All default to nothing.

Pairs are (to the left, up) [rad], triples (forward, left, up) [m]. A habit may depend on where one points:
its `Surface` is smooth and bounded, and belongs to the person.
"""

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from armspan.frames import Array
from armspan.records import Vec2, Vec3

Coefficients: TypeAlias = tuple[float, float, float, float, float, float]

_FLAT: Coefficients = (0.0,) * 6
_WIDTH = 0.6
_USUAL_DISTANCE = 2.5


@dataclass(frozen=True, slots=True)
class Surface:
    """A pair of angles [rad] as a function of azimuth, elevation [rad] and distance [m] of the target.

    Quadratic in tanh(angle / 0.6) and linear in the tanh of the logarithm of distance / 2.5 m, so that it
    stays bounded for targets steeply below, where nobody was measured.
    """

    left: Coefficients = _FLAT
    up: Coefficients = _FLAT

    def at(self, azimuth: float, elevation: float, distance: float) -> Array:
        """The pair (2,) [rad]."""
        a, e = np.tanh(azimuth / _WIDTH), np.tanh(elevation / _WIDTH)
        far = np.tanh(np.log(distance / _USUAL_DISTANCE))
        terms = np.array([a, e, a * e, a * a - 0.2, e * e - 0.2, far])
        return np.asarray(np.array([self.left, self.up]) @ terms)


@dataclass(frozen=True, slots=True)
class Aim:
    """Errors of the line dominant eye to fingertip.

    ``repeat`` is the standard deviation between gestures at one target; on the move the error is drawn
    afresh over ``travel`` [rad] of the target's way. With probability ``slip`` a gesture ends somewhere else
    altogether, by an angle between two bounds [rad].
    """

    bias: Vec2 = (0.0, 0.0)
    surface: Surface = field(default_factory=Surface)
    repeat: Vec2 = (0.0, 0.0)
    travel: float = 0.1
    slip: float = 0.0
    slipped: Vec2 = (0.35, 1.4)


@dataclass(frozen=True, slots=True)
class Elbow:
    """How far the line elbow-fingertip deviates from shoulder-fingertip, and how the hand sits.

    ``stretched`` is the bend that remains when the whole arm is asked to be stretched; ``roll`` turns the
    forearm and ``upper_roll`` the upper arm about its own axis [rad], 0 with the palm down.
    """

    bend: Vec2 = (0.0, 0.0)
    surface: Surface = field(default_factory=Surface)
    repeat: Vec2 = (0.0, 0.0)
    stretched: Vec2 = (0.0, 0.0)
    wrist: Vec2 = (0.0, 0.0)
    wrist_repeat: float = 0.0
    roll: float = 0.0
    upper_roll: float = 0.0
    roll_repeat: float = 0.0


@dataclass(frozen=True, slots=True)
class Trunk:
    """What shoulder and head do while the arm points.

    The trunk turns by ``turn`` [rad, to the left] plus ``turn_gain`` times the target's azimuth and the
    shoulder comes along; the shoulder blade moves it by ``shift`` more, rises by ``rise`` [m/rad] with the
    target, and by chance with ``shift_repeat``. The head turns by ``head_gain`` (sideways, up) of the
    target's direction about a neck that lies ``eyes_from_neck`` (behind, below) the eyes [m].
    """

    turn: float = 0.0
    turn_gain: float = 0.0
    shift: Vec3 = (0.0, 0.0, 0.0)
    shift_repeat: Vec3 = (0.0, 0.0, 0.0)
    rise: float = 0.0
    head_gain: Vec2 = (0.0, 0.0)
    eyes_from_neck: Vec2 = (0.09, 0.04)


@dataclass(frozen=True, slots=True)
class SetUp:
    """Standard deviations [rad] of the poses asked for during set-up: level, straight ahead, hanging.

    ``hang_bend`` is how far the forearm of the hanging arm comes forward [rad].
    """

    level: float = 0.0
    heading: float = 0.0
    hang: float = 0.0
    hang_bend: float = 0.0


@dataclass(frozen=True, slots=True)
class Feedback:
    """How the person follows and corrects.

    ``lag`` [s] behind a moving target; ``gain`` of one correction, whose error is ``noise`` of its size plus
    ``floor`` [rad]; an offset below ``tolerance`` [rad] is left alone.
    """

    lag: float = 0.15
    gain: float = 1.0
    noise: float = 0.0
    floor: float = 0.0
    tolerance: float = 0.0


@dataclass(frozen=True, slots=True)
class Steadiness:
    """Standard deviations of what moves by itself.

    ``hold``: the held aim (sideways, up) [rad]; ``elbow``: its bend [rad]; ``tremor`` at 8 to 11 Hz [rad];
    ``sway``: of the whole body (forward, left, up) [m].
    """

    hold: Vec2 = (0.0, 0.0)
    elbow: float = 0.0
    tremor: float = 0.0
    sway: Vec3 = (0.0, 0.0, 0.0)
