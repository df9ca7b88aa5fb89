"""Coverage through the whole pipeline: director, last filter, plant, at 20 Hz, against bounds and published numbers.

On a sheet of 1 x 1 m. Robots begin in a line at the edge, on a ring or at random places; times begin with the first
wish and include the way to the first lane, which the published ones leave out. A sweep's bound is A / (n v d): 88.9,
22.2, 14.8 s for 1, 4, 6 discs of 75 mm at 150 mm/s. Ideal discs (latency 0, 10 m/s²) may come up to the edge; the
Cellulo plant keeps 45 mm off it, slows down at corners and reaches 0.6 to 1.0 of what it is told. "Of what can be
reached" counts only what a robot can cover that keeps off the edge. Deployment is told as H beside the least known one
of the unit square (exact for 1, 4, 9). Everything is measured at the truth. Run: python benchmarks/swarm/coverage.py
Prints Markdown tables.
"""

import argparse
import itertools
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing import Pool
from typing import Any

import numpy as np

from armspan.conductor.settings import BandSettings, Settings
from armspan.conductor.steering import Steering
from armspan.frames import Array
from armspan.records import COMMANDS, Body, Output, Sheet
from armspan.simulation.discs import IdealDiscs
from armspan.simulation.robots import VirtualRobots
from armspan.study.coverage import locational_cost
from armspan.study.swarm import SwarmAccount
from armspan.swarm.limits import Limits

SHEET, TICK = Sheet(1.0, 1.0), 0.05
BODY = Body(1.65, (0.0, 0.2, 0.25), 0.7)
LIMITS = {
    "disc": Limits(body_radius_m=0.0375, accel_m_s2=10.0, latency_s=0.0),
    "cellulo": Limits(),
}
RADIUS = {"disc": 0.0375, "cellulo": 0.043}
ANCHORS = {
    ("sweep", 1): "88.9; 89.8 / 94.9 / 98.7",
    ("sweep", 4): "22.2; 23.5 / 24.8 / 26.0",
    ("sweep", 6): "14.8; 17.2 / 18.4 / -",
    ("random-walk", 1): "230 / 312",
    ("random-walk", 4): "58.8 / 75.9",
    ("random-walk", 6): "38.2 / 51.3",
}
SECONDS = {("sweep", 1): 240.0, ("random-walk", 1): 900.0, ("random-walk", 4): 400.0, ("random-walk", 6): 300.0}
OPTIMA = {1: 1 / 6, 2: 0.10416, 4: 1 / 24, 5: 0.0353, 6: 0.0300, 9: 1 / 54}
"""The least known H of the unit square."""

DEPLOY = ("deploy", "deploy-field")


@dataclass(frozen=True, slots=True)
class Case:
    """A behaviour of n robots on a plant, from a line, a ring or random places."""

    behaviour: str
    plant: str
    robots: int
    start: str
    seed: int

    @property
    def seconds(self) -> float:
        """How long it runs at most."""
        return SECONDS.get((self.behaviour, self.robots), 120.0)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What was measured: times in s, from the first wish; ``settled`` is when H had come within 2 % of the optimum."""

    times: dict[str, float | None]
    reachable: dict[str, float | None]
    share: float
    cost: float
    settled: float | None
    document: dict[str, object]


# --- a run ---------------------------------------------------------------------------------------------------


def starts(case: Case) -> Array:
    """Where the robots begin (n, 2) [m]: random places keep `Limits.spacing_m` from each other."""
    n, limits = case.robots, LIMITS[case.plant]
    if case.start == "line":
        return np.stack([(np.arange(n) + 0.5) / n, np.full(n, 0.06)], axis=1)
    if case.start == "ring":
        angle = math.tau * np.arange(n) / n
        return 0.5 + 0.3 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rng = np.random.default_rng([case.seed, n])
    places: list[Array] = []
    while len(places) < n:
        place = rng.uniform(limits.body_radius_m, 1.0 - limits.body_radius_m, 2)
        if all(math.dist(place, other) >= limits.spacing_m for other in places):
            places.append(place)
    return np.array(places)


def plant_of(case: Case, names: list[str]) -> IdealDiscs | VirtualRobots:
    """The robots of a case, at rest."""
    if case.plant == "disc":
        return IdealDiscs(names, starts(case), SHEET)
    return VirtualRobots(names, starts(case), np.zeros(case.robots), SHEET, np.random.default_rng(case.seed))


def run(case: Case) -> Outcome:
    """Drive a behaviour through `Steering` until it is done, or time is over."""
    names, limits = [f"r{k}" for k in range(case.robots)], LIMITS[case.plant]
    robots, account = plant_of(case, names), SwarmAccount(names, SHEET, limits, body=RADIUS[case.plant])
    steering = Steering(Settings(BODY, SHEET, (BandSettings("wrist"),), tuple(names), limits=limits, dice=case.seed))
    deploys, asked, began, settled = case.behaviour in DEPLOY, False, 0.0, None
    for t in (TICK * step for step in range(round(case.seconds / TICK) + 1)):
        for _, state in robots.advance(t):
            account.hear(state)
            send(robots, account, t, steering.robot(state))
        here = robots.truth()[0]
        if asked:
            account.take(t, here)
        if not asked and len(steering.states) == case.robots:
            asked = bool(steering.behave(t, case.behaviour, "asked for", None))
            account.take(t, here)
            began = t
        send(robots, account, t, steering.tick(t, None))
        account.want(t, steering.wishes)
        if deploys and asked and settled is None and cost_of(here) <= 1.02 * OPTIMA.get(case.robots, 0.0):
            settled = t - began
        if asked and not steering.director.running:
            break
    swept, margin = account.coverage, limits.body_radius_m
    reachable = swept.times(only=swept.reachable(margin, SHEET))
    return Outcome(swept.times(), reachable, swept.share(), cost_of(robots.truth()[0]), settled, account.document())


def send(robots: IdealDiscs | VirtualRobots, account: SwarmAccount, t: float, outputs: Sequence[Output]) -> None:
    """Everything that leaves is heard, and commands reach the robots."""
    for output in outputs:
        account.hear(output)
        if isinstance(output, COMMANDS):
            robots.command(t, output)


def cost_of(places: Array) -> float:
    return locational_cost(places, SHEET, normalised=True)


# --- the tables ----------------------------------------------------------------------------------------------


def middle(values: Sequence[float | None]) -> str:
    """The median, with those that never happened as endless."""
    median = float(np.median([math.inf if value is None else value for value in values]))
    return f"{median:.1f}" if math.isfinite(median) else "-"


def three(found: Sequence[dict[str, float | None]]) -> str:
    return " / ".join(middle([times[key] for times in found]) for key in ("t90", "t95", "t99"))


def safe(outcomes: Sequence[Outcome]) -> str:
    """Least gap, collisions, stuck robots and violations of some runs."""
    documents = [outcome.document for outcome in outcomes]
    gaps = [gap for document in documents if isinstance(gap := document["min_gap_mm"], float)]
    counts = [sum(int(str(document[key] or 0)) for document in documents) for key in ("collisions", "deadlocks")]
    broken = Counter[str]()
    for document in documents:
        broken.update(document["violations"])  # type: ignore[call-overload]
    kinds = ", ".join(f"{number} {kind}" for kind, number in broken.items()) or "0"
    return (
        f"{min(gaps):.1f} | {counts[0]} | {counts[1]} | {kinds}" if gaps else f"- | {counts[0]} | {counts[1]} | {kinds}"
    )


def measure(pool: Any, behaviour: str, plant: str, robots: int, start: str, seeds: int) -> list[Outcome]:
    found: list[Outcome] = pool.map(run, [Case(behaviour, plant, robots, start, seed) for seed in range(seeds)])
    return found


SAFE = "least gap mm | collisions | stuck | violations"


def sweeps(pool: Any, seeds: int, plants: Sequence[str]) -> None:
    print("\n| sweep | n | starts | runs | t90 / t95 / t99 s | of what can be reached | covered, least "
          f"| bound; published | {SAFE} |\n|---|---|---|---|---|---|---|---|---|---|---|---|", flush=True)  # fmt: skip
    for plant in plants:
        for n, start in itertools.product((1, 4, 6), ("line", "ring", "random")):
            found = measure(pool, "sweep", plant, n, start, seeds if start == "random" or plant == "cellulo" else 1)
            print(
                f"| {plant} | {n} | {start} | {len(found)} | {three([each.times for each in found])} "
                f"| {three([each.reachable for each in found])} | {100 * min(each.share for each in found):.1f} % "
                f"| {ANCHORS['sweep', n]} | {safe(found)} |",
                flush=True,
            )


def walks(pool: Any, seeds: int, plants: Sequence[str]) -> None:
    print("\n| random walk | n | runs | t90 / t95 / t99 s, medians | of what can be reached | published t90 / t95 "
          f"| {SAFE} |\n|---|---|---|---|---|---|---|---|---|---|", flush=True)  # fmt: skip
    for plant, n in itertools.product(plants, (1, 4, 6)):
        found = measure(pool, "random-walk", plant, n, "random", seeds)
        print(
            f"| {plant} | {n} | {len(found)} | {three([each.times for each in found])} "
            f"| {three([each.reachable for each in found])} | {ANCHORS['random-walk', n]} | {safe(found)} |",
            flush=True,
        )


def deployments(pool: Any, seeds: int, plants: Sequence[str]) -> None:
    print("\n| behaviour | plant | n | runs | H at the end, median / worst | least known | worst over it "
          f"| s to 2 %, median | {SAFE} |\n|---|---|---|---|---|---|---|---|---|---|---|---|", flush=True)  # fmt: skip
    for behaviour, plant, (n, least) in itertools.product(DEPLOY, plants, OPTIMA.items()):
        found = measure(pool, behaviour, plant, n, "random", seeds)
        costs = [each.cost for each in found]
        print(
            f"| {behaviour} | {plant} | {n} | {len(found)} | {np.median(costs):.5f} / {max(costs):.5f} | {least:.5f} "
            f"| {100 * (max(costs) / least - 1):+.2f} % | {middle([each.settled for each in found])} | {safe(found)} |",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--plant", choices=tuple(LIMITS), action="append")
    parser.add_argument("--part", choices=("sweep", "walk", "deploy"), action="append")
    parser.add_argument("--jobs", type=int, default=1, help="processes side by side")
    args = parser.parse_args()
    parts = {"sweep": sweeps, "deploy": deployments, "walk": walks}
    with Pool(args.jobs) as pool:
        for part in args.part or parts:
            parts[part](pool, args.seeds, args.plant or tuple(LIMITS))


if __name__ == "__main__":
    main()
