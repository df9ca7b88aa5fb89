"""``armspan emulate phone``: a phone that is not there, in the bytes of any of its apps."""

import argparse
import asyncio
import signal
from contextlib import suppress

import numpy as np

from armspan.devices.phone.emulator import EmulatedPhone, Faults, play, serve
from armspan.devices.phone.voices import LoggerVoice, PageVoice, ServerVoice, lying_still
from armspan.errors import ConfigError

APPS = ("browser", "sensor-logger", "sensor-server")
PLATFORMS = ("android", "ios", "apple-watch", "wear-os")


def add_parser(devices: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the device and its options."""
    parser = devices.add_parser(
        "phone",
        help="a phone or a watch, with our page open, Sensor Logger or SensorServer",
        description="Emulate a phone that lies still. It speaks until Ctrl-C.",
    )
    parser.add_argument("--app", choices=APPS, default="browser", help="default: %(default)s")
    parser.add_argument("--to", metavar="URL", help="where it goes, as `armspan run` prints it; not for sensor-server")
    parser.add_argument("--port", type=int, default=8080, metavar="P", help="sensor-server's own; default: %(default)s")
    parser.add_argument("--platform", choices=PLATFORMS, default="android", help="default: %(default)s")
    parser.add_argument("--rate", type=float, default=60.0, metavar="HZ", help="default: %(default)s")
    parser.add_argument(
        "--batch", type=float, default=0.2, metavar="S", help="between two pushes; default: %(default)s"
    )
    parser.add_argument("--drop", type=float, default=0.0, metavar="SHARE", help="of messages lost, 0 to 1")
    parser.add_argument("--jitter-ms", type=float, default=0.0, metavar="J", help="of each message's way")
    parser.add_argument("--burst-ms", type=float, default=0.0, metavar="B", help="messages come together every B")
    parser.add_argument("--silence-at", type=float, metavar="S", help="say nothing for 3 s")
    parser.add_argument("--break-at", type=float, metavar="S", help="break the line, and come back")
    parser.add_argument("--seed", type=int, default=0, metavar="K", help="default: %(default)s")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Be the phone until told to end."""
    _check(args)
    with suppress(asyncio.CancelledError):
        asyncio.run(_speak(args))
    return 0


def _check(args: argparse.Namespace) -> None:
    if (args.to is None) != (args.app == "sensor-server"):
        raise ConfigError(f"--to is for a phone that goes somewhere; with --app {args.app} " + _instead(args.app))
    if args.to is not None and not args.to.startswith(("http://", "https://")):
        raise ConfigError(f"--to is {args.to!r}; expected a URL such as https://127.0.0.1:8443/?token=...")
    if not 1 <= args.rate <= 1000:
        raise ConfigError(f"--rate is {args.rate:g}; expected 1 to 1000 samples a second")
    if not 0 <= args.drop <= 1:
        raise ConfigError(f"--drop is {args.drop:g}; expected a share from 0 to 1")
    for name in ("batch", "jitter_ms", "burst_ms"):
        value = getattr(args, name)
        if not 0 <= value <= 60_000:
            raise ConfigError(f"--{name.replace('_', '-')} is {value:g}; expected a time from 0")


def _instead(app: str) -> str:
    return "it waits at --port" if app == "sensor-server" else "say where, as `armspan run` prints it"


async def _speak(args: argparse.Namespace) -> None:
    """Speak until SIGTERM or Ctrl-C, and end as one that has done its work."""
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    if task is not None:
        for number in (signal.SIGTERM, signal.SIGINT):
            with suppress(NotImplementedError):  # on Windows Ctrl-C comes as an exception
                loop.add_signal_handler(number, task.cancel)
    phone = _phone(args)
    if args.app == "sensor-server":
        await serve(phone, args.port, lambda at: print(f"listening on ws://127.0.0.1:{at}", flush=True))
    else:
        print(f"speaking to {args.to.partition('?')[0]}", flush=True)
        await play(phone, args.to)


def _phone(args: argparse.Namespace) -> EmulatedPhone:
    faults = Faults(
        lost=args.drop,
        jitter=args.jitter_ms / 1000.0,
        burst=args.burst_ms / 1000.0,
        silences=() if args.silence_at is None else ((args.silence_at, 3.0),),
        breaks=() if args.break_at is None else (args.break_at,),
    )
    samples, rng = lying_still(args.rate), np.random.default_rng(args.seed)
    match args.app:
        case "browser":
            return EmulatedPhone(PageVoice(apple=args.platform == "ios"), samples, faults, rng)
        case "sensor-logger":
            return EmulatedPhone(LoggerVoice(args.platform, args.batch), samples, faults, rng, ordered=False)
    return EmulatedPhone(ServerVoice(), samples, faults, rng)
