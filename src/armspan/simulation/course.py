"""Free movements of both arms, as pieces that are added to the hanging arms and taken away again.

Each piece draws the joints' angles away from where they hang with a weight that rises and falls as a
minimum-jerk movement (Flash and Henis 1991), so that pieces may overlap and be broken off at any time, and the
sum stays twice continuously differentiable. Arms are numbered: 0 left, 1 right.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from armspan.frames import Array
from armspan.records import Vec2
from armspan.simulation.figure import Figure
from armspan.simulation.fluctuation import Band, Fluctuation
from armspan.simulation.joints import ANGLES, ELEVATION, FLEXION, JOINTS, PLANE, posture_from_joints
from armspan.simulation.movement import minimum_jerk
from armspan.simulation.posture import ELBOW, HOLD

LEFT, RIGHT = 0, 1
_HURRY = 0.35


@dataclass(frozen=True, slots=True)
class Wave:
    """A cyclic part: joints (2, 7) that go with the cosine and the sine of the piece's phase, times ``order``."""

    cosine: Array
    sine: Array
    order: int = 1


@dataclass(frozen=True, slots=True)
class Piece:
    """One thing that the arms do. Pairs are (left, right), times in seconds.

    Each arm sets out at ``start``, is there after ``rise``, leaves at ``end`` and hangs again after ``fall``.
    ``joints`` (2, 7) is where it is taken to, ``via`` (2, 7) by how much it makes a detour on both ways,
    ``share`` how far it takes part. ``rate`` [Hz] and ``phase`` [rad] are those of the waves, ``unsteady``
    by how many radians the phase runs ahead and behind.
    """

    joints: Array
    start: Vec2
    rise: Vec2
    end: Vec2
    fall: Vec2
    via: Array = field(default_factory=lambda: np.zeros((2, JOINTS)))
    share: Vec2 = (1.0, 1.0)
    waves: tuple[Wave, ...] = ()
    rate: Vec2 = (1.0, 1.0)
    phase: Vec2 = (0.0, 0.0)
    unsteady: Vec2 = (0.0, 0.0)

    @property
    def begun(self) -> float:
        """When the first arm sets out [s]."""
        return min(start for start, share in zip(self.start, self.share, strict=True) if share > 0.0)

    @property
    def over(self) -> float:
        """When the last arm hangs again [s]."""
        ends = zip(self.end, self.fall, self.share, strict=True)
        return max(end + fall for end, fall, share in ends if share > 0.0)

    def weight(self, arm: int, times: Array) -> Array:
        """How far (m,) the arm is drawn away from where it hangs, 0 to 1."""
        up = minimum_jerk((times - self.start[arm]) / self.rise[arm])
        return np.asarray(self.share[arm] * (up - minimum_jerk((times - self.end[arm]) / self.fall[arm])))

    def at(self, arm: int, times: Array) -> Array:
        """Where (7, m) the arm is drawn to."""
        ahead, jitter = self.unsteady
        theta = 2.0 * np.pi * self.rate[arm] * (times - self.start[arm]) + self.phase[arm]
        theta = theta + ahead * np.sin(0.43 * theta + jitter)
        joints: Array = np.repeat(self.joints[arm][:, None], len(times), axis=1)
        for wave in self.waves:
            joints += wave.cosine[arm][:, None] * np.cos(wave.order * theta)
            joints += wave.sine[arm][:, None] * np.sin(wave.order * theta)
        return joints

    def detour(self, arm: int, times: Array) -> Array:
        """The detour (7, m) on the way there and back."""
        there = _bump((times - self.start[arm]) / self.rise[arm])
        back = _bump((times - self.end[arm]) / self.fall[arm])
        return np.asarray(self.share[arm] * self.via[arm][:, None] * (there + back))

    def cut(self, t: float) -> "Piece":
        """The piece as it goes on when the arms give up at ``t`` [s]; its ways are not shortened."""
        end, fall = list(self.end), list(self.fall)
        for arm in (LEFT, RIGHT):
            until = max(t, self.start[arm])
            if until < end[arm]:
                end[arm], fall[arm] = until, max(fall[arm], self.rise[arm], _HURRY)
        return replace(self, end=(end[LEFT], end[RIGHT]), fall=(fall[LEFT], fall[RIGHT]))


def _bump(share: Array) -> Array:
    s = np.minimum(np.maximum(share, 0.0), 1.0)
    return np.asarray(64.0 * (s * (1.0 - s)) ** 3)


class Course:
    """The pieces of one person, whose arms hang at ``hang`` (2, 7).

    While it moves, each joint errs by ``noise`` [rad], slowly.
    """

    def __init__(self, hang: Array, noise: float, rng: np.random.Generator) -> None:
        self.hang = hang
        self._pieces: list[tuple[float, float, Piece]] = []  # with begun and over, which are asked for often
        bands = [Band(row, noise, 0.15, 2.0, 6) for row in range(2 * ANGLES)]
        self._noise = Fluctuation(bands, 2 * ANGLES, rng)

    def add(self, piece: Piece) -> None:
        """One more piece."""
        self._pieces.append((piece.begun, piece.over, piece))

    def cut(self, t: float) -> None:
        """Give up, from ``t`` [s] on, whatever is under way and whatever was meant to follow."""
        kept = [piece.cut(t) for begun, _, piece in self._pieces if begun < t]
        self._pieces = [(piece.begun, piece.over, piece) for piece in kept]

    def forget(self, before: float) -> None:
        """Forget the pieces that were over ``before`` [s]."""
        self._pieces = [entry for entry in self._pieces if entry[1] > before]

    def at(self, arm: int, times: Array) -> Array:
        """The joints (7, m) of one arm."""
        hang = self.hang[arm][:, None]
        joints, moving = np.repeat(hang, len(times), axis=1), np.zeros(len(times))
        first, last = times.min(), times.max()
        for begun, over, piece in self._pieces:
            if over <= first or begun >= last:
                continue
            weight = piece.weight(arm, times)
            joints += weight * (piece.at(arm, times) - hang) + piece.detour(arm, times)
            moving += weight
        if moving.any():
            joints[:ANGLES] += moving * self._noise.at(times)[arm * ANGLES : (arm + 1) * ANGLES]
        return joints


class Performing:
    """One arm's posture on its course, wavering as a held arm does."""

    def __init__(self, course: Course, figure: Figure, arm: int) -> None:
        self._course, self._arm = course, arm
        self._side = 1.0 if arm == LEFT else -1.0
        self._offset = figure.person.shoulder_offset

    def at(self, times: Array, waver: Array) -> Array:
        """The posture (20, m) at ``times`` (m,) [s]."""
        joints = self._course.at(self._arm, times)
        joints[[PLANE, ELEVATION]] += waver[HOLD]
        joints[FLEXION] += waver[ELBOW][0]
        return posture_from_joints(joints, self._side, self._offset)
