"""A person of known measures, filmed by a pinhole camera: the truth that skeletons and views must find.

World: x where the person faces, y to their left, z up [m]; the mid-ankles stand near x = y = 0.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SIZE = (1920, 1440)
FOCAL = 1800.0


def turn_about_y(degrees: float) -> Array:
    """Turns +x down toward -z for positive angles."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


@dataclass
class Person:
    stature: float = 1.75
    eye_height: float = 1.636
    forward: float = 0.117  # joint to eye
    joint_width: float = 0.36
    acromion_share: float = 0.820
    shoulder_below: float = 0.025  # the point that networks mark, under the acromion
    pupils: float = 0.063
    limbs: tuple[float, float, float] = (0.300, 0.262, 0.182)  # joint to elbow, to wrist, to index fingertip
    sole: float = 0.0
    extra: dict[str, Array] = field(default_factory=dict)

    @property
    def joint_height(self) -> float:
        return self.acromion_share * self.stature - self.shoulder_below + self.sole

    def measures(self, arm: str = "right", eye: str = "right") -> dict[str, float]:
        """The truth, from a pivot 15 mm below the acromion, 22 mm outside of the joint, 31 mm more of reach."""
        left = {"right": -1.0, "left": 1.0}
        pivot_left = left[arm] * (self.joint_width / 2 + 0.022)
        return {
            "eye height": self.eye_height + self.sole,
            "forward": self.forward,
            "left": left[eye] * self.pupils / 2 - pivot_left,
            "up": self.eye_height - (self.acromion_share * self.stature - 0.015),
            "arm length": sum(self.limbs) + 0.031,
        }

    def trunk(self) -> dict[str, Array]:
        s, ground = self.stature, self.sole
        x = 0.025 * s  # shoulders a little ahead of the ankles
        eye = x + self.forward
        points: dict[str, tuple[float, float, float]] = {
            "nose": (eye + 0.015, 0.0, self.eye_height + ground - 0.035),
            "neck": (x, 0.0, self.joint_height),
            "crown": (x + 0.06, 0.0, s + ground),
        }
        for side, left in (("l", 1.0), ("r", -1.0)):
            points |= {
                f"{side}eye": (eye, left * self.pupils / 2, self.eye_height + ground),
                f"{side}ear": (eye - 0.09, left * 0.075, self.eye_height + ground - 0.02),
                f"{side}sh": (x, left * self.joint_width / 2, self.joint_height),
                f"{side}hip": (0.5 * x, left * 0.09, 0.52 * s + ground),
                f"{side}kn": (0.4 * x, left * 0.10, 0.28 * s + ground),
                f"{side}an": (0.0, left * 0.10, 0.098 + ground),
                f"{side}heel": (-0.05, left * 0.10, 0.035 + ground),
                f"{side}toe": (0.18, left * 0.13, 0.020 + ground),
            }
        return {name: np.array(point) for name, point in points.items()}

    def arm(self, side: str, direction: Array, bend: float = 0.0) -> dict[str, Array]:
        """An arm from its joint along ``direction``; the forearm is turned down by ``bend`` degrees about y."""
        unit = direction / np.linalg.norm(direction)
        fore = turn_about_y(bend) @ unit
        upper, lower, hand = self.limbs
        elbow = self.trunk()[side + "sh"] + upper * unit
        wrist = elbow + lower * fore
        return {
            side + "el": elbow,
            side + "wr": wrist,
            side + "idxknuckle": wrist + 0.45 * hand * fore,
            side + "idxtip": wrist + hand * fore,
            side + "midtip": wrist + (hand + 0.007) * fore,
        }

    def t_pose(self) -> dict[str, Array]:
        left = np.array([0.0, 1.0, 0.0])
        return self.trunk() | self.arm("l", left) | self.arm("r", -left) | self.extra

    def pointing(self, arm: str = "right", slope: float = 10.0, bend: float = 0.0) -> dict[str, Array]:
        """The arm stretched forward, down by ``slope`` degrees, the finger before the eye; the other hangs."""
        inward = (self.joint_width - self.pupils) / 2 / sum(self.limbs)
        inward *= 1.0 if arm == "right" else -1.0
        ahead = turn_about_y(slope) @ np.array([np.sqrt(1.0 - inward**2), inward, 0.0])
        other = "l" if arm == "right" else "r"
        hanging = self.arm(other, np.array([0.0, 0.0, -1.0]))
        return self.trunk() | hanging | self.arm(arm[0], ahead, bend) | self.extra


def film(
    points: dict[str, Array],
    seen_from: str = "front",
    *,
    height: float = 1.3,
    distance: float = 5.0,
    roll: float = 0.0,
    turn: float = 0.0,
) -> dict[str, tuple[float, float, float]]:
    """Pixels of a level camera at ``height`` and ``distance`` [m], in front or at a side.

    The picture is tilted by ``roll`` and the person turned to the left by ``turn`` [degrees].
    """
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    turned = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    place = {"front": (1.0, 0.0), "back": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}[seen_from]
    camera = np.array([distance * place[0], distance * place[1], height])
    ahead = np.array([-place[0], -place[1], 0.0])
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    c, s = np.cos(np.radians(roll)), np.sin(np.radians(roll))
    pixels = {}
    for name, point in points.items():
        offset = turned @ point - camera
        x, y = FOCAL * np.array([offset @ right, -offset[2]]) / (offset @ ahead)
        pixels[name] = (SIZE[0] / 2 + c * x - s * y, SIZE[1] / 2 + s * x + c * y, 0.9)
    return pixels
