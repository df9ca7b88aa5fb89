"""What ``armspan emulate metawear`` and ``armspan emulate toio`` share: the door to them, and bad radio links."""

import argparse
import asyncio
import logging
import signal
from collections.abc import Callable, Coroutine, Mapping, Sequence
from contextlib import AsyncExitStack, ExitStack, suppress
from pathlib import Path
from typing import Any, TextIO

import msgspec
import numpy as np

from armspan.cli.ranges import number, seed, share
from armspan.errors import ConfigError
from armspan.links.ble_emulated import Air, Peripheral, emulated_radio
from armspan.links.hci import BUMBLE
from armspan.links.hci_air import HOST, serve_air
from armspan.links.waves import LinkFaults

SILENCE_S = 3.0
TICK_S = 0.02
"""How often the world goes on [s]."""
TOLD_S = 0.1
"""How often the truth is written [s]."""


def add_door(parser: argparse.ArgumentParser) -> None:
    """Add what every emulator has but its port."""
    parser.add_argument("--seed", type=seed, default=0, metavar="K", help="default: %(default)s")
    parser.add_argument("--truth", type=Path, metavar="FILE", help="write what is really so, lines of JSON")


def add_link_faults(parser: argparse.ArgumentParser) -> "argparse._ArgumentGroup":
    """Add what goes wrong on the radio; gives the group for what else goes wrong."""
    faults = parser.add_argument_group("what goes wrong")
    faults.add_argument("--drop", type=share, default=0.0, metavar="SHARE", help="lost of what nobody confirms, 0 to 1")
    faults.add_argument("--run", dest="run_length", type=run_length, default=1.0, metavar="N", help="lost in a row")
    faults.add_argument("--latency-ms", type=millis, default=0.0, metavar="L", help="added each way")
    faults.add_argument("--burst-ms", type=millis, default=0.0, metavar="B", help="between two connection events")
    faults.add_argument("--link-loss-at", type=seconds, metavar="S", help="break the links, for --away-s")
    faults.add_argument("--breaks-per-minute", type=rate, default=0.0, metavar="N", help="more of these, at random")
    faults.add_argument("--away-s", type=seconds, default=3.0, metavar="S", help="out of reach; default: %(default)s")
    faults.add_argument("--silence-at", type=seconds, metavar="S", help="nothing comes for 3 s, though the links hold")
    return faults


def link_faults(args: argparse.Namespace) -> LinkFaults:
    """The links that were asked for."""
    return LinkFaults(
        loss=args.drop,
        write_loss=args.drop,
        run=args.run_length,
        latency_s=args.latency_ms / 1000.0,
        burst_s=args.burst_ms / 1000.0,
        breaks_at=() if args.link_loss_at is None else (args.link_loss_at,),
        breaks_per_minute=args.breaks_per_minute,
        away_s=args.away_s,
        silent=() if args.silence_at is None else ((args.silence_at, args.silence_at + SILENCE_S),),
    )


# --- the scene ------------------------------------------------------------------------------------------


def until_told(scene: Callable[[], Coroutine[Any, Any, None]]) -> int:
    """Run until SIGTERM or Ctrl-C, and end as one that has done its work."""

    async def main() -> None:
        loop, task = asyncio.get_running_loop(), asyncio.current_task()
        if task is not None:
            for number in (signal.SIGTERM, signal.SIGINT):
                with suppress(NotImplementedError):  # on Windows Ctrl-C comes as an exception
                    loop.add_signal_handler(number, task.cancel)
        await scene()

    with suppress(asyncio.CancelledError):
        asyncio.run(main())
    return 0


async def on_air(
    peripherals: Sequence[Peripheral], args: argparse.Namespace, live: Callable[[Air], Coroutine[Any, Any, None]]
) -> None:
    """Put peripherals on an air, tell where it is, and let them ``live``."""
    logging.getLogger("bumble").propagate = False  # it warns of what goes wrong here on purpose
    async with AsyncExitStack() as stack:
        air, port = await _whole(_opened(peripherals, args, stack))
        addresses = ", ".join(peripheral.address for peripheral in peripherals)
        print(f'radio = "{BUMBLE}tcp-client:{HOST}:{port}"  # {addresses}', flush=True)
        await live(air)


async def _opened(
    peripherals: Sequence[Peripheral], args: argparse.Namespace, stack: AsyncExitStack
) -> tuple[Air, int]:
    air = await stack.enter_async_context(emulated_radio(np.random.default_rng([args.seed, 1])))
    for peripheral in peripherals:
        await air.add(peripheral, link_faults(args))
    return air, await stack.enter_async_context(serve_air(air, args.port))


async def _whole(work: Coroutine[Any, Any, tuple[Air, int]]) -> tuple[Air, int]:
    """Finish what must not be left half done, also when it is cancelled."""
    task = asyncio.ensure_future(work)
    try:
        return await asyncio.shield(task)
    except asyncio.CancelledError:
        await task
        raise


async def world(go_on: Callable[[float], None], air: Air | None, truth: "Truth | None") -> None:
    """Let the world go on in real time, ``go_on`` with the time since its beginning [s]; never ends by itself."""
    loop = asyncio.get_running_loop()
    began = loop.time()
    if truth is not None:
        truth.begin(began)
    while True:
        t = loop.time() - began
        go_on(t)
        if truth is not None:
            truth.tell(t)
        if air is not None and air.failures:
            raise air.failures[0]
        await asyncio.sleep(TICK_S)


class Truth:
    """A truth log: first ``monotonic`` [s], the system's clock at t = 0, then what each device really does."""

    def __init__(self, file: TextIO, true: Callable[[float], Sequence[Mapping[str, object]]]) -> None:
        self._file, self._true, self._next = file, true, 0.0

    @staticmethod
    def to(
        path: Path | None, true: Callable[[float], Sequence[Mapping[str, object]]], stack: ExitStack
    ) -> "Truth | None":
        """A log in a new file; one that says something already is kept (ConfigError)."""
        if path is None:
            return None
        if path.is_file() and path.stat().st_size:
            raise ConfigError(f"{path} exists and is kept: name another file with --truth, or delete it first")
        return Truth(stack.enter_context(path.open("a", encoding="utf-8")), true)

    def begin(self, now: float) -> None:
        """The world begins at ``now`` [s]."""
        self._write({"monotonic": now})

    def tell(self, t: float) -> None:
        """Write down what is so, where that is due."""
        if t >= self._next:
            self._next = t + TOLD_S
            for line in self._true(t):
                self._write({"t": round(t, 4), **line})
            self._file.flush()

    def _write(self, line: Mapping[str, object]) -> None:
        self._file.write(msgspec.json.encode(line).decode() + "\n")


def run_length(text: str) -> float:
    """A mean length of runs."""
    return number(text, "a mean number of losses in a row", 1, 1000)


def rate(text: str) -> float:
    """Events a minute."""
    return number(text, "a number a minute", 0, 60)


def millis(text: str) -> float:
    """A time in milliseconds."""
    return number(text, "a time in milliseconds", 0, 5000)


def seconds(text: str) -> float:
    """A time in seconds."""
    return number(text, "a time in seconds", 0, 86400)
