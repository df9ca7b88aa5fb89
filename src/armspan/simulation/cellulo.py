"""A Cellulo robot's own rules, for n robots at once: goal tracking, wheel mixing, kidnap, pose broadcast.

Pure state machines in the firmware's units: no bytes, no SI. Arrays are (3, n) with rows x, y, theta. A pose
is in counts, hundredths of the pattern's 0.508 mm grid, and hundredths of a degree; a velocity is in mm/s and
rad/s; both in the pattern's frame (x right, y down, theta clockwise from above). Times are milliseconds
since boot. Recorded from EPFL's firmware (chili-epfl/CelluloV2, motion.c, localization.c) in an emulator.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armspan.frames import Array

Mask: TypeAlias = NDArray[np.bool_]

MM_PER_COUNT = 0.00508
COUNTS_PER_TURN = 36000

GAIN: Array = np.array([[0.02], [0.02], [0.001]])  # 2 mm/s a grid unit, 0.1 rad/s a degree
TOLERANCE: Array = np.array([[500.0], [500.0], [200.0]])  # 5 grid units, 2 degrees
SLEW: Array = np.array([[20.0], [20.0], [0.5]])  # the most a tracked velocity changes in a frame
MOVED: Array = np.array([[100.0], [100.0], [200.0]])  # 1 grid unit, 2 degrees
RESYNC_MS = 1000
IDLE_MS = 500
KIDNAP_FRAMES = 10
DEFAULT_PERIOD_MS = 100

PWM_TOP = 4095
PWM_DEAD_ZONE = 1056
PWM_PER_VELOCITY: Array = np.array([[30.0], [30.0], [40.0 * 28.0]])  # 28 mm from the centre to a wheel
WHEELS: Array = np.array([[2 / 3, 0.0, 1 / 3], [-1 / 3, 0.57735, 1 / 3], [-1 / 3, -0.57735, 1 / 3]])


def motors_from_velocity(velocity: ArrayLike, theta: ArrayLike) -> NDArray[np.int64]:
    """Signed PWM (3, n) of wheels 1 to 3 for velocities (3, n) [mm/s, rad/s] at headings (n,) [0.01 degree].

    Open loop: the dead zone is jumped over, and what exceeds the top scales all three wheels down.
    """
    vx, vy, w = np.asarray(velocity, dtype=float)
    angle = np.radians(np.asarray(theta) / 100)
    c, s = np.cos(angle), np.sin(angle)
    target = np.trunc(WHEELS @ (PWM_PER_VELOCITY * np.stack([c * vx + s * vy, c * vy - s * vx, w])))
    target += PWM_DEAD_ZONE * np.sign(target)
    peak = np.maximum(np.abs(target).max(axis=0), PWM_TOP)
    motors: NDArray[np.int64] = np.trunc(target * (PWM_TOP / peak)).astype(np.int64)
    return motors


class Motion:
    """The goals of n robots and what their motors are told, one step for each new valid camera frame.

    ``tracked`` (3, n) is the velocity that the goal asks for, ``driven`` (3, n) the one that the motors were
    last told, haptics included. There is no time-out: a goal holds until the next one.
    """

    def __init__(self, n: int) -> None:
        self.tracked: Array = np.zeros((3, n))
        self.driven: Array = np.zeros((3, n))
        self.shake = Vibration(n)
        self._goal: Array = np.zeros((3, n))
        self._limit: Array = np.zeros((2, n))
        self._controlled: Mask = np.zeros((3, n), dtype=bool)
        self._tracking: Mask = np.zeros(n, dtype=bool)
        self._reached: Mask = np.zeros(n, dtype=bool)
        self._unheld: Mask = np.zeros(n, dtype=bool)
        self._framed: Array = np.full(n, -np.inf)
        self._theta: Array = np.zeros(n)

    def track_velocity(self, robot: int, velocity: ArrayLike) -> None:
        """Follow a velocity (3,) [mm/s, mm/s, rad/s] as it is, without slew."""
        self._controlled[:, robot] = self._tracking[robot] = False
        self.tracked[:, robot] = velocity

    def track_pose(
        self,
        robot: int,
        x: float | None = None,
        y: float | None = None,
        theta: float | None = None,
        *,
        vmax: float = 0.0,
        wmax: float = 0.0,
    ) -> None:
        """Go to the coordinates told [counts, 0.01 degree], at most at ``vmax`` [mm/s] and ``wmax`` [rad/s].

        A coordinate that is not told is not driven. All three are the firmware's pose tracker, x and y its
        position tracker, theta its orientation tracker, and so on.
        """
        for axis, value in enumerate((x, y, theta)):
            self._controlled[axis, robot] = value is not None
            self._goal[axis, robot] = 0.0 if value is None else value
        self.tracked[~self._controlled[:, robot], robot] = 0.0
        self._limit[:, robot] = vmax, wmax
        self._tracking[robot], self._reached[robot] = self._controlled[:, robot].any(), False

    def clear(self, robot: int) -> None:
        """Forget the goal and stop."""
        self.track_velocity(robot, (0.0, 0.0, 0.0))

    def block(self, robot: int, unheld: bool) -> None:
        """Keep the motors off: the robot moves only while it is held, and nobody holds it."""
        self._unheld[robot] = unheld

    def motors(self) -> NDArray[np.int64]:
        """Signed PWM (3, n) that the wheels have now."""
        return motors_from_velocity(self.driven, self._theta)

    def frame(self, now: float, pose: Array, fresh: Mask, kidnapped: Mask) -> Mask:
        """One camera frame: (n,) whether a goal was reached just now.

        ``fresh`` (n,) tells where the frame is new and valid; elsewhere the motors keep what they have.
        """
        step = fresh & (now - self._framed < RESYNC_MS) & ~(kidnapped | self._unheld)
        self._framed[fresh] = now
        arrived = self._track(pose, step)
        driven = self.tracked + self.shake.frame(now, step, self.tracked) if self.shake.on else self.tracked
        np.copyto(self.driven, driven, where=step)
        np.copyto(self._theta, pose[2], where=step)
        self.driven[:, kidnapped | (self._unheld & fresh)] = 0.0
        return arrived

    def _track(self, pose: Array, step: Mask) -> Mask:
        """Update ``tracked`` where a goal pose is tracked; (n,) whether it was reached just now."""
        if not self._tracking.any():
            return self._tracking
        error = self._goal - pose
        error[2] = (error[2] + COUNTS_PER_TURN / 2) % COUNTS_PER_TURN - COUNTS_PER_TURN / 2
        far = (np.abs(error) >= TOLERANCE) & self._controlled
        change = _limited(GAIN * error * far, self._limit) - self.tracked
        slewed = self.tracked + np.minimum(np.maximum(change, -SLEW), SLEW)
        np.copyto(self.tracked, slewed, where=self._controlled & step)
        near = ~far.any(axis=0) & self._tracking
        arrived: Mask = near & step & ~self._reached
        np.copyto(self._reached, near, where=step)
        return arrived


def _limited(velocity: Array, limit: Array) -> Array:
    """Velocities (3, n) shortened to the limits (2, n) of speed and of turn rate."""
    speed = np.stack([np.hypot(velocity[0], velocity[1]), np.abs(velocity[2])])
    share = limit / np.maximum(np.maximum(speed, limit), 1e-12)
    velocity[:2] *= share[0]
    velocity[2] *= share[1]
    return velocity


class Vibration:
    """The simple vibration of n robots: a velocity added with a sign that flips each period.

    Of the firmware's haptics only this one is here; vibrate-on-motion and the backdrive assists are not.
    """

    def __init__(self, n: int) -> None:
        self.on = False
        self._active: Mask = np.zeros(n, dtype=bool)
        self._push: Array = np.zeros((3, n))
        self._sign: Array = np.zeros((3, n))  # 0: to be chosen against the motion at the first frame
        self._period, self._flipped, self._end = (np.zeros(n) for _ in range(3))

    def start(self, now: float, robot: int, push: ArrayLike, period: float, duration: float) -> None:
        """Vibrate by (3,) [mm/s, mm/s, rad/s], ``duration`` 0 for ever; a running one keeps its phase."""
        if not self._active[robot]:
            self._sign[:, robot], self._flipped[robot] = 0.0, now
        self._push[:, robot], self._period[robot] = push, period
        self._end[robot] = now + duration if duration > 0 else np.inf
        self._active[robot] = self.on = True

    def stop(self, robot: int) -> None:
        """End the vibration."""
        self._active[robot] = False
        self.on = bool(self._active.any())

    def frame(self, now: float, step: Mask, tracked: Array) -> Array:
        """What is added (3, n) in this frame; the frame in which it ends is still shaken."""
        self._sign[self._sign == 0.0] = np.where(tracked > 0, -1.0, 1.0)[self._sign == 0.0]
        over = self._active & (now >= self._end)
        flip = self._active & ~over & (now - self._flipped >= self._period)
        self._sign[:, flip] *= -1.0
        self._flipped[flip] = now
        added = self._push * self._sign * (self._active & step)
        self._active &= ~over
        self.on = bool(self._active.any())
        return added


class Sighting(NamedTuple):
    """What the localisation of n robots has to tell after a frame, (n,) each."""

    pose: Mask  # the pose is sent
    lifted: Mask  # kidnapped just now
    returned: Mask  # back on the pattern; told before the pose


class Localisation:
    """Kidnap and pose broadcast of n robots. At boot they count as kidnapped, and nothing is told.

    ``period`` (n,) [ms] is the broadcast's; ``stamped`` (n,) tells which send time stamps: those never idle.
    """

    def __init__(self, n: int) -> None:
        self.kidnapped: Mask = np.ones(n, dtype=bool)
        self.period: Array = np.full(n, float(DEFAULT_PERIOD_MS))
        self.stamped: Mask = np.zeros(n, dtype=bool)
        self._invalid: Array = np.zeros(n)
        self._sent: Array = np.full(n, -np.inf)
        self._reference: Array = np.full((3, n), -np.inf)
        self._moved: Array = np.full(n, -np.inf)
        self._idled: Array = np.full(n, -np.inf)
        self._idle: Mask = np.zeros(n, dtype=bool)

    def frame(self, now: float, pose: Array, valid: Mask) -> Sighting:
        """One camera frame, ``valid`` (n,) where it was decoded."""
        self._invalid = np.where(valid, 0.0, self._invalid + 1.0)
        returned = valid & self.kidnapped
        lifted = (self._invalid >= KIDNAP_FRAMES) & ~self.kidnapped
        self.kidnapped ^= returned | lifted
        due = valid & (now >= self._sent + self.period)
        if not self.stamped.all():
            due = self._idling(now, pose, valid, due)
        self._sent[due] = now
        return Sighting(due, lifted, returned)

    def _idling(self, now: float, pose: Array, valid: Mask, awake: Mask) -> Mask:
        """(n,) which robots send, given those that would if ``awake``.

        Who is still for long enough idles from the next frame on, and then sends at once.
        """
        late = valid & (now >= self._idled + np.maximum(self.period, IDLE_MS))
        due = np.where(self._idle & ~self.stamped, late, awake)
        far = (np.abs(pose - self._reference) >= MOVED) & valid
        np.copyto(self._reference, pose, where=far)
        moved = far.any(axis=0)
        self._moved[moved] = now
        self._idled[moved | (self._idle & due)] = now
        self._idle = now - self._moved >= IDLE_MS
        return due
