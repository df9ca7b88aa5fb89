"""Which way an app counts acceleration, and whether its attitude can be believed.

A record's specific force points up at rest. Android, the W3C and Sensor Logger's standardised frames say it so;
Apple says its negative, of gravity and of the motion alike (Sensor Logger's COORDINATES.md, 'Differences between
iOS and Android'; its issues 2 and 20). Gravity's direction tells the two apart wherever there is an attitude, since
all of these apps agree about that.
"""

from dataclasses import dataclass

from armspan.devices.phone.readings import GRAVITY, up
from armspan.records import Quaternion, Vec3

_QUIET = 2.0
_MEMORY = 100.0
_ENOUGH = 60.0
_AGREE = 0.8


@dataclass(slots=True)
class Upright:
    """Finds the sign that makes a force point up where the attitude says that up is.

    ``sign`` is what is assumed until there is evidence. ``agreement`` runs from -1 to 1: the cosine between gravity
    as felt and as the attitude has it, over the last hundred quiet samples.
    """

    sign: float = 1.0
    _sum: float = 0.0
    _weight: float = 0.0

    def assume(self, sign: float) -> None:
        """Take a sign on the word of the app's units or kind, until gravity has spoken."""
        if not self._weight:
            self.sign = sign

    def feel(self, told: Vec3, attitude: Quaternion) -> None:
        """Take an acceleration with gravity [m/s²] in the app's own sign, and the attitude with it."""
        length = sum(value * value for value in told) ** 0.5
        if abs(length - GRAVITY) > _QUIET:
            return
        cosine = sum(a * b for a, b in zip(told, up(attitude), strict=True)) / length
        keep = 1.0 - 1.0 / _MEMORY
        self._sum, self._weight = keep * self._sum + cosine, keep * self._weight + 1.0
        if abs(self._sum) > 0.5 * self._weight:
            self.sign = 1.0 if self._sum > 0.0 else -1.0

    @property
    def agreement(self) -> float:
        """How well gravity and attitude agree, 1 where they do; 1 while nothing is known."""
        return self.sign * self._sum / self._weight if self._weight else 1.0

    @property
    def believes(self) -> bool:
        """Whether the attitude can be believed: gravity has not spoken against it for a second."""
        return self._weight < _ENOUGH or self.agreement > _AGREE

    def force(self, told: Vec3) -> Vec3:
        """Specific force [m/s²], up at rest."""
        x, y, z = told
        return (self.sign * x, self.sign * y, self.sign * z)
