"""Does a page slow the loop? `conductor.step` with nobody looking and with three, in one live session.

20 virtual robots at 20 Hz and two bands at 100 Hz in real time, calibrated, the cursor on; spans with and without
viewers take turns, so that whatever else the machine does meets both. ``lines`` acknowledge every frame at once and
draw nothing; ``tabs`` are headless Chromium, which draws on the cores that the loop needs too where there is no
graphics card. Run: python benchmarks/page/steps.py
"""

import argparse
import asyncio
import tempfile
from pathlib import Path

import numpy as np
from room import twenty_robots
from watched import NOBODY, page, watch

from armspan.config.house import open_house
from armspan.config.page.host import PageHost
from armspan.config.session_files import fresh_log
from armspan.session import Session

WATCHED = {"nobody": NOBODY, "3 lines": ("lines", "3"), "3 tabs": ("tabs", "table", "table", "table")}


async def opened(host: PageHost) -> Session:
    """The room's session as soon as its person is calibrated."""

    async def steer() -> None:
        await host.play(open_house(host.room, Path(), seconds=3600.0), "steering", fresh_log("steps", host.sessions))

    await host.begin("steering", steer)
    for _ in range(300):
        await asyncio.sleep(1)
        sight = host.session.conductor.sight() if host.session is not None else None  # type: ignore[attr-defined]
        if sight is not None and sight.place is not None:
            assert host.session is not None
            return host.session
    raise SystemExit(f"the virtual person was not calibrated: {host.status}")


async def measure(seconds: float, rounds: int, folder: Path) -> None:
    host = PageHost(twenty_robots(), "steps", sessions=folder)
    steps: dict[str, dict[str, list[float]]] = {name: {} for name in WATCHED}
    p99s: dict[str, list[float]] = {name: [] for name in WATCHED}
    async with page(host, host.shown, lambda: host.press("stop")) as (live, address):  # type: ignore[arg-type]
        session = await opened(host)
        took = session.counters.step_us
        for _ in range(rounds):
            for name, viewers in WATCHED.items():
                before = {kind: len(times) for kind, times in took.items()}
                await watch(live, address, viewers, seconds)
                new = {kind: times[before.get(kind, 0) :] for kind, times in took.items()}
                for kind, times in new.items():
                    steps[name].setdefault(kind, []).extend(times)
                p99s[name].append(float(np.percentile(np.concatenate(list(new.values())), 99)))
        await host.close()
    report(steps, p99s)


def report(steps: dict[str, dict[str, list[float]]], p99s: dict[str, list[float]]) -> None:
    print("| who looks | event | steps | p50 us | p99 us | max us |\n|---|---|---|---|---|---|")
    for name, kinds in steps.items():
        whole = [time for times in kinds.values() for time in times]
        for kind, times in [*sorted(kinds.items(), key=lambda item: -len(item[1]))[:3], ("all", whole)]:
            low, high = np.percentile(times, [50, 99])
            print(f"| {name} | {kind} | {len(times)} | {low:.0f} | {high:.0f} | {max(times):.0f} |")
    nobody = float(np.median(p99s["nobody"]))
    for name, found in p99s.items():
        change = 100 * (float(np.median(found)) / nobody - 1)
        spans = ", ".join(f"{value:.0f}" for value in found)
        print(f"{name}: p99 of each span {spans} us; their median {change:+.0f} % of that with nobody")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0, help="each")
    parser.add_argument("--rounds", type=int, default=4)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        asyncio.run(measure(args.seconds, args.rounds, Path(name)))


if __name__ == "__main__":
    main()
