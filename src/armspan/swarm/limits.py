"""What robots may do at most, whoever asks."""

import math

import msgspec

from armspan.errors import ConfigError


class Limits(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The caps that the last filter keeps.

    ``speed_m_s``: Cellulo's motors saturate near 0.15. ``lease_s`` is how long a motion command stays valid
    and ``lead_m`` how far ahead of the robot a position goal may lie: a robot whose commands stop coming rests
    within it.
    ``body_radius_m`` is the robot's own, ``gap_m`` what stays free between two bodies or a body and the edge.
    """

    speed_m_s: float = 0.15
    lease_s: float = 0.3
    lead_m: float = 0.045
    body_radius_m: float = 0.045
    gap_m: float = 0.01

    def __post_init__(self) -> None:
        for name, most in (
            ("speed_m_s", 0.3),
            ("lease_s", 0.3),
            ("lead_m", 0.06),
            ("body_radius_m", 0.5),
            ("gap_m", 0.5),
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0 < value <= most):
                raise ConfigError(f"limits.{name} is {value}; expected more than 0 and at most {most}")
