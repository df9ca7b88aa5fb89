"""What robots may do at most, whoever asks."""

import math

import msgspec

from armspan.errors import ConfigError


class Limits(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The caps that the last filter keeps.

    ``speed_m_s``: Cellulo's motors saturate near 0.15. ``lease_s`` is how long a motion command stays valid
    and ``lead_m`` how far ahead of the robot a position goal may lie: a robot whose commands stop coming rests
    within it.
    ``body_radius_m`` is the robot's own, ``gap_m`` what stays free between two bodies.
    ``accel_m_s2`` caps how fast a wanted velocity changes (a stop is not held back). ``latency_s`` is the longest that
    a command is expected to take to a robot, or a state from it. Below ``battery`` (a share) a robot is stopped.
    """

    speed_m_s: float = 0.15
    accel_m_s2: float = 1.0
    latency_s: float = 0.05
    battery: float = 0.05
    lease_s: float = 0.3
    lead_m: float = 0.045
    body_radius_m: float = 0.045
    gap_m: float = 0.01

    def __post_init__(self) -> None:
        for name, most in (
            ("speed_m_s", 0.3),
            ("accel_m_s2", 10.0),
            ("lease_s", 0.3),
            ("lead_m", 0.06),
            ("body_radius_m", 0.5),
            ("gap_m", 0.5),
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0 < value <= most):
                raise ConfigError(f"limits.{name} is {value}; expected more than 0 and at most {most}")
        for name, most in (("latency_s", 0.5), ("battery", 1.0)):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0 <= value <= most):
                raise ConfigError(f"limits.{name} is {value}; expected 0 to {most}")

    @property
    def spacing_m(self) -> float:
        """The distance between two robots' centres [m] at which neither gives way to the other."""
        return 2 * (self.body_radius_m + self.speed_m_s * self.latency_s) + self.gap_m + 0.005
