"""``armspan body``: the five measures that pointing needs, without a tape."""

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import Any, get_args

import msgspec

from armspan.body.marker_sheet import marker_pdf
from armspan.body.measured import Measured, measure
from armspan.body.told import Told
from armspan.cli.body_answer import document, table
from armspan.cli.results import Results
from armspan.config.body_file import check_new, write_body
from armspan.config.body_views import Side, View, Wanted, check_free, read_view
from armspan.config.pifpaf import predict
from armspan.config.weights import fetch_weights, weights_folder
from armspan.errors import ConfigError
from armspan.records import Arm

_EYE_TEST = (
    "The dominant eye was taken to be the right one, as in two people of three. To find it: point with a straight "
    "arm at a small thing far off, both eyes open, and close the left eye. Still on it: right. It jumps: left. Three "
    "times; if the answers differ, --eye both."
)


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "body",
        help="find a person's five measures from their height, a skeleton file or pictures",
        description=(
            "Find eye height, shoulder to eye and arm length with their uncertainty. Height and sex alone do "
            "(barefoot, against a wall); every further measure narrows them. --front (facing the camera, arms "
            "stretched out to the sides, level) and --side (the pointing arm stretched forward, level, camera at that "
            "side) take a picture, or the JSON of OpenPose, openpifpaf, COCO or MediaPipe. Camera at chest height, "
            "level, 4 m away. Pictures are read where they lie, and nothing of them is kept unless --keep asks for it."
        ),
        epilog=(
            "The dominant eye: point at a small thing far off, both eyes open, and close the left one; if the finger "
            "stays on it, the right eye is dominant."
        ),
    )
    _add_told(parser)
    _add_views(parser)
    parser.add_argument("--out", type=Path, metavar="BODY.toml", help="write the measures there")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--print-marker", type=Path, metavar="FILE.pdf", help="write the A4 marker sheet, and end")
    parser.add_argument(
        "--set-up", action="store_true", help="fetch the networks that find people in pictures, and end"
    )
    parser.set_defaults(run=run)


def _add_told(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--height-m", type=float, metavar="H", help="standing height without shoes, in metres")
    add("--sex", choices=("man", "woman"), help="narrows the measures somewhat")
    add("--span-m", type=float, metavar="S", help="fingertip to fingertip, arms stretched out to the sides")
    add("--shoulder-height-m", type=float, metavar="H", help="top of the shoulder (its bony edge) above the floor")
    add("--forearm-hand-m", type=float, metavar="L", help="elbow to middle fingertip, the elbow bent")
    add("--sole-m", type=float, default=0.0, metavar="H", help="thickness of the soles worn (default: barefoot)")
    add("--seat-height-m", type=float, metavar="H", help="for a seated user: the seat's top above the floor")
    add("--arm", choices=get_args(Arm), default="right", help="the arm that points (default: %(default)s)")
    add("--eye", choices=("right", "left", "both"), help="the dominant eye (default: right; both: unsure)")
    add("--self-reported", action="store_true", help="the height is what the person says, not measured")


def _add_views(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--front", type=Path, metavar="FILE", help="picture or skeleton file from the front")
    add("--side", type=Path, metavar="FILE", help="picture or skeleton file from the side of the pointing arm")
    add("--marker", action="store_true", help="the marker sheet lies on the floor and gives the scale")
    add("--person", type=int, metavar="N", help="which of several people, from 1 on the left")
    add("--size", type=_size, metavar="WxH", help="the picture's size in pixels, for skeleton files in shares of it")
    add("--keep", type=Path, metavar="DIR", help="write the points found, and the pictures with them drawn in")
    add("--delete-pictures", action="store_true", help="delete the files of --front and --side once measured")
    add("--backend", choices=("blazepose", "openpifpaf"), default="blazepose", help="default: %(default)s")
    add("--checkpoint", type=Path, metavar="FILE", help="openpifpaf's network: a pickle, so trust its origin")
    add("--python", type=Path, metavar="FILE", help="the interpreter of the environment that holds openpifpaf")


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size in pixels such as 1920x1080")
    return int(width), int(height)


def run(args: argparse.Namespace) -> int:
    """Measure, print the result on stdout, and return the exit code."""
    if args.print_marker:
        return _print_marker(args.print_marker)
    if args.set_up:
        print(f"The networks are in {fetch_weights(weights_folder(), _say)}")
        return 0
    if args.out:
        check_new(args.out)
    if args.keep:
        check_free(args.keep, [side for side in get_args(Side) if getattr(args, side)])
    told, views = _told(args), _views(args)
    found = measure(told, [view.measured for view in views])
    if args.keep:
        _keep(args.keep, views, found)
    if args.out:
        write_body(args.out, found.fused.body, _note(args, views))
    if args.json:
        sys.stdout.buffer.write(msgspec.json.encode(document(found)) + b"\n")
    else:
        Results().print(table(found))
    _talk(args, found)
    if args.delete_pictures:
        for view in views:
            view.path.unlink(missing_ok=True)
    return 0


def _say(text: str) -> None:
    print(text, file=sys.stderr)


def _print_marker(path: Path) -> int:
    try:
        with path.open("xb") as file:
            file.write(marker_pdf())
    except FileExistsError:
        raise ConfigError(f"{path} exists and is kept: name another file") from None
    except OSError as error:
        raise ConfigError(f"{path} cannot be written ({error.strerror}): name another file") from None
    print(f"{path} is written: print it on A4 at 100 %, and check its ruler of 100 mm")
    return 0


def _told(args: argparse.Namespace) -> Told:
    return Told(
        height_m=args.height_m,
        sex=args.sex,
        span_m=args.span_m,
        shoulder_height_m=args.shoulder_height_m,
        forearm_hand_m=args.forearm_hand_m,
        sole_m=args.sole_m,
        seat_height_m=args.seat_height_m,
        arm=args.arm,
        eye=args.eye or "right",
        self_reported=args.self_reported,
    )


def _views(args: argparse.Namespace) -> list[View]:
    files: list[tuple[Path, Side]] = [(args.front, "front"), (args.side, "side")]
    named = [(path, side) for path, side in files if path is not None]
    asked = (args.marker, args.keep, args.delete_pictures, args.checkpoint, args.size, args.person is not None)
    if not named and any(asked):
        raise ConfigError("There is no picture: name one with --front or --side, or leave the options for pictures out")
    wanted = Wanted(weights_folder(), args.size, args.person, args.marker, _backend(args))
    return [read_view(path, side, wanted) for path, side in named]


def _backend(args: argparse.Namespace) -> Any:
    if args.backend == "blazepose":
        if args.checkpoint or args.python:
            raise ConfigError("--checkpoint and --python go with --backend openpifpaf: add it, or leave them out")
        return None
    if args.checkpoint is None:
        raise ConfigError("--backend openpifpaf needs its network: name the file with --checkpoint")
    return partial(predict, checkpoint=args.checkpoint, python=args.python or Path(sys.executable))


def _note(args: argparse.Namespace, views: list[View]) -> str:
    typed = {
        "height": args.height_m,
        "span": args.span_m,
        "shoulder height": args.shoulder_height_m,
        "forearm and hand": args.forearm_hand_m,
        "soles": args.sole_m or None,
        "seat": args.seat_height_m,
    }
    told = ", ".join(f"{name} {value:g} m" for name, value in typed.items() if value is not None)
    seen = "".join(f", {view.side} view {view.path.name}" for view in views)
    return f"Written by `armspan body` from: {told}{seen}. Dominant eye: {args.eye or 'right'}."


def _keep(folder: Path, views: list[View], found: Measured) -> None:
    for view, seen in zip(views, found.seen, strict=True):
        for path in view.keep(folder, seen, found.fused.body.arm):
            _say(f"armspan body: {path} is written")


def _talk(args: argparse.Namespace, found: Measured) -> None:
    for note in found.notes:
        _say(f"armspan body: {note}")
    for odd in found.fused.rejected:
        told = odd.observation
        _say(
            f"armspan body: {told.measure} {told.value:.3f} m from {told.source} is {abs(odd.z):.1f} standard "
            "deviations from what this height tells, and was left out: look at the points with --keep DIR"
        )
    if args.eye is None and not args.json:
        _say(_EYE_TEST)
