"""``armspan emulate cellulo``: Cellulo robots behind EPFL's relay, or each on a pseudo-terminal."""

import argparse
import asyncio
import math
import signal
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TextIO, get_args

import numpy as np

from armspan.cli.ranges import integer, number, port, seed, share
from armspan.cli.run import positive
from armspan.devices.cellulo.emulator import Emulator, addresses, places
from armspan.devices.cellulo.faults import Faults, Generation, Trouble
from armspan.devices.cellulo.firmware import Firmware
from armspan.devices.cellulo.relay import PORT
from armspan.errors import ConfigError
from armspan.records import Sheet, Vec2


def add_parser(devices: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the device and its options."""
    parser = devices.add_parser("cellulo", help="Cellulo robots behind EPFL's relay, on a TCP port of this machine")
    parser.add_argument("--robots", type=_count, default=4, metavar="N", help="default: %(default)s")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--port", type=port, default=PORT, metavar="P", help="0 for any; default: %(default)s")
    where.add_argument("--pty", action="store_true", help="a serial port for each robot instead: prints their paths")
    parser.add_argument("--sheet", type=_size, default=(0.8, 0.6), metavar="WxH", help="in metres; default: 0.8x0.6")
    parser.add_argument("--seed", type=seed, default=0, metavar="K", help="default: %(default)s")
    parser.add_argument("--truth", type=Path, metavar="FILE", help="write what the robots really do, lines of JSON")
    faults = parser.add_argument_group("what goes wrong")
    faults.add_argument("--latency-ms", type=_latency, default=0.0, metavar="L", help="added each way")
    faults.add_argument("--drop", type=share, default=0.0, metavar="SHARE", help="of commands lost, 0 to 1")
    faults.add_argument("--burst-ms", type=_latency, default=0.0, metavar="B", help="what is told comes in bursts")
    faults.add_argument("--sniff-ms", type=_latency, default=0.0, metavar="L", help="added after a second of silence")
    faults.add_argument("--deaf", type=_deaf, default=0, metavar="N", help="first commands lost after a start or link")
    faults.add_argument("--boot-s", type=_seconds, default=1.0, metavar="S", help="to start; default: %(default)s")
    faults.add_argument(
        "--generation",
        choices=get_args(Generation),
        default="v1",
        help="v2 has no keys, old answers nothing; default: v1",
    )
    faults.add_argument("--link-loss-at", type=positive, metavar="S", help="break the robots' links for 3 s")
    faults.add_argument("--kidnap-at", type=positive, metavar="S", help="lift the first robot for 2 s")
    faults.add_argument(
        "--fault",
        type=_trouble,
        action="append",
        default=[],
        metavar="KIND[:ROBOT]@START[+SECONDS][/EVERY]",
        help="link-loss, silence, kidnap, blind (no camera) or load (100 g), as link-loss:r2@5+3/20; more than once",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Be the robots until told to end."""
    sheet = Sheet(*args.sheet)
    rng = np.random.default_rng(args.seed)
    xy = places(args.robots, sheet)
    heading = rng.uniform(0, 2 * math.pi, size=args.robots)
    firmware = Firmware(xy, heading, sheet, rng, faults=_faults(args))
    robots = {mac: f"r{k}" for k, mac in enumerate(addresses(args.robots), 1)}
    with ExitStack() as stack:
        truth = stack.enter_context(_fresh(args.truth)) if args.truth else None
        emulator = Emulator(firmware, robots, truth, args.link_loss_at, args.kidnap_at, args.fault)
        with suppress(asyncio.CancelledError):
            asyncio.run(_serve(emulator, None if args.pty else args.port))
    return 0


def _faults(args: argparse.Namespace) -> Faults:
    return Faults(
        args.latency_ms / 1000,
        args.drop,
        args.boot_s,
        args.burst_ms / 1000,
        args.sniff_ms / 1000,
        args.deaf,
        args.generation,
    )


def _fresh(path: Path) -> TextIO:
    """A new file; one that says something already is kept (ConfigError)."""
    if path.is_file() and path.stat().st_size:
        raise ConfigError(f"{path} exists and is kept: name another file with --truth, or delete it first")
    return path.open("a", encoding="utf-8")


def _tell(port: int, macs: Sequence[str]) -> None:
    """Say where the robots are, and what a room file says of it."""
    print(f"listening on 127.0.0.1:{port}", flush=True)
    print(f'relay = "127.0.0.1:{port}"  # {", ".join(macs)}', flush=True)


async def _serve(emulator: Emulator, port: int | None) -> None:
    """Serve until SIGTERM or Ctrl-C, and end as one that has done its work."""
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    if task is not None:
        for told in (signal.SIGTERM, signal.SIGINT):
            with suppress(NotImplementedError):  # on Windows Ctrl-C comes as an exception
                loop.add_signal_handler(told, task.cancel)
    if port is not None:
        await emulator.serve(port, lambda at: _tell(at, emulator.macs))
        return
    async with emulator.on_ptys() as paths:
        for name, path in zip(emulator.names, paths, strict=True):
            print(f"{name} on {path}", flush=True)
        await emulator.live()


def _count(text: str) -> int:
    return integer(text, "a number of robots", 1, 200)


def _latency(text: str) -> float:
    return number(text, "a latency in milliseconds", 0, 5000)


def _deaf(text: str) -> int:
    return integer(text, "a number of commands", 0, 100)


def _seconds(text: str) -> float:
    return number(text, "a time in seconds", 0, 60)


def _trouble(text: str) -> Trouble:
    try:
        return Trouble.parse(text)
    except ConfigError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _size(text: str) -> Vec2:
    width, times, height = text.partition("x")
    if not times:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size in metres as 0.8x0.6")
    return number(width, "a width in metres", 0.1, 20), number(height, "a height in metres", 0.1, 20)
