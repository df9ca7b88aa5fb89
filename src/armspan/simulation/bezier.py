"""How a Cellulo follows a chain of cubic Bezier curves: to its beginning, after a carrot along it, to its end.

In the firmware's units: mm, mm/s, degrees and rad/s, in the pattern's frame. Follows EPFL's source
(chili-epfl/CelluloV2, motion.c and bezier.c): the carrot is at most 0.15 s ahead, and the curve's parameter is
searched, not integrated.
"""

import math
from dataclasses import dataclass, field

from armspan.records import Vec2

MOST = 100
"""Segments that a robot keeps; further ones are ignored."""
AHEAD_S, NEAR = 0.15, 0.707
STEP, FINEST = 0.01, 1e-5
REACHED_MM, GAIN, ALIGN_GAIN = 2.54, 2.0, 0.08
TO_START, ALONG, TO_END, DONE = 1, 2, 3, 4


@dataclass(slots=True)
class Chain:
    """Cubic curves end to end from ``start`` [mm]; each is told by its two control points and its end."""

    start: Vec2 = (0.0, 0.0)
    segments: list[tuple[Vec2, Vec2, Vec2]] = field(default_factory=list)

    def begin(self, start: Vec2) -> None:
        """Begin anew, without any curve."""
        self.start = start
        self.segments = []

    def append(self, first: Vec2, second: Vec2, end: Vec2) -> None:
        """Go on by a curve, if there is room for one."""
        if len(self.segments) < MOST:
            self.segments.append((first, second, end))

    @property
    def end(self) -> Vec2:
        """The last point."""
        return self.segments[-1][2] if self.segments else self.start

    def at(self, parameter: float) -> Vec2:
        """The point at a parameter: whole numbers are where curves meet."""
        if parameter >= len(self.segments):
            return self.end
        k = max(int(parameter), 0)
        u = max(parameter, 0.0) - k
        a, (b, c, d) = (self.segments[k - 1][2] if k else self.start), self.segments[k]
        weights = ((1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u * u * (1 - u), u**3)
        x, y = (sum(w * p[axis] for w, p in zip(weights, (a, b, c, d), strict=True)) for axis in (0, 1))
        return x, y


@dataclass(slots=True)
class Follower:
    """A goal to follow a chain at ``v`` [mm/s], turning at ``w`` [rad/s], or at ``angle`` [degrees] to the way.

    With an ``angle``, ``w`` is the fastest turn.
    """

    chain: Chain
    v: float
    w: float = 0.0
    angle: float | None = None
    state: int = TO_START
    _carrot: float = 0.0

    def wish(self, xy: Vec2, theta: float) -> tuple[float, float, float]:
        """The velocity [mm/s, mm/s, rad/s] that a robot at ``xy`` [mm] with heading ``theta`` [degrees] wants."""
        if self.state == TO_START:
            vx, vy = self._toward(xy, self.chain.start)
            if (vx, vy) != (0.0, 0.0) or not _near(xy, self.chain.start):
                return vx, vy, 0.0
            self.state = ALONG
        if self.state == ALONG:
            wish = self._along(xy, theta)
            if wish is not None:
                return wish
            self.state = TO_END
        if self.state == TO_END and not _near(xy, self.chain.end):
            return *self._toward(xy, self.chain.end), 0.0 if self.angle is not None else self.w
        self.state = DONE
        return 0.0, 0.0, 0.0

    def _along(self, xy: Vec2, theta: float) -> tuple[float, float, float] | None:
        """After the carrot; None once it has come to the end."""
        self._carrot += self._stride(xy)
        if self._carrot >= len(self.chain.segments):
            return None
        x, y = self.chain.at(self._carrot)
        dx, dy = x - xy[0], y - xy[1]
        far = math.hypot(dx, dy)
        if far == 0.0:
            return 0.0, 0.0, self.w if self.angle is None else 0.0
        return self.v * dx / far, self.v * dy / far, self._turn(math.degrees(math.atan2(dy, dx)), theta)

    def _stride(self, xy: Vec2) -> float:
        """How far the carrot goes on: halved until it is not too far, doubled until it is not too near."""
        step, most = STEP, AHEAD_S * self.v
        ahead = math.dist(self.chain.at(self._carrot + step), xy)
        while ahead > most and step > FINEST:
            step /= 2
            ahead = math.dist(self.chain.at(self._carrot + step), xy)
        if ahead > most:
            return 0.0
        while ahead < NEAR * most and self._carrot + step < len(self.chain.segments):
            further = math.dist(self.chain.at(self._carrot + 2 * step), xy)
            if further > most:
                break
            step, ahead = 2 * step, further
        return step

    def _turn(self, course: float, theta: float) -> float:
        if self.angle is None:
            return self.w
        error = (self.angle + course - theta + 180.0) % 360.0 - 180.0
        return min(max(ALIGN_GAIN * error, -self.w), self.w)

    def _toward(self, xy: Vec2, goal: Vec2) -> Vec2:
        """As the position tracker: an axis that is near is not driven, the whole no faster than ``v``."""
        vx, vy = (GAIN * (g - p) / 0.508 if abs(g - p) >= REACHED_MM else 0.0 for g, p in zip(goal, xy, strict=True))
        share = self.v / max(math.hypot(vx, vy), self.v, 1e-9)
        return vx * share, vy * share


def _near(xy: Vec2, goal: Vec2) -> bool:
    return all(abs(g - p) < REACHED_MM for g, p in zip(goal, xy, strict=True))
