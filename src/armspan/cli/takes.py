"""``armspan takes``: the takes in a folder listed, looked at, deleted, trimmed, relabelled."""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from armspan.config.take_edits import ListedTake, checked_take, delete_take, list_takes, listed, relabel_take, trim_take
from armspan.config.take_files import read_take
from armspan.errors import ConfigError
from armspan.gesture.takes import NULL
from armspan.study.take_picture import draw_take


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb, what it does and the options of each."""
    parser = subparsers.add_parser(
        "takes",
        help="list, look at, delete, trim and relabel recorded takes",
        description="Takes lie in DIR/LABEL/PERSON_NN.csv, each with a sidecar of the same name in JSON. What is "
        "deleted or trimmed is kept in DIR/.deleted.",
    )
    deeds = parser.add_subparsers(dest="deed", metavar="DEED", required=True, title="deeds")
    _add(deeds, "list", "what there is", _list, folder=True)
    show = _add(deeds, "show", "one take: its facts, and a picture of its bands", _show)
    show.add_argument("--picture", type=Path, metavar="FILE", help="draw the take into this PNG")
    show.add_argument("--overwrite", action="store_true", help="replace the picture if it exists")
    _add(deeds, "delete", "move takes to DIR/.deleted", _delete, many=True)
    trim = _add(deeds, "trim", "keep a part of a take; the whole one goes to DIR/.deleted", _trim)
    trim.add_argument("start", type=seconds, metavar="START", help="seconds on the take's clock")
    trim.add_argument("end", type=seconds, metavar="END")
    relabel = _add(deeds, "relabel", "give a take another label", _relabel)
    relabel.add_argument("label", metavar="LABEL")


def _add(
    deeds: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    words: str,
    deed: Any,
    *,
    folder: bool = False,
    many: bool = False,
) -> argparse.ArgumentParser:
    parser = deeds.add_parser(name, help=words, description=f"{words[0].upper()}{words[1:]}.")
    if folder:
        parser.add_argument("folder", type=Path, metavar="DIR")
    else:
        parser.add_argument("file", type=Path, nargs="+" if many else None, metavar="FILE.csv")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=deed)
    return parser


def seconds(text: str) -> float:
    """A number of seconds, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds")
    return value


def _list(args: argparse.Namespace) -> int:
    takes = list_takes(args.folder)
    if args.json:
        _print_json({"folder": str(args.folder), "takes": msgspec.to_builtins(takes)})
        return 0
    for line in table_of(takes):
        print(line)
    print(summary_of(takes) if takes else f"{args.folder} holds no takes; record some with `armspan record`")
    return 0


def _show(args: argparse.Namespace) -> int:
    if args.picture:
        _check_picture(args.picture, args.overwrite)
    take = listed(checked_take(args.file))
    if args.picture:
        draw_take(args.picture, read_take(args.file), _title(take))
    if args.json:
        _print_json(msgspec.to_builtins(take) | {"picture": str(args.picture) if args.picture else None})
        return 0
    for line in table_of([take]):
        print(line)
    if args.picture:
        print(f"drawn into {args.picture}")
    return 0


def _delete(args: argparse.Namespace) -> int:
    moved = {str(path): str(delete_take(path)) for path in [checked_take(path) for path in dict.fromkeys(args.file)]}
    if args.json:
        _print_json({"deleted": moved})
    else:
        for old, new in moved.items():
            print(f"{old} is kept as {new}")
    return 0


def _trim(args: argparse.Namespace) -> int:
    take = trim_take(args.file, args.start, args.end)
    if args.json:
        _print_json(msgspec.to_builtins(take))
    else:
        print(f"{args.file} now lasts {take.seconds:.2f} s; the whole take is kept in .deleted")
    return 0


def _relabel(args: argparse.Namespace) -> int:
    target = relabel_take(args.file, args.label)
    if args.json:
        _print_json({"from": str(args.file), "to": str(target)})
    else:
        print(f"{args.file} is now {target}")
    return 0


def table_of(takes: Sequence[ListedTake]) -> list[str]:
    """The takes as lines of a table, the first one its head."""
    rows: list[tuple[str, ...]] = [
        ("take", "label", "person", "no.", "seconds", "Hz", "gesture [s]", "bands", "remarks")
    ]
    rows += [_row(take) for take in takes]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def _row(take: ListedTake) -> tuple[str, ...]:
    span = f"{take.gesture_s[0]:.2f} to {take.gesture_s[1]:.2f}" if take.gesture_s else "-"
    rate = f"{take.rate_hz:.0f}" if take.rate_hz else "-"
    return (
        take.path,
        take.label,
        take.person,
        str(take.number),
        f"{take.seconds:.2f}",
        rate,
        span,
        "+".join(take.bands),
        ", ".join([*_remarks(take), *filter(None, [take.note])]),
    )


def _remarks(take: ListedTake) -> list[str]:
    return [word for word, told in (("practice", take.practice), ("simulated", take.simulated)) if told]


def summary_of(takes: Sequence[ListedTake]) -> str:
    """How many takes there are of each label, in a line."""
    words = []
    for label in sorted({take.label for take in takes}):
        flags = [take.practice for take in takes if take.label == label]
        words.append(f"{label} {flags.count(False)}" + (f" (+{flags.count(True)})" if True in flags else ""))
    null = sum(take.seconds for take in takes if take.label == NULL and not take.practice)
    return f"takes (+ for practice): {', '.join(words)}" + (f"; {null / 60:.1f} min of everyday motion" if null else "")


def _title(take: ListedTake) -> str:
    remarks = ", ".join(_remarks(take))
    return f"{take.label}, {take.person} no. {take.number}" + (f" ({remarks})" if remarks else "")


def _check_picture(picture: Path, overwrite: bool) -> None:
    """Refuse a place where the picture cannot be, or would replace something."""
    if picture.is_dir():
        raise ConfigError(f"{picture} is a folder: name a file for the picture")
    if not picture.parent.is_dir():
        raise ConfigError(f"{picture.parent} is not a folder: make it first, or draw elsewhere")
    if picture.exists() and not overwrite:
        raise ConfigError(f"{picture} exists: name another picture, or replace it with --overwrite")


def _print_json(document: Any) -> None:
    print(msgspec.json.encode(document).decode())
