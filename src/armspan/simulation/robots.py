"""Virtual Cellulo robots on a sheet: the firmware's rules, a body each, and a radio to the host.

Everything here is in SI in the ``sheet`` frame, headings clockwise from above; the conversion to the
firmware's units is at this file's edge to ``cellulo``. The robots know no lease: as on the real ones, the
last goal holds for ever.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import partial
from heapq import heappop, heappush
from itertools import count
from operator import itemgetter

import numpy as np
from numpy.typing import ArrayLike

from armspan.errors import DataError
from armspan.frames import Array
from armspan.records import Command, Drive, GoTo, Haptic, Light, RobotState, Sheet, Stop, Vec2, is_finite
from armspan.simulation.addresses import addressed
from armspan.simulation.bodies import Bodies, Plant
from armspan.simulation.cellulo import COUNTS_PER_TURN, MM_PER_COUNT, Localisation, Mask, Motion, Sighting
from armspan.simulation.lights import LEDS, TICKS_PER_SECOND, TOP, Effect, Lights

__all__ = ["Plant", "VirtualRobots"]

COUNTS_PER_M = 1000.0 / MM_PER_COUNT
COUNTS_PER_RAD = COUNTS_PER_TURN / (2.0 * math.pi)
COUNTS: Array = np.array([[COUNTS_PER_M], [COUNTS_PER_M], [COUNTS_PER_RAD]])
SI: Array = np.array([[0.001], [0.001], [1.0]])  # from mm/s, mm/s, rad/s
TOP_VELOCITY = 327.67  # what the wire can carry, in mm/s or rad/s
TOP_LIMIT = 655.35
TOP_TURN = 7.5  # [rad/s] EPFL's recommended limit, for goals with a heading
SHAKE_MM_PER_S, SHAKE_MS = 60.0, 20.0  # of a haptic at full strength
BLOCK = 64  # frames for which random numbers are drawn at once
JUST = 1e-9  # [s] so that a frame counts as in time in spite of rounding


class VirtualRobots:
    """n robots that take commands and tell their states, by a radio that is late but keeps the order.

    ``xy`` (n, 2) [m] and ``heading`` (n,) [rad] are in ``sheet``; off its paper a robot is blind. What
    happens depends only on ``rng``'s seed and on the commands with their times, not on the steps of
    ``advance``. A `Haptic` is the firmware's simple vibration, 60 mm/s at full strength.

    Raises:
        DataError: where names, places and headings do not fit together.

    """

    def __init__(
        self,
        names: Sequence[str],
        xy: ArrayLike,
        heading: ArrayLike,
        sheet: Sheet,
        rng: np.random.Generator,
        plant: Plant | None = None,
    ) -> None:
        self.names = _checked_names(names, xy, heading)
        n = len(names)
        self.plant = plant or Plant()
        gain, self._noise_dice, self._up_dice, self._down_dice = rng.spawn(4)
        self.bodies = Bodies(xy, heading, self.plant, gain)
        self._motion, self._localisation = Motion(n), Localisation(n)
        self._localisation.period[:] = round(1000 * self.plant.broadcast_period)
        self._localisation.stamped[:] = True
        self._lights = [Lights() for _ in names]
        self._size: Array = np.array([[sheet.width_m], [sheet.height_m]])
        self._origin: Array = np.array([[sheet.origin_m[0]], [sheet.origin_m[1]], [0.0]])
        self._number = {name: i for i, name in enumerate(names)}
        self._pending: list[tuple[float, int, Callable[[float], None]]] = []
        self._order = count()
        self._air: list[tuple[float, RobotState]] = []
        self._commanded, self._heard = [0.0] * n, np.zeros(n)
        self._seen: Array = np.zeros((3, n))
        self._noise: Array = np.zeros((BLOCK, 3, n))
        self._delay: Array = np.zeros((BLOCK, n))
        self._frames, self._now = 0, 0.0

    @property
    def contacts(self) -> int:
        """How often two robots came to touch."""
        return self.bodies.discs.contacts

    def command(self, t: float, command: Command) -> None:
        """Send a command at session time ``t`` [s]; it arrives after the radio's latency.

        Raises:
            DeviceNotFound: for a robot that does not exist.
            DataError: for a number that is not finite, or a light that does not exist.

        """
        _check(command)
        for robot in addressed(command.robot, self._number):
            arrival = max(t + self._down_dice.uniform(*self.plant.latency), self._commanded[robot])
            self._commanded[robot] = arrival
            self._schedule(arrival, partial(self._obey, robot, command))

    def lift(self, t: float, robot: str) -> None:
        """Take a robot off the sheet at ``t`` [s]."""
        (i,) = addressed(robot, self._number)
        self._schedule(t, lambda _: self.bodies.lift(i))

    def put_down(self, t: float, robot: str, xy: Vec2, heading: float) -> None:
        """Put a robot on the sheet at ``t`` [s], at ``xy`` [m] and ``heading`` [rad]; it resumes its goal."""
        (i,) = addressed(robot, self._number)
        self._schedule(t, lambda _: self.bodies.put_down(i, xy, heading))

    def advance(self, t: float) -> list[tuple[float, RobotState]]:
        """Run to session time ``t`` [s]: what arrived since the last call, as (arrival, state), in order.

        A state's own ``t`` is that of the camera frame. What is commanded for a frame that has run already
        counts from the next one. A robot off the pattern tells ``held`` once, with
        the last pose that it saw, and nothing more until it is back.
        """
        while self._frames * self.plant.frame <= t + JUST:
            self._frame()
            self._frames += 1
        self._now = max(self._now, t)
        self._air.sort(key=itemgetter(0))
        arrived = bisect_right(self._air, t + JUST, key=itemgetter(0))
        told, self._air = self._air[:arrived], self._air[arrived:]
        return told

    def truth(self) -> tuple[Array, Array, Array]:
        """Real xy (n, 2) [m], heading (n,) [rad], velocity (n, 2) [m/s] in ``sheet`` at the last frame."""
        pose = self.bodies.pose
        return pose[:2].T.copy(), pose[2] % (2.0 * math.pi), self.bodies.velocity[:2].T.copy()

    def lights(self) -> Array:
        """The lights' colours (n, 6, 3) that a person sees now, 0 to 1."""
        tick = _tick(self._now)
        for lights in self._lights:
            lights.advance(tick)
        return np.array([lights.now for lights in self._lights]) / TOP

    # --- one frame -------------------------------------------------------------------------------------

    def _frame(self) -> None:
        t, row = self._frames * self.plant.frame, self._frames % BLOCK
        now = float(round(1000 * t))
        if row == 0:
            self._roll()
        if self._frames:
            self.bodies.move(self._motion.driven * SI)
        while self._pending and self._pending[0][0] <= t + JUST:
            arrival, _, act = heappop(self._pending)
            act(arrival)
        pose, valid = self._see(self._noise[row])
        sighting = self._localisation.frame(now, pose, valid)
        self._motion.frame(now, pose, valid, self._localisation.kidnapped)
        self._tell(t, sighting, self._delay[row])

    def _roll(self) -> None:
        """Draw the random numbers of the next frames, as many whatever happens in them."""
        noise = np.array([self.plant.position_noise, self.plant.position_noise, self.plant.heading_noise])
        self._noise = self._noise_dice.standard_normal(self._noise.shape) * noise[:, None] * COUNTS
        self._delay = self._up_dice.uniform(*self.plant.latency, size=self._delay.shape)

    def _see(self, noise: Array) -> tuple[Array, Mask]:
        """The camera's poses (3, n) in the firmware's units, and where they are valid (n,)."""
        place = self.bodies.pose
        pose = np.rint((place + self._origin) * COUNTS + noise)
        pose[2] %= COUNTS_PER_TURN
        on_paper = (place[:2] >= 0.0) & (place[:2] <= self._size) & (pose[:2] >= 0.0)
        valid: Mask = on_paper[0] & on_paper[1] & ~self.bodies.lifted
        np.copyto(self._seen, pose, where=valid)
        return pose, valid

    def _tell(self, t: float, sighting: Sighting, delay: Array) -> None:
        who = np.flatnonzero(sighting.pose | sighting.lifted)
        if not who.size:
            return
        arrivals = np.maximum(t + delay[who], self._heard[who])
        self._heard[who] = arrivals
        poses = (self._seen[:, who] / COUNTS - self._origin).T.tolist()
        held = sighting.lifted[who].tolist()
        told = zip(who.tolist(), arrivals.tolist(), poses, held, strict=True)
        for i, arrival, (x, y, heading), lifted in told:
            self._air.append((arrival, RobotState(t, self.names[i], (x, y), heading, lifted)))

    # --- commands --------------------------------------------------------------------------------------

    def _schedule(self, t: float, act: Callable[[float], None]) -> None:
        heappush(self._pending, (t, next(self._order), act))

    def _obey(self, robot: int, command: Command, at: float) -> None:
        match command:
            case GoTo():
                self._go(robot, command)
            case Drive(velocity=(vx, vy), turn=turn):
                told = np.clip([1000 * vx, 1000 * vy, turn], -TOP_VELOCITY, TOP_VELOCITY)
                self._motion.track_velocity(robot, told)
            case Stop():
                self._motion.clear(robot)
            case Light(colour=colour, led=led):
                self._lights[robot].advance(_tick(at))
                effect = Effect.CONST_ALL if led is None else Effect.CONST_SINGLE
                self._lights[robot].show(effect, colour, led or 0)
            case Haptic(strength=strength, duration=duration):
                push = (SHAKE_MM_PER_S * strength, SHAKE_MM_PER_S * strength, 0.0)
                self._motion.shake.start(1000 * at, robot, push, SHAKE_MS, max(1.0, 1000 * duration))

    def _go(self, robot: int, command: GoTo) -> None:
        x, y = np.rint((np.array(command.xy) + self._origin[:2, 0]) * COUNTS_PER_M).tolist()
        theta = None if command.heading is None else round(command.heading * COUNTS_PER_RAD) % COUNTS_PER_TURN
        vmax = min(max(1000 * command.speed, 0.0), TOP_LIMIT)
        self._motion.track_pose(robot, max(x, 0.0), max(y, 0.0), theta, vmax=vmax, wmax=TOP_TURN)


def _tick(t: float) -> int:
    return math.floor(t * TICKS_PER_SECOND + JUST)


def _check(command: Command) -> None:
    if not is_finite(command):
        raise DataError(f"{command} has a number that is not finite; a robot would keep such a goal for ever")
    if isinstance(command, Light) and command.led is not None and not 0 <= command.led < LEDS:
        raise DataError(f"{command.robot!r} has lights 0 to {LEDS - 1}, not {command.led}; None means all")
    if isinstance(command, Light) and not all(0 <= shade <= 255 for shade in command.colour):
        raise DataError(f"a light's colour {command.colour} is not made of numbers from 0 to 255")


def _checked_names(names: Sequence[str], xy: ArrayLike, heading: ArrayLike) -> tuple[str, ...]:
    n = len(names)
    if len(set(names)) != n:
        raise DataError(f"robots' names are not all different: {', '.join(names)}; rename one")
    places, headings = np.shape(xy), np.shape(heading)
    if (places, headings) != ((n, 2), (n,)):
        raise DataError(f"{n} robots need xy ({n}, 2) and headings ({n},), not shapes {places} and {headings}")
    return tuple(names)
