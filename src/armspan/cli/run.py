"""``armspan run``: a room with the doors that its file names, every run logged."""

import argparse
import sys
from pathlib import Path

import msgspec

from armspan.cli.page import open_page
from armspan.cli.play import play, read_account, step_times, talk
from armspan.cli.replay import tell_if_cut
from armspan.cli.report import print_account
from armspan.config.house import open_house
from armspan.config.room_file import read_room
from armspan.config.session_files import fresh_log
from armspan.errors import ConfigError
from armspan.study.gestures import gestures_of


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "run",
        help="open a room in a browser: set up, point, record, train, steer",
        description="Open the room that a file describes and serve its page, with a session that is logged. "
        "`armspan init` writes such a file; without one a virtual person stands in a virtual room. With any of "
        "--no-page, --pace, --seconds, --log and --json the session goes by itself, without a page.",
    )
    parser.add_argument("room", type=Path, nargs="?", metavar="ROOM.toml", help="default: a simulated room")
    parser.add_argument("--port", type=port, default=8080, metavar="N", help="of the page; default: %(default)s")
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="where others reach the page, such as 0.0.0.0: they need the token that is shown; default: %(default)s, "
        "this machine only",
    )
    parser.add_argument(
        "--speed", type=speed, default=1.0, metavar="N", help="on the page, a virtual room goes N times as fast as real"
    )
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")
    parser.add_argument("--no-page", action="store_true", help="the terminal only; the set-up begins by itself")
    parser.add_argument("--pace", choices=("live", "fast"), help="default: live")
    parser.add_argument("--seconds", type=positive, metavar="S", help="end after S seconds of session time")
    parser.add_argument("--log", type=Path, metavar="FILE", help="default: sessions/DATE_ROOM.mcap")
    parser.add_argument("--overwrite", action="store_true", help="replace the log if it exists")
    parser.add_argument("--json", action="store_true", help="print one JSON object at the end")
    parser.set_defaults(run=run)


def port(text: str) -> int:
    """A port, 0 for any that is free, for argparse."""
    if not (text.isascii() and text.isdecimal()) or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is not a port from 0 to 65535")
    return int(text)


def speed(text: str) -> float:
    """How many times as fast, for argparse."""
    try:
        times = float(text)
    except ValueError:
        times = 0.0
    if not 0.1 <= times <= 20:
        raise argparse.ArgumentTypeError(f"{text!r} is not how many times as fast, from 0.1 to 20")
    return times


def positive(text: str) -> float:
    """A number of seconds above zero, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds above zero")
    return value


def run(args: argparse.Namespace) -> int:
    """Serve the room's page, or run the room and say what happened."""
    if not (args.no_page or args.pace or args.seconds or args.log or args.json):
        return open_page(args.room, args.host, args.port, speed=args.speed, browser=not args.no_browser)
    if args.room is None:
        raise ConfigError("which room? Name its file, such as one that `armspan init room.toml` writes")
    house = open_house(read_room(args.room), args.room.parent, args.seconds)
    path = args.log or fresh_log(args.room.stem)
    for log in house.logs.values():
        tell_if_cut(log)
        if path.resolve() == log.path.resolve():
            raise ConfigError(f"{path} is a log that the room replays, and is kept: name another one with --log")
    if invitation := house.doors.invitation():
        print(invitation, file=sys.stderr)
    try:
        counters = play(house, path, live=args.pace != "fast", overwrite=args.overwrite, sinks=[talk])
    finally:
        for sentence in house.doors.advice():
            print(sentence, file=sys.stderr)
    log_file, found = read_account(path, house)
    document = {
        **found.document(),
        "step_us": step_times(counters),
        "dropped": counters.dropped,
        "not_finite": counters.not_finite,
        "log": str(path),
    }
    if house.doors:
        document["devices"] = house.reports or house.doors.reports()
    if house.model is not None:
        document["gestures"] = gestures_of(log_file.records).document()
    if args.json:
        print(msgspec.json.encode(document).decode())
    else:
        print_account(document)
    return 0
