"""Playing a session from the command line: the log opened, signals heeded, results read back from the log."""

import asyncio
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np

from armspan.cli.typed import typed
from armspan.config.house import House
from armspan.config.session_files import make_folder
from armspan.log import LogFile, LogWriter, read
from armspan.ports import Sink
from armspan.records import Record, Say
from armspan.session import Counters, Session
from armspan.study.account import Account, account


def play(house: House, path: Path, *, live: bool, overwrite: bool = False, sinks: Sequence[Sink] = ()) -> Counters:
    """Run a house's session into a log; robots are stopped and the log is whole on Ctrl-C and SIGTERM too.

    Raises:
        LogError: the log cannot be made, or exists.
        KeyboardInterrupt: after Ctrl-C or SIGTERM, when all is closed.

    """
    make_folder(path.parent)
    with told_when_interrupted(path), LogWriter(path, house.header, overwrite=overwrite or _empty(path)) as log:
        session = asyncio.run(_play(house, live, [log, *sinks]))
    return session.counters


@contextmanager
def told_when_interrupted(path: Path) -> Iterator[None]:
    """Say where the log is, and that the robots stand, when a session is broken off."""
    try:
        yield
    except KeyboardInterrupt:
        print(f"the robots were stopped; the log is {path}", file=sys.stderr)
        raise


async def _play(house: House, live: bool, sinks: list[Sink]) -> Session:
    session = house.session(sinks)
    task = asyncio.ensure_future(house.run(session, live=live))
    stop_on_signals(task)
    try:
        with typed(house.lead.press) if house.doors else nullcontext():
            await task
    except asyncio.CancelledError:
        raise KeyboardInterrupt from None
    return session


def stop_on_signals(task: "asyncio.Task[None] | asyncio.Future[None]") -> None:
    """Let Ctrl-C and SIGTERM cancel a session, so that its robots are stopped on the way out."""
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        try:
            loop.add_signal_handler(number, task.cancel)
        except (
            NotImplementedError,
            RuntimeError,
        ):  # Windows, or not the main thread: Python's own Ctrl-C remains
            return


def _empty(path: Path) -> bool:
    return path.is_file() and path.stat().st_size == 0


def read_account(path: Path, house: House) -> tuple[LogFile, Account]:
    """The log just written, and what it shows: the results come from the file, not from memory."""
    log, settings = read(path), house.settings
    found = account(
        log.records, settings.body, settings.sheet, settings.zones, settings.limits, settings.light_height_m
    )
    return log, found


def step_times(counters: Counters) -> dict[str, object]:
    """Median, 99th percentile and maximum of the conductor's step [µs], over all events and by kind."""

    def of(values: Sequence[float]) -> dict[str, float]:
        p50, p99 = np.percentile(values, [50, 99])
        return {"p50": round(float(p50), 1), "p99": round(float(p99), 1), "max": round(float(max(values)), 1)}

    every = [value for values in counters.step_us.values() for value in values]
    if not every:
        return {"p50": None, "p99": None}
    return {**of(every), "by_kind": {kind: of(values) for kind, values in sorted(counters.step_us.items())}}


def talk(record: Record) -> None:
    """A sink that repeats on stderr what the person is told."""
    if isinstance(record, Say):
        print(f"{record.t:7.1f} s  {record.text}", file=sys.stderr, flush=True)
