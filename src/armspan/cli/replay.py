"""``armspan replay``: a log through the conductor again."""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec

from armspan.conductor import Settings
from armspan.config.recalled import mind_of, settings_of
from armspan.log import LogFile, read
from armspan.records import EVENTS, Record


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "replay",
        help="play a log through the conductor; with --check compare what it decides",
        description="Play a session's events through the conductor again and print what it decides.",
    )
    parser.add_argument("log", type=Path, metavar="LOG", help="a session's MCAP file")
    parser.add_argument("--check", action="store_true", help="the decisions must equal those in the log")
    parser.add_argument("--json", action="store_true", help="one JSON object a record, or one for --check")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Replay; exit code 1 when ``--check`` finds a difference."""
    log = read(args.log)
    tell_if_cut(log)
    settings = settings_of(log)
    if args.check:
        return _check(log, settings, args.json)
    for output in decisions(log, settings):
        print(msgspec.json.encode(output).decode() if args.json else output)
    return 0


def tell_if_cut(log: LogFile) -> None:
    """Say on stderr that a log lacks its end."""
    if not log.complete:
        print(f"{log.path} was cut off; its {len(log.records)} whole records are used", file=sys.stderr)


def decisions(log: LogFile, settings: Settings) -> Iterator[Record]:
    """What a new conductor, recorder or swarm's mind decides for the events of a log."""
    mind = mind_of(log, settings)
    for record in log.records:
        if isinstance(record, EVENTS):
            yield from mind.step(record)  # type: ignore[arg-type]


def first_difference(log: LogFile, settings: Settings) -> tuple[int, Record | None, Record | None] | None:
    """Number, logged and replayed record of the first decision that differs, or None when all are equal.

    A log that was cut may lack the last event's decisions; that is no difference.
    """
    logged = [record for record in log.records if not isinstance(record, EVENTS)]
    replayed = list(decisions(log, settings))
    for number, (old, new) in enumerate(zip(logged, replayed, strict=False)):
        if old != new:
            return number, old, new
    if len(logged) > len(replayed):
        return len(replayed), logged[len(replayed)], None
    if len(replayed) > len(logged) and log.complete:
        return len(logged), None, replayed[len(logged)]
    return None


def _check(log: LogFile, settings: Settings, as_json: bool) -> int:
    found = first_difference(log, settings)
    decided = sum(not isinstance(record, EVENTS) for record in log.records)
    if as_json:
        number, old, new = found or (None, None, None)
        answer = {
            "equal": found is None,
            "decisions": decided,
            "differs_at": number,
            "logged": old,
            "replayed": new,
        }
        print(msgspec.json.encode(answer).decode())
    elif found is None:
        print(f"equal: {decided} decisions from {len(log.records) - decided} events")
    else:
        number, old, new = found
        print(f"decision {number} differs\n  logged:   {old}\n  replayed: {new}")
    return 0 if found is None else 1
