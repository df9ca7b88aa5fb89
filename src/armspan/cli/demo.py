"""``armspan demo``: the main job with a virtual person, virtual bands and virtual robots."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import msgspec
import numpy as np

from armspan.cli.play import play, read_account, step_times, talk
from armspan.cli.progress import Progress
from armspan.cli.report import print_account
from armspan.cli.run import positive
from armspan.config.demo_room import demo_room
from armspan.config.house import House, open_emulated
from armspan.config.model_files import read_model
from armspan.config.room_file import RoomFile
from armspan.config.session_files import fresh_log, make_folder
from armspan.errors import ConfigError, ModelError, known_names
from armspan.gesture.takes import INITIAL
from armspan.log import LogFile
from armspan.pointing.laser import LaserSettings
from armspan.ports import Sink
from armspan.records import Record
from armspan.simulation.gesture_styles import LABELS
from armspan.study.account import Account
from armspan.study.gestures import gestures_of
from armspan.study.picture import draw
from armspan.study.sheet_error import sheet_errors, sheet_rms
from armspan.swarm.director import STOP

EVERYDAY = "everyday:12"


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "demo",
        help="watch the main job: set-up, four stops, pointing at twenty targets",
        description="A virtual person with a band on the wrist finds their place by pointing at a robot at four "
        "stops, then points at twenty targets, first without and then with a cursor shown by the robots' lights.",
    )
    parser.add_argument("--headless", action="store_true", help="no live display; as fast as it goes")
    parser.add_argument(
        "--pace",
        choices=("live", "fast"),
        help="in real time, or as fast as it goes; default: live in a terminal, else fast",
    )
    parser.add_argument(
        "--seed", type=seed, default=1, metavar="N", help="one seed is one session; default: %(default)s"
    )
    parser.add_argument("--seconds", type=positive, metavar="S", help="end after S seconds of session time")
    parser.add_argument("--arm", choices=("straight", "natural"), default="straight", help="how the arm is held")
    parser.add_argument(
        "--bands",
        type=worn,
        default=Worn(1, None),
        metavar="N|metawear[:N]",
        help="a second one sits on the upper arm; metawear puts them behind emulated boards and a radio, in real time",
    )
    parser.add_argument(
        "--robots",
        choices=("virtual", "cellulo"),
        default="virtual",
        help="cellulo puts them behind an emulated relay and their bytes, in real time; default: %(default)s",
    )
    parser.add_argument(
        "--laser", action="store_true", help="the person also wears a laser, and each robot has a receptor for it"
    )
    parser.add_argument(
        "--gestures",
        type=Path,
        metavar="MODEL",
        help="a model of `armspan train`: after pointing, the person makes its gestures, a band on either wrist",
    )
    parser.add_argument(
        "--trials", type=count, default=20, metavar="N", help="targets to point at; default: %(default)s"
    )
    parser.add_argument("--log", type=Path, metavar="FILE", help="default: sessions/DATE_demo.mcap")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="a PNG; default: beside the log")
    parser.add_argument("--overwrite", action="store_true", help="replace the log and the picture if they exist")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def seed(text: str) -> int:
    """A whole number from 0, for argparse."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 0")
    return int(text)


def count(text: str) -> int:
    """A whole number from 1, for argparse."""
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1")
    return int(text)


class Worn(NamedTuple):
    """How many bands, and what they are where they are not virtual."""

    number: int
    kind: Literal["metawear"] | None


def worn(text: str) -> Worn:
    """``1``, ``2``, ``metawear`` or ``metawear:2``, for argparse."""
    kind, colon, number = text.rpartition(":") if text[-1:].isdigit() else (text, ":", "1")
    if number not in ("1", "2") or kind not in ("", "metawear") or bool(kind) != bool(colon):
        raise argparse.ArgumentTypeError(f"{text!r} is not 1, 2, metawear or metawear:2")
    return Worn(int(number), "metawear" if kind else None)


def room_of(args: argparse.Namespace) -> RoomFile:
    """The demo's room, with gestures where a model is named."""
    if args.gestures is None:
        return demo_room(args.seed, posture=args.arm, bands=args.bands.number, trials=args.trials, laser=_laser(args))
    labels = read_model(args.gestures).facts.labels
    strange = [label for label in labels if label not in LABELS]
    if strange:
        known = known_names("A gesture", strange[0], LABELS)
        raise ModelError(f"{args.gestures}: the virtual person cannot make all its gestures; {known}")
    programme = gesture_programme(labels)
    return demo_room(
        args.seed,
        posture=args.arm,
        bands=args.bands.number,
        trials=args.trials,
        laser=_laser(args),
        model=str(args.gestures.absolute()),
        gestures=programme,
    )


def _laser(args: argparse.Namespace) -> LaserSettings | None:
    return LaserSettings() if args.laser else None


def gesture_programme(labels: Sequence[str]) -> tuple[str, ...]:
    """Each gesture once, everyday motion between them; ``stop`` comes last, since robots stay stopped after it."""
    order = sorted((label for label in labels if label != INITIAL), key=lambda label: (label == STOP, label))
    return tuple(item for label in order for item in (label, EVERYDAY))


def run(args: argparse.Namespace) -> int:
    """Play the demo and show what it showed."""
    robots = None if args.robots == "virtual" else args.robots
    house = open_emulated(room_of(args), args.bands.kind, robots, seconds=args.seconds)
    path = args.log or fresh_log("demo")
    picture = args.picture or path.with_suffix(".png")
    _check_picture(picture, path, args.overwrite)
    watched = sys.stderr.isatty() and not args.headless
    if house.lasts and args.pace == "fast":
        raise ConfigError("emulated devices live by the clock: leave --pace fast out")
    live = house.lasts or (args.pace or ("live" if watched else "fast")) == "live"
    with Progress(house.settings, shown=watched) as progress:
        sinks: list[Sink] = [progress] if watched else [] if args.headless else [talk]
        counters = play(house, path, live=live, overwrite=args.overwrite, sinks=sinks)
    log, found = read_account(path, house)
    _draw(picture, log, found, house)
    document = _document(
        args, house, found, log.records, {"step_us": step_times(counters), "log": str(path), "picture": str(picture)}
    )
    if args.json:
        print(msgspec.json.encode(document).decode())
    else:
        print_account(document, f"The demo, seed {args.seed}, {args.arm} arm, {_in_words(args)}, simulated")
    return 0


def _in_words(args: argparse.Namespace) -> str:
    number = "one" if args.bands.number == 1 else "two"
    bands = f"{number} {'emulated MetaWear ' if args.bands.kind else ''}band{'s' if args.bands.number > 1 else ''}"
    bands += " and a laser" if args.laser else ""
    return bands if args.robots == "virtual" else f"{bands}, emulated Cellulo robots"


def _check_picture(picture: Path, log: Path, overwrite: bool) -> None:
    """Refuse before the session what would fail, or replace something, after it."""
    if picture.resolve() == log.resolve():
        raise ConfigError(f"{picture} would be both the log and its picture: name another picture with --picture")
    if picture.is_dir():
        raise ConfigError(f"{picture} is a folder: name a file for the picture with --picture")
    if picture.exists() and not overwrite and picture.stat().st_size:
        raise ConfigError(f"{picture} exists: name another picture with --picture, or replace it with --overwrite")
    make_folder(picture.parent)


def _draw(picture: Path, log: LogFile, found: Account, house: House) -> None:
    try:
        draw(picture, log.records, found, house.settings.sheet, house.settings.zones)
    except OSError as error:
        raise ConfigError(f"{picture} cannot be written ({error.strerror}); the log is whole: {log.path}") from None


def _document(
    args: argparse.Namespace, house: House, found: Account, records: Sequence[Record], more: dict[str, Any]
) -> dict[str, Any]:
    document = found.document()
    calibration = document["calibration"]
    if isinstance(calibration, dict):
        calibration["sheet_rms_mm"] = _against_truth(house, found)
    if house.model is not None:
        document["gestures"] = gestures_of(records).document()
    setting: dict[str, Any] = {
        "seed": args.seed,
        "arm": args.arm,
        "bands": args.bands.number,
        "simulated": True,
    }
    if house.lasts:
        setting["emulated"] = {"bands": args.bands.kind, "robots": args.robots}
    return {**setting, **document, **more}


def _against_truth(house: House, found: Account) -> float | None:
    """The calibration's error over the sheet [mm], against what the virtual world knows."""
    truth = house.world.truth if house.world else None
    if truth is None or found.calibration is None:
        return None
    heights = (house.settings.body.eye_height_m, truth.eye_height)
    calibration = (found.calibration.xyz, found.calibration.yaw)
    rms = sheet_rms(sheet_errors(calibration, (truth.xyz, truth.yaw), heights, house.settings.sheet))
    return round(1000 * rms, 2) if np.isfinite(rms) else None
