"""The set-up: heading and mounting from two poses, then the stops of one robot that place the user."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from armspan.conductor.arm import Arm
from armspan.conductor.hits import Hits
from armspan.conductor.settings import Settings
from armspan.errors import CalibrationError
from armspan.frames import Array, rotation_from_quaternion
from armspan.orientation import Hold, mount_from_forward, mount_from_poses
from armspan.pointing.calibration import HIDDEN, NATURAL, STRAIGHT, Fit, Noise, calibrate, quality
from armspan.pointing.pairs import Pairs, still_pairs
from armspan.pointing.priors import PITCH_SD, TABLE_SD, Priors
from armspan.pointing.rays import default_model
from armspan.pointing.stops import StopPairs
from armspan.records import Calibrated, Model, Output, RobotState, Say, Vec2
from armspan.swarm.errands import Errands

_PATIENCE = 12.0
_REST = 0.002
RESTED = 4.0
"""Seconds of rest in which VQF finds a raw gyroscope's offset: without, the heading drifts by 2 to 19 deg/min."""

ENOUGH = 3
"""Stops from which a place can be fitted."""

HANGING: Array = np.array([0.0, 0.0, -1.0])


class Step(Enum):
    """Where the set-up stands."""

    IDLE = "idle"
    REST = "rest"
    STRETCH = "stretch"
    HANG = "hang"
    DRIVE = "drive"
    POINT = "point"


@dataclass(slots=True)
class SetUp:
    """Leads a person from strapping the bands on to a known place; ``tick`` does one step of it."""

    settings: Settings
    arm: Arm
    errands: Errands
    hits: Hits | None = None
    step: Step = Step.IDLE
    model: Model = "head-finger"
    fit: Fit | None = None
    draft: Fit | None = None
    asked: float = 0.0
    _holds: dict[str, Hold] = field(default_factory=dict)
    _forward: dict[str, Array] = field(default_factory=dict)
    _stop: int = 0
    _pairs: dict[int, StopPairs] = field(default_factory=dict)
    _done: set[int] = field(default_factory=set)
    _home: Vec2 | None = None
    _rest: tuple[Vec2, float] = ((np.inf, np.inf), 0.0)
    _unlit: bool = False
    _last: int = -1

    @property
    def robot(self) -> str:
        """The robot that drives to the stops: the first of the room."""
        return self.settings.robots[0]

    @property
    def _arms(self) -> str:
        return "both arms" if self.arm.both else "your arm"

    def begin(self, t: float) -> list[Output]:
        """Start, or start again."""
        self._stop, self._home, self._unlit = 0, None, False
        self._pairs.clear()
        self._done.clear()
        self.draft = None
        usual: Model = "forearm" if self.settings.beam else default_model(self.settings.body, self._two_bands)
        self.model = self.settings.model or usual
        if len(self.settings.stops) < 3 or not self.settings.robots:
            self.step = Step.IDLE
            return [
                Say(
                    t,
                    "The set-up needs a robot and three stops at least: name them in the room file",
                    "trouble",
                )
            ]
        if any(band.raw for band in self.arm.bands):
            asked = self._ask(t, Step.REST, f"Rest {self._arms} on your lap or the table, quite still", "rest")
            self._holds = {band.settings.name: Hold(needed=RESTED) for band in self.arm.bands}
            return asked
        return self._ask_to_stretch(t)

    def _ask_to_stretch(self, t: float) -> list[Output]:
        return self._ask(
            t, Step.STRETCH, f"Stretch {self._arms} straight forward, level, palm down, and hold still", "stretch"
        )

    def again(self, t: float, number: int) -> list[Output]:
        """Take one stop (from 1) anew and keep the others, as long as the bands' headings hold."""
        if self.fit is None or self.step is not Step.IDLE or any(band.mount is None for band in self.arm.bands):
            return [Say(t, "There is no finished set-up whose stop could be taken again", "trouble")]
        if not 1 <= number <= len(self.settings.stops):
            return [Say(t, f"Stop {number} is none; there are stops 1 to {len(self.settings.stops)}", "trouble")]
        self._done.discard(number - 1)
        return self._next_stop(t)

    @property
    def progress(self) -> tuple[int, int]:
        """The stop (from 1) that the user is led to, and how many there are."""
        return self._stop + 1, len(self.settings.stops)

    def cancel(self) -> None:
        """Give up, for instance after a stop."""
        self.step = Step.IDLE

    def tick(self, t: float, states: Mapping[str, RobotState]) -> list[Output]:
        """Take what the arm and the robots do at ``t`` [s]; the last step gives `Calibrated`."""
        steps: dict[Step, Callable[[float, Mapping[str, RobotState]], list[Output]]] = {
            Step.REST: self._rest_first,
            Step.STRETCH: self._stretch,
            Step.HANG: self._hang,
            Step.DRIVE: self._drive,
            Step.POINT: self._point,
        }
        if self.step not in steps:
            return []
        silent = self.arm.any_silent(t)
        if silent:
            return self._remind(t, f"Nothing is heard of {' and '.join(silent)}: is the band on and near?", "band")
        outputs = steps[self.step](t, states)
        return outputs or self._remind(t, "", "")

    def _ask(self, t: float, step: Step, text: str, cue: str) -> list[Output]:
        self.step, self.asked = step, t
        self._holds = {band.settings.name: Hold() for band in self.arm.bands}
        return [Say(t, text, cue)]

    def _remind(self, t: float, text: str, cue: str) -> list[Output]:
        """Say again what is needed when nothing has come of it for a while."""
        if t - self.asked < _PATIENCE:
            return []
        self.asked = t
        if self.step is Step.POINT and self._awaits_light and self.hits and not self.hits.heard(self.robot):
            self._unlit = True
            return [Say(t, f"The receptor of {self.robot} sees nothing: this goes on without it", "")]
        if cue == "band":
            return [Say(t, text, "")]
        moves = ": the bands feel it move" if self.arm.any_moving else ""
        again = {
            Step.REST: (f"Rest {self._arms} on something, quite still", "rest"),
            Step.STRETCH: (f"Stretch {self._arms} straight forward and hold still{moves}", "stretch"),
            Step.HANG: (f"Let {self._arms} hang straight down and hold still{moves}", "hang"),
            Step.DRIVE: (f"{self.robot} does not reach its stop: is it on the sheet, and the way free?", ""),
            Step.POINT: (f"{self._point_at} and hold still", f"point:{self.robot}"),
        }
        return [Say(t, *again[self.step])]

    def _held(self, t: float) -> bool:
        """Whether all bands have held the pose that was asked for."""
        done = []
        for band in self.arm.bands:
            quaternion = band.quaternion()
            hold = self._holds[band.settings.name]
            done.append(quaternion is not None and hold.add(t, quaternion, self.arm.any_moving or t < self.asked + 0.8))
        return all(done)

    def _rest_first(self, t: float, states: Mapping[str, RobotState]) -> list[Output]:
        return self._ask_to_stretch(t) if self._held(t) else []

    def _stretch(self, t: float, states: Mapping[str, RobotState]) -> list[Output]:
        if not self._held(t):
            return []
        self._forward = {name: hold.rotations() for name, hold in self._holds.items()}
        if all(band.settings.wrist_from_sensor for band in self.arm.bands):
            return self._mount(t, states, None)
        return self._ask(t, Step.HANG, f"Now let {self._arms} hang straight down, and hold still", "hang")

    def _hang(self, t: float, states: Mapping[str, RobotState]) -> list[Output]:
        if not self._held(t):
            return []
        return self._mount(t, states, {name: hold.rotations() for name, hold in self._holds.items()})

    def _mount(self, t: float, states: Mapping[str, RobotState], hanging: dict[str, Array] | None) -> list[Output]:
        try:
            for name, band in self.arm.by_name.items():
                known = band.settings.wrist_from_sensor
                if known is not None:
                    band.mount = mount_from_forward(self._forward[name], rotation_from_quaternion(known))
                elif hanging is not None:
                    band.mount = mount_from_poses(self._forward[name], hanging[name])
        except CalibrationError as error:
            return self._ask(t, Step.STRETCH, f"Once more, please: {error}", "stretch")
        home = states.get(self.robot)
        self._home = home.xy if home else None
        return self._next_stop(t)

    def _next_stop(self, t: float) -> list[Output]:
        self._stop = min(set(range(len(self.settings.stops))) - self._done)
        self.errands.send(self.robot, self.settings.stops[self._stop])
        self.step, self.asked = Step.DRIVE, t
        count = f"({self._stop + 1} of {len(self.settings.stops)})"
        return [Say(t, f"{self._point_at} and follow it {count}", f"point:{self.robot}")]

    def _drive(self, t: float, states: Mapping[str, RobotState]) -> list[Output]:
        if self.robot not in self.errands.goals:
            before = self._pairs.get(self._last) if self._last != self._stop else None
            self._pairs[self._stop] = StopPairs(before.direction if before and before.forearms else HANGING)
            self.step, self.asked = Step.POINT, t
        return []

    def _point(self, t: float, states: Mapping[str, RobotState]) -> list[Output]:
        forearm, state = self.arm.forearm.in_user(), states.get(self.robot)
        if forearm is None or state is None:
            return []
        upperarm = self.arm.upperarm.in_user() if self.arm.upperarm else None
        still = not self.arm.moving and self._robot_rests(t, state) and not state.held
        still = still and (not self._awaits_light or self.hits is None or self.hits.sees(t, self.robot))
        if not self._pairs[self._stop].add(t, forearm, upperarm, state.xy, still):
            return []
        self._done.add(self._stop)
        self._last = self._stop
        if len(self._done) < len(self.settings.stops):
            self._try()
            return self._next_stop(t)
        return self._finish(t)

    @property
    def _two_bands(self) -> bool:
        return self.arm.upperarm is not None

    @property
    def _point_at(self) -> str:
        return f"{'Bring the spot onto' if self.settings.beam else 'Point at'} the light of {self.robot}"

    @property
    def _awaits_light(self) -> bool:
        """Whether a stop counts only while the robot is hit: not where nothing was ever seen by its receptor."""
        beam = self.settings.beam
        return beam is not None and self.robot in beam.receptors and not self._unlit

    def _robot_rests(self, t: float, state: RobotState) -> bool:
        xy, since = self._rest
        if np.hypot(state.xy[0] - xy[0], state.xy[1] - xy[1]) > _REST:
            self._rest = (state.xy, t)
            return False
        return t - since >= 0.2

    def _finish(self, t: float) -> list[Output]:
        self.step = Step.IDLE
        if self._home is not None:
            self.errands.send(self.robot, self._home)
        try:
            fit = self._fit()
        except CalibrationError as error:
            return [Say(t, f"That did not work out: {error}", "trouble"), *self.begin(t)]
        self.fit = self.draft = fit
        found = Calibrated(
            t,
            self.arm.forearm.settings.name,
            (float(fit.xyz[0]), float(fit.xyz[1]), float(fit.xyz[2])),
            float(fit.yaw),
            tuple(float(v) for v in np.ravel(fit.covariance)),
            float(fit.rms),
            float(fit.sigma),
            sum(stop.used for stop in fit.stops),
        )
        return [found, Say(t, verdict(fit), "ready")]

    def _try(self) -> None:
        """Fit the stops so far, where they are enough, to show how well each goes with the others."""
        if len(self._done) >= ENOUGH:
            try:
                self.draft = self._fit()
            except CalibrationError:
                self.draft = None

    def _fit(self) -> Fit:
        """The place from all stops, and what the arm needs beside it."""
        height = self.settings.table_height_m
        bent = self.settings.posture == "natural" and not self._elbow_seen
        plane = None if height is None or bent else (height, TABLE_SD)  # an unseen elbow hides in the height
        priors = Priors(plane, PITCH_SD, self.settings.body.covariance is not None)
        body, pairs, beam = self.settings.body, self._all_pairs(), self.settings.beam
        return calibrate(body, pairs, self.model, noise=self.noise(), priors=priors, laser=beam)

    def noise(self) -> Noise:
        """What is expected of the user before the pairs say more."""
        if self.settings.posture == "straight" or self._elbow_seen:
            return STRAIGHT
        return HIDDEN if self.settings.beam else NATURAL

    @property
    def _elbow_seen(self) -> bool:
        return self.model == "two-band" or (self.settings.beam is not None and self._two_bands)

    def _all_pairs(self) -> Pairs:
        """What was collected, with every point at the height of the robot's light."""
        stops = [self._pairs[number] for number in sorted(self._done)]
        names = [str(number + 1) for number in sorted(self._done) for _ in self._pairs[number].points]
        points = np.array([(*xy, -self.settings.light_height_m) for stop in stops for xy in stop.points])
        forearms = np.array([attitude for stop in stops for attitude in stop.forearms])
        upperarms = np.array([attitude for stop in stops for attitude in stop.upperarms])
        return still_pairs(forearms, upperarms if self.arm.upperarm else None, points, tuple(names))


def verdict(fit: Fit) -> str:
    """The quality of a calibration in plain words."""
    left_out = [stop.stop for stop in fit.stops if not stop.used]
    worst = max((stop for stop in fit.stops if stop.used), key=lambda stop: stop.residual).stop
    text = f"Your place is known; the pointing fits to {np.degrees(fit.rms):.1f} degrees, which is {quality(fit)}"
    if quality(fit) == "poor":
        text += f": stop {worst} fits worst; pointing again with a straight arm may help"
    if left_out:
        text += f". Stop {left_out[0]} fits none of the others and was left out"
    return text
