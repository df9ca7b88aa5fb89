"""What a phone's sensors can say, and what no sensor says."""

import math
from collections.abc import Sequence

from armspan.errors import DeviceError
from armspan.records import Quaternion, Vec3

GRAVITY = 9.80665
STRONGEST = 50.0 * GRAVITY
"""[m/s²]: three times the widest range of the accelerometers in phones."""
FASTEST = 100.0
"""[rad/s]: three times the widest range of their gyroscopes, 2000 deg/s."""
_OFF_UNIT = 0.1


def vector(values: Sequence[float], what: str, most: float) -> Vec3:
    """Three numbers of a sensor, none beyond ``most`` (DeviceError)."""
    if len(values) != 3 or not all(math.isfinite(value) and abs(value) <= most for value in values):
        raise DeviceError(f"{what} is {_shown(values)}; expected three numbers up to {most:.0f}")
    x, y, z = values
    return (float(x), float(y), float(z))


def quaternion(w: float, x: float, y: float, z: float) -> Quaternion:
    """A unit quaternion (w, x, y, z), from one of nearly that length (DeviceError)."""
    length = math.hypot(w, x, y, z)
    if not abs(length - 1.0) <= _OFF_UNIT:
        raise DeviceError(f"the attitude is {_shown((w, x, y, z))} of length {length:.3f}; expected length 1")
    return (w / length, x / length, y / length, z / length)


def _shown(values: Sequence[float]) -> str:
    return str([round(value, 3) if math.isfinite(value) else value for value in values[:4]])


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The quaternion of the turn ``b`` followed by ``a``."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def turned(attitude: Quaternion, gyr: Vec3, seconds: float) -> Quaternion:
    """``earth_from_sensor`` after turning at ``gyr`` [rad/s, in sensor] for some seconds, which may be negative."""
    rate = math.hypot(*gyr)
    half = 0.5 * rate * seconds
    if abs(half) < 1e-12:
        return attitude
    share = math.sin(half) / rate
    return product(attitude, (math.cos(half), gyr[0] * share, gyr[1] * share, gyr[2] * share))


def quaternion_from_angles(alpha_deg: float, beta_deg: float, gamma_deg: float) -> Quaternion:
    """``earth_from_sensor`` from a browser's three angles.

    They turn about z, then about the turned x, then about the twice turned y (W3C, Device Orientation and Motion,
    section 'Device orientation model').
    """
    z, x, y = (math.radians(angle) / 2.0 for angle in (alpha_deg, beta_deg, gamma_deg))
    turn = product((math.cos(z), 0.0, 0.0, math.sin(z)), (math.cos(x), math.sin(x), 0.0, 0.0))
    return product(turn, (math.cos(y), 0.0, math.sin(y), 0.0))


def up(attitude: Quaternion) -> Vec3:
    """The upward direction of earth, in ``sensor``."""
    w, x, y, z = attitude
    return (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z)


def between(a: Sequence[float], b: Sequence[float], share: float) -> tuple[float, ...]:
    """Numbers a ``share`` of the way from ``a`` to ``b``."""
    return tuple(p + share * (q - p) for p, q in zip(a, b, strict=True))


def attitude_between(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    """The attitude a ``share`` of the way from ``a`` to ``b``, which are close to each other."""
    if sum(p * q for p, q in zip(a, b, strict=True)) < 0.0:
        b = (-b[0], -b[1], -b[2], -b[3])
    w, x, y, z = between(a, b, share)
    length = math.hypot(w, x, y, z)
    return (w / length, x / length, y / length, z / length)
