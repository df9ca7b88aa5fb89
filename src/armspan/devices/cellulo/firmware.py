"""Robots that speak Cellulo's bytes: EPFL's firmware rules and a body each, behind a radio; no I/O, no clock.

Places are in the pattern's own coordinates [m, rad], clockwise from above. The rules come from the simulation's
`Motion`, `Localisation` and `Lights`, from `keys`, and from `orders`, which obeys commands.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armspan.devices.cellulo import picture
from armspan.devices.cellulo.faults import Faults
from armspan.devices.cellulo.keys import SAMPLE_MS
from armspan.devices.cellulo.orders import obey
from armspan.devices.cellulo.quantities import COUNTS_PER_TURN, MM_PER_COUNT, Value
from armspan.devices.cellulo.radio import Radio
from armspan.devices.cellulo.unit import ALERTS, LAST_WORDS_S, LOW, Unit
from armspan.devices.cellulo.wire import EVENTS
from armspan.frames import Array
from armspan.records import Sheet, Vec2
from armspan.simulation.bodies import Bodies, Plant
from armspan.simulation.cellulo import DEFAULT_PERIOD_MS, Localisation, Mask, Motion, Sighting
from armspan.simulation.lights import TICKS_PER_SECOND, TOP, Effect

__all__ = ["Faults", "Firmware", "Truth"]

COUNTS: Array = np.array([[1000 / MM_PER_COUNT], [1000 / MM_PER_COUNT], [COUNTS_PER_TURN / (2 * math.pi)]])
SI: Array = np.array([[0.001], [0.001], [1.0]])  # from mm/s, mm/s, rad/s
TIMESTAMPS = 1 << 32
JUST = 1e-9  # [s] so that a frame counts as in time in spite of rounding
BYTE_S = {"v1": 10 / 921600, "v2": 10 / 115200, "old": 10 / 115200}


class Truth(NamedTuple):
    """Where robots really are: ``xy`` (n, 2) [m] in ``sheet``, ``heading`` (n,) [rad], ``lifted`` (n,)."""

    xy: Array
    heading: Array
    velocity: Array
    lifted: Mask


class Firmware:
    """n robots that take bytes and tell bytes; as on real ones there is no dead-man, a goal holds for ever.

    ``xy`` (n, 2) [m] and ``heading`` (n,) [rad] are where they stand in the pattern's own coordinates; the paper
    begins at the sheet's origin. ``age_ms`` (n,) are their own clocks at t = 0, and may be set before anything else.
    """

    def __init__(
        self,
        xy: ArrayLike,
        heading: ArrayLike,
        sheet: Sheet,
        rng: np.random.Generator,
        plant: Plant | None = None,
        faults: Faults | None = None,
    ) -> None:
        n = len(np.asarray(heading))
        self.plant, self.faults = plant or Plant(), faults or Faults()
        gain, self._camera_dice, radio = rng.spawn(3)
        self.bodies = Bodies(xy, heading, self.plant, gain)
        self.motion, self.localisation = Motion(n), Localisation(n)
        self.units = [Unit(deaf=self.faults.deaf) for _ in range(n)]
        self._paper: Array = np.array(sheet.origin_m)[:, None]
        self._size: Array = np.array([[sheet.width_m], [sheet.height_m]])
        self.age_ms: NDArray[np.int64] = radio.integers(0, 1 << 24, size=n)
        self._radio = Radio(n, self.plant.latency, self.faults, radio)
        self._starting: Array = np.full(n, -np.inf)
        self._off: Mask = np.zeros(n, dtype=bool)
        self._blind: Array = np.full(n, -np.inf)
        self._hands: dict[int, tuple[Array, float]] = {}
        self._pending: list[tuple[float, int, Callable[[float], None]]] = []
        self._order = count()
        self._frames = 0

    def __len__(self) -> int:
        return len(self.units)

    # --- what a person, or the air, does ---------------------------------------------------------------

    def feed(self, t: float, robot: int, data: bytes) -> None:
        """Send bytes to a robot by radio at ``t`` [s]: late, in order, or lost."""
        arrival = self._radio.down(t, robot)
        if arrival is not None:
            self.schedule(arrival, partial(self._hear, robot, data))

    def met(self, robot: int) -> None:
        """A host's link came up: what it says first may be lost."""
        self.units[robot].deaf = self.faults.deaf

    def lift(self, t: float, robot: int) -> None:
        """Take a robot off the paper at ``t`` [s]."""
        self.schedule(t, lambda _: self.bodies.lift(robot))

    def put_down(self, t: float, robot: int, xy: Vec2, heading: float) -> None:
        """Put a robot down at ``t`` [s], at ``xy`` [m] and ``heading`` [rad]; it resumes its goal."""
        self.schedule(t, lambda _: self.bodies.put_down(robot, xy, heading))

    def press(self, t: float, robot: int, event: str, key: int) -> None:
        """Let a robot tell ``touchBegan``, ``longTouch`` or ``touchReleased`` of a key at ``t`` [s]."""
        self.schedule(t, partial(self._say_then, robot, EVENTS.encode(event, key=key)))

    def touch(self, t: float, robot: int, keys: Iterable[int] = (), grasp: float = 0.0) -> None:
        """From ``t`` [s] on, lay fingers on ``keys`` and a hand around: a ``grasp`` of 10 or more is a hold."""
        fingers = tuple(keys)
        self.schedule(t, lambda at: self._feel(at, robot, fingers, grasp))

    def push(self, t: float, robot: int, velocity: Sequence[float], seconds: float) -> None:
        """Let a hand drag a robot at a velocity (3,) [m/s, rad/s] from ``t`` [s] on, stronger than its motors."""
        self.schedule(t, lambda at: self._hands.update({robot: (np.array(velocity), at + seconds)}))

    def load(self, t: float, robot: int, grams: float) -> None:
        """Lay a weight on a robot at ``t`` [s], 0 to take it off."""
        self.schedule(t, lambda _: self.bodies.load(robot, grams))

    def blind(self, t: float, robot: int, seconds: float) -> None:
        """Let a robot's camera give no pictures for a while."""
        self.schedule(t, lambda at: self._blind.__setitem__(robot, at + seconds))

    def charge(self, t: float, robot: int, state: int) -> None:
        """Let a robot's charger find a state: 0 discharging, 1 low, 2 charging, 3 charged, 4 off, 5 fault."""
        self.schedule(t, lambda at: self._charge(at, robot, state))

    # --- what can be seen ------------------------------------------------------------------------------

    def asleep(self, robot: int) -> bool:
        """Whether a robot was shut down, and its radio with it."""
        return self.units[robot].asleep

    def truth(self) -> Truth:
        """Where the robots really are, in ``sheet``, at the last frame."""
        pose, bodies = self.bodies.pose, self.bodies
        xy = (pose[:2] - self._paper).T
        return Truth(xy, pose[2] % (2 * math.pi), bodies.velocity[:2].T.copy(), bodies.lifted.copy())

    def lights(self, t: float) -> Array:
        """The lights' colours (n, 6, 3) that a person sees at ``t`` [s], 0 to 1."""
        return np.array([unit.seen(_tick(t)) for unit in self.units]) / TOP

    def advance(self, t: float) -> list[tuple[int, bytes]]:
        """Run to ``t`` [s]: the packets that arrived at the host since the last call, (robot, bytes), in order."""
        while True:
            frame = self._frames * self.plant.frame
            if self._pending and self._pending[0][0] <= min(t, frame) + JUST:
                at, _, act = heappop(self._pending)
                act(at)
            elif frame <= t + JUST:
                self._frame(frame)
                self._frames += 1
            else:
                break
        return self._radio.arrived(t)

    # --- one frame -------------------------------------------------------------------------------------

    def _frame(self, t: float) -> None:
        now = float(round(1000 * t))
        if self._frames:
            self._move(t)
        pose, valid, missing = self._see(t)
        sighting = self.localisation.frame(now, pose, valid, missing)
        arrived = self.motion.frame(now, pose, valid, self.localisation.kidnapped)
        self._tell(t, pose, sighting, arrived)
        for robot, unit in enumerate(self.units):
            if unit.fading and unit.dark(_tick(t)):
                self._off[robot] = True
                unit.fading = False
            if unit.wanted_picture and valid[robot]:
                unit.wanted_picture = False
                self._send_picture(t, robot)

    def _move(self, t: float) -> None:
        before = self.bodies.pose.copy()
        self.bodies.move(self.motion.driven * SI)
        for robot in self.motion.raw:
            unit = self.units[robot]
            extra = (unit.wheels - self.motion.driven[:, robot]) * SI[:, 0]
            self.bodies.nudge(robot, extra, min(t - unit.wheels_since, self.plant.frame))
        for robot, (velocity, until) in list(self._hands.items()):
            self.bodies.pose[:, robot] = before[:, robot] + velocity * self.plant.frame
            self.bodies.velocity[:, robot] = velocity
            if t >= until:
                del self._hands[robot]

    def _see(self, t: float) -> tuple[Array, Mask, Mask]:
        """The camera's poses (3, n) in counts, where they are valid (n,), and where there is no picture at all."""
        plant, place = self.plant, self.bodies.pose
        noise = np.array([[plant.position_noise], [plant.position_noise], [plant.heading_noise]])
        pose = np.rint((place + noise * self._camera_dice.standard_normal(place.shape)) * COUNTS)
        pose[2] %= COUNTS_PER_TURN
        on = (place[:2] >= self._paper) & (place[:2] <= self._paper + self._size) & (pose[:2] >= 0)
        missing: Mask = t < self._blind
        valid: Mask = on.all(axis=0) & ~self.bodies.lifted & ~self._off & (t >= self._starting) & ~missing
        return pose, valid, missing

    def _tell(self, t: float, pose: Array, sighting: Sighting, arrived: Mask) -> None:
        for robot in np.flatnonzero(sighting.lifted | sighting.pose | arrived).tolist():
            if sighting.lifted[robot] or sighting.returned[robot]:
                self.say(t, robot, EVENTS.encode("kidnapChanged", kidnapped=bool(sighting.lifted[robot])))
            if sighting.pose[robot]:
                self.say(t, robot, self._pose_packet(t, robot, pose[:, robot].astype(int).tolist()))
            if arrived[robot]:
                self.say(t, robot, EVENTS.encode("trackingGoalReached"))

    def _pose_packet(self, t: float, robot: int, counts: Sequence[int]) -> bytes:
        x, y, theta = counts
        args: dict[str, Value] = {"x_raw": x, "y_raw": y, "theta_raw": theta}
        if not self.localisation.stamped[robot]:
            return EVENTS.encode("poseChanged", **args)
        ticks = (round(1000 * t) + int(self.age_ms[robot])) % TIMESTAMPS
        return EVENTS.encode("poseChangedTimestamped", **args, timestamp_ms=ticks)

    def _send_picture(self, t: float, robot: int) -> None:
        """A picture takes its time on the wire between the robot and its radio."""
        x, y, theta = self.bodies.pose[:, robot].tolist()
        grey = picture.picture((1000 * x, 1000 * y), theta, bool(self.bodies.lifted[robot]))
        for k, packet in enumerate(picture.packets(grey)):
            at = t + (k + 1) * len(packet) * BYTE_S[self.faults.generation]
            self.schedule(at, partial(self._say_then, robot, packet))

    def _say_then(self, robot: int, packet: bytes, at: float) -> None:
        self.say(at, robot, packet)

    # --- the radio -------------------------------------------------------------------------------------

    def say(self, t: float, robot: int, packet: bytes) -> None:
        """Let a robot tell something at ``t`` [s], if it is on, and of a generation that knows the words."""
        if self.units[robot].asleep or self.faults.generation == "old":
            return
        self._radio.up(t, robot, packet)

    def schedule(self, t: float, act: Callable[[float], None]) -> None:
        """Let something happen at ``t`` [s]; it is told the time."""
        heappush(self._pending, (t, next(self._order), act))

    def _hear(self, robot: int, data: bytes, at: float) -> None:
        unit = self.units[robot]
        if unit.asleep or at < self._starting[robot] or self.faults.generation == "old":
            return
        if unit.deaf > 0:
            unit.deaf -= 1
            return
        for packet in unit.ears.feed(data):
            obey(self, robot, packet, at)

    # --- power, hands ----------------------------------------------------------------------------------

    def sleep(self, robot: int, at: float) -> None:
        """Switch a robot off: the motors at once, everything once its lights have faded."""
        unit = self.units[robot]
        if not (unit.asleep or unit.fading):
            self.motion.clear(robot)
            unit.fade(_tick(at))

    def boot(self, robot: int, at: float, *, cold: bool = False) -> None:
        """Start again: the settings are those of the boot, the clock begins anew; the lights stay if not ``cold``."""
        unit = self.units[robot]
        self.motion.clear(robot)
        self.motion.shake.stop(robot)
        self.motion.backdrive.still(robot)
        self.motion.backdrive.ease(robot, False)
        self.motion.backdrive.help(robot, (0.0, 0.0, 0.0))
        self.motion.block(robot, False)
        self.motion.held[robot] = False
        self.localisation.period[robot], self.localisation.stamped[robot] = DEFAULT_PERIOD_MS, False
        self.localisation.kidnapped[robot] = True
        self._starting[robot] = started = at + self.faults.boot_s
        self.age_ms[robot] = -round(1000 * started)
        unit.start(self.faults.deaf, cold)
        self._off[robot] = False
        self.schedule(started, lambda t: self.say(t, robot, EVENTS.encode("bootComplete")))

    def _charge(self, at: float, robot: int, state: int) -> None:
        unit = self.units[robot]
        if state == unit.battery:
            return
        unit.battery = state
        self.say(at, robot, EVENTS.encode("batteryStateChanged", state=state))
        if state in ALERTS and not unit.asleep:
            colour, flashes = ALERTS[state]
            unit.show(_tick(at), Effect.ALERT_ALL, colour, flashes)
        if state == LOW:
            self.schedule(at + LAST_WORDS_S, lambda t: self._give_up(t, robot))

    def _give_up(self, at: float, robot: int) -> None:
        if self.units[robot].battery == LOW:
            self.say(at, robot, EVENTS.encode("lowBattery"))
            self.sleep(robot, at)

    def _feel(self, at: float, robot: int, keys: tuple[int, ...], grasp: float) -> None:
        unit = self.units[robot]
        if self.faults.generation != "v1":
            return  # their keys are never read
        unit.keys.feel(keys, grasp)
        if not unit.sampling:
            unit.sampling = True
            period = SAMPLE_MS / 1000
            self.schedule(math.ceil(at / period - JUST) * period, partial(self._sample, robot))

    def _sample(self, robot: int, at: float) -> None:
        unit = self.units[robot]
        for name, key in unit.keys.sample(round(1000 * at)):
            if name == "on" and unit.asleep:
                self.boot(robot, at, cold=True)
            elif name == "off" and not unit.asleep:
                self.say(at, robot, EVENTS.encode("shuttingDown"))
                self.sleep(robot, at)
            elif name not in ("on", "off"):
                self.say(at, robot, EVENTS.encode(name, key=key))
        self.tell_hold(robot, at)
        unit.sampling = unit.keys.busy
        if unit.sampling:
            self.schedule(at + SAMPLE_MS / 1000, partial(self._sample, robot))

    def tell_hold(self, robot: int, at: float) -> None:
        """Tell the gesture where it changed."""
        unit = self.units[robot]
        held = unit.feels and unit.keys.held
        if held != self.motion.held[robot]:
            self.motion.held[robot] = unit.held = held
            self.say(at, robot, EVENTS.encode("gestureChanged", gesture=int(held)))


def _tick(t: float) -> int:
    return math.floor(t * TICKS_PER_SECOND + JUST)
