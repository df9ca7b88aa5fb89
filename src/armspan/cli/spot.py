"""``armspan spot``: the gestures in a recorded stream or in a session's log."""

import argparse
from pathlib import Path
from typing import Any

import msgspec

from armspan.cli.replay import tell_if_cut
from armspan.conductor import Conductor
from armspan.config.model_files import read_model, read_stream, read_truth
from armspan.config.recalled import settings_of
from armspan.errors import LogError
from armspan.gesture.decision import Spotted
from armspan.gesture.model import GestureModel
from armspan.gesture.scoring import EventScore, score_events
from armspan.gesture.stream import signals_of, spot
from armspan.log import read
from armspan.log.layout import MAGIC
from armspan.records import EVENTS, Gesture, ImuSample, Press


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "spot",
        help="find gestures in a recorded stream or a log",
        description="Prints start, end, time of recognition, label and score of each gesture found; with --truth also "
        "event F1, insertions, substitutions, duplicates, false triggers an hour and latency.",
    )
    parser.add_argument("model", type=Path, metavar="MODEL")
    parser.add_argument("stream", type=Path, metavar="STREAM.csv|LOG")
    parser.add_argument("--truth", type=Path, metavar="FILE", help="CSV with start_s,end_s,label")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Spot, and score where the truth is told."""
    model = read_model(args.model)
    truth = read_truth(args.truth, model.facts.labels) if args.truth else None
    events, seconds = _spot(args.stream, model)
    score = score_events(events, truth, seconds) if truth is not None else None
    if args.json:
        print(msgspec.json.encode(_document(args, events, seconds, score)).decode())
        return 0
    print("start_s,end_s,label,score,recognised_s")
    for event in events:
        end = "" if event.end is None else f"{event.end:.2f}"
        print(f"{event.start:.2f},{end},{event.label},{event.score:.3f},{event.t:.2f}")
    if score is not None:
        print(_words(score))
    return 0


def _spot(path: Path, model: GestureModel) -> tuple[list[Spotted], float]:
    if is_log(path):
        return spot_log(path, model)
    stream = read_stream(path)
    return spot(model, signals_of(stream, model)), stream.seconds


def spot_log(path: Path, model: GestureModel) -> tuple[list[Spotted], float]:
    """The gestures that a conductor with this model finds in a log, and the log's length [s].

    Raises:
        LogError: the log cannot be read, or holds no band that was set up.

    """
    log = read(path)
    tell_if_cut(log)
    if not any(isinstance(record, Press) and record.name == "setup" for record in log.records):
        raise LogError(
            f"{path} holds no set-up of the bands: gestures need the user's frame; spot a stream as CSV instead"
        )
    conductor, found = Conductor(settings_of(log), model), []
    for record in log.records:
        if isinstance(record, EVENTS):
            outputs = conductor.step(record)  # type: ignore[arg-type]
            found += [Spotted(o.t, o.started, None, o.label, o.score) for o in outputs if isinstance(o, Gesture)]
    samples = [record.t for record in log.records if isinstance(record, ImuSample)]
    return found, max(samples, default=0.0)


def is_log(path: Path) -> bool:
    """Whether a file is a session's log, by its first bytes."""
    try:
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False  # the reader of streams says what is wrong


def _document(
    args: argparse.Namespace, events: list[Spotted], seconds: float, score: EventScore | None
) -> dict[str, Any]:
    found: dict[str, Any] = {
        "model": str(args.model),
        "stream": str(args.stream),
        "seconds": round(seconds, 3),
        "events": [msgspec.to_builtins(event) for event in events],
    }
    return found | ({"score": msgspec.to_builtins(score), "event_f1": score.f1} if score else {})


def _words(score: EventScore) -> str:
    text = (
        f"{score.hits} of {score.gestures} gestures found, event F1 {score.f1:.3f}; {score.insertions} insertions, "
        f"{score.substitutions} substitutions, {score.duplicates} duplicates"
    )
    if score.per_hour is not None and score.bound_per_hour is not None:
        text += (
            f"; {score.per_hour:.3g} false triggers an hour outside gestures, below {score.bound_per_hour:.3g} (95 %)"
        )
    if score.latency_s:
        text += f"; recognised {score.latency_s[0]:.2f} s after the onset (median; 95 %: {score.latency_s[1]:.2f})"
    return text
