"""A band's own fusion, seen from outside: the true attitude, turned by what such a filter gets wrong."""

import numpy as np

from armspan.frames import Array
from armspan.records import Quaternion
from armspan.simulation.band_traits import BandTraits
from armspan.simulation.inertial import GRAVITY, Motion


class OnboardFusion:
    """The errors of one filter that gets a sample every ``period`` [s] from ``start`` [s] on."""

    def __init__(self, traits: BandTraits, period: float, start: float) -> None:
        self._traits, self._start = traits, start
        self._share = period / traits.settling if traits.settling else 0.0
        self._shaken = (0.0, 0.0)

    def quaternions(self, felt: Motion, yaw: Array, tilt: Array, times: Array) -> list[Quaternion]:
        """``earth_from_sensor`` (w, x, y, z) at the next ``times`` (m,) [s] in a row.

        ``yaw`` (m,) and ``tilt`` (2, m) [rad] are errors besides the drift and the motion's.
        """
        traits = self._traits
        half = (traits.heading + traits.yaw_drift * (times - self._start) + yaw) / 2.0
        ahead, left = (tilt + self._misled(felt.acceleration)) / 2.0
        # Yaw after a small tilt, as one quaternion, whose length is put right at the end.
        c, s = np.cos(half), np.sin(half)
        error = (c, c * ahead - s * left, c * left + s * ahead, s)
        wxyz = _product(error, _quaternion(felt.room_from_sensor))
        wxyz /= np.sqrt((wxyz * wxyz).sum(axis=0))
        return [(w, x, y, z) for w, x, y, z in wxyz.T.astype(np.float32).tolist()]

    def _misled(self, acceleration: Array) -> Array:
        """Tilts (2, m) [rad] of a filter that takes the mean felt force of some seconds for the vertical."""
        x, y = self._shaken
        tilts: list[tuple[float, float]] = []
        for ahead, left in (acceleration[:, :2] / GRAVITY).tolist():
            # The believed vertical leans with the acceleration a; the turn that sets it upright is a × z.
            x, y = x + self._share * (left - x), y + self._share * (-ahead - y)
            tilts.append((x, y))
        self._shaken = (x, y)
        return np.array(tilts).T


def _product(left: tuple[Array, Array, Array, Array], right: Array) -> Array:
    """Quaternion products (4, m)."""
    (a, b, c, d), (w, x, y, z) = left, right
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def _quaternion(rotations: Array) -> Array:
    """Unit quaternions (4, m), up to their sign, of rotations (m, 3, 3).

    Four times the outer product of the quaternion with itself is linear in the matrix; its row with the
    greatest diagonal is the quaternion times its greatest component.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotations.transpose(1, 2, 0)
    products = np.array(
        [
            [1.0 + xx + yy + zz, zy - yz, xz - zx, yx - xy],
            [zy - yz, 1.0 + xx - yy - zz, yx + xy, xz + zx],
            [xz - zx, yx + xy, 1.0 - xx + yy - zz, zy + yz],
            [yx - xy, xz + zx, zy + yz, 1.0 - xx - yy + zz],
        ]
    )
    greatest = products[[0, 1, 2, 3], [0, 1, 2, 3]].argmax(axis=0)
    row = products[greatest, :, np.arange(len(greatest))].T
    return np.asarray(row / np.sqrt((row * row).sum(axis=0)))
