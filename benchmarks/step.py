"""The conductor's speed: time of every step by kind of event, of a whole replay and of the session's loop.

Simulated: two bands at 100 Hz, 20 robots, six zones, cursor on, calibrated and then 60 s of pointing. The log's
events go through fresh conductors; beside it, in the same run and on the same events, the least that any program
would do: decode the record's JSON and, for samples, one update of VQF. Run: python benchmarks/step.py
Prints Markdown tables, times in microseconds where nothing else is said.
"""

import argparse
import asyncio
import platform
import tempfile
import time
from collections.abc import AsyncGenerator, Callable, Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
from vqf import VQF

from armspan.cli.play import play
from armspan.cli.replay import decisions, first_difference, settings_of
from armspan.conductor import Conductor, Settings
from armspan.config.demo_room import demo_room
from armspan.config.house import open_house
from armspan.config.room_file import RoomFile, ZoneEntry
from armspan.config.virtual_entries import SimulatedBand, SimulatedPerson, SimulatedRobot, Simulation
from armspan.devices.replay import NoSwarm
from armspan.log import LogFile, LogWriter, read
from armspan.ports import Sink
from armspan.records import EVENTS, Calibrated, Event, ImuSample, Record, Sheet, Tick
from armspan.session import FastPace, Session
from armspan.simulation.script import Phase

SHEET = Sheet(2.0, 1.5)
STOPS = ((0.12, 0.12), (1.88, 0.12), (1.88, 1.38), (0.12, 1.38))
ZONES = ("garden", "harbour", "market", "mill", "school", "tower")
SETTING_UP, CALIBRATING, POINTING = "Tick, setting up", "Tick that calibrates", "Tick, calibrated"


def big_room(fusion: Literal["onboard", "raw"], robots: int = 20, seed: int = 1) -> RoomFile:
    """Two bands, robots in rows on a big sheet, two rows of hexagonal zones between them."""
    places = [(0.3 + 0.35 * (k % 5), 0.25 + 0.33 * (k // 5)) for k in range(robots)]
    middles = [(0.475 + 0.525 * (k % 3), 0.415 + 0.66 * (k // 3)) for k in range(len(ZONES))]
    return RoomFile(
        sheet=SHEET,
        bands=(SimulatedBand("wrist", fusion=fusion), SimulatedBand("upperarm", "upperarm", fusion=fusion)),
        robots=tuple(SimulatedRobot(f"robot{k:02}", place, 37.0 * k % 360) for k, place in enumerate(places)),
        zones=tuple(ZoneEntry(name, _hexagon(*xy)) for name, xy in zip(ZONES, middles, strict=True)),
        stops_m=STOPS,
        simulation=Simulation(seed, 0.75, SimulatedPerson((1.0, 1.75), trials=200, feedback="on")),
    )


def _hexagon(x: float, y: float, radius: float = 0.08) -> tuple[tuple[float, float], ...]:
    angles = np.arange(6) * np.pi / 3
    return tuple((round(x + radius * float(np.cos(a)), 4), round(y + radius * float(np.sin(a)), 4)) for a in angles)


def pointing_session(room: RoomFile, seconds: float, folder: Path) -> tuple[LogFile, float]:
    """The log of a session that ends ``seconds`` after the first calibration, and how long it took [s]."""
    house, path, until = open_house(room, seconds=600.0), folder / "session.mcap", [np.inf]

    def end_in_time(record: Record) -> None:
        if isinstance(record, Calibrated):
            until[0] = min(until[0], record.t + seconds)
        if record.t >= until[0] and house.world:
            house.world.script.phase = Phase.DONE

    began = time.perf_counter()
    play(house, path, live=False, overwrite=True, sinks=[end_in_time])
    took = time.perf_counter() - began
    if not np.isfinite(until[0]):
        raise SystemExit("the virtual person was not calibrated: choose another seed")
    return read(path), took


# --- one step ------------------------------------------------------------------------------------------------


def step_times(events: list[Event], settings: Settings, replays: int) -> tuple[list[str], np.ndarray]:
    """Kinds (n,) of the events and microseconds (replays, n) of each one's step through fresh conductors."""
    rows, kinds = [], []
    for _ in range(replays + 1):  # the first one warms up
        conductor, kinds, row, calibrated = Conductor(settings), [], [], False
        for event in events:
            began = time.perf_counter_ns()
            outputs = conductor.step(event)
            row.append(time.perf_counter_ns() - began)
            now = isinstance(event, Tick) and any(isinstance(output, Calibrated) for output in outputs)
            kinds.append(kind_of(event, calibrated, now))
            calibrated = calibrated or now
        rows.append(row)
    return kinds, np.array(rows[1:]) / 1000


def kind_of(event: Event, calibrated: bool, now: bool) -> str:
    """What a table calls an event; ticks are told apart by what they have to do."""
    if not isinstance(event, Tick):
        return type(event).__name__
    return POINTING if calibrated else CALIBRATING if now else SETTING_UP


def least_times(events: list[Event], replays: int) -> np.ndarray:
    """Microseconds (replays, n) of what cannot be left out: decode the record, update VQF with a sample."""
    decoders = {kind: msgspec.json.Decoder(kind) for kind in EVENTS}
    lines = [(decoders[type(event)].decode, msgspec.json.encode(event)) for event in events]
    rows = []
    for _ in range(replays + 1):
        filters, row = {}, []
        for decode, line in lines:
            began = time.perf_counter_ns()
            event = decode(line)
            if isinstance(event, ImuSample):
                if event.source not in filters:
                    filters[event.source] = VQF(0.01)
                filters[event.source].update(np.array(event.gyr), np.array(event.acc))
            row.append(time.perf_counter_ns() - began)
        rows.append(row)
    return np.array(rows[1:]) / 1000


def step_table(title: str, kinds: list[str], steps: np.ndarray, least: np.ndarray) -> None:
    """Print the steps' times by kind of event beside those of the baseline."""
    print(f"\n{title}\n")
    print(
        "| event | count | p50 | p99 | max | max of each event's best replay | baseline p50 | baseline p99 | "
        "mean / baseline |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    names = np.array(kinds)
    for kind in sorted(set(kinds), key=lambda kind: -(names == kind).sum()):
        print(_row(kind, steps[:, names == kind], least[:, names == kind]))
    print(_row("all", steps, least))


def _row(kind: str, steps: np.ndarray, least: np.ndarray) -> str:
    (p50, p99), (low, high) = np.percentile(steps, [50, 99]), np.percentile(least, [50, 99])
    return (
        f"| {kind} | {steps.shape[1]} | {p50:.1f} | {p99:.1f} | {steps.max():.0f} | {steps.min(axis=0).max():.0f} | "
        f"{low:.1f} | {high:.1f} | {steps.mean() / least.mean():.1f} |"
    )


# --- the whole replay, the loop and the simulation -----------------------------------------------------------


def fastest(times: int, what: Callable[[], object]) -> float:
    """Seconds that ``what`` takes, the least of several times."""
    found = []
    for _ in range(times):
        began = time.perf_counter()
        what()
        found.append(time.perf_counter() - began)
    return min(found)


def first_minute(folder: Path) -> tuple[LogFile, float]:
    """The log of the demo's first 60 s: two bands, four robots; and how long it took [s]."""
    path, began = folder / "minute.mcap", time.perf_counter()
    play(open_house(demo_room(1, bands=2, feedback="on"), seconds=60.0), path, live=False, overwrite=True)
    return read(path), time.perf_counter() - began


def replay_row(name: str, log: LogFile, played: float, replays: int) -> str:
    """How long a session takes to read, decide anew and compare, beside the baseline."""
    settings, events = settings_of(log), events_in(log)
    if first_difference(log, settings) is not None:
        raise SystemExit(f"{name}: the replay differs")
    seconds = events[-1].t
    reading = fastest(replays, lambda: read(log.path))
    steps = fastest(replays, lambda: sum(1 for _ in decisions(log.records, settings)))
    whole = fastest(replays, lambda: first_difference(read(log.path), settings))
    least = float(least_times(events, replays).sum(axis=1).min()) / 1e6
    return (
        f"| {name} | {seconds:.0f} | {len(events)} | {reading:.2f} | {steps:.2f} | {whole:.2f} | "
        f"{seconds / whole:.0f} | {least:.2f} | {played:.2f} | {seconds / played:.0f} |"
    )


def events_in(log: LogFile) -> list[Event]:
    """What happened, without what was decided."""
    return [record for record in log.records if isinstance(record, EVENTS)]  # type: ignore[misc]


class Nothing:
    """A conductor that decides nothing: what is left is the loop."""

    def step(self, event: Event) -> list[Record]:
        """Nothing follows."""
        return []


async def _source(events: Iterable[Event], pace: Callable[[float], object] | None) -> AsyncGenerator[Event, None]:
    for event in events:
        if pace is not None:
            await pace(event.t)
        yield event


def loop_us(events: list[Event], sinks: list[Sink], *, paced: bool, replays: int) -> float:
    """Microseconds an event that the session's loop takes with a conductor that does nothing."""

    async def run() -> None:
        session = Session(Nothing(), NoSwarm(), sinks)
        if paced:
            door = FastPace(session).door()
            await session.run([door.through(_source(events, door))])
        else:
            await session.run([_source(events, None)])

    return fastest(replays, lambda: asyncio.run(run())) / len(events) * 1e6


def loop_table(events: list[Event], folder: Path, replays: int) -> None:
    """Print what the loop costs an event beside a plain ``for`` over the same events."""
    nothing = Nothing()
    plain = fastest(replays, lambda: [nothing.step(event) for event in events]) / len(events) * 1e6
    with LogWriter(folder / "loop.mcap", {}, overwrite=True) as log:
        rows = (
            ("plain loop, for comparison", plain),
            ("session, events let in as they come (live)", loop_us(events, [], paced=False, replays=replays)),
            ("session, paced event by event (replay in a room)", loop_us(events, [], paced=True, replays=replays)),
            ("session as they come, and the log written", loop_us(events, [log], paced=False, replays=replays)),
        )
    print("\nThe loop alone, with a conductor that does nothing\n\n| loop | us an event |\n|---|---|")
    for name, micros in rows:
        print(f"| {name} | {micros:.2f} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="of pointing after the calibration")
    parser.add_argument("--replays", type=int, default=5)
    args = parser.parse_args()
    print(f"{_processor()}, Python {platform.python_version()}, numpy {np.__version__}, vqf {version('vqf')}")
    with tempfile.TemporaryDirectory() as name:
        folder, events = Path(name), []
        rows = [replay_row("4 robots, two bands onboard", *first_minute(folder), args.replays)]
        for fusion in ("onboard", "raw"):
            log, took = pointing_session(big_room(fusion), args.seconds, folder)
            events = events_in(log)
            kinds, steps = step_times(events, settings_of(log), args.replays)
            title = f"Two bands ({fusion}), 20 robots, six zones, {events[-1].t:.0f} s, {args.replays} replays"
            step_table(title, kinds, steps, least_times(events, args.replays))
            rows.append(replay_row(f"20 robots, two bands {fusion}", log, took, args.replays))
        print("\nWhole sessions, best of several, seconds\n")
        print(
            "| session | length | events | read | steps | replay --check | x real time | baseline | "
            "simulated and logged in | x real time |"
        )
        print("|" + "---|" * 10)
        print("\n".join(rows))
        loop_table(events, folder, args.replays)


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(": ")[2] for line in lines if line.startswith("model name")), platform.machine())


if __name__ == "__main__":
    main()
