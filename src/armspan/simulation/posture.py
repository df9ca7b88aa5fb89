"""Postures as functions of time: an arm that is held somewhere, and an arm that points.

A posture is an array (20, m), its rows named in `figure`; it wavers with the person's fluctuations (7, m).
"""

import numpy as np

from armspan.frames import Array
from armspan.records import Vec2
from armspan.simulation.arm import (
    Arm,
    bent_arm,
    chord,
    elbow_to_fingertip,
    fingertip_on_sight,
    tangents,
    turned,
    unit,
)
from armspan.simulation.figure import BACK, FOREARM, HAND, HEAD, OUTER, ROWS, SHIFT, UPPER, Figure
from armspan.simulation.fluctuation import Band, Fluctuation
from armspan.simulation.habits import Steadiness
from armspan.simulation.movement import Movements

# The rows of what wavers by itself (7, m).
SWAY, HOLD, ELBOW = slice(0, 3), slice(3, 5), slice(5, 7)

# The rows of what a pointing person intends (14,): the place aimed at, the elbow's bend, the hand against the
# forearm, the roll of forearm and upper arm, the head's turn, the shoulder's shift.
AIM, BEND, WRIST = slice(0, 3), slice(3, 5), slice(5, 7)
ROLLS, LOOK, DRAWN_IN = slice(7, 9), slice(9, 11), slice(11, 14)
INTENT = 14


def wavering(steadiness: Steadiness, rng: np.random.Generator) -> Fluctuation:
    """What sways and trembles in one person, rows as named above.

    Sway is mostly slower than 0.1 Hz (quiet standing, drifting from foot to foot); a held arm wavers at 0.15
    to 2.5 Hz and trembles at 8 to 11 Hz.
    """
    bands: list[Band] = []
    for row, sd in enumerate(steadiness.sway):
        bands += [Band(row, 0.95 * sd, 0.008, 0.1, 6), Band(row, 0.3 * sd, 0.1, 0.8, 4)]
    for row, sd in enumerate(steadiness.hold, HOLD.start):
        bands += [Band(row, sd, 0.15, 2.5, 7), Band(row, steadiness.tremor, 8.0, 11.0, 2)]
    bands += [Band(row, steadiness.elbow, 0.1, 1.0, 5) for row in range(ELBOW.start, ELBOW.stop)]
    return Fluctuation(bands, ELBOW.stop, rng)


class Held:
    """An arm that is held in one posture (20,), wavering by a ``share`` of what a pointing arm does."""

    def __init__(self, posture: Array, share: float = 1.0) -> None:
        self._posture = posture[:, None]
        # A held arm wavers as a whole. Near the vertical left and above are not told apart by the room.
        self._sideways, self._up = np.zeros(ROWS), np.zeros(ROWS)
        for rows in (UPPER, FOREARM, HAND):
            left, up = _across(posture[rows])
            self._sideways[rows], self._up[rows] = share * left, share * up

    def at(self, times: Array, waver: Array) -> Array:
        """The posture (20, m) at ``times`` (m,) [s]."""
        left, up = waver[HOLD]
        return np.asarray(self._posture + self._sideways[:, None] * left + self._up[:, None] * up)


def _across(direction: Array) -> tuple[Array, Array]:
    steep = abs(direction[2]) > 0.95
    helper = np.array([1.0, 0.0, 0.0]) if steep else np.array([0.0, 0.0, 1.0])
    left = np.cross(helper, direction)
    left /= np.linalg.norm(left)
    return left, np.cross(direction, left)


class Pointing:
    """An arm whose fingertip is kept on the line from the dominant eye to the place aimed at."""

    def __init__(self, figure: Figure, intent: Array) -> None:
        self._figure = figure
        self.intent = Movements(intent)

    def at(self, times: Array, waver: Array) -> Array:
        """The posture (20, m) at ``times`` (m,) [s]."""
        arm, intent, sway = self._figure.arm, self.intent.at(times), waver[SWAY]
        eye = self._figure.dominant_eye(intent[LOOK]) + sway
        shoulder = self._figure.shoulder[:, None] + intent[DRAWN_IN] + sway
        sight = unit(intent[AIM] - eye)
        sight = turned(sight, tangents(sight), waver[HOLD])
        bend, lower = intent[BEND] + waver[ELBOW], elbow_to_fingertip(arm, intent[WRIST])
        reach = chord(arm, bend, lower)
        fingertip = fingertip_on_sight(eye, sight, shoulder, reach)
        segments = bent_arm(arm, (fingertip - shoulder) / reach, bend, intent[WRIST], reach, lower)
        posture = np.empty((ROWS, len(times)))
        posture[UPPER], posture[FOREARM], posture[HAND] = segments.upper, segments.forearm, segments.hand
        posture[BACK], posture[OUTER] = _rolled(segments.left, segments.above, intent[ROLLS])
        posture[HEAD], posture[SHIFT] = intent[LOOK], intent[DRAWN_IN]
        return posture


def _rolled(left: Array, above: Array, rolls: Array) -> Array:
    """What was above (3, m) after right-handed ``rolls`` (n, m) [rad] about the segment: (n, 3, m)."""
    return np.asarray(np.cos(rolls)[:, None] * above - np.sin(rolls)[:, None] * left)


def stretched_arm(arm: Arm, direction: Vec2, bend: Array, roll: float) -> Array:
    """The posture (20,) of an arm that is stretched to the front, palm down.

    ``direction`` is the fingertip's azimuth and elevation [rad] from the shoulder, ``bend`` (2,) [rad] what
    is left of the elbow's bend, ``roll`` [rad] the forearm's.
    """
    azimuth, elevation = direction
    level = np.cos(elevation)
    to_tip = np.array([[np.cos(azimuth) * level], [np.sin(azimuth) * level], [np.sin(elevation)]])
    straight, bend = np.zeros((2, 1)), bend[:, None]
    lower = elbow_to_fingertip(arm, straight)
    segments = bent_arm(arm, to_tip, bend, straight, chord(arm, bend, lower), lower)
    (back,) = _rolled(segments.left, segments.above, np.array([[roll]]))
    parts = [segments.upper, segments.forearm, segments.hand, back, segments.above, np.zeros((5, 1))]
    return np.concatenate(parts)[:, 0]


def hanging_arm(tilt: Array, bend: float, side: float) -> Array:
    """An arm (20,) that hangs, ``tilt`` (2,) [rad] forward and outward, the back of the hand half outward."""
    upper = np.array([tilt[0], side * tilt[1], -1.0])
    forearm = upper + np.array([np.tan(bend), 0.0, 0.0])
    return _assembled(upper, forearm, np.array([1.0, side, 0.0]), np.array([1.0, 0.3 * side, 0.0]))


def resting_arm(errors: Array, side: float) -> Array:
    """A hand (20,) that rests before the belly, with ``errors`` (6,) [rad] of its two directions."""
    upper = np.array([0.25, 0.15 * side, -0.95]) + errors[:3]
    forearm = np.array([0.75, -0.6 * side, -0.1]) + errors[3:]
    return _assembled(upper, forearm, np.array([0.3, 0.0, 0.95]), np.array([0.78, -0.62 * side, 0.0]))


def _assembled(upper: Array, forearm: Array, back: Array, outer: Array) -> Array:
    upper, forearm = unit(np.column_stack([upper, forearm])).T
    return np.concatenate([upper, forearm, forearm, back, outer, np.zeros(5)])
