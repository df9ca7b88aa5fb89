"""Samples to attitude, and how a band sits on the arm.

An attitude is ``earth_from_sensor``: earth's z is up, its heading arbitrary and different for each band. It
comes from the band's own fusion or from VQF (Laidig & Seel 2023, Information Fusion 91, 187-204) on raw
samples. Two held poses make it ``user_from_wrist``: the arm stretched forward and level gives the heading,
the arm hanging gives the direction of the forearm in the sensor. One pose cannot tell mounting from heading.
"""

from dataclasses import dataclass, field

import numpy as np
from vqf import VQF

from armspan.errors import CalibrationError
from armspan.frames import Array, rotation_from_quaternion, yaw_rotation
from armspan.records import ImuSample, Quaternion

MOVING = 0.35
"""Rate [rad/s] above which an arm counts as moving: a held arm's jitter stays below 10 deg/s."""

_EDGE = 1e-6  # ticks are multiples of a twentieth, which floats are not
_MOST_FILLED = 0.25
"""Longest gap [s] that is bridged by turning at the mean rate; the attitude restarts from gravity beyond."""


@dataclass(slots=True)
class Attitude:
    """Follows one band: feed it every sample, read ``quaternion`` when it is needed.

    ``rate`` [Hz] is the band's nominal rate, used by VQF only. Lost packets are bridged by interpolated samples, so
    that a gap turns as far as its rate says.
    """

    rate: float = 100.0
    t: float = -np.inf
    _last: ImuSample | None = None
    _filter: VQF | None = field(default=None, repr=False)

    def update(self, sample: ImuSample) -> None:
        """Take the next sample; one that is older than the last is passed over."""
        if sample.t <= self.t:
            return
        if sample.quat is None:
            self._integrate(sample)
        self.t, self._last = sample.t, sample

    @property
    def quaternion(self) -> Quaternion | None:
        """``earth_from_sensor`` (w, x, y, z), or None before the first sample."""
        if self._last is None:
            return None
        if self._last.quat is not None:
            return self._last.quat
        if self._filter is None:
            return None
        w, x, y, z = self._filter.getQuat6D().tolist()
        return (w, x, y, z)

    @property
    def integrates(self) -> bool:
        """Whether samples come without a quaternion of the band's own."""
        return self._filter is not None

    def _integrate(self, sample: ImuSample) -> None:
        gyr, acc = np.array(sample.gyr, dtype=float), np.array(sample.acc, dtype=float)
        gap = sample.t - self.t
        if self._filter is None:
            self._filter = VQF(1.0 / self.rate)
        if self._last is None or gap > _MOST_FILLED:
            self._filter.update(gyr, acc)
            return
        steps = max(1, round(gap * self.rate))
        stretch = gap * self.rate / steps  # the filter's step is fixed: the rate carries the true length
        old_gyr, old_acc = np.array(self._last.gyr, dtype=float), np.array(self._last.acc, dtype=float)
        for k in range(1, steps + 1):
            share = k / steps
            self._filter.update((old_gyr + share * (gyr - old_gyr)) * stretch, old_acc + share * (acc - old_acc))


@dataclass(slots=True)
class Hold:
    """Attitudes of one held pose, taken ``needed`` seconds long after the first ``settle`` seconds of rest.

    The settling time covers the arm's lag of 0.1 to 0.2 s behind the eye and the end of the reach.
    """

    needed: float = 1.0
    settle: float = 0.5
    still_since: float | None = None
    quaternions: list[Quaternion] = field(default_factory=list)

    def add(self, t: float, quaternion: Quaternion, moving: bool) -> bool:
        """Take an attitude at ``t`` [s]; True when the pose has been held long enough."""
        if moving:
            self.still_since = None
            self.quaternions.clear()
            return False
        if self.still_since is None:
            self.still_since = t
        if t - self.still_since >= self.settle - _EDGE:
            self.quaternions.append(quaternion)
        return t - self.still_since >= self.settle + self.needed - _EDGE

    def rotations(self) -> Array:
        """``earth_from_sensor`` (n, 3, 3) of the hold."""
        return rotation_from_quaternion(np.array(self.quaternions))


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """How a band sits and where its heading points: user = Rz(-heading) earth_from_sensor sensor_from_wrist.

    ``wrist_from_sensor`` is (3, 3); ``heading`` [rad] is the direction of the stretched arm in ``earth``.
    """

    wrist_from_sensor: Array
    heading: float

    def user_from_wrist(self, earth_from_sensor: Quaternion) -> Array:
        """Attitude (3, 3) of the forearm (or the upper arm) in the user frame."""
        attitude = rotation_from_quaternion(earth_from_sensor)
        return np.asarray(yaw_rotation(-self.heading) @ attitude @ self.wrist_from_sensor.T)


def mount_from_poses(forward: Array, hanging: Array, *, tolerance: float = np.radians(20)) -> Mount:
    """The mounting and the heading from two held poses.

    ``forward`` and ``hanging`` are ``earth_from_sensor`` (n, 3, 3): the arm stretched forward, level and palm
    down; the arm hanging. Each pose is a few degrees off in people, so where the two disagree about the
    forearm's direction in the sensor each gets half.

    Raises:
        CalibrationError: when the arm was not level, or the two poses are the same.

    """
    up_forward, up_hanging = _mean_up(forward), _mean_up(hanging)
    along = -up_hanging  # the hand points down, so the forearm's x axis is against up
    tilt = float(np.arcsin(np.clip(along @ up_forward, -1.0, 1.0)))
    if abs(tilt) > tolerance:
        raise CalibrationError(_not_level(tilt))
    across = along - (along @ up_forward) * up_forward
    across /= np.linalg.norm(across)
    x = np.cos(tilt / 2) * across + np.sin(tilt / 2) * up_forward
    z = np.cos(tilt / 2) * up_forward - np.sin(tilt / 2) * across
    wrist_from_sensor = np.stack([x, np.cross(z, x), z])
    return Mount(wrist_from_sensor, heading_of(forward, wrist_from_sensor))


def mount_from_forward(forward: Array, wrist_from_sensor: Array, tolerance: float = np.radians(20)) -> Mount:
    """The heading alone, where the mounting is known (3, 3).

    Raises:
        CalibrationError: when the arm was not level.

    """
    along = wrist_from_sensor[0]
    tilt = float(np.arcsin(np.clip(along @ _mean_up(forward), -1.0, 1.0)))
    if abs(tilt) > tolerance:
        raise CalibrationError(_not_level(tilt))
    return Mount(wrist_from_sensor, heading_of(forward, wrist_from_sensor))


def heading_of(forward: Array, wrist_from_sensor: Array) -> float:
    """Circular mean [rad] of the forearm's direction in ``earth`` over attitudes (n, 3, 3)."""
    along = forward @ wrist_from_sensor[0]
    return float(np.arctan2(along[:, 1].mean(), along[:, 0].mean()))


def _mean_up(earth_from_sensor: Array) -> Array:
    up = earth_from_sensor[:, 2, :].mean(axis=0)  # the third row is earth's z written in the sensor
    return np.asarray(up / np.linalg.norm(up))


def _not_level(tilt: float) -> str:
    return (
        f"the arm was not level: it pointed {abs(np.degrees(tilt)):.0f} degrees {'up' if tilt > 0 else 'down'} when it "
        "should point straight forward; stretch it level, hold still, then let it hang straight down"
    )
