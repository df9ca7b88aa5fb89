"""``armspan emulate``: robots that are not there, in bytes, for a host that cannot tell the difference."""

import argparse
import asyncio
import math
import signal
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TextIO

import numpy as np

from armspan.cli.run import positive
from armspan.devices.cellulo.emulator import Emulator, addresses, places
from armspan.devices.cellulo.firmware import Faults, Firmware
from armspan.devices.cellulo.relay import PORT
from armspan.errors import ConfigError
from armspan.records import Sheet, Vec2


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    verb = subparsers.add_parser(
        "emulate",
        help="pretend to be robots, byte for byte",
        description="Emulate devices. The first line on stdout tells where they listen; Ctrl-C ends them.",
    )
    devices = verb.add_subparsers(dest="device", metavar="DEVICE", required=True, title="devices")
    parser = devices.add_parser("cellulo", help="Cellulo robots behind EPFL's relay, on a TCP port of this machine")
    parser.add_argument("--robots", type=_count, default=4, metavar="N", help="default: %(default)s")
    parser.add_argument("--port", type=_port, default=PORT, metavar="P", help="0 for any; default: %(default)s")
    parser.add_argument("--sheet", type=_size, default=(0.8, 0.6), metavar="WxH", help="in metres; default: 0.8x0.6")
    parser.add_argument("--seed", type=_whole, default=0, metavar="K", help="default: %(default)s")
    parser.add_argument("--truth", type=Path, metavar="FILE", help="write what the robots really do, lines of JSON")
    parser.add_argument("--latency-ms", type=_latency, default=0.0, metavar="L", help="added each way")
    parser.add_argument("--drop", type=_share, default=0.0, metavar="SHARE", help="of commands lost, 0 to 1")
    parser.add_argument("--link-loss-at", type=positive, metavar="S", help="break the robots' links for 3 s")
    parser.add_argument("--kidnap-at", type=positive, metavar="S", help="lift the first robot for 2 s")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Be the robots until told to end."""
    sheet = Sheet(*args.sheet)
    rng = np.random.default_rng(args.seed)
    xy = places(args.robots, sheet)
    heading = rng.uniform(0, 2 * math.pi, size=args.robots)
    firmware = Firmware(xy, heading, sheet, rng, faults=Faults(args.latency_ms / 1000, args.drop))
    robots = {mac: f"r{k}" for k, mac in enumerate(addresses(args.robots), 1)}
    with ExitStack() as stack:
        truth = stack.enter_context(_fresh(args.truth)) if args.truth else None
        emulator = Emulator(firmware, robots, truth, args.link_loss_at, args.kidnap_at)
        with suppress(asyncio.CancelledError):
            asyncio.run(_serve(emulator, args.port))
    return 0


def _fresh(path: Path) -> TextIO:
    """A new file; one that says something already is kept (ConfigError)."""
    if path.is_file() and path.stat().st_size:
        raise ConfigError(f"{path} exists and is kept: name another file with --truth, or delete it first")
    return path.open("a", encoding="utf-8")


async def _serve(emulator: Emulator, port: int) -> None:
    """Serve until SIGTERM or Ctrl-C, and end as one that has done its work."""
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    if task is not None:
        for number in (signal.SIGTERM, signal.SIGINT):
            with suppress(NotImplementedError):  # on Windows Ctrl-C comes as an exception
                loop.add_signal_handler(number, task.cancel)
    await emulator.serve(port, lambda at: print(f"listening on 127.0.0.1:{at}", flush=True))


def _number(text: str, what: str, low: float, high: float) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f"{text!r} is not {what} from {low:g} to {high:g}")
    return value


def _integer(text: str, what: str, low: int, high: int) -> int:
    value = _number(text, what, low, high)
    if value != int(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not {what} from {low} to {high}")
    return int(value)


def _count(text: str) -> int:
    return _integer(text, "a number of robots", 1, 200)


def _port(text: str) -> int:
    return _integer(text, "a port", 0, 65535)


def _whole(text: str) -> int:
    return _integer(text, "a seed", 0, 2**32)


def _latency(text: str) -> float:
    return _number(text, "a latency in milliseconds", 0, 5000)


def _share(text: str) -> float:
    return _number(text, "a share", 0, 1)


def _size(text: str) -> Vec2:
    width, times, height = text.partition("x")
    if not times:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size in metres as 0.8x0.6")
    return _number(width, "a width in metres", 0.1, 20), _number(height, "a height in metres", 0.1, 20)
