"""``armspan train``: a gesture model from a folder of takes, and an honest account of it."""

import argparse
import sys
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from rich.console import Console
from rich.progress import Progress as Bar
from rich.table import Table

from armspan.cli.demo import seed
from armspan.cli.results import Results
from armspan.cli.run import positive
from armspan.config.model_files import check_picture, check_target, write_model
from armspan.config.take_files import read_takes, write_whole
from armspan.errors import DataError, ModelError
from armspan.gesture.model import Facts, GestureModel
from armspan.gesture.pipeline import KINDS, RECIPES
from armspan.gesture.training import Wanted, advice, train
from armspan.study.confusion_picture import draw_confusion

SHORTEST, LONGEST = 0.25, 10.0
"""Seconds that a spotting window may have."""


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "train",
        help="train a gesture model on a folder of takes",
        description="Train on DIR/LABEL/PERSON_NN.csv; takes labelled null are everyday motion. Any columns will do: "
        "the model takes them by name. Cross-validation by take and by person says how good it is.",
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--model", choices=KINDS, default="kernels", help="default: %(default)s")
    parser.add_argument("--recipe", choices=sorted(RECIPES), default="standard", help="default: %(default)s")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="MODEL", help="the file to write")
    parser.add_argument("--bands", choices=("right", "left"), help="use the columns of one band only")
    parser.add_argument(
        "--with",
        dest="others",
        type=Path,
        metavar="DIR",
        help="takes of other people: a general model, refined by the own takes, which count more",
    )
    parser.add_argument(
        "--window",
        type=positive,
        metavar="S",
        help="seconds of a spotting window; default: the length of a usual gesture, 1 to 2.5",
    )
    parser.add_argument(
        "--rate", type=per_hour, default=1.0, metavar="N", help="false triggers an hour put up with; default: 1"
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="default: %(default)s")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="confusion matrix; default: MODEL with .png")
    parser.add_argument("--onnx", type=Path, metavar="FILE", help="also write the network as ONNX (cnn only)")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def per_hour(text: str) -> float:
    """A rate above zero, for argparse."""
    try:
        return positive(text)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of triggers an hour above zero") from None


def run(args: argparse.Namespace) -> int:
    """Train and say how good the model is."""
    check_target(args.output)
    picture = args.picture or args.output.with_suffix(".png")
    check_picture(picture)
    _check_apart({"the model": args.output, "its picture": picture, "the ONNX file": args.onnx})
    if args.window is not None and not SHORTEST <= args.window <= LONGEST:
        raise ModelError(
            f"--window {args.window:g} s: expected {SHORTEST:g} to {LONGEST:g} s, about one gesture's length"
        )
    if args.others and args.others.resolve() == args.folder.resolve():
        raise DataError(
            f"--with {args.others} is the folder of the own takes: name one with other people's, or leave it out"
        )
    if args.onnx:
        check_target(args.onnx, "ONNX file", b"\x08")
        if args.model != "cnn":
            raise ModelError(f"--onnx writes a network, and {args.model} is none: add --model cnn, or leave --onnx out")
    takes = read_takes(args.folder, bands=args.bands)
    others = read_takes(args.others, bands=args.bands) if args.others else []
    wanted = Wanted(kind=args.model, recipe=args.recipe, rate_per_hour=args.rate, seed=args.seed, window_s=args.window)
    with Bar(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        job = bar.add_task("reading", total=1.0)
        model = train(takes, wanted, lambda what, share: bar.update(job, description=what, completed=share), others)
    write_model(args.output, model)
    if args.onnx:
        write_whole(args.onnx, network_file(model))
    table = (model.facts.scores["by_take"] or {}).get("confusion")
    if table is not None:
        draw_confusion(picture, np.array(table), model.facts.labels, f"{args.folder}, held-out takes")
    document = describe(model.facts) | {"model": str(args.output), "picture": str(picture) if table else None}
    if args.json:
        print(msgspec.json.encode(document).decode())
    else:
        show(model.facts, args.output)
    return 0


def _check_apart(targets: dict[str, Path | None]) -> None:
    """Refuse two results in one file (ModelError)."""
    seen: dict[Path, str] = {}
    for what, path in targets.items():
        if path is None:
            continue
        other = seen.setdefault(path.resolve(), what)
        if other != what:
            raise ModelError(f"{path} would be both {other} and {what}: give one of them another name")


def network_file(model: GestureModel) -> bytes:
    """The network that spots, as ONNX: windows in, decision values out."""
    from armspan.gesture.onnx_file import to_onnx  # needs the extra cnn

    return to_onnx(model.windows.model.state(), model.windows.recipe.state())


def describe(facts: Facts) -> dict[str, Any]:
    """What a program wants to know of a model."""
    by_take = facts.scores.get("by_take") or {}
    return {
        "kind": facts.kind,
        "recipe": facts.recipe,
        "labels": facts.labels,
        "columns": facts.columns,
        "rate_hz": facts.rate_hz,
        "takes": facts.takes,
        "persons": facts.persons,
        "null_s": facts.null_s,
        "window_s": facts.window_s,
        "rule": msgspec.to_builtins(facts.rule),
        "accuracy": by_take.get("accuracy"),
        "macro_f1": by_take.get("macro_f1"),
        "cross_validation": {name: facts.scores.get(name) for name in ("by_take", "by_person")},
        "spotting": facts.scores.get("spotting"),
        "advice": advice(facts),
    }


def show(facts: Facts, path: Path) -> None:
    """The account in words."""
    console = Results(soft_wrap=True, highlight=False)
    takes = sum(facts.takes.values())
    console.print(
        f"{path}: {facts.kind}, {facts.recipe} recipe, {takes} takes of {len(facts.labels)} gestures by "
        f"{len(facts.persons)} {'person' if len(facts.persons) == 1 else 'persons'}, "
        f"{facts.null_s / 60:.1f} min of everyday motion"
    )
    table = Table("held out", "accuracy", "macro F1", box=None, pad_edge=False)
    for name, words in (("by_take", "takes"), ("by_person", "whole persons")):
        entry = facts.scores.get(name)
        if entry:
            table.add_row(words, f"{100 * entry['accuracy']:.1f} %", f"{entry['macro_f1']:.3f}")
    console.print(table)
    console.print(spotting_words(facts.scores["spotting"]))
    for line in advice(facts):
        console.print(f"- {line}")


def spotting_words(spotting: dict[str, Any]) -> str:
    """What spotting did on held-out data, with no more claimed than was seen."""
    text = f"Live, on held-out data: {spotting['recognised']} of {spotting['takes']} takes noticed"
    if spotting["latency_s"] is not None:
        text += f", {spotting['latency_s']:.1f} s after their onset (median)"
    if not spotting["null_hours"]:
        return f"{text}; nothing is known of false triggers: record everyday motion (armspan record --null 600)"
    return (
        f"{text}; {spotting['false_triggers']} false triggers in {60 * spotting['null_hours']:.1f} min, so below "
        f"{spotting['below_per_hour']:.3g} an hour (95 %)"
    )


def percent(share: float | None) -> str:
    """A share in per cent."""
    return "-" if share is None else f"{100 * share:.1f} %"
