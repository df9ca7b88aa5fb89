"""What two wheels cost: toio cubes beside holonomic robots of their size, and how soon a cube rests whose link is cut.

Simulated. Four cubes on a ring mat, behind the product's own protocol core and byte for byte, do six behaviours one
after the other; from the same places, headings and limits so do holonomic robots in the same run: virtual Cellulo of a
cube's radius, with its wheels' lag and gain, its camera's noise and frames, and the same radio (8 to 22 ms either way).
The same mind steers both. Seconds are until no robot is busy any more, distances between the middles of the nearest
two, looked at every 5 ms; a cube's body is a disc of 22.5 mm. Then one cube behind its driver and an emulated radio is
driven to full speed, told a goal far ahead, and its link is cut. Run: python benchmarks/toio.py
Prints Markdown tables.
"""

import argparse
import asyncio
import heapq
import itertools
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from scipy.spatial.distance import pdist

from armspan.conductor.robots_only import RobotsOnly
from armspan.conductor.settings import Settings
from armspan.devices.toio.mat import FRAME_S, Chassis, Mat
from armspan.devices.toio.quantities import UNIT_M
from armspan.devices.toio.robot import SETTINGS, Placement, Robot
from armspan.devices.toio.wire import decode
from armspan.frames import Array
from armspan.records import Body, Command, Drive, Event, GoTo, Haptic, Light, Output, Press, Sheet, Stop, Tick
from armspan.simulation.robots import Plant, VirtualRobots
from armspan.swarm.limits import Limits

sys.path[:0] = [str(Path(__file__).parents[1] / "tests")]

from devices.toio.scenes import Host, emulated  # noqa: E402
from devices.toio.test_killed import full_speed, rested  # noqa: E402
from fast_time import run  # noqa: E402

BEHAVIOURS = {"gather": "0.28 0.28", "disperse": "", "sweep": "", "deploy": "", "split": "", "merge": ""}
"""In this order, each with the place that is pointed at."""
LATENCIES = (0.05, 0.1)
RADIO = (0.008, 0.022)
"""What bytes take either way [s]."""
ROBOTS, SIDE, RADIUS = 4, 410 * UNIT_M, 0.0225
SHEET = Sheet(SIDE, SIDE)
STEP, TICK, PATIENCE, PAUSE = 0.005, 0.05, 40.0, 0.5
LAGS, SPEEDS = (0.05, 0.1, 0.15), (0.15, 0.2, 0.3)


class Cubes:
    """Emulated cubes and what the host knows of them, with a delay between that keeps the order."""

    def __init__(self, names: Sequence[str], xy: Array, heading: Array, rng: np.random.Generator) -> None:
        mat, self._dice = rng.spawn(2)
        self.mat = Mat(xy, heading, mat)
        self.robots = [Robot(name, Placement()) for name in names]
        self._down: list = []
        self._up: list = []
        self._order = itertools.count()
        self._last = {True: [0.0] * len(names), False: [0.0] * len(names)}
        for cube, robot in enumerate(self.robots):
            robot.linked(0.0, True)
            for note in SETTINGS:
                self.mat.cubes[cube].write(0.0, *note)
            self._write(cube, 0.0)

    @property
    def contacts(self) -> int:
        """How often two came to touch."""
        return self.mat.contacts

    def truth(self) -> Array:
        """Real places (n, 2) [m]."""
        return self.mat.truth()[0]

    def command(self, t: float, command: Command) -> None:
        """Send a command at ``t`` [s]."""
        for cube, robot in enumerate(self.robots):
            if command.robot in (None, robot.name):
                robot.take(command, t)
                self._write(cube, t)

    def advance(self, t: float) -> list[Event]:
        """Run to ``t`` [s]: what the host hears."""
        for at, cube, note in _due(self._down, t):
            self.mat.cubes[cube].write(at, *note)
        for at, cube, note in self.mat.advance(t):
            self._fly(self._up, at, cube, note)
        heard = [event for _, cube, note in _due(self._up, t) for event in self.robots[cube].hear(decode(*note), t)]
        for cube, robot in enumerate(self.robots):
            if robot.wake() <= t:
                self._write(cube, t)
        return heard

    def _write(self, cube: int, t: float) -> None:
        robot = self.robots[cube]
        for note in robot.motion(t) + robot.signs():
            self._fly(self._down, t, cube, note)

    def _fly(self, air: list, t: float, cube: int, note: tuple[str, bytes]) -> None:
        last = self._last[air is self._up]
        last[cube] = max(t + self._dice.uniform(*RADIO), last[cube])
        heapq.heappush(air, (last[cube], next(self._order), cube, note))


def _due(air: list, t: float) -> list:
    due = []
    while air and air[0][0] <= t:
        at, _, cube, note = heapq.heappop(air)
        due.append((at, cube, note))
    return due


class Holonomic:
    """Virtual Cellulo with a cube's radius, wheels, camera and radio, but for the wheels' directions."""

    def __init__(self, names: Sequence[str], xy: Array, heading: Array, rng: np.random.Generator) -> None:
        cube = Chassis()
        plant = Plant(
            lag=cube.lag,
            gain=cube.gain,
            position_noise=cube.noise[0] * UNIT_M,
            heading_noise=math.radians(cube.noise[1]),
            frame=FRAME_S,
            latency=RADIO,
            radius=RADIUS,
        )
        self.robots = VirtualRobots(names, xy, heading, SHEET, rng, plant)

    @property
    def contacts(self) -> int:
        """How often two came to touch."""
        return self.robots.contacts

    def truth(self) -> Array:
        """Real places (n, 2) [m]."""
        return self.robots.truth()[0]

    def command(self, t: float, command: Command) -> None:
        """Send a command at ``t`` [s]."""
        self.robots.command(t, command)

    def advance(self, t: float) -> list[Event]:
        """Run to ``t`` [s]: what the host hears."""
        return [state for _, state in self.robots.advance(t)]


Plants: TypeAlias = Cubes | Holonomic
KINDS: dict[str, type[Plants]] = {"cubes": Cubes, "holonomic": Holonomic}


@dataclass(frozen=True, slots=True)
class Done:
    """How a behaviour went: seconds, the least distance of two middles [m], contacts, whether it ended."""

    seconds: float
    least: float
    contacts: int
    ended: bool


class Scene:
    """Robots and the mind that steers them."""

    def __init__(self, kind: str, latency: float, seed: int) -> None:
        rng = np.random.default_rng(seed)
        xy, heading = starts(rng)
        names = tuple("abcdefghijkl"[: len(xy)])
        limits = Limits(body_radius_m=0.024, latency_s=latency)
        body = Body(1.6, (0.0, 0.0, 0.0), 0.7)
        self.mind = RobotsOnly(Settings(body=body, sheet=SHEET, bands=(), robots=names, limits=limits))
        self.robots = KINDS[kind](names, xy, heading, rng)
        self.steps, self.least = 0, math.inf

    @property
    def t(self) -> float:
        """Time since the beginning [s]."""
        return self.steps * STEP

    @property
    def busy(self) -> bool:
        """Whether a behaviour goes on."""
        return bool(self.mind.steering.director.running)

    def go(self, seconds: float, *, while_busy: bool = False) -> None:
        """Let time pass."""
        end = self.t + seconds
        while self.t < end and (self.busy or not while_busy):
            self.steps += 1
            for event in self.robots.advance(self.t):
                self._send(self.mind.step(event))
            if self.steps % round(TICK / STEP) == 0:
                self._send(self.mind.step(Tick(self.t)))
            self.least = min(self.least, float(pdist(self.robots.truth()).min()))

    def do(self, behaviour: str, spot: str) -> Done:
        """Ask for a behaviour and wait for its end."""
        began, contacts, self.least = self.t, self.robots.contacts, math.inf
        for press in (Press(self.t, "point", spot), Press(self.t, "behaviour", behaviour)):
            self._send(self.mind.step(press))
        if not self.busy:
            raise ValueError(f"{behaviour} did not begin")
        self.go(PATIENCE, while_busy=True)
        done = Done(self.t - began, self.least, self.robots.contacts - contacts, not self.busy)
        self.go(PAUSE)
        return done

    def _send(self, outputs: list[Output]) -> None:
        for output in outputs:
            if isinstance(output, GoTo | Drive | Light | Haptic | Stop):
                self.robots.command(self.t, output)


def starts(rng: np.random.Generator) -> tuple[Array, Array]:
    """Places (n, 2) [m] at least four radii apart, headings (n,) [rad]."""
    places: list[Array] = []
    while len(places) < ROBOTS:
        place = rng.uniform(0.06, SIDE - 0.06, 2)
        if all(math.dist(place, other) > 4 * RADIUS for other in places):
            places.append(place)
    return np.array(places), rng.uniform(0.0, 2.0 * math.pi, ROBOTS)


def together(latency: float, seeds: range) -> dict[str, list[list[Done]]]:
    """Every seed with each kind: behaviours in order."""
    found: dict[str, list[list[Done]]] = {kind: [] for kind in KINDS}
    for seed in seeds:
        for kind in KINDS:
            scene = Scene(kind, latency, seed)
            scene.go(0.3)
            found[kind].append([scene.do(*behaviour) for behaviour in BEHAVIOURS.items()])
    return found


def print_together(seeds: range) -> None:
    print(f"{ROBOTS} robots, {len(seeds)} seeds from {seeds.start} on\n")
    heads = ["behaviour", "latency_s"]
    for kind in KINDS:
        heads += [f"{kind}: seconds, median / max", "least distance mm", "contacts", "unfinished"]
    print(f"| {' | '.join([*heads, 'cubes take, median'])} |\n" + "|---" * (len(heads) + 1) + "|")
    for latency in LATENCIES:
        found = together(latency, seeds)
        for k, behaviour in enumerate(BEHAVIOURS):
            row, medians = [behaviour, f"{latency:g}"], []
            for kind in KINDS:
                runs = [behaviours[k] for behaviours in found[kind]]
                seconds = [one.seconds for one in runs]
                medians.append(np.median(seconds))
                row += [f"{medians[-1]:.1f} / {max(seconds):.1f}", f"{1000 * min(one.least for one in runs):.0f}"]
                row += [f"{sum(one.contacts for one in runs)}", f"{sum(not one.ended for one in runs)}"]
            print(f"| {' | '.join(row)} | {medians[0] / medians[1]:.2f} x |", flush=True)


def cut(lag: float, speed: float, after: float, seed: int) -> tuple[float, float, float]:
    """Cut a cube's link at full speed, ``after`` [s] more: speed then [m/s], how long and how far it goes on [s, m]."""
    found = []

    async def scene() -> None:
        chassis = Chassis(lag=lag, gain=(1.02, 1.02))  # as fast as any cube is
        async with emulated([(0.06, 0.2)], chassis=chassis, seed=seed) as air, Host(air, retry_s=30.0) as host:
            await host.met()
            await full_speed(host, speed)
            await asyncio.sleep(after)
            found.append(host.speed())
            air.cut(air.entries[0].address, 30.0)
            found.extend(await rested(host))

    run(scene, 60)
    return found[0], found[1], found[2]


def print_cut(runs: int) -> None:
    print(f"\nThe link is cut, {runs} runs in each row, 20 to {20 + 10 * (runs - 1)} ms after the last goal\n")
    print(
        "| wheels' lag s | told mm/s | when cut mm/s | at rest (5 mm/s) after s, median / max | way mm, median / max |"
    )
    print("|---|---|---|---|---|")
    for lag, speed in itertools.product(LAGS, SPEEDS):
        rows = np.array([cut(lag, speed, 0.01 * k, k) for k in range(runs)])
        (v, rest, way), (_, most, far) = np.median(rows, axis=0), rows.max(axis=0)
        cells = f"{1000 * v:.0f} | {rest:.2f} / {most:.2f} | {1000 * way:.0f} / {1000 * far:.0f}"
        print(f"| {lag:g} | {1000 * speed:.0f} | {cells} |", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=4, help="starts of the behaviours; default: %(default)s")
    parser.add_argument("--first", type=int, default=0, help="the first seed; default: %(default)s")
    parser.add_argument("--runs", type=int, default=6, help="links cut in each row; default: %(default)s")
    args = parser.parse_args()
    print_together(range(args.first, args.first + args.seeds))
    print_cut(args.runs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
