"""Robots that cross each other's ways: collisions, deadlocks, gaps and times, ours beside ORCA on identical cases.

On a circle swap n robots stand evenly on a circle, turned at random, and each goes to the place opposite; on random
goals starts and goals are drawn at `Limits.spacing_m` from each other. The plants are the ideal disc (75 mm, 150 mm/s)
and the virtual Cellulo; ``latency`` is added to every command and to every state, so that a round trip has it twice.
Beside the last filter, in the same cases, ORCA of RVO2 (pyrvo: 1 s ahead, 2 mm/s of jitter against symmetry, no walls),
with a margin of 5 mm about each body, and of 15 mm or what is driven in one latency. Its velocities are driven as they
are, but where they lead straight to the goal: that is then told, so that the robot stops there. Every 50 ms robots are
commanded, every 10 ms the true places are looked at. Run: python benchmarks/swarm/crossings.py
Prints Markdown tables; cases that ended badly are listed below them.
"""

import argparse
import itertools
import math
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing import Pool
from typing import TypeAlias

import numpy as np
import pyrvo

from armspan.frames import Array
from armspan.records import Command, Drive, GoTo, RobotState, Sheet
from armspan.simulation.discs import IdealDiscs
from armspan.simulation.robots import Plant, VirtualRobots
from armspan.study.swarm import Gaps
from armspan.swarm.limits import Limits
from armspan.swarm.safety import SafetyFilter

SIZES = {4: 1.0, 8: 1.0, 12: 1.4, 20: 1.8}
"""Robots, and the side [m] of their sheet."""

LATENCIES = (0.0, 0.05, 0.1, 0.2)
PLANTS, KINDS, WAYS = ("disc", "cellulo"), ("circle", "random"), ("armspan", "orca-5mm", "orca-wide")
SPEED, TICK, LOOKS, ARRIVED, LIMIT = 0.15, 0.05, 5, 0.008, 120.0
RADIUS = {"disc": 0.0375, "cellulo": 0.0433}
"""Half the width of the body that must not touch another [m]; Cellulo's is across its corners."""

OWN_LATENCY = {"disc": 0.0, "cellulo": 0.03}
AROUND = 1.0
"""ORCA knows no walls: it gets as much [m] more sheet on every side."""

Robots: TypeAlias = IdealDiscs | VirtualRobots
Decide: TypeAlias = Callable[[float, Mapping[str, RobotState]], list[Command]]


@dataclass(frozen=True, slots=True)
class Case:
    """Who does what where: all that a run depends on."""

    way: str
    plant: str
    kind: str
    robots: int
    latency: float
    seed: int

    @property
    def limits(self) -> Limits:
        """The caps that the filter keeps."""
        body = 0.0375 if self.plant == "disc" else 0.045
        return Limits(body_radius_m=body, latency_s=self.latency + OWN_LATENCY[self.plant])

    @property
    def size(self) -> float:
        """The side of the sheet [m]."""
        return SIZES[self.robots]


@dataclass(frozen=True, slots=True)
class Outcome:
    """How it ended: ``finished`` [s] is None for a deadlock; ``gap`` [m] the least between two bodies."""

    finished: float | None
    gap: float
    collisions: int
    tick_ms: float


# --- cases ---------------------------------------------------------------------------------------------------


def starts_and_goals(case: Case, rng: np.random.Generator) -> tuple[Array, Array]:
    """Where robots start and where they go to (n, 2) [m]."""
    if case.kind == "circle":
        angle = math.tau * np.arange(case.robots) / case.robots + rng.uniform(0, math.tau)
        start = case.size / 2 + (case.size / 2 - 0.06) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return start, case.size - start
    return scattered(case, rng), scattered(case, rng)


def scattered(case: Case, rng: np.random.Generator) -> Array:
    """Random places (n, 2) [m], none nearer to another than `Limits.spacing_m`."""
    while True:
        places: list[Array] = []
        for _ in range(5000):
            place = rng.uniform(0.05, case.size - 0.05, 2)
            if all(math.dist(place, other) >= case.limits.spacing_m for other in places):
                places.append(place)
            if len(places) == case.robots:
                return np.array(places)


def robots_on(case: Case, start: Array, sheet: Sheet) -> Robots:
    """The robots of a case, at rest."""
    names = names_of(case)
    if case.plant == "disc":
        return IdealDiscs(names, start, sheet, latency=case.latency)
    plant = Plant(latency=(0.005 + case.latency, 0.03 + case.latency))
    return VirtualRobots(names, start, np.zeros(case.robots), sheet, np.random.default_rng(case.seed), plant)


def names_of(case: Case) -> list[str]:
    return [f"r{k:02}" for k in range(case.robots)]


# --- who decides ---------------------------------------------------------------------------------------------


def filtered(case: Case, goal: Array, sheet: Sheet) -> Decide:
    """Every robot wishes to be at its goal, and the last filter makes that safe."""
    safety = SafetyFilter(case.limits, sheet, np.random.default_rng(case.seed))
    goals = dict(zip(names_of(case), goal.tolist(), strict=True))

    def decide(t: float, states: Mapping[str, RobotState]) -> list[Command]:
        wishes = [GoTo(t, name, (x, y), SPEED, t + 0.3) for name, (x, y) in goals.items()]
        return [*safety.watch(t, states), *safety.admit(t, wishes, states)]

    return decide


def orca(case: Case, goal: Array, margin: float) -> Decide:
    """RVO2's velocities, driven as they are; straight to the goal where nothing is in the way."""
    names, rng = names_of(case), np.random.default_rng([case.seed, 1])
    simulator = pyrvo.RVOSimulator(TICK, 1.0, 10, 1.0, 1.0, RADIUS[case.plant] + margin, SPEED)
    for _ in names:
        simulator.add_agent((0.0, 0.0))

    def decide(t: float, states: Mapping[str, RobotState]) -> list[Command]:
        at = np.array([states[name].xy for name in names])
        straight = goal - at
        away = np.hypot(*straight.T)
        straight *= (np.minimum(SPEED, away / TICK) / np.maximum(away, 1e-9))[:, None]
        angle = rng.uniform(0, math.tau, len(names))
        wished = straight + 0.002 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        for k in range(len(names)):
            simulator.set_agent_position(k, at[k].tolist())
            simulator.set_agent_pref_velocity(k, wished[k].tolist())
        simulator.do_step()
        chosen = np.array([simulator.get_agent_velocity(k).to_tuple() for k in range(len(names))])
        free = np.hypot(*(chosen - wished).T) < 0.003
        return [
            GoTo(t, name, (float(x), float(y)), SPEED, t + 0.3)
            if is_free
            else Drive(t, name, (float(vx), float(vy)), 0.0, t + 0.3)
            for name, is_free, (x, y), (vx, vy) in zip(names, free, goal, chosen, strict=True)
        ]

    return decide


def decider(case: Case, goal: Array, sheet: Sheet) -> Decide:
    if case.way == "armspan":
        return filtered(case, goal, sheet)
    return orca(case, goal, 0.005 if case.way == "orca-5mm" else max(0.015, SPEED * case.latency))


# --- a run ---------------------------------------------------------------------------------------------------


def run(case: Case) -> Outcome:
    """Drive a case until all have arrived, or time is over."""
    start, goal = starts_and_goals(case, np.random.default_rng([case.seed, case.robots]))
    around = 0.0 if case.way == "armspan" else AROUND
    start, goal, sheet = start + around, goal + around, Sheet(case.size + 2 * around, case.size + 2 * around)
    robots, gaps = robots_on(case, start, sheet), Gaps(RADIUS[case.plant])
    decide = decider(case, goal, sheet)
    states: dict[str, RobotState] = {}
    gaps.take(0.0, start)
    spent, ticks, finished = 0.0, 0, None
    for t in (TICK * k for k in range(round(LIMIT / TICK))):
        look(robots, gaps, states, t)
        if (np.hypot(*(robots.truth()[0] - goal).T) < ARRIVED).all():
            finished = t
            break
        if len(states) < case.robots:
            continue
        began = time.perf_counter()
        commands = decide(t, states)
        spent, ticks = spent + time.perf_counter() - began, ticks + 1
        for command in commands:
            robots.command(t, command)
    least = gaps.least
    gap = math.inf if least is None else least.gap
    return Outcome(finished, gap, max(gaps.collisions, robots.contacts), 1000 * spent / max(1, ticks))


def look(robots: Robots, gaps: Gaps, states: dict[str, RobotState], t: float) -> None:
    """Advance to ``t`` [s] in small steps, and look at the true places after each."""
    for moment in (t - TICK * k / LOOKS for k in reversed(range(LOOKS))):
        if moment >= 0.0:
            states.update({state.robot: state for _, state in robots.advance(moment)})
            gaps.take(moment, robots.truth()[0])


# --- the table -----------------------------------------------------------------------------------------------


def row(cases: list[Case], outcomes: list[Outcome]) -> str:
    case = cases[0]
    times = sorted(outcome.finished for outcome in outcomes if outcome.finished is not None)
    took = f"{np.median(times):.1f} / {times[-1]:.1f}" if times else "-"
    name = (
        "**Armspan**"
        if case.way == "armspan"
        else case.way.replace("orca-5mm", "ORCA, 5 mm").replace(
            "orca-wide", f"ORCA, {1000 * max(0.015, SPEED * case.latency):.0f} mm"
        )
    )
    return (
        f"| {case.plant} | {case.kind} | {case.robots} | {1000 * case.latency:.0f} | {name} | {len(cases)} "
        f"| {sum(outcome.collisions for outcome in outcomes)} | {len(outcomes) - len(times)} "
        f"| {1000 * min(outcome.gap for outcome in outcomes):.1f} | {took} "
        f"| {np.mean([outcome.tick_ms for outcome in outcomes]):.2f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10, help="cases of each sort")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--plant", choices=PLANTS, action="append")
    parser.add_argument("--kind", choices=KINDS, action="append")
    parser.add_argument("--way", choices=WAYS, action="append")
    parser.add_argument("--robots", type=int, choices=tuple(SIZES), action="append")
    parser.add_argument("--latency-ms", type=float, action="append")
    parser.add_argument("--jobs", type=int, default=1, help="processes side by side")
    args = parser.parse_args()
    latencies = LATENCIES if args.latency_ms is None else [each / 1000 for each in args.latency_ms]
    seeds = range(args.first, args.first + args.seeds)
    sorts = itertools.product(args.plant or PLANTS, args.kind or KINDS, args.robots or SIZES, latencies)
    print("| plant | case | n | latency ms | who | cases | collisions | deadlocks | least gap mm "
          "| seconds, median / max | ms a tick |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|---|---|", flush=True)
    bad: list[str] = []
    with Pool(args.jobs) as pool:
        for (plant, kind, robots, latency), way in itertools.product(sorts, args.way or WAYS):
            cases = [Case(way, plant, kind, robots, latency, seed) for seed in seeds]
            outcomes = pool.map(run, cases, chunksize=1)
            print(row(cases, outcomes), flush=True)
            bad += [
                f"- {case} -> {outcome}"
                for case, outcome in zip(cases, outcomes, strict=True)
                if way == "armspan" and (outcome.finished is None or outcome.collisions)
            ]
            if bad and way == "armspan":
                print(*bad, sep="\n", file=sys.stderr, flush=True)
    print("\nOurs that ended badly:", *(bad or ["none"]), sep="\n")


if __name__ == "__main__":
    main()
