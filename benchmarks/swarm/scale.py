"""Time of a tick as the swarm grows: simulation and last filter, beside ir-sim on the same scene.

Robots start evenly on a square sheet of 0.16 m² each and drive to random goals; whoever arrives gets another one, so
that all are busy all the time. Every 50 ms all are commanded. "Simulation" is the plant: its own steps, the commands it
takes and the states it tells; "filter" is `SafetyFilter.watch` and ``admit``. ir-sim (2.12, omni robots of the same
size and speed, no display, no collision checks) does the same starts and goals with its own ORCA (RVO2 in C++) and with
its own RVO (Python), without latency, noise or leases. One process, one thread. Run: python benchmarks/swarm/scale.py
Prints Markdown tables.
"""

import argparse
import contextlib
import io
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

import numpy as np
import yaml

from armspan.frames import Array
from armspan.records import Command, GoTo, RobotState, Sheet
from armspan.simulation.discs import IdealDiscs
from armspan.simulation.robots import VirtualRobots
from armspan.swarm.limits import Limits
from armspan.swarm.safety import SafetyFilter

ROBOTS = (20, 50, 200, 500, 1000)
PITCH, TICK, SPEED, ARRIVED, MARGIN = 0.4, 0.05, 0.15, 0.01, 0.05
ORCA = {"name": "orca", "neighborDist": 1.0, "maxNeighbors": 10, "timeHorizon": 1.0, "timeHorizonObst": 1.0}
RVO = {"name": "rvo", "vxmax": SPEED, "vymax": SPEED, "acce": 10.0, "mode": "rvo", "neighbor_threshold": 1.0}


def scene(n: int, rng: np.random.Generator) -> tuple[float, Array, Callable[[int], Array]]:
    """The side of the sheet [m], the starts (n, 2), and what draws so many goals."""
    side = PITCH * n**0.5
    columns = int(np.ceil(n**0.5))
    line = (np.arange(columns) + 0.5) * side / columns
    starts = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)[:n]
    return side, starts, lambda count: rng.uniform(MARGIN, side - MARGIN, (count, 2))


class Spent:
    """Milliseconds of each tick, of the plant and of the filter."""

    def __init__(self) -> None:
        self.plant: list[float] = []
        self.filter: list[float] = []

    def row(self, n: int, who: str) -> str:
        """A row of the table."""
        plant, safety = np.array(self.plant), np.array(self.filter)
        both = plant + safety
        return (
            f"| {n} | {who} | {np.median(plant):.2f} | {np.median(safety):.2f} / {np.percentile(safety, 99):.2f} "
            f"| {np.median(both):.2f} / {np.percentile(both, 99):.2f} | {1000 * TICK / both.mean():.1f} x "
            f"| {1000 * np.median(both) / n:.0f} | {1000 * np.median(safety) / n:.0f} |"
        )


def ours(n: int, plant: str, ticks: int, seed: int) -> tuple[Spent, int, float]:
    """The time that a run took, the collisions in it, and how far a robot drove on average [m]."""
    rng = np.random.default_rng(seed)
    side, starts, draw = scene(n, rng)
    names, sheet = [f"r{k:04}" for k in range(n)], Sheet(side, side)
    robots: IdealDiscs | VirtualRobots = (
        IdealDiscs(names, starts, sheet)
        if plant == "disc"
        else VirtualRobots(names, starts, np.zeros(n), sheet, np.random.default_rng(seed))
    )
    limits = Limits(body_radius_m=0.0375, latency_s=0.0) if plant == "disc" else Limits()
    safety = SafetyFilter(limits, sheet, np.random.default_rng(seed))
    states: dict[str, RobotState] = {}
    goals, spent, driven, was = draw(n), Spent(), 0.0, starts
    for k in range(ticks):
        t = TICK * k
        began = time.perf_counter()
        states.update({state.robot: state for _, state in robots.advance(t)})
        stepped = time.perf_counter()
        at = robots.truth()[0]
        driven, was = driven + float(np.hypot(*(at - was).T).mean()), at
        there = np.hypot(*(at - goals).T) < ARRIVED
        goals[there] = draw(int(there.sum()))
        wishes = [GoTo(t, name, (x, y), SPEED, t + 0.3) for name, (x, y) in zip(names, goals.tolist(), strict=True)]
        asked = time.perf_counter()
        commands: list[Command] = [*safety.watch(t, states), *safety.admit(t, wishes, states)]
        answered = time.perf_counter()
        for command in commands:
            robots.command(t, command)
        if len(states) == n:
            spent.plant.append(1000 * (stepped - began + time.perf_counter() - answered))
            spent.filter.append(1000 * (answered - asked))
    return spent, robots.contacts, driven


def irsim_ms(n: int, behaviour: str, bearable: float, seed: int) -> tuple[float, float, int]:
    """Milliseconds of ir-sim's step and of making the scene, and how many steps fitted into the time [s]."""
    with contextlib.redirect_stdout(io.StringIO()):
        import irsim
    side, starts, draw = scene(n, np.random.default_rng(seed))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(irsim_scene(side, starts, draw(n), behaviour)), encoding="utf-8")
        began = time.perf_counter()
        env = irsim.make(str(path), display=False, headless=True, disable_all_plot=True, log_level="ERROR")
    made = time.perf_counter() - began
    times: list[float] = []
    while sum(times) < bearable and len(times) < 200:
        for robot in env.robot_list:
            if robot.arrive:
                x, y = draw(1)[0].tolist()
                robot.set_goal([x, y, 0.0], init=False)
        began = time.perf_counter()
        env.step()
        times.append(time.perf_counter() - began)
    env.end(0)
    return 1000 * float(np.median(times)), 1000 * made, len(times)


def irsim_scene(side: float, starts: Array, goals: Array, behaviour: str) -> dict[str, object]:
    """The scene as ir-sim wants it."""
    robots: dict[str, object] = {
        "number": len(starts),
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.0375},
        "distribution": {"name": "manual"},
        "state": [[x, y, 0.0] for x, y in starts.tolist()],
        "goal": [[x, y, 0.0] for x, y in goals.tolist()],
        "vel_max": [SPEED, SPEED],
        "vel_min": [-SPEED, -SPEED],
        "goal_threshold": ARRIVED,
        **({"group_behavior": ORCA | {"safe_radius": 0.005}} if behaviour == "orca" else {"behavior": RVO}),
    }
    world = {
        "width": side,
        "height": side,
        "step_time": TICK,
        "sample_time": TICK,
        "control_mode": "auto",
        "collision_mode": "unobstructed",
    }
    return {"world": world, "robot": [robots]}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ticks", type=int, default=400, help="20 a second")
    parser.add_argument("--bearable", type=float, default=60.0, help="seconds for each of ir-sim's runs at most")
    parser.add_argument("--robots", type=int, nargs="+", default=ROBOTS)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    print(
        "| n | plant | simulation ms | filter ms, median / p99 | together ms, median / p99 | times real time "
        "| µs a robot | of these the filter's |"
    )
    print("|---|---|---|---|---|---|---|---|")
    notes: list[str] = []
    for n in args.robots:
        for plant in ("disc", "cellulo"):
            spent, contacts, driven = ours(n, plant, args.ticks, args.seed)
            print(spent.row(n, plant), flush=True)
            notes.append(f"- {n} {plant}: {contacts} collisions, {driven / (args.ticks * TICK):.3f} m/s on average")
    print("\n", *notes, sep="\n")
    print("\n| n | ir-sim | ms a step | times real time | µs a robot | scene made in ms | steps |")
    print("|---|---|---|---|---|---|---|")
    for behaviour in ("orca", "rvo"):
        for n in args.robots:
            ms, made, steps = irsim_ms(n, behaviour, args.bearable, args.seed)
            print(
                f"| {n} | {behaviour} | {ms:.1f} | {1000 * TICK / ms:.2f} x | {1000 * ms / n:.0f} "
                f"| {made:.0f} | {steps} |",
                flush=True,
            )
            if ms * 4 > 1000 * args.bearable:
                break


if __name__ == "__main__":
    main()
