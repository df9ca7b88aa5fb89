"""Arms whose laser meets what they point at, by Newton's method, and a puppet that wears one."""

import numpy as np

from armspan.frames import sheet_from_user, yaw_rotation
from armspan.pointing.laser import LaserSettings, laser_rays
from armspan.records import Hit
from puppet import PLACE, Puppet
from straight_arms import BODY, seen_from


def aimed(laser, targets_user):
    """Attitudes whose beams meet the targets (n, 3): the error of the meeting, taken away by Newton's method."""

    def attitude(yaw, pitch):
        c, s = np.cos(pitch), np.sin(pitch)
        return yaw_rotation(yaw) @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])

    def miss(angles, target):
        origin, direction = laser_rays(laser, BODY, attitude(*angles), None)
        reach = (target[2] - origin[2]) / direction[2]
        return (origin + reach * direction - target)[:2]

    found = []
    for target in targets_user:
        angles = np.array([np.arctan2(target[1], target[0]), 0.5])
        for _ in range(30):
            here = miss(angles, target)
            if np.abs(here).max() < 1e-10:
                break
            slope = np.stack([(miss(angles + step, target) - here) / 1e-6 for step in 1e-6 * np.eye(2)], axis=1)
            angles = angles - np.linalg.solve(slope, here)
        assert np.abs(miss(angles, target)).max() < 1e-9
        found.append(attitude(*angles))
    return np.array(found)


RADIUS = 0.02
HEIGHT = 0.045


class LaserPuppet(Puppet):
    """Brings its laser's spot onto what it points at; robots with a working receptor tell when it is on them."""

    def __init__(self, *, laser=None, working=("ash", "elm"), **changes):
        self.laser = laser or LaserSettings(receptors=("ash", "elm"))
        self.working, self.lit = set(working), set()
        super().__init__(laser=self.laser, **changes)

    def point_at(self, target):
        self._target = target
        point = (*self.robots[target], -HEIGHT) if isinstance(target, str) else (*target, 0.0)
        self.asked = aimed(self.laser, seen_from(np.array([point]), *PLACE))[0]

    def shine(self, xy):
        """Bring the spot to a place (x, y) at the height of the robots' lights."""
        self._target = None
        self.asked = aimed(self.laser, seen_from(np.array([(*xy, -HEIGHT)]), *PLACE))[0]

    def step(self):
        made = super().step()
        before = len(self.outputs)
        lit = {robot for robot in self.working if self.spot_on(robot)}
        for robot in sorted(lit ^ self.lit):
            self.tell(Hit(self.t, robot, robot in lit))
        self.lit = lit
        return made + self.outputs[before:]

    def spot_on(self, robot):
        """Whether the beam meets the top of a robot."""
        origin, direction = laser_rays(self.laser, BODY, self.attitude, None)
        place = sheet_from_user(*PLACE)
        start, way = place.points(origin), place.directions(direction)
        if way[2] <= 0.0:
            return False
        at = start + (-HEIGHT - start[2]) / way[2] * way
        return float(np.hypot(*(at[:2] - self.robots[robot]))) < RADIUS
