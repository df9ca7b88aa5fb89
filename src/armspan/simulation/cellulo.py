"""A Cellulo robot's own rules, for n robots at once: goal tracking, wheel mixing, kidnap, pose broadcast.

Pure state machines in the firmware's units: no bytes, no SI. Arrays are (3, n) with rows x, y, theta. A pose
is in counts, hundredths of the pattern's 0.508 mm grid, and hundredths of a degree; a velocity is in mm/s and
rad/s; both in the pattern's frame (x right, y down, theta clockwise from above). Times are milliseconds
since boot. Recorded from EPFL's firmware (chili-epfl/CelluloV2, motion.c, localization.c) in an emulator.
"""

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armspan.frames import Array
from armspan.simulation.bezier import DONE, Follower
from armspan.simulation.haptics import Backdrive, Vibration

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


def velocity_from_motors(motors: ArrayLike, theta: float) -> Array:
    """The velocity (3,) [mm/s, rad/s] that wheels with a PWM (3,) turn for, at a heading [0.01 degree].

    The inverse of `motors_from_velocity` where nothing was scaled down.
    """
    pwm = np.asarray(motors, dtype=float)
    rolled = np.sign(pwm) * np.maximum(np.abs(pwm) - PWM_DEAD_ZONE, 0.0)
    x, y, w = np.linalg.solve(WHEELS, rolled) / PWM_PER_VELOCITY[:, 0]
    c, s = np.cos(np.radians(theta / 100)), np.sin(np.radians(theta / 100))
    return np.array([c * x - s * y, s * x + c * y, w])


class Motion:
    """The goals of n robots and what their motors are told, one step for each new valid camera frame.

    ``tracked`` (3, n) is the velocity that the goal asks for, ``driven`` (3, n) the one that the motors were
    last told, haptics included, ``raw`` the wheels' PWM (3,) of robots that were told it since their last frame.
    ``held`` (n,) tells whose hold is felt. There is no time-out: a goal holds until the next one.
    """

    def __init__(self, n: int) -> None:
        self.tracked: Array = np.zeros((3, n))
        self.driven: Array = np.zeros((3, n))
        self.shake, self.backdrive = Vibration(n), Backdrive(n)
        self.raw: dict[int, NDArray[np.int64]] = {}
        self.held: Mask = np.zeros(n, dtype=bool)
        self._curves: dict[int, Follower] = {}
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
        self._curves.pop(robot, None)
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
        self._curves.pop(robot, None)
        for axis, value in enumerate((x, y, theta)):
            self._controlled[axis, robot] = value is not None
            self._goal[axis, robot] = 0.0 if value is None else value
        self.tracked[~self._controlled[:, robot], robot] = 0.0
        self._limit[:, robot] = vmax, wmax
        self._tracking[robot], self._reached[robot] = self._controlled[:, robot].any(), False

    def track_curve(self, robot: int, follower: Follower) -> None:
        """Follow a chain of curves."""
        self.track_velocity(robot, self.tracked[:, robot])
        self._curves[robot] = follower

    def clear(self, robot: int) -> None:
        """Forget the goal and stop."""
        self.track_velocity(robot, (0.0, 0.0, 0.0))

    def block(self, robot: int, unheld: bool) -> None:
        """Let the motors turn only while the robot is held."""
        self._unheld[robot] = unheld

    def turn_wheels(self, robot: int, outputs: Mapping[int, int]) -> Array:
        """Give wheels (0 to 2) a PWM until the next frame; the velocity (3,) [mm/s, rad/s] that the robot then has."""
        pwm = self.motors()[:, robot]
        for wheel, output in outputs.items():
            pwm[wheel] = min(max(output, -PWM_TOP), PWM_TOP)
        self.raw[robot] = pwm
        return velocity_from_motors(pwm, float(self._theta[robot]))

    def motors(self) -> NDArray[np.int64]:
        """Signed PWM (3, n) that the wheels have now."""
        motors = motors_from_velocity(self.driven, self._theta)
        for robot, pwm in self.raw.items():
            motors[:, robot] = pwm
        return motors

    def frame(self, now: float, pose: Array, fresh: Mask, kidnapped: Mask) -> Mask:
        """One camera frame: (n,) whether a goal was reached just now.

        ``fresh`` (n,) tells where the frame is new and valid; elsewhere the motors keep what they have.
        """
        free = self._unheld & ~self.held
        step = fresh & (now - self._framed < RESYNC_MS) & ~(kidnapped | free)
        self._framed[fresh] = now
        arrived = self._track(pose, step)
        if self._curves:
            arrived = arrived | self._follow(pose, step)
        driven = self.tracked + self.shake.frame(now, step, self.tracked) if self.shake.on else self.tracked
        if self.backdrive.on:
            driven = driven + self.backdrive.frame(now, pose, step, kidnapped, self.held)
        np.copyto(self.driven, driven, where=step)
        np.copyto(self._theta, pose[2], where=step)
        self.driven[:, kidnapped | (free & fresh)] = 0.0
        if self.raw:
            self.raw = {robot: pwm for robot, pwm in self.raw.items() if not (fresh[robot] or kidnapped[robot])}
        return arrived

    def _follow(self, pose: Array, step: Mask) -> Mask:
        """Update ``tracked`` where a curve is followed; (n,) whether its end was reached just now."""
        arrived: Mask = np.zeros_like(step)
        for robot in [robot for robot in self._curves if step[robot]]:
            follower, (x, y, theta) = self._curves[robot], pose[:, robot].tolist()
            before = follower.state
            wish = np.array(follower.wish((x * MM_PER_COUNT, y * MM_PER_COUNT), theta / 100))
            change = np.clip(wish - self.tracked[:, robot], -SLEW[:, 0], SLEW[:, 0])
            self.tracked[:, robot] += change
            arrived[robot] = follower.state == DONE != before
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

    def frame(self, now: float, pose: Array, valid: Mask, missing: Mask | None = None) -> Sighting:
        """One camera frame, ``valid`` (n,) where it was decoded, ``missing`` (n,) where there was none at all."""
        invalid = np.where(valid, 0.0, self._invalid + 1.0)
        self._invalid = invalid if missing is None else np.where(missing, self._invalid, invalid)
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
