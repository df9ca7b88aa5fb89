"""``armspan run``: a room with the doors that its file names, every run logged."""

import argparse
import sys
from pathlib import Path

import msgspec

from armspan.cli.play import fresh_name, play, read_account, step_times, talk
from armspan.cli.replay import tell_if_cut
from armspan.cli.report import print_account
from armspan.config.house import open_house
from armspan.config.room_file import read_room
from armspan.errors import ConfigError
from armspan.study.gestures import gestures_of


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "run",
        help="open the room that a file describes, and log the session",
        description="Run a session with the devices that a room file names. `armspan init` writes such a file.",
    )
    parser.add_argument("room", type=Path, metavar="ROOM.toml")
    parser.add_argument("--pace", choices=("live", "fast"), default="live", help="default: %(default)s")
    parser.add_argument("--seconds", type=positive, metavar="S", help="end after S seconds of session time")
    parser.add_argument("--log", type=Path, metavar="FILE", help="default: sessions/DATE_ROOM.mcap")
    parser.add_argument("--overwrite", action="store_true", help="replace the log if it exists")
    parser.add_argument("--json", action="store_true", help="print one JSON object at the end")
    parser.set_defaults(run=run)


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
    """Run the room and say what happened."""
    house = open_house(read_room(args.room), args.room.parent, args.seconds)
    path = args.log or fresh_name(args.room.stem)
    for log in house.logs.values():
        tell_if_cut(log)
        if path.resolve() == log.path.resolve():
            raise ConfigError(f"{path} is a log that the room replays, and is kept: name another one with --log")
    if invitation := house.doors.invitation():
        print(invitation, file=sys.stderr)
    try:
        counters = play(house, path, live=args.pace == "live", overwrite=args.overwrite, sinks=[talk])
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
