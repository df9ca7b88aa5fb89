"""The seven arm gestures of the 2019 report (figure 2.1.1), and arms at rest, as one person performs them.

Angles are in degrees in the tables, as a person would describe them; see `joints` for their meaning.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from armspan.frames import Array
from armspan.records import Vec2
from armspan.simulation.arm import Arm
from armspan.simulation.course import LEFT, RIGHT, Piece, Wave
from armspan.simulation.gesture_styles import CYCLIC, CycleStyle, GestureStyle, Label, TakeStyle, draw_take
from armspan.simulation.joints import (
    ANGLES,
    AXIAL,
    ELEVATION,
    FLEXION,
    JOINTS,
    PLANE,
    PRONATION,
    wrist_step,
)

_HIGH = (80.0, 133.0, -10.0, 14.0, 10.0)
_LOW = (80.0, 46.0, -55.0, 12.0, 30.0)
_POSTURES: Mapping[Label, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "x_left_high": (_HIGH, _LOW),
    "x_right_high": (_LOW, _HIGH),
    "raise_both": ((74.0, 142.0, 0.0, 14.0, 5.0),) * 2,
    "mixing": ((42.0, 26.0, -68.0, 84.0, 40.0),) * 2,
    "stop": ((4.0, 75.0, -54.0, 97.0, 0.0),) * 2,
    "arms_to_ground": ((50.0, 24.0, -45.0, 22.0, 75.0),) * 2,
    "breaststroke": ((46.0, 82.0, -86.0, 78.0, 10.0),) * 2,
}
_PALMS = {True: 65.0, False: -15.0}
_STROKE = np.radians((31.0, 4.0, 0.0, -56.0, 8.0))
_BEFORE_THE_FACE = np.radians(106.0)
"""How far elbows are bent at most when the forearms are crossed, so that they stay clear of the face."""

_LEAST_BEND = np.radians(-4.0)
_ELEVATIONS = np.radians((-30.0, 172.0))
_RISE, _FALL = (0.75, 0.22), (0.80, 0.20)
_ARM = 0.56
"""Upper arm and forearm [m] of a person whose circles have the radius in the tables."""


@dataclass(frozen=True, slots=True)
class Performed:
    """The truth about one gesture: its first arm set out at ``start`` and the last hung again at ``end`` [s].

    From ``reached`` to ``left`` [s] both arms did what the gesture consists of.
    """

    label: Label
    start: float
    end: float
    reached: float
    left: float


class Repertoire:
    """All gestures of one person with arms of those lengths; it counts the takes, as warm-up and fatigue need."""

    def __init__(self, style: GestureStyle, arm: Arm, rng: np.random.Generator) -> None:
        self.style, self._arm, self._rng = style, arm, rng
        self._done: dict[Label, int] = {}

    def gesture(self, label: Label, start: float) -> tuple[Piece, Performed]:
        """The next take of ``label``, its first arm setting out at ``start`` [s]."""
        before, alike = sum(self._done.values()), self._done.get(label, 0)
        self._done[label] = alike + 1
        take = draw_take(self.style, before, alike, label, self._rng)
        if label == "initial":
            piece = self._at_rest(start, take)
        elif label in CYCLIC:
            piece = self._cyclic(label, start, take)
        else:
            piece = self._static(label, start, take)
        return piece, _told(label, piece)

    def _at_rest(self, start: float, take: TakeStyle) -> Piece:
        joints = self.style.hang.copy()
        joints[:, :ANGLES] += 0.3 * (take.joints[:, :ANGLES] - self.style.habits["initial"])
        end = start + 0.5 + self.style.hold * take.hold
        return Piece(joints, (start, start), (0.5, 0.5), (end, end), (0.5, 0.5))

    def _static(self, label: Label, start: float, take: TakeStyle) -> Piece:
        joints = self._angles(label, take)
        via = np.zeros((2, JOINTS))
        via[:, PLANE] = self.style.via * np.sin(joints[:, ELEVATION]).clip(0.3, 1.0)
        hold = float(np.clip(self.style.hold * take.hold, 0.8, 2.0))
        begin = (start + take.onset[LEFT], start + take.onset[RIGHT])
        rise, fall = self._ways(joints, take)
        until = max(begin) + max(rise) + hold
        end = (until + 0.5 * take.onset[RIGHT], until + 0.5 * take.onset[LEFT])
        return Piece(joints, begin, rise, end, fall, via)

    def _cyclic(self, label: Label, start: float, take: TakeStyle) -> Piece:
        joints, cycle = self._angles(label, take), self.style.cycles[label]
        rate = float(np.clip(cycle.rate * take.rate * take.tempo / self.style.tempo, 0.7, 1.5))
        lasting = float(np.clip(cycle.cycles / rate, 1.5, 4.0))
        begin = (start + take.onset[LEFT], start + take.onset[RIGHT])
        rise, fall = self._ways(joints, take)
        # A hand circles already while it comes up, and a little while it goes down.
        until = max(begin) + 0.5 * max(rise) + lasting
        phase = float(self._rng.normal(0.0, 0.5))
        share = take.amplitude * take.radius
        wave = self._stroke(joints, cycle, share) if label == "breaststroke" else self._circle(joints, cycle, share)
        return Piece(
            joints,
            begin,
            rise,
            (until + take.onset[RIGHT], until + take.onset[LEFT]),
            fall,
            waves=(wave, _harmonic(cycle, share)),
            rate=(rate, rate),
            phase=(phase, phase + cycle.apart),
            unsteady=(0.25, float(self._rng.uniform(0.0, 2.0 * np.pi))),
        )

    def _angles(self, label: Label, take: TakeStyle) -> Array:
        joints = take.joints.copy()
        joints[:, :ANGLES] += np.radians(_POSTURES[label])
        if label == "stop":
            joints[:, PRONATION] += np.radians(_PALMS[self.style.palms_out])
            joints[:, FLEXION] = np.minimum(joints[:, FLEXION], _BEFORE_THE_FACE)
        hang = self.style.hang[:, ELEVATION]
        joints[:, ELEVATION] = hang + take.elevation * (joints[:, ELEVATION] - hang)
        joints[:, ELEVATION] = np.clip(joints[:, ELEVATION], *_ELEVATIONS)
        joints[:, FLEXION] = np.maximum(joints[:, FLEXION], np.radians(2.0))
        return joints

    def _ways(self, joints: Array, take: TakeStyle) -> tuple[Vec2, Vec2]:
        """How long each arm needs to get there and back [s]: farther ways take longer."""
        far = np.abs(joints - self.style.hang)[:, : FLEXION + 1].max(axis=1) / (np.pi / 2.0)
        up, down = [(first + more * far) / take.tempo for first, more in (_RISE, _FALL)]
        return (float(up[LEFT]), float(up[RIGHT])), (float(down[LEFT]), float(down[RIGHT]))

    def _circle(self, joints: Array, cycle: CycleStyle, share: float) -> Wave:
        """Joint movements that carry the wrists round ellipses, to first order in the radius."""
        scale = (self._arm.upper + self._arm.forearm) / _ARM
        ahead = np.array([np.cos(cycle.tilt / 2.0), 0.0, -np.sin(cycle.tilt / 2.0)])
        upright = np.sin(cycle.tilt) ** 2
        aside = np.array([0.0, 1.0 - upright, upright])
        radius = scale * share * cycle.radius
        cosine, sine = np.zeros((2, JOINTS)), np.zeros((2, JOINTS))
        for arm in (LEFT, RIGHT):
            step = wrist_step(joints[arm], self._arm.upper, self._arm.forearm)
            flip = np.array([1.0, cycle.together if arm == RIGHT else 1.0, 1.0])
            cosine[arm, :PRONATION] = _carried(step, radius * flip * ahead)
            sine[arm, :PRONATION] = _carried(step, cycle.direction * cycle.roundness * radius * flip * aside)
        return Wave(cosine, sine)

    def _stroke(self, joints: Array, cycle: CycleStyle, share: float) -> Wave:
        """Hands that go forward, apart, and back to the chest: plane and bend a quarter turn from each other."""
        both = cycle.radius * share * _STROKE
        cosine, sine = np.zeros((2, JOINTS)), np.zeros((2, JOINTS))
        cosine[:, [PLANE, ELEVATION, PRONATION]] = both[[PLANE, ELEVATION, PRONATION]]
        bend = np.minimum(-both[FLEXION], joints[:, FLEXION] - _LEAST_BEND)
        sine[:, FLEXION] = cycle.direction * bend
        cosine[:, AXIAL] = 0.1 * both[PLANE]
        # Pushing forward brings the elbows in.
        sine[:, PLANE] = cycle.direction * 0.3 * both[PLANE]
        return Wave(cosine, sine)


_EASE = np.diag((0.7, 1.0, 1.0, 1.0))


def _carried(step: Array, offset: Array) -> Array:
    """The joints' share (4,) [rad] in moving the wrist by ``offset`` (3,) [m]: the least turns that do it."""
    weighted = step @ _EASE
    damped = weighted @ weighted.T + 0.002 * np.eye(3)
    return np.asarray(_EASE @ weighted.T @ np.linalg.solve(damped, offset))


def _harmonic(cycle: CycleStyle, share: float) -> Wave:
    cosine = np.zeros((2, JOINTS))
    cosine[:, :ANGLES] = share * cycle.harmonic
    return Wave(cosine, np.roll(cosine, 1, axis=0) * 0.5, order=2)


def _told(label: Label, piece: Piece) -> Performed:
    reached = max(start + rise for start, rise in zip(piece.start, piece.rise, strict=True))
    return Performed(label, piece.begun, piece.over, reached, min(piece.end))
