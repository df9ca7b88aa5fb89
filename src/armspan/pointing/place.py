"""The user's place while it is used: ``sheet_from_user`` with its drift, refined by every confirmed selection.

A band's heading drifts by 1 to 3.5 degrees a minute. A heading error turns whole rays about the vertical
through the eye, which is the user frame's z axis: in (x, y, z, yaw) it is a change of yaw alone. So the
place is a Kalman filter over (x, y, z, yaw, rate of yaw), started by the calibration, that a confirmed
selection updates with the angle between the ray and the thing chosen.
"""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from armspan.frames import SHEET_FLIP, Array, Transform, sheet_from_user, yaw_rotation
from armspan.pointing.field import MissField
from armspan.records import Calibrated

DRIFT_RATE = np.radians(2.0) / 60
"""Standard deviation [rad/s] of a band's heading drift before anything is known of it."""

SWAY_RATE = 0.01**2 / 60
"""Growth [m²/s] of the variance of where the user stands: a centimetre in a minute."""

_GATE = 9.21
"""Squared Mahalanobis distance (two axes, 99 %) beyond which a selection does not move the place."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaceNow:
    """``sheet_from_user`` at one moment: ``xyz`` (3,) [m], ``yaw`` [rad], ``covariance`` (4, 4), ``sigma`` [rad]."""

    xyz: Array
    yaw: float
    covariance: Array
    sigma: float

    def transform(self) -> Transform:
        """``sheet_from_user``."""
        return sheet_from_user(self.xyz, self.yaw)


@dataclass(slots=True)
class Place:
    """``sheet_from_user`` at time ``t`` [s], with ``state`` (x, y, z, yaw, yaw rate) and ``covariance`` (5, 5).

    ``sigma`` [rad] is the pointing noise per axis of this person, known with ``dof`` degrees of freedom: the
    calibration begins it, and every confirmed robot says more.
    """

    source: str
    t: float
    state: Array
    covariance: Array
    sigma: float
    rms: float
    pairs: int
    dof: float = 8.0
    field: MissField = dataclasses.field(default_factory=MissField)

    @classmethod
    def from_calibration(cls, found: Calibrated, assumed: float = 4.0, drift_rate: float = DRIFT_RATE) -> "Place":
        """Start from a calibration whose noise was assumed with a worth of ``assumed`` degrees of freedom.

        ``drift_rate`` [rad/s] is the heading's expected drift.
        """
        covariance = np.zeros((5, 5))
        covariance[:4, :4] = np.reshape(found.covariance, (4, 4))
        covariance[4, 4] = drift_rate**2
        state = np.array([*found.xyz, found.yaw, 0.0])
        dof = assumed + max(0.0, 2.0 * found.pairs - 4.0)
        return cls(found.source, found.t, state, covariance, found.sigma, found.rms, found.pairs, dof)

    def advance(self, t: float) -> None:
        """Let the time pass: the heading drifts at its rate, and all grows less certain."""
        dt = t - self.t
        if dt <= 0:
            return
        flow = np.eye(5)
        flow[3, 4] = dt
        self.state = flow @ self.state
        self.covariance = flow @ self.covariance @ flow.T
        self.covariance[0, 0] += SWAY_RATE * dt
        self.covariance[1, 1] += SWAY_RATE * dt
        self.t = t

    def confirm(
        self, origin_user: Array, direction_user: Array, point_sheet: Array, extent: Array | None = None
    ) -> bool:
        """Learn from a selection: a ray (3,), (3,) that was meant for a point (3,) [m] in ``sheet``.

        ``extent`` (2, 2) [m²] is the covariance of a wide target's points about its middle. False, and
        nothing learnt, when the ray misses the point by more than chance allows (99 %).
        """
        # The filter takes the whole miss: a drift must not hide in the field, which learns only what is left.
        residual, slope = self._miss(origin_user, direction_user, point_sheet)
        noise = self.sigma**2 * np.eye(2)
        if extent is not None:
            noise += slope[:, :2] @ extent @ slope[:, :2].T
        spread = slope @ self.covariance @ slope.T + noise
        surprise = float(residual @ np.linalg.solve(spread, residual))
        if surprise > _GATE:
            return False
        gain = np.linalg.solve(spread, slope @ self.covariance).T
        self.state = self.state - gain @ residual
        keep = np.eye(5) - gain @ slope  # Joseph's form keeps the covariance symmetric and positive
        self.covariance = keep @ self.covariance @ keep.T + gain @ noise @ gain.T
        left, _ = self._miss(origin_user, direction_user, point_sheet)
        self.field.learn(direction_user, left, 0.5 * float(np.trace(noise)) / self.sigma**2 - 1.0)
        if extent is None:
            self._rescale(surprise)
        return True

    def aimed(self, direction_user: Array) -> tuple[Array, float]:
        """Where a ray (3,) of this person is meant to go, (3,), and the noise per axis [rad] that is left."""
        expected, stays = self.field.at(direction_user)
        meant = direction_user + expected @ _tangent(direction_user)
        return np.asarray(meant / np.linalg.norm(meant)), self.sigma * float(np.sqrt(stays))

    def _rescale(self, surprise: float) -> None:
        """Draw noise and covariance toward the misses seen: with an unknown scale both share it.

        The posterior mean of a scaled inverse chi-squared variance after two more squared residuals whose
        sum, in units of what was expected, is ``surprise``. The drift's own prior has its own scale.
        """
        factor = (self.dof + surprise) / (self.dof + 2.0)
        self.dof += 2.0
        self.sigma *= float(np.sqrt(factor))
        scale = np.array([*[np.sqrt(factor)] * 4, 1.0])
        self.covariance = self.covariance * np.outer(scale, scale)

    def _miss(self, origin: Array, direction: Array, point: Array) -> tuple[Array, Array]:
        """The miss angles (2,) [rad] in the ray's tangent plane and their slope (2, 5) over the state."""
        turn = yaw_rotation(float(self.state[3]))
        seen = turn.T @ (SHEET_FLIP @ (point - self.state[:3])) - origin
        reach = float(np.linalg.norm(seen))
        basis = _tangent(direction)
        slope_seen = np.zeros((3, 5))
        slope_seen[:, :3] = -turn.T @ SHEET_FLIP
        from_axis = seen + origin
        slope_seen[:, 3] = [from_axis[1], -from_axis[0], 0.0]
        return basis @ seen / reach, basis @ slope_seen / reach

    def now(self, sigma: float | None = None) -> PlaceNow:
        """The place at the time it was last advanced to, for rays of a noise ``sigma`` [rad] or the usual one."""
        noise = self.sigma if sigma is None else sigma
        return PlaceNow(self.state[:3], float(self.state[3]), self.covariance[:4, :4], noise)

    def calibrated(self) -> Calibrated:
        """The place as a record."""
        x, y, z, yaw, _ = (float(v) for v in self.state)
        covariance = tuple(float(v) for v in self.covariance[:4, :4].ravel())
        return Calibrated(self.t, self.source, (x, y, z), yaw, covariance, self.rms, self.sigma, self.pairs)


def _tangent(direction: Array) -> Array:
    """Two unit vectors (2, 3) across a direction: to its left and upward."""
    x, y, z = direction.tolist()
    length = math.hypot(x, y)
    a, b = (-y / length, x / length) if length > 1e-9 else (0.0, 1.0)
    return np.array([[a, b, 0.0], [-z * b, z * a, x * b - y * a]])
