"""What the page costs: 20 virtual robots at 50 Hz and 12 channels of two bands, shown to none, one and three.

The records of the room go straight into what the page shows (no conductor decides meanwhile; what is believed is asked
of a calibrated one), so that the process's CPU time without viewers is taken away from that with them. ``lines``
acknowledge every frame at once: all 50 frames a second are sent. ``tabs`` are headless Chromium, which here draws
without a graphics card on the cores that the server needs too. Run: python benchmarks/page/load.py
"""

import argparse
import asyncio
import math
import statistics
from collections.abc import Iterator

from room import calibrated
from watched import NOBODY, page, watch

from armspan.conductor import Settings
from armspan.records import ImuSample, Light, Pointed, Record, RobotState
from armspan.web.host import Device, Status
from armspan.web.shown import Shown

HZ = 50
WATCHED = {
    "nobody": NOBODY,
    "1 line": ("lines", "1"),
    "3 lines": ("lines", "3"),
    "1 tab: scene, plan and signals": ("tabs", "all"),
    "1 tab: plan and signals": ("tabs", "flat"),
    "3 tabs: scene, plan and signals": ("tabs", "all", "all", "all"),
}


class Still:
    """A host that runs nothing."""

    status = Status(activity="steering")

    def __init__(self, settings: Settings) -> None:
        self.settings = settings

    def devices(self) -> list[Device]:
        """None."""
        return []

    async def press(self, name: str, value: str = "") -> None:
        """Nobody is there to be told."""

    async def steer(self) -> None:
        """Nothing to open."""

    async def close(self) -> None:
        """Nothing to end."""


def records(t: float, settings: Settings) -> Iterator[Record]:
    """What a room tells within 20 ms: every robot moved and one light changed, two samples of either band, the spot."""
    for k, robot in enumerate(settings.robots):
        turn = t + k
        xy = (0.3 + 0.35 * (k % 5) + 0.05 * math.cos(turn), 0.25 + 0.33 * (k // 5) + 0.05 * math.sin(turn))
        yield RobotState(t, robot, xy, turn % (2 * math.pi), False, 0.8)
    lit = settings.robots[int(t * HZ) % len(settings.robots)]
    yield Light(t, lit, (255, 255 * (int(t * HZ) % 2), 0), int(t * HZ) % 6)
    for band in settings.bands:
        for dt in (0.0, 0.01):
            now = t + dt
            acc = (9.81 * math.sin(3 * now), 9.81 * math.cos(3 * now), math.sin(17 * now))
            yield ImuSample(now, band.name, acc, (math.sin(5 * now), 0.2, math.cos(7 * now)))
    spot = (1.0 + 0.3 * math.cos(t), 0.7 + 0.2 * math.sin(t))
    yield Pointed(t, settings.bands[0].name, spot, ((4e-4, 1e-4), (1e-4, 3e-4)), settings.robots[7], None, 0.93, True)


async def feed(shown: Shown, settings: Settings) -> None:
    """The records at their own pace, until cancelled."""
    loop = asyncio.get_running_loop()
    began, t = loop.time(), 0.0
    while True:
        for record in records(t, settings):
            shown(record)
        t += 1 / HZ
        await asyncio.sleep(max(began + t - loop.time(), 0.0))


async def measure(seconds: float, rounds: int) -> None:
    mind, shown = await calibrated(5.0, []), Shown()
    shown.clear(mind, simulated=True)  # type: ignore[arg-type]
    host = Still(mind.settings)
    found: dict[str, list[tuple[float, ...]]] = {name: [] for name in WATCHED}
    async with page(host, shown, lambda: host.press("stop")) as (live, address), asyncio.TaskGroup() as group:
        feeding = group.create_task(feed(shown, mind.settings))
        for _ in range(rounds):
            for name, viewers in WATCHED.items():
                seen = await watch(live, address, viewers, seconds)
                found[name].append((seen.cpu, seen.made, seen.received, seen.drawn, seen.size))
        feeding.cancel()
    print("| who looks | server's CPU, % of a core | of that the page's | made /s | got /s | drawn /s | kB/s each |")
    print("|---|---|---|---|---|---|---|")
    alone = statistics.median(row[0] for row in found["nobody"])
    for name, rows in found.items():
        cpu, made, got, drawn, size = (statistics.median(column) for column in zip(*rows, strict=True))
        print(
            f"| {name} | {100 * cpu:.1f} | {100 * (cpu - alone):.1f} | {made:.1f} | {got:.1f} | {drawn:.1f} | "
            f"{size / 1000:.0f} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=8.0, help="each")
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    asyncio.run(measure(args.seconds, args.rounds))


if __name__ == "__main__":
    main()
