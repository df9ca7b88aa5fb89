"""An arm on strings before a conductor: it does what is said, exactly, and its robots stand where they are sent."""

import numpy as np

from armspan.conductor import BandSettings, Conductor, Settings
from armspan.frames import rotation_from_quaternion, yaw_rotation
from armspan.records import GoTo, ImuSample, Press, RobotState, Say, Sheet, Tick, Zone
from straight_arms import BODY, pointing_at, seen_from

SHEET = Sheet(0.9, 0.6)
STOPS = ((0.15, 0.12), (0.75, 0.12), (0.75, 0.48), (0.15, 0.48))
PLACE = (np.array([0.45, 0.85, 0.75]), 1.5)
"""sheet_from_user: the eye over a spot a quarter of a metre before the sheet, the floor 0.75 m below it."""

FORWARD = np.eye(3)
RAISED = np.array([[np.cos(0.5), 0.0, -np.sin(0.5)], [0.0, 1.0, 0.0], [np.sin(0.5), 0.0, np.cos(0.5)]])
HANGING = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""user_from_wrist of the arm stretched forward, raised by half a radian, and hanging: x down, y left."""

WORN = np.array([0.9, 0.1, -0.3, 0.3]) / np.sqrt(0.9**2 + 0.1**2 + 0.3**2 + 0.3**2)
HEADING = -2.0
"""How the band sits (wrist_from_sensor) and where its earth's x points: nobody knows."""


def settings(**changes):
    given = {
        "body": BODY,
        "sheet": SHEET,
        "bands": (BandSettings("wrist"),),
        "robots": ("ash", "elm"),
        "zones": (Zone("pond", ((0.1, 0.25), (0.2, 0.25), (0.2, 0.35), (0.1, 0.35))),),
        "stops": STOPS,
    }
    return Settings(**(given | changes))


class Puppet:
    """Lets a conductor run in steps of a tick; ``outputs`` is all that it decided."""

    def __init__(self, **changes):
        self.conductor = Conductor(settings(**changes))
        self.t, self.outputs = 0.0, []
        self.attitude = self.asked = HANGING
        self.robots = {"ash": (0.45, 0.3), "elm": (0.6, 0.25)}
        self.held, self.silent, self.obeys, self.restless = set(), False, True, False
        self._target = None

    def tell(self, event):
        """One event, and what comes of it."""
        outputs = self.conductor.step(event)
        self.outputs += outputs
        for output in outputs:
            if isinstance(output, Say):
                self._hear(output.cue)
            elif isinstance(output, GoTo):
                self.robots[output.robot] = output.xy
        return outputs

    def press(self, name, value=""):
        return self.tell(Press(self.t, name, value))

    def step(self):
        """A twentieth of a second: five samples, the robots' states, a tick; what was decided in it."""
        before = len(self.outputs)
        self.t = round(self.t + 0.05, 9)
        if self._target is not None:
            self.point_at(self._target)
        moving = self.restless or not np.allclose(self.attitude, self.asked, atol=1e-3)
        self.attitude = self.asked
        for k in range(5 * (not self.silent)):
            for band in self.conductor.settings.bands:
                self.tell(self._sample(self.t - 0.04 + 0.01 * k, band.name, moving))
        for name, xy in list(self.robots.items()):
            self.tell(RobotState(self.t, name, xy, 0.0, held=name in self.held))
        self.tell(Tick(self.t))
        return self.outputs[before:]

    def run(self, seconds, until=None):
        """Some time, or until a record of that type is decided; what was decided in it."""
        before, end = len(self.outputs), self.t + seconds
        while self.t < end - 1e-9:
            made = self.step()
            if until is not None and any(isinstance(record, until) for record in made):
                break
        return self.outputs[before:]

    def set_up(self):
        """Lead through the whole set-up."""
        self.press("setup")
        for _ in range(1200):
            if any(isinstance(record, Say) and record.cue == "ready" for record in self.step()):
                return self
        raise AssertionError("the set-up does not end: " + str(self.said()))

    def said(self):
        return [record.cue or record.text for record in self.outputs if isinstance(record, Say)]

    def of(self, kind):
        return [record for record in self.outputs if isinstance(record, kind)]

    def point_at(self, target):
        """Point at a robot's light by its name, or at a place (x, y) on the sheet; it is followed."""
        self._target = target
        point = (*self.robots[target], -0.045) if isinstance(target, str) else (*target, 0.0)
        self.asked = pointing_at(seen_from(np.array([point]), *PLACE))[0]

    def pose(self, attitude):
        self._target, self.asked = None, attitude

    def _hear(self, cue):
        verb, _, thing = cue.partition(":")
        if not self.obeys:
            return
        if verb == "stretch":
            self.pose(FORWARD)
        elif verb == "hang":
            self.pose(HANGING)
        elif verb == "point":
            self.point_at(thing)

    def _sample(self, t, band, moving):
        earth_from_sensor = yaw_rotation(HEADING) @ self.attitude @ rotation_from_quaternion(WORN)
        rate = (3.0 if moving else 0.05, 0.0, 0.0)
        return ImuSample(t, band, tuple(9.81 * earth_from_sensor[2]), rate, None, quaternion(earth_from_sensor))


def quaternion(rotation):
    """The unit quaternion (w, x, y, z) of a rotation matrix, from its largest component."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    squares = np.array([1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i])
    k = int(np.argmax(squares))
    rows = [
        [squares[0], h - f, c - g, d - b],
        [h - f, squares[1], b + d, c + g],
        [c - g, b + d, squares[2], f + h],
        [d - b, c + g, f + h, squares[3]],
    ]
    return tuple(float(v) for v in np.array(rows[k]) / (2 * np.sqrt(squares[k])))
