"""What a Cellulo adds to its goal for a hand to feel: vibrations, and motors that help or resist a push; n at once.

In the firmware's units: mm/s and rad/s in the pattern's frame, (3, n) with rows x, y, theta; milliseconds. The simple
vibration was recorded from EPFL's firmware in an emulator; the others follow its source (chili-epfl/CelluloV2,
haptics.c), as far as that is known: the low-pass of a held robot's help is an assumption.
"""

import numpy as np
from numpy.typing import ArrayLike

from armspan.frames import Array
from armspan.simulation.contacts import Mask

RIPPLE_FROM = np.array([[15.0], [15.0], [0.4]])
"""mm/s and rad/s above which vibrate-on-motion shakes."""
FRAMES = 5
"""Frames in a row that make a robot count as pushed, or as let go."""
CASUAL_FROM = np.array([[10.0], [0.1]])
CASUAL_GAIN, CASUAL_FADE, CASUAL_TURN_FADES = 0.6, 70.0, (1.5, 0.75)
HELD_KEEP = 0.9
HAPTIC_FROM = np.array([[20.0], [0.2]])
HAPTIC_FADE, HAPTIC_TURN_FADE = 55.0, 1.0
SMOOTH: Array = np.array([[0.5], [0.5], [0.8]])
"""The share of the old in the measured speed."""
HALF_TURN = 18000.0


class Vibration:
    """The simple vibration of n robots: a velocity added with a sign that flips each period."""

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


class Backdrive:
    """Vibrate-on-motion and the two backdrive assists of n robots: what follows from how a robot is moved.

    ``speed`` (3, n) is the measured one, smoothed; it is measured only while something needs it.
    """

    def __init__(self, n: int) -> None:
        self.on = False
        self.speed: Array = np.zeros((3, n))
        self._pose: Array = np.full((3, n), np.nan)
        self._seen: Array = np.zeros(n)
        self._ripple, self._period, self._flipped = np.zeros(n), np.zeros(n), np.zeros(n)
        self._sign: Array = np.ones(n)
        self._casual: Mask = np.zeros(n, dtype=bool)
        self._help: Array = np.zeros((3, n))
        self._low: Array = np.zeros((3, n))
        self._fast: Array = np.zeros((2, n))  # frames in a row on the other side of the threshold
        self._pushed: Mask = np.zeros((2, n), dtype=bool)

    def ripple(self, now: float, robot: int, coefficient: float, period: float) -> None:
        """Shake with the motion, until `still`."""
        self._ripple[robot], self._period[robot], self._flipped[robot] = coefficient, period, now
        self._switch()

    def still(self, robot: int) -> None:
        """Shake no more; the assists go on."""
        self._ripple[robot] = 0.0
        self._switch()

    def ease(self, robot: int, on: bool) -> None:
        """Help whoever pushes, and turn the other assist off."""
        self._casual[robot] = on
        if on:
            self._help[:, robot] = 0.0
        self._switch()

    def help(self, robot: int, coefficients: ArrayLike) -> None:
        """Help (or resist, below zero) by shares of the speed (3,), and turn the other assist off; zeros: none."""
        self._help[:, robot] = coefficients
        if self._help[:, robot].any():
            self._casual[robot] = False
        self._switch()

    def _switch(self) -> None:
        self.on = bool(self._ripple.any() or self._casual.any() or self._help.any())
        if not self.on:
            self._pose[:] = np.nan
            self.speed[:] = 0.0

    def frame(self, now: float, pose: Array, step: Mask, kidnapped: Mask, held: Mask) -> Array:
        """What is added (3, n) in this frame, with poses (3, n) [counts, 0.01 degree]."""
        self._measure(now, pose, step, kidnapped)
        added = self._shaken(now, step)
        helped = self._casual | self._help.any(axis=0)
        if helped.any():
            self._feel(step)
            added += np.where(self._casual, self._eased(held), self._helped())
        return np.where(step, added, 0.0)

    def _measure(self, now: float, pose: Array, step: Mask, kidnapped: Mask) -> None:
        known = step & ~np.isnan(self._pose[0])
        moved = pose - np.where(known, self._pose, pose)
        moved[2] = (moved[2] + HALF_TURN) % (2 * HALF_TURN) - HALF_TURN
        seconds = np.maximum(now - self._seen, 1.0) / 1000
        raw = moved * np.array([[0.00508], [0.00508], [np.pi / HALF_TURN]]) / seconds
        np.copyto(self.speed, SMOOTH * self.speed + (1 - SMOOTH) * raw, where=known)
        self.speed[:, kidnapped] = 0.0
        np.copyto(self._pose, pose, where=step)
        self._pose[:, kidnapped] = np.nan
        np.copyto(self._seen, now, where=step)

    def _shaken(self, now: float, step: Mask) -> Array:
        flip = step & (self._ripple > 0) & (now - self._flipped >= self._period)
        self._sign[flip] *= -1.0
        self._flipped[flip] = now
        fast = np.abs(self.speed)
        added: Array = self._sign * self._ripple * fast * (fast > RIPPLE_FROM)
        return added

    def _feel(self, step: Mask) -> None:
        """Whether a robot is pushed or turned (2, n): five frames in a row above the threshold, until five below."""
        magnitude = np.stack([np.hypot(self.speed[0], self.speed[1]), np.abs(self.speed[2])])
        above = magnitude > np.where(self._casual, CASUAL_FROM, HAPTIC_FROM)
        self._fast = np.where(step, np.where(above != self._pushed, self._fast + 1, 0.0), self._fast)
        turned = self._fast >= FRAMES
        self._pushed ^= turned
        self._fast[turned] = 0.0

    def _eased(self, held: Mask) -> Array:
        self._low = HELD_KEEP * self._low + (1 - HELD_KEEP) * self.speed
        v, w = np.hypot(self.speed[0], self.speed[1]), np.abs(self.speed[2])
        share = np.empty_like(self.speed)
        share[:2] = _faded(v, CASUAL_FADE) ** 2
        share[2] = _faded(w, CASUAL_TURN_FADES[0]) ** 2 * _faded(w, CASUAL_TURN_FADES[1]) ** 2
        return np.where(held, self._low, CASUAL_GAIN * share * self.speed) * self._rows()

    def _helped(self) -> Array:
        share = np.empty_like(self.speed)
        share[:2] = _faded(np.hypot(self.speed[0], self.speed[1]), HAPTIC_FADE)
        share[2] = _faded(np.abs(self.speed[2]), HAPTIC_TURN_FADE)
        return self._help * share * self.speed * self._rows()

    def _rows(self) -> Mask:
        """(3, n) which components are pushed."""
        return self._pushed[[0, 0, 1]]


def _faded(magnitude: Array, full: float) -> Array:
    """From 0 at rest to 1 at ``full`` and above."""
    return np.minimum(magnitude / full, 1.0)
