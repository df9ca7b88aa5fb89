"""A laser on the wrist: its ray, and what a receptor that sees its spot is worth.

The visible spot closes the loop by the user's own eye (Gromov et al., ICRA 2019: 0.5 m without, nearly nothing with
it), and it goes along the forearm whatever the elbow does: so the ray of such a room is that of the laser, and the
line from eye to fingertip does not matter.
"""

import math

import msgspec
import numpy as np

from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import Body, Vec2, Vec3

HAND_SHARE = 0.245
"""Length of the hand as a share of shoulder to fingertip (Drillis and Contini 1966: 0.108 of 0.44 of the stature)."""

_FARTHEST_M = 0.3
_WIDEST_DEG = 60.0


class LaserSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How the laser sits, and how far receptors can be believed.

    ``position_m`` is where the beam begins in ``wrist`` (along the forearm to the hand, to the left, out of the back of
    the hand), ``direction_deg`` how far it goes to the left of the forearm and above it: by default the laser hangs
    below the wrist and shines 12 degrees down, about where fingers point. ``receptors`` names the robots that have one.
    ``false_hit`` is the share of time in which one sees a light that is not the laser's or not meant, ``missed`` the
    share of time in which a robot that is meant is not hit, the way there included. A robot that is hit for ``dwell_s``
    is chosen; it can be chosen by a new hit when it was dark for ``release_s``.
    """

    position_m: Vec3 = (0.0, 0.0, -0.03)
    direction_deg: Vec2 = (0.0, -12.0)
    receptors: tuple[str, ...] = ()
    false_hit: float = 0.001
    missed: float = 0.3
    dwell_s: float = 0.3
    release_s: float = 0.5

    def __post_init__(self) -> None:
        for name, chance in (("false_hit", self.false_hit), ("missed", self.missed)):
            if not 1e-6 <= chance <= 0.5:
                raise ConfigError(f"laser.{name} is {chance}; it is a probability, expected from 1e-6 to 0.5")
        if not 0.1 <= self.dwell_s <= 2.0:
            raise ConfigError(f"laser.dwell_s is {self.dwell_s}; expected 0.1 to 2 s, and 0.3 is a good start")
        if not 0.0 <= self.release_s <= 5.0:
            raise ConfigError(f"laser.release_s is {self.release_s}; expected 0 to 5 s, and 0.5 is a good start")
        if not all(abs(part) <= _FARTHEST_M for part in self.position_m):
            raise ConfigError(
                f"laser.position_m is {list(self.position_m)}; expected metres from the wrist, each up to {_FARTHEST_M}"
            )
        if not all(abs(angle) <= _WIDEST_DEG for angle in self.direction_deg):
            raise ConfigError(
                f"laser.direction_deg is {list(self.direction_deg)}; expected degrees to the left of the forearm and "
                f"above it, each within {_WIDEST_DEG:g}"
            )

    def direction_wrist(self) -> Array:
        """The beam's unit direction (3,) in ``wrist``."""
        left, up = (math.radians(angle) for angle in self.direction_deg)
        return np.array([math.cos(up) * math.cos(left), math.cos(up) * math.sin(left), math.sin(up)])

    def odds(self, on: bool) -> float:
        """How much likelier it is that a receptor sees light, or sees none, when its robot is meant than when not."""
        return (1.0 - self.missed) / self.false_hit if on else self.missed / (1.0 - self.false_hit)


def laser_rays(
    laser: LaserSettings, body: Body, user_from_forearm: Array, user_from_upperarm: Array | None
) -> tuple[Array, Array]:
    """Origins [m] and unit directions (..., 3) in ``user`` of the laser's beam, as `arm_rays` of ``forearm``.

    Attitudes are (..., 3, 3). The wrist lies at the end of a straight arm; where the upper arm is felt and both lengths
    are known, at the end of the arm as it is bent.
    """
    shoulder = np.array([0.0, 0.0, body.eye_height_m]) - np.asarray(body.shoulder_to_eye_m)
    hand, whole, along = HAND_SHARE * body.shoulder_to_fingertip_m, body.shoulder_to_fingertip_m, user_from_forearm
    wrist = shoulder + (whole - hand) * along[..., :, 0]
    if user_from_upperarm is not None and body.upper_arm_m is not None and body.elbow_to_fingertip_m is not None:
        elbow = shoulder + body.upper_arm_m * user_from_upperarm[..., :, 0]
        wrist = elbow + (body.elbow_to_fingertip_m - hand) * along[..., :, 0]
    return wrist + along @ np.asarray(laser.position_m), along @ laser.direction_wrist()
