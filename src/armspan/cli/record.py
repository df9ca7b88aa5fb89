"""``armspan record``: takes of gestures and everyday motion, hands-free, each written as soon as it is finished."""

import argparse
import datetime
import sys
from pathlib import Path
from typing import Any

import msgspec

from armspan.cli.demo import seed
from armspan.cli.play import play, talk
from armspan.cli.run import positive
from armspan.conductor.recorder_plan import Recording
from armspan.config.record_room import (
    RecordHouse,
    TakeWriter,
    check_labels,
    check_person,
    open_record_house,
    read_record_room,
    virtual_room,
    wrists_of,
)
from armspan.config.session_files import fresh_log
from armspan.config.take_files import next_number
from armspan.errors import ConfigError, known_names
from armspan.gesture.takes import NULL, SEVEN
from armspan.records import Arm, Press, Record

_WRISTS: tuple[Arm, Arm] = ("right", "left")


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "record",
        help="record takes of arm gestures, hands-free",
        description="Leads you through takes by words: set-up with both arms stretched forward, then for each gesture "
        "one take for practice, which is kept and not learnt from, and N takes. Each is written at once as "
        "DIR/LABEL/PERSON_NN.csv with a JSON sidecar; nothing is overwritten. Without --room a virtual person with "
        "two virtual bands does what is asked.",
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument(
        "--gestures", metavar="seven|LABEL,...", help="default: seven, the report's; none if only --null is given"
    )
    parser.add_argument("--takes", type=int, default=5, metavar="N", help="of each gesture; default: %(default)s")
    parser.add_argument("--person", default="p01", metavar="CODE", help="who makes them; default: %(default)s")
    parser.add_argument("--null", type=positive, metavar="SECONDS", help="at the end everyday motion, best 600")
    parser.add_argument("--bands", metavar="right,left", help="the wrists to record; default: all that wear a band")
    parser.add_argument("--taps", action="store_true", help="a double click on a band starts and ends a take")
    parser.add_argument("--shuffle", action="store_true", help="mix the gestures instead of one after the other")
    parser.add_argument("--room", type=Path, metavar="ROOM.toml", help="the bands; default: virtual ones")
    parser.add_argument(
        "--seed", type=seed, default=1, metavar="N", help="of the virtual person and of --shuffle; default: %(default)s"
    )
    parser.add_argument(
        "--pace", choices=("live", "fast"), help="default: live with --room, else fast: a virtual person needs no clock"
    )
    parser.add_argument("--log", type=Path, metavar="FILE", help="default: sessions/DATE_record.mcap")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Record, and say what was written."""
    room = read_record_room(args.room) if args.room else virtual_room(args.seed)
    recording = _recording(args, wrists_of(room))
    house = open_record_house(room, recording, args.room.parent if args.room else Path())
    path = args.log or fresh_log("record")
    live = (args.pace or ("live" if args.room else "fast")) == "live"
    today = f"{datetime.date.today():%Y-%m-%d}" if house.doors else None
    writer = TakeWriter(args.folder, house.recorder, simulated=house.simulated, recorded=today)
    try:
        play(house, path, live=live, sinks=[*([_tell_virtual] if writer.simulated else []), talk, writer])
    except KeyboardInterrupt:
        print(f"{len(writer.written)} finished takes are in {args.folder}", file=sys.stderr)
        raise
    document = _document(args, house, writer) | {"log": str(path)}
    if args.json:
        print(msgspec.json.encode(document).decode())
    else:
        _show(document)
    return 0


def _tell_virtual(record: Record) -> None:
    """A sink that says at the beginning who makes these gestures."""
    if isinstance(record, Press) and record.name == "setup":
        print("A virtual person makes these gestures: the takes are marked as simulated", file=sys.stderr)


def _recording(args: argparse.Namespace, worn: tuple[Arm, ...]) -> Recording:
    """What is asked for, checked against the folder (ConfigError, DataError)."""
    person = check_person(args.person)
    gestures = _gestures(args.gestures, args.null is not None)
    labels = [*gestures, *([NULL] if args.null else [])]
    check_labels(args.folder, labels)
    return Recording(
        gestures,
        args.takes,
        person,
        args.null or 0.0,
        _wrists(args.bands, worn),
        args.taps,
        args.shuffle,
        args.seed,
        {label: next_number(args.folder, label, person) for label in labels},
    )


def _gestures(text: str | None, null_only: bool) -> tuple[str, ...]:
    """The labels, in order, each once."""
    if text is None:
        return () if null_only else SEVEN
    labels: list[str] = []
    for name in text.split(","):
        labels += SEVEN if name.strip() == "seven" else [name.strip()]
    if not all(labels):
        raise ConfigError(f"--gestures {text!r} names an empty label: separate labels by single commas")
    if twice := [label for k, label in enumerate(labels) if label in labels[:k]]:
        raise ConfigError(f"gesture {twice[0]!r} is asked for twice in {text!r}: name each once")
    return tuple(labels)


def _wrists(text: str | None, worn: tuple[Arm, ...]) -> tuple[Arm, ...]:
    if text is None:
        return worn
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in worn:
            raise ConfigError(known_names("band on the wrist", name, worn))
    return tuple(wrist for wrist in _WRISTS if wrist in names)


def _document(args: argparse.Namespace, house: RecordHouse, writer: TakeWriter) -> dict[str, Any]:
    """What was written, by label; takes that do not count apart."""
    takes: dict[str, dict[str, int]] = {}
    for _, side in writer.written:
        entry = takes.setdefault(side.label, {"takes": 0, "practice": 0, "spoilt": 0})
        entry["spoilt" if side.note else "practice" if side.practice else "takes"] += 1
    return {
        "folder": str(args.folder),
        "person": args.person,
        "simulated": writer.simulated,
        "bands": list(house.recorder.recording.wrists),
        "takes": takes,
        "files": [str(path) for path, _ in writer.written],
    }


def _show(document: dict[str, Any]) -> None:
    simulated = ", simulated" if document["simulated"] else ""
    print(f"{document['folder']}: takes of {document['person']}, bands {' and '.join(document['bands'])}{simulated}")
    for label, count in document["takes"].items():
        more = [f"{count[kind]} {words}" for kind, words in _APART.items() if count[kind]]
        print(f"  {label}: {count['takes']}" + (f" (and {', '.join(more)})" if more else ""))
    print(f"the log is {document['log']}")


_APART = {"practice": "for practice", "spoilt": "that do not count"}
