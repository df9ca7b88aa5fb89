"""``armspan study``: where pointing errors come from, computed afresh."""

import argparse
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from multiprocessing import get_context, parent_process
from pathlib import Path
from tempfile import TemporaryFile
from threading import Thread

import msgspec
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table as Shown

from armspan.cli import ranges
from armspan.cli.results import Results
from armspan.cli.study_tables import value_tables
from armspan.config.error_recordings import read_error_recordings
from armspan.errors import ConfigError
from armspan.study.pointing_error.monte_carlo import Mapper
from armspan.study.pointing_error.pictures import draw_all
from armspan.study.pointing_error.reproduction import reproduction
from armspan.study.pointing_error.tables import Table, tables
from armspan.study.pointing_error.value import COUNT, PEOPLE, study
from armspan.study.pointing_error.value_pictures import draw_values


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "study",
        help="where pointing errors come from: the report's section 1.3, and beyond",
        description="Studies whose numbers and pictures are computed afresh; see docs/where-errors-come-from.md.",
    )
    studies = parser.add_subparsers(dest="study", metavar="STUDY", required=True, title="studies")
    one = studies.add_parser(
        "pointing-error",
        help="what a wrong angle, a wrong measure or a moved user costs",
        description=(
            "The report's simulation of wrong angles and wrong measures in three readings; the errors that calibration "
            "does not take in; simulated calibrations by the hundred thousand; the value of more stops, a second band, "
            "feedback, and static against moving pairs, simulated and, with --recordings, real."
        ),
    )
    add = one.add_argument
    add("--json", action="store_true", help="print one JSON object")
    add("--picture", type=Path, metavar="DIR", help="draw the pictures there")
    add("--recordings", type=Path, metavar="DIR", help="real recordings: a folder with people/ and pointing/")
    add(
        "--count",
        type=_count,
        default=COUNT,
        metavar="N",
        help="calibrations, 100 or more (default: %(default)s)",
    )
    add("--people", type=_people, default=PEOPLE, metavar="N", help="virtual people (default: %(default)s)")
    add("--seed", type=ranges.seed, default=0, metavar="N", help="another draw of everything (default: %(default)s)")
    parser.set_defaults(run=run)


def _count(text: str) -> int:
    return ranges.integer(text, "a number of calibrations", 100, 10_000_000)


def _people(text: str) -> int:
    return ranges.integer(text, "a number of people", 1, 10_000)


def run(args: argparse.Namespace) -> int:
    """Compute, draw, and print the results on stdout; the exit code is 0."""
    recordings = read_error_recordings(args.recordings) if args.recordings else None
    if args.picture:
        _keep_what_is_there(args.picture)
        _make(args.picture)
    with _progress() as told, _mapper() as mapper:
        told("the report's section 1.3", 0, 1)
        found = reproduction()
        values = study(recordings, count=args.count, people=args.people, seed=args.seed, progress=told, mapper=mapper)
    if args.picture:
        names = [*draw_all(found, args.picture), *(path.name for path in draw_values(args.picture, values))]
        print(f"armspan study: drawn in {args.picture}: {', '.join(names)}", file=sys.stderr)
    if args.json:
        document = {"reproduction": asdict(found), "values": values.document()}
        sys.stdout.buffer.write(msgspec.json.encode(document) + b"\n")
    else:
        _show(Results(), (*tables(found), *value_tables(values)))
    if recordings is None:
        print("armspan study: simulated only; --recordings DIR adds real people", file=sys.stderr)
    return 0


def _make(folder: Path) -> None:
    """Make the folder, and see that pictures can be written into it before minutes are spent on them."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()
    except OSError as error:
        raise ConfigError(
            f"{folder} cannot be a folder for pictures ({error.strerror}): name another one with --picture"
        ) from None


def _keep_what_is_there(folder: Path) -> None:
    """Refuse to draw over pictures (ConfigError): they may have taken many minutes."""
    there = sorted(folder.glob("*.png"))
    if there:
        raise ConfigError(f"{there[0]} exists and is kept: name a folder without pictures with --picture")


@contextmanager
def _mapper() -> Iterator[Mapper]:
    """``map`` over all cores; the answers do not depend on how many there are."""
    cores = os.cpu_count() or 1
    if cores == 1:
        yield map
        return
    pool = ProcessPoolExecutor(min(cores, 8), get_context("spawn"), initializer=_end_with_parent)
    try:
        _start_deaf(pool, min(cores, 8))
        yield pool.map
    finally:
        pool.shutdown(cancel_futures=True)


def _start_deaf(pool: ProcessPoolExecutor, workers: int) -> None:
    """Start the workers with Ctrl-C ignored, which they inherit: a terminal sends it to all, and one shall answer."""
    heard = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        for _ in range(workers):
            pool.submit(os.getpid)
    finally:
        signal.signal(signal.SIGINT, heard)


def _end_with_parent() -> None:
    """In a worker: end when the command is killed; a worker of a pool waits for its next task forever."""
    Thread(target=_outlive, daemon=True).start()


def _outlive() -> None:
    if (parent := parent_process()) is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _progress() -> Iterator[Callable[[str, int, int], None]]:
    """A bar on stderr, where somebody is looking."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        yield partial(_advance, bar, bar.add_task("begins", total=1))


def _advance(bar: Progress, task: TaskID, what: str, done: int, total: int) -> None:
    bar.update(task, description=what, completed=done, total=total)


def _show(console: Console, told: Iterable[Table]) -> None:
    for table in told:
        shown = Shown(*(escape(column) for column in table.columns), title=escape(table.title))
        for row in table.rows:
            shown.add_row(*(escape(cell) for cell in row))
        console.print(shown)
