"""Bands and robots through their wires on bad radios, for ten minutes in real time: gaps, losses, stops, recoveries.

Two emulated MetaWear bands with 1 % of their packets lost and links that break three times a minute, four emulated
Cellulo robots whose links break in turn, the real drivers and the real conductor between them; robots walk at random
whenever they may. What the robots really do is taken from the emulator, what a session knows from its records.
"""

import argparse
import asyncio
import math
import time
from collections import defaultdict

import numpy as np

from armspan.config.demo_room import demo_room
from armspan.config.emulated import RADIO
from armspan.config.house import open_emulated
from armspan.devices.cellulo.driver import CelluloRelay
from armspan.devices.cellulo.faults import Trouble
from armspan.links.waves import LinkFaults
from armspan.records import ImuSample, Link, Press, Tick
from armspan.simulation.script import Script

REST = 0.005
"""A robot slower than this [m/s] stands."""


class Watch:
    """What happens, every 5 ms: which bands are in reach, how fast the robots are and where."""

    def __init__(self, house, emulation):
        self.house, self.emulation = house, emulation
        self.rows, self.links, self.delays, self.steps = [], [], defaultdict(list), []
        self._decided = None

    async def look(self):
        """Look, for ever."""
        world, now = self.emulation.world, self.house.now
        while True:
            away = [self.emulation.air.waves.reaches[worn.board.address].away for worn in self.emulation.worn]
            xy, _, velocity = world.robots.truth()
            self.rows.append((now(), away, np.hypot(*velocity.T), xy))
            await asyncio.sleep(0.005)

    def hear(self, record):
        """Hear a record of the session."""
        if isinstance(record, ImuSample):
            self.delays[record.source].append(self.house.now() - record.t)
        elif isinstance(record, Link):
            self.links.append((self.house.now(), record.source, record.up, record.fresh))
        elif isinstance(record, Tick):
            self._decided = time.perf_counter()

    def up(self):
        """The devices whose links are up."""
        last = {source: up for _, source, up, _ in self.links}
        return {source for source, up in last.items() if up}

    def wrote(self):
        """Bytes for robots left."""
        if self._decided is not None:
            self.steps.append(time.perf_counter() - self._decided)
            self._decided = None


async def leading(house, emulation, watch, seconds):
    """The world's events, and whoever waits at the table: they ask for a walk when nothing runs, and free robots."""
    asked = 3.0
    async for event in emulation.source(house.now, seconds):
        yield event
        if isinstance(event, Tick) and event.t >= asked:
            asked = event.t + 0.5
            steering = watch.conductor._steering
            free = set(steering.filter.waiting) & watch.up()
            if (free or not steering.director.running) and not watch.conductor._silent:
                for robot in sorted(free):
                    yield Press(event.t, "resume", robot)
                yield Press(event.t, "behaviour", "random-walk")


async def play(house, emulation, watch, seconds):
    session = house.session([watch.hear])
    watch.conductor = session.conductor
    async with emulation.opened(house.now) as doors:
        session.swarm.add(doors.commanded)
        looking = asyncio.create_task(watch.look())
        try:
            await session.run(
                [leading(house, emulation, watch, seconds)], [driver.source() for driver in doors.drivers]
            )
        finally:
            looking.cancel()
        return doors, session


def spans(times, flags):
    """(from, to) of every stretch of time in which a flag is set."""
    found, since = [], None
    for t, flag in zip(times, flags, strict=True):
        if flag and since is None:
            since = t
        elif not flag and since is not None:
            found.append((since, t))
            since = None
    return found


def rests(times, speeds, t, most=3.0, still=REST):
    """How long after ``t`` [s] all have come to rest, NaN where they had been resting, inf where they do not."""
    at = np.searchsorted(times, t)
    if at >= len(times) or speeds[max(at - 1, 0)].max() < 0.02:
        return math.nan
    for k in range(at, len(times)):
        if speeds[k].max() < still:
            return times[k] - t
        if times[k] > t + most:
            break
    return math.inf


def told(values, scale=1000, unit="ms"):
    values = np.array([v for v in values if not math.isnan(v)])
    if not len(values):
        return "none"
    p50, p95 = np.percentile(values, [50, 95], method="higher")
    return f"{scale * p50:.0f} / {scale * p95:.0f} / {scale * values.max():.0f} {unit} (n = {len(values)})"


def report(house, emulation, watch, doors, session, seconds):
    times = np.array([row[0] for row in watch.rows])
    away = np.array([row[1] for row in watch.rows])
    speeds = np.array([row[2] for row in watch.rows])
    places = np.array([row[3] for row in watch.rows])
    lost_bands = sorted((a, k) for k in range(away.shape[1]) for a, _ in spans(times, away[:, k]))
    rows = [("bands' link losses", f"{len(lost_bands)} in {seconds / 60:.0f} min")]
    rows.append(
        (
            "all robots at rest after a band's loss, p50 / p95 / max",
            told([rests(times, speeds, t) for t, _ in lost_bands]),
        )
    )
    rows.append(
        (
            "the same below 25 and 2 mm/s",
            "; ".join(told([rests(times, speeds, t, still=still) for t, _ in lost_bands]) for still in (0.025, 0.002)),
        )
    )
    recovered = []
    for a, k in lost_bands:
        if a > seconds - 6.0:  # there is no time left to come back
            continue
        back = next((b for b0, b in spans(times, away[:, k]) if b0 >= a), None)
        name = emulation.worn[k].band.name
        up = next((t for t, source, is_up, _ in watch.links if source == name and is_up and t > a), math.inf)
        recovered.append(up - (back or a))
    rows.append(("band back in reach to link up, p50 / p95 / max", told(recovered)))
    fresh = sum(1 for _, source, up, new in watch.links if up and new and source in watch.delays)
    rows.append(("links that began anew", f"{fresh}"))
    names = emulation.world.robots.names
    own, ways, back = [], [], []
    for trouble in emulation.troubles:
        k = names.index(trouble.robot)
        for t in np.arange(trouble.at, seconds - 4.0, trouble.every or seconds):
            rest = rests(times, speeds[:, [k]], t)
            own.append(rest)
            at, end = np.searchsorted(times, [t, t + 2.0])
            if not math.isnan(rest):
                ways.append(float(np.linalg.norm(np.diff(places[at:end, k], axis=0), axis=1).sum()))
            ends = t + trouble.seconds
            back.append(
                next((u - ends for u, s, up, _ in watch.links if s == trouble.robot and up and u > ends), math.inf)
            )
    rows.append(("robot at rest after its own link's loss, p50 / p95 / max", told(own)))
    rows.append(("way from there, p50 / p95 / max", told(ways, 1000, "mm")))
    rows.append(("robot's link back in reach to up, p50 / p95 / max", told(back)))
    delays = np.array([d for each in watch.delays.values() for d in each])
    steps = np.array(watch.steps)
    rows.append(
        ("sample measured to session, p50 / p95", "{:.1f} / {:.1f} ms".format(*1000 * np.percentile(delays, [50, 95])))
    )
    rows.append(
        ("tick to robot bytes written, p50 / p95", "{:.1f} / {:.1f} ms".format(*1000 * np.percentile(steps, [50, 95])))
    )
    both = np.random.default_rng(0).choice(delays, 20000) + np.random.default_rng(1).choice(steps, 20000)
    rows.append(
        (
            "sample measured to bytes written without the wait for a tick, p95",
            f"{1000 * np.percentile(both, 95):.1f} ms",
        )
    )
    for driver in doors.drivers:
        if hasattr(driver, "report"):
            rows.append((f"{driver.report().name}: counters", str(driver.report())[:400]))
    rows.append(("samples dropped, not finite", f"{session.counters.dropped}, {session.counters.not_finite}"))
    print("| | |\n|---|---|")
    for what, value in rows:
        print(f"| {what} | {value} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--breaks", type=float, default=3.0, help="a minute, for each band")
    parser.add_argument("--loss", type=float, default=0.01)
    parser.add_argument("--profile", choices=("fusion", "raw"), default="fusion")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    room = demo_room(args.seed, bands=2, trials=1)
    house = open_emulated(room, "metawear", "cellulo")
    house.world.script = Script((), start=math.inf)  # nobody asks the person for anything: they stand, breathe, sway
    names = [robot.name for robot in room.robots]
    troubles = [Trouble("link-loss", 10.0 + 7.0 * k, 3.0, name, 29.0) for k, name in enumerate(names)]
    faults = LinkFaults(
        RADIO.loss if args.loss is None else args.loss,
        run=RADIO.run,
        burst_s=RADIO.burst_s,
        breaks_per_minute=args.breaks,
    )
    emulation = house.emulation
    emulation.faults, emulation.troubles, emulation.profile = faults, tuple(troubles), args.profile
    watch = Watch(house, emulation)
    write = CelluloRelay._write

    def watched(self, *more):
        write(self, *more)
        watch.wrote()

    CelluloRelay._write = watched
    doors, session = asyncio.run(play(house, emulation, watch, args.seconds))
    report(house, emulation, watch, doors, session, args.seconds)


if __name__ == "__main__":
    main()
