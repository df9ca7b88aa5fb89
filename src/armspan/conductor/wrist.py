"""One sample of a band that has been set up, as the ten columns of a take, in plain floats: it is asked per sample."""

import math
from functools import lru_cache
from typing import TypeAlias

from scipy.spatial.transform import Rotation

from armspan.conductor.arm import Band
from armspan.orientation import Mount
from armspan.records import ImuSample, Quaternion, Vec3

Row: TypeAlias = tuple[float, float, float, float, float, float, float, float, float, float]

WRIST = ("qx", "qy", "qz", "qw", "ax", "ay", "az", "gx", "gy", "gz")
"""The columns, without the band's name before them."""

GRAVITY = 9.80665


def wrist_row(band: Band, sample: ImuSample) -> Row | None:
    """A take's columns for a sample that ``band`` has just felt, or None before the set-up.

    Attitude ``user_from_wrist`` (x, y, z, w); linear acceleration without gravity [m/s²] and rate [rad/s] in ``user``.
    The quaternion's sign is that with w >= 0.
    """
    quaternion = band.quaternion()
    if band.mount is None or quaternion is None:
        return None
    turn, sensor_from_wrist = _turns(band.mount)
    user_from_sensor = _product(turn, quaternion)
    w, x, y, z = _product(user_from_sensor, sensor_from_wrist)
    sign = -1.0 if w < 0 else 1.0
    ax, ay, az = _rotated(user_from_sensor, sample.acc)
    return (sign * x, sign * y, sign * z, sign * w, ax, ay, az - GRAVITY, *_rotated(user_from_sensor, sample.gyr))


@lru_cache(maxsize=16)
def _turns(mount: Mount) -> tuple[Quaternion, Quaternion]:
    """``user_from_earth`` and ``sensor_from_wrist`` (w, x, y, z) of a mounting."""
    w, x, y, z = Rotation.from_matrix(mount.wrist_from_sensor.T).as_quat(scalar_first=True).tolist()
    half = -mount.heading / 2
    return (math.cos(half), 0.0, 0.0, math.sin(half)), (w, x, y, z)


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def _rotated(q: Quaternion, v: Vec3) -> Vec3:
    w, x, y, z = q
    a, b, c = v
    tx, ty, tz = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return (
        a + w * tx + y * tz - z * ty,
        b + w * ty + z * tx - x * tz,
        c + w * tz + x * ty - y * tx,
    )
