"""``armspan swarm``: a behaviour on simulated robots, and what it showed."""

import argparse
import asyncio
import math
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
from rich.markup import escape
from rich.table import Table

from armspan import __version__
from armspan.cli.demo import count, seed
from armspan.cli.play import stop_on_signals, talk
from armspan.cli.results import Results
from armspan.cli.run import positive
from armspan.cli.swarm_report import print_run, title
from armspan.config.doors import make_doors
from armspan.config.room_file import ZoneEntry, read_room
from armspan.config.session_files import make_folder
from armspan.config.swarm_act import Act, behind_relay, drive, simulate
from armspan.config.swarm_run import PLANTS, STARTS, SwarmRun, Wanted, run_in_room, swarm_run
from armspan.devices.cellulo.emulator import addresses
from armspan.errors import ConfigError, DataError
from armspan.log import LogWriter
from armspan.ports import Sink
from armspan.records import Sheet, Vec2
from armspan.session import Stopwatch
from armspan.study.swarm_picture import draw_swarm
from armspan.swarm.director import DICTIONARY, MAKERS, STOP

SHEET, RELAY_SHEET = Sheet(1.0, 1.0), Sheet(0.8, 0.6)
"""The sheet where none is told: the anchors' square metre, and the emulated robots'."""

ROBOTS = 4
PLANT, START = PLANTS[0], STARTS[0]


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "swarm",
        help="run a behaviour on simulated or real robots, and measure it",
        description="Run a behaviour of the swarm on simulated robots as fast as it goes, or in real time on a room's "
        "real ones or on Cellulo robots behind a relay, through the same safety filter as everything else. Write "
        "places as X,Y in metres from the sheet's corner, negative ones as --user=-0.2,0.5.",
    )
    parser.add_argument("behaviour", nargs="?", metavar="BEHAVIOUR", help="see --list; sweep@ZONE covers one zone")
    parser.add_argument("--list", action="store_true", help="tell all behaviours, and which gesture begins which")
    parser.add_argument("--robots", type=count, metavar="N", help=f"default: {ROBOTS}")
    parser.add_argument("--seconds", type=positive, default=60.0, metavar="S", help="default: %(default)s")
    parser.add_argument("--seed", type=seed, default=0, metavar="K", help="default: %(default)s")
    parser.add_argument(
        "--latency-ms", type=latency, default=0.0, metavar="L", help="added each way; default: %(default)s"
    )
    parser.add_argument("--plant", choices=PLANTS, help=f"virtual robots, or ideal discs of 75 mm; default: {PLANT}")
    parser.add_argument("--sheet", type=size, metavar="WxH", help="in metres; default: 1x1, with --relay 0.8x0.6")
    parser.add_argument("--start", choices=STARTS, help=f"where the robots begin; default: {START}")
    parser.add_argument(
        "--zone", type=polygon, action="append", metavar="'X,Y X,Y X,Y'", help="the area to cover; several to patrol"
    )
    parser.add_argument(
        "--point", type=place, action="append", metavar="X,Y", help="the pointed spot; told again, it moves on there"
    )
    parser.add_argument("--user", type=place, metavar="X,Y", help="where the user stands, for come")
    parser.add_argument(
        "--room", type=Path, metavar="ROOM.toml", help="take sheet, zones, limits and robots from it, virtual or real"
    )
    parser.add_argument("--relay", type=address, metavar="HOST:PORT", help="drive Cellulo robots behind EPFL's relay")
    parser.add_argument("--macs", type=_words, metavar="MAC,...", help="their addresses; default: the emulator's")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="paths and covered area as a PNG")
    parser.add_argument("--log", type=Path, metavar="FILE", help="keep the session as MCAP")
    parser.add_argument("--overwrite", action="store_true", help="replace the log and the picture if they exist")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


# --- what is told on the command line --------------------------------------------------------------------


def _refused(text: str, what: str) -> argparse.ArgumentTypeError:
    return argparse.ArgumentTypeError(f"{text!r} is not {what}")


def _pair(text: str, mark: str, what: str) -> Vec2:
    try:
        first, second = map(float, text.split(mark))
    except ValueError:
        raise _refused(text, what) from None
    if not (math.isfinite(first) and math.isfinite(second)):
        raise _refused(text, what)
    return first, second


def place(text: str) -> Vec2:
    """A place as 0.2,0.5 for argparse."""
    return _pair(text, ",", "a place in metres such as 0.2,0.5")


def polygon(text: str) -> tuple[Vec2, ...]:
    """A polygon's corners as "0.1,0.1 0.4,0.1 0.4,0.5" for argparse."""
    return tuple(place(corner) for corner in text.split())


def size(text: str) -> Sheet:
    """A sheet as 0.8x0.6 for argparse."""
    width, height = _pair(text, "x", "a size in metres such as 0.8x0.6")
    if not (0.05 <= width <= 20 and 0.05 <= height <= 20):
        raise _refused(text, "a size between 0.05 and 20 metres each way")
    return Sheet(width, height)


def latency(text: str) -> float:
    """A latency [ms] for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= 450:
        raise _refused(text, "a latency from 0 to 450 milliseconds")
    return value


def address(text: str) -> tuple[str, int]:
    """A relay's host and port for argparse."""
    host, _, port = text.rpartition(":")
    if not (host and port.isdecimal() and 0 < int(port) < 65536):
        raise _refused(text, "a relay such as 127.0.0.1:2556")
    return host, int(port)


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(","))


def run_of(args: argparse.Namespace) -> SwarmRun:
    """The run that is asked for (ConfigError)."""
    if args.behaviour is None:
        raise ConfigError("no behaviour is named; `armspan swarm --list` tells them")
    _check_together(args)
    sheet = args.sheet or (RELAY_SHEET if args.relay else SHEET)
    wanted = Wanted(
        behaviour=args.behaviour,
        robots=args.robots or (len(args.macs) if args.macs else ROBOTS),
        seconds=args.seconds,
        seed=args.seed,
        plant=args.plant or PLANT,
        latency=args.latency_ms / 1000,
        sheet=sheet,
        start=args.start or ("grid" if args.relay else START),
        zones=tuple(ZoneEntry(f"zone-{k}", corners) for k, corners in enumerate(args.zone or (), 1)),
        points=tuple(args.point or ()),
        user=args.user,
    )
    return swarm_run(wanted) if args.room is None else run_in_room(wanted, read_room(args.room))


def _check_together(args: argparse.Namespace) -> None:
    """Refuse options that say the same thing twice, or that nobody would heed."""
    for one, others in (("room", ("sheet", "zone", "robots", "start", "relay")), ("relay", ("start", "plant"))):
        for other in others:
            if getattr(args, one) is not None and getattr(args, other) is not None:
                raise ConfigError(f"--{one} and --{other} do not go together: leave one out")
    if args.macs and not args.relay:
        raise ConfigError("--macs are addresses behind a relay: tell which with --relay HOST:PORT")
    if args.macs and args.robots not in (None, len(args.macs)):
        raise ConfigError(f"--macs has {len(args.macs)} addresses for {args.robots} robots: give one to each")
    if args.log and args.picture and args.log.resolve() == args.picture.resolve():
        raise ConfigError(f"{args.picture} would be both the log and the picture: give them different names")
    for path, what in ((args.picture, "picture"), (args.log, "log")):
        if path is not None and path.is_dir():
            raise ConfigError(f"{path} is a folder: name a file for the {what}")
        if path is not None and path.exists() and path.stat().st_size and not args.overwrite:
            raise ConfigError(f"{path} exists: name another {what}, or replace it with --overwrite")


# --- the run ---------------------------------------------------------------------------------------------


def run(args: argparse.Namespace) -> int:
    """Run the behaviour and say what it showed."""
    if args.list:
        _tell_all(args.json)
        return 0
    act = Act(run_of(args))
    for path in (args.picture, args.log):
        if path is not None:
            make_folder(path.parent)
    _play(act, args)
    document = document_of(act, args)
    if args.picture:
        draw_swarm(args.picture, act.account, act.run.settings.zones, title(document))
    if args.json:
        print(msgspec.json.encode(document).decode())
    else:
        print_run(document)
    return 0


def _play(act: Act, args: argparse.Namespace) -> None:
    """Play the run; on Ctrl-C and SIGTERM the robots are stopped first (KeyboardInterrupt)."""
    with ExitStack() as stack:
        sinks: list[Sink] = [talk]
        if args.log:
            sinks.append(stack.enter_context(_log(args.log, act)))
        try:
            asyncio.run(_until_told(act, args, sinks))
        except asyncio.CancelledError:
            print("the robots were stopped", file=sys.stderr)
            raise KeyboardInterrupt from None


@contextmanager
def _log(path: Path, act: Act) -> Iterator[LogWriter]:
    """A log that takes the place of an older one only where the behaviour was begun."""
    fresh = path.with_name(f"{path.name}.new") if path.exists() else path
    try:
        with LogWriter(fresh, _header(act), overwrite=True) as log:
            yield log
    finally:
        if act.began is None:
            fresh.unlink(missing_ok=True)
        elif fresh != path:
            fresh.replace(path)


async def _until_told(act: Act, args: argparse.Namespace, sinks: Sequence[Sink]) -> None:
    now, room = Stopwatch(), act.run.room
    if args.relay:
        macs = args.macs or addresses(len(act.run.settings.robots))
        host, port = args.relay
        where = f"behind the relay at {host}:{port}"
        task = asyncio.ensure_future(drive(act, behind_relay(act, host, port, macs, now), now, where, sinks))
    elif room is not None:
        doors = make_doors(room, now, args.room.parent)
        task = asyncio.ensure_future(drive(act, doors, now, f"where {args.room} says", sinks))
    else:
        task = asyncio.ensure_future(simulate(act, sinks))
    stop_on_signals(task)
    await task


def _header(act: Act) -> dict[str, object]:
    settings = msgspec.to_builtins(act.run.settings)
    return {"armspan": __version__, "epoch_ns": 0, "settings": settings, "behaviour": act.run.behaviour}


# --- what it showed --------------------------------------------------------------------------------------


def document_of(act: Act, args: argparse.Namespace) -> dict[str, Any]:
    """The run's settings and its account, JSON-able."""
    if not len(act.account.times):
        raise DataError("no robot's place was taken; run for longer")
    wanted, limits = act.run.wanted, act.run.settings.limits
    finished = None if act.finished is None or act.began is None else round(act.finished - act.began, 3)
    return {
        "behaviour": act.run.behaviour,
        "seed": wanted.seed,
        "plant": "relay" if args.relay else "real" if act.run.room else wanted.plant,
        "simulated": not (args.relay or act.run.room),
        "latency_ms": round(1000 * wanted.latency, 3),
        "sheet_m": [wanted.sheet.width_m, wanted.sheet.height_m],
        "start": "room" if args.room else "relay" if args.relay else wanted.start,
        "limits": msgspec.to_builtins(limits),
        "finished_s": finished,
        **act.account.document(),
        "stopped": dict(act.mind.steering.filter.waiting),
        **{name: str(path) for name in ("log", "picture") if (path := getattr(args, name))},
    }


def _tell_all(as_json: bool) -> None:
    """All behaviours with a line each, and the dictionary of gestures."""
    lines = {STOP: "All robots stop, latched: nothing moves until an explicit resume."} | {
        name: _first_line(maker) for name, maker in MAKERS.items()
    }
    if as_json:
        print(msgspec.json.encode({"behaviours": lines, "gestures": DICTIONARY}).decode())
        return
    for what, words in (("Behaviours", lines), ("Gestures, where a room does not say otherwise", DICTIONARY)):
        table = Table(title=what, show_header=False, title_justify="left")
        table.add_column(style="bold", no_wrap=True)
        table.add_column()
        for row in words.items():
            table.add_row(*map(escape, row))
        Results().print(table)


def _first_line(maker: object) -> str:
    made = maker.func if isinstance(maker, partial) else maker
    line = (made.__doc__ or "").strip().splitlines()[0].replace("``", "")
    extra = maker.keywords if isinstance(maker, partial) else {}
    return line + (f" ({', '.join(f'{name} = {value}' for name, value in extra.items())})" if extra else "")
