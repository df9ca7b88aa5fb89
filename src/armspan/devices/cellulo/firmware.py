"""Robots that speak Cellulo's bytes: EPFL's firmware rules and a body each, behind a radio; no I/O, no clock.

Places are in the pattern's own coordinates [m, rad], clockwise from above. The rules come from the simulation's
`Motion`, `Localisation` and `Lights`; of the haptics the simple vibration alone moves a robot. Gestures, the
camera's picture, Bézier curves, the backdrive assists and raw motor outputs are heard and do nothing.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from heapq import heappop, heappush
from itertools import count

import numpy as np
from numpy.typing import ArrayLike

from armspan.devices.cellulo.quantities import COUNTS_PER_TURN, MM_PER_COUNT, Value
from armspan.devices.cellulo.wire import COMMANDS, EVENTS, Decoder, Packet
from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import Sheet, Vec2
from armspan.simulation.bodies import Bodies, Plant
from armspan.simulation.cellulo import DEFAULT_PERIOD_MS, Localisation, Mask, Motion, Sighting
from armspan.simulation.lights import TICKS_PER_SECOND, TOP, Effect, Lights

COUNTS: Array = np.array([[1000 / MM_PER_COUNT], [1000 / MM_PER_COUNT], [COUNTS_PER_TURN / (2 * math.pi)]])
SI: Array = np.array([[0.001], [0.001], [1.0]])  # from mm/s, mm/s, rad/s
TIMESTAMPS = 1 << 32
JUST = 1e-9  # [s] so that a frame counts as in time in spite of rounding


@dataclass(frozen=True, slots=True)
class Faults:
    """What the radio and the robots do wrong.

    ``latency_s`` is added each way, ``drop`` the share of what is sent to a robot that never arrives,
    ``boot_s`` how long a robot starts.
    """

    latency_s: float = 0.0
    drop: float = 0.0
    boot_s: float = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.latency_s) and self.latency_s >= 0):
            raise ConfigError(f"a latency of {self.latency_s} s is none; expected zero or more")
        if not 0 <= self.drop <= 1:
            raise ConfigError(f"a share of {self.drop} cannot be dropped; expected 0 to 1")


class Firmware:
    """n robots that take bytes and tell bytes; as on real ones there is no dead-man, a goal holds for ever.

    ``xy`` (n, 2) [m] and ``heading`` (n,) [rad] are where they stand; the paper begins at the sheet's origin.
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
        gain, self._camera_dice, self._radio_dice = rng.spawn(3)
        self.bodies = Bodies(xy, heading, self.plant, gain)
        self.motion, self._localisation = Motion(n), Localisation(n)
        self._lights = [Lights() for _ in range(n)]
        self._paper: Array = np.array(sheet.origin_m)[:, None]
        self._size: Array = np.array([[sheet.width_m], [sheet.height_m]])
        self._ears = [Decoder(COMMANDS) for _ in range(n)]
        self._booted = self._radio_dice.integers(0, 1 << 24, size=n)  # the clock of a robot is nobody else's
        self._starting: Array = np.full(n, -np.inf)
        self._asleep: Mask = np.zeros(n, dtype=bool)
        self._pending: list[tuple[float, int, Callable[[float], None]]] = []
        self._air: list[tuple[float, int, int, bytes]] = []
        self._order = count()
        self._last_down, self._last_up = [0.0] * n, [0.0] * n
        self._frames = 0

    def __len__(self) -> int:
        return len(self._ears)

    def feed(self, t: float, robot: int, data: bytes) -> None:
        """Send bytes to a robot by radio at ``t`` [s]: late, in order, or lost."""
        if self.faults.drop and self._radio_dice.random() < self.faults.drop:
            return
        self._last_down[robot] = arrival = max(t + self._late(), self._last_down[robot])
        self._schedule(arrival, partial(self._hear, robot, data))

    def lift(self, t: float, robot: int) -> None:
        """Take a robot off the paper at ``t`` [s]."""
        self._schedule(t, lambda _: self.bodies.lift(robot))

    def put_down(self, t: float, robot: int, xy: Vec2, heading: float) -> None:
        """Put a robot down at ``t`` [s], at ``xy`` [m] and ``heading`` [rad]; it resumes its goal."""
        self._schedule(t, lambda _: self.bodies.put_down(robot, xy, heading))

    def press(self, t: float, robot: int, event: str, key: int) -> None:
        """Let a robot tell ``touchBegan``, ``longTouch`` or ``touchReleased`` of a key at ``t`` [s]."""
        packet = EVENTS.encode(event, key=key)
        self._schedule(t, lambda at: self._say(at, robot, packet))

    def asleep(self, robot: int) -> bool:
        """Whether a robot was shut down, and its radio with it."""
        return bool(self._asleep[robot])

    def advance(self, t: float) -> list[tuple[int, bytes]]:
        """Run to ``t`` [s]: the packets that arrived at the host since the last call, (robot, bytes), in order."""
        while self._frames * self.plant.frame <= t + JUST:
            self._frame(self._frames * self.plant.frame)
            self._frames += 1
        told = []
        while self._air and self._air[0][0] <= t + JUST:
            _, _, robot, packet = heappop(self._air)
            told.append((robot, packet))
        return told

    def lights(self, t: float) -> Array:
        """The lights' colours (n, 6, 3) that a person sees at ``t`` [s], 0 to 1."""
        for lights in self._lights:
            lights.advance(math.floor(t * TICKS_PER_SECOND + JUST))
        return np.array([lights.now for lights in self._lights]) / TOP

    # --- one frame -------------------------------------------------------------------------------------

    def _frame(self, t: float) -> None:
        now = float(round(1000 * t))
        if self._frames:
            self.bodies.move(self.motion.driven * SI)
        while self._pending and self._pending[0][0] <= t + JUST:
            at, _, act = heappop(self._pending)
            act(at)
        pose, valid = self._see(t)
        sighting = self._localisation.frame(now, pose, valid)
        arrived = self.motion.frame(now, pose, valid, self._localisation.kidnapped)
        self._tell(t, pose, sighting, arrived)

    def _see(self, t: float) -> tuple[Array, Mask]:
        """The camera's poses (3, n) in counts, and where they are valid (n,)."""
        plant, place = self.plant, self.bodies.pose
        noise = np.array([[plant.position_noise], [plant.position_noise], [plant.heading_noise]])
        pose = np.rint((place + noise * self._camera_dice.standard_normal(place.shape)) * COUNTS)
        pose[2] %= COUNTS_PER_TURN
        on = (place[:2] >= self._paper) & (place[:2] <= self._paper + self._size) & (pose[:2] >= 0)
        valid: Mask = on.all(axis=0) & ~self.bodies.lifted & ~self._asleep & (t >= self._starting)
        return pose, valid

    def _tell(self, t: float, pose: Array, sighting: Sighting, arrived: Mask) -> None:
        for robot in np.flatnonzero(sighting.lifted | sighting.pose | arrived).tolist():
            if sighting.lifted[robot] or sighting.returned[robot]:
                self._say(t, robot, EVENTS.encode("kidnapChanged", kidnapped=bool(sighting.lifted[robot])))
            if sighting.pose[robot]:
                self._say(t, robot, self._pose_packet(t, robot, pose[:, robot].astype(int).tolist()))
            if arrived[robot]:
                self._say(t, robot, EVENTS.encode("trackingGoalReached"))

    def _pose_packet(self, t: float, robot: int, counts: Sequence[int]) -> bytes:
        x, y, theta = counts
        args: dict[str, Value] = {"x_raw": x, "y_raw": y, "theta_raw": theta}
        if not self._localisation.stamped[robot]:
            return EVENTS.encode("poseChanged", **args)
        ticks = (round(1000 * t) + int(self._booted[robot])) % TIMESTAMPS
        return EVENTS.encode("poseChangedTimestamped", **args, timestamp_ms=ticks)

    # --- the radio -------------------------------------------------------------------------------------

    def _late(self) -> float:
        return float(self._radio_dice.uniform(*self.plant.latency)) + self.faults.latency_s

    def _say(self, t: float, robot: int, packet: bytes) -> None:
        if self._asleep[robot]:
            return
        self._last_up[robot] = arrival = max(t + self._late(), self._last_up[robot])
        heappush(self._air, (arrival, next(self._order), robot, packet))

    def _schedule(self, t: float, act: Callable[[float], None]) -> None:
        heappush(self._pending, (t, next(self._order), act))

    def _hear(self, robot: int, data: bytes, at: float) -> None:
        if self._asleep[robot] or at < self._starting[robot]:
            return
        for packet in self._ears[robot].feed(data):
            self._obey(robot, packet, at)

    # --- commands --------------------------------------------------------------------------------------

    def _obey(self, robot: int, packet: Packet, at: float) -> None:
        raw, name = [number for number in packet.raw if isinstance(number, int)], packet.name
        match name:
            case "ping":
                self._say(at, robot, EVENTS.encode("acknowledged"))
            case "setPoseBcastPeriod":
                self._localisation.period[robot] = raw[0]
            case "setTimestampingEnabled":
                self._localisation.stamped[robot] = bool(raw[0])
            case "queryBatteryState":
                self._say(at, robot, EVENTS.encode("batteryStateChanged", state=0))
            case "setLocomotionInteractivityMode":
                self.motion.block(robot, bool(raw[0]))
            case "setVisualEffect":
                self._lights[robot].advance(math.floor(at * TICKS_PER_SECOND + JUST))
                self._lights[robot].show(Effect(raw[0]), raw[1:4], raw[4])
            case "simpleVibrate":
                self.motion.shake.start(1000 * at, robot, np.array(raw[:3]) / 100, raw[3], raw[4])
            case "clearHapticFeedback":
                self.motion.shake.stop(robot)
            case "reset":
                self._reset(robot, at)
            case "shutdown":
                self.motion.clear(robot)
                self._asleep[robot] = True
            case _:
                self._move(robot, packet)

    def _move(self, robot: int, packet: Packet) -> None:
        args = packet.args
        if packet.name == "clearTracking":
            self.motion.clear(robot)
        elif packet.name == "setGoalVelocity":
            self.motion.track_velocity(robot, [_number(value) for value in args.values()])
        elif packet.name.startswith("setGoal") and "Poly" not in packet.name:
            x, y = (round(_number(args[key]) / MM_PER_COUNT) if key in args else None for key in ("x_mm", "y_mm"))
            theta = 100 * _number(args["theta_deg"]) if "theta_deg" in args else None
            vmax, wmax = (_number(args.get(key, 0.0)) for key in ("v_max_mm_s", "w_max_rad_s"))
            self.motion.track_pose(robot, x, y, theta, vmax=vmax, wmax=wmax)

    def _reset(self, robot: int, at: float) -> None:
        """Start again: the settings are those of the boot, the clock begins anew, the lights stay."""
        self.motion.clear(robot)
        self.motion.shake.stop(robot)
        self.motion.block(robot, False)
        self._localisation.period[robot], self._localisation.stamped[robot] = DEFAULT_PERIOD_MS, False
        self._localisation.kidnapped[robot] = True
        self._starting[robot] = started = at + self.faults.boot_s
        self._booted[robot] = -round(1000 * started)
        self._schedule(started, lambda t: self._say(t, robot, EVENTS.encode("bootComplete")))


def _number(value: Value) -> float:
    return float(value) if isinstance(value, int | float) else 0.0
