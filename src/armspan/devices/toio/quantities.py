"""A toio cube's own units: places on its mats, and what a motor's speed value does.

A mat of 560 mm has 411 position IDs (toio-sdk-for-unity); a value of 8 to 115 turns a wheel of 12.5 mm at 4.3 rpm
each, less is standstill, more is 494 rpm (toio core cube specification, motor); wheels stand 26.6 mm apart.
"""

import math

from armspan.records import Vec2

UNIT_M = 0.560 / 411
"""One position ID [m]."""
WHEELS_APART_M = 0.0266
LEAST, MOST = 8, 115
"""Speed values that turn a wheel, and the one beyond which it is no faster."""
SPEED_M_S = 4.3 * math.pi * 0.0125 / 60
"""A wheel's speed [m/s] for each speed value."""
MATS: dict[str, tuple[Vec2, Vec2]] = {
    "ring": ((45.0, 45.0), (455.0, 455.0)),
    "tile": ((545.0, 45.0), (955.0, 455.0)),
    "simple": ((98.0, 142.0), (402.0, 358.0)),
}
"""Position IDs of the mats' corners: top left, bottom right."""


def speed_of(value: int) -> float:
    """A wheel's speed [m/s] at a signed speed value."""
    size = abs(value)
    return math.copysign(min(size, MOST) * SPEED_M_S, value) if size >= LEAST else 0.0


def value_of(speed: float) -> int:
    """The signed speed value whose speed is nearest to ``speed`` [m/s]."""
    exact = abs(speed) / SPEED_M_S
    size = 0 if 2 * exact < LEAST else min(max(round(exact), LEAST), MOST)
    return size if speed >= 0 else -size
