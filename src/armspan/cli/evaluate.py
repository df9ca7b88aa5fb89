"""``armspan evaluate``: how good a model is on takes that it has not seen."""

import argparse
from pathlib import Path
from typing import Any

import msgspec

from armspan.cli.train import percent
from armspan.config.model_files import check_picture, read_model
from armspan.config.take_files import read_takes
from armspan.gesture.evaluation import evaluate
from armspan.study.confusion_picture import draw_confusion


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "evaluate",
        help="try a gesture model on a folder of takes",
        description="Classify every take of DIR/LABEL/PERSON_NN.csv; recordings labelled null count false triggers.",
    )
    parser.add_argument("model", type=Path, metavar="MODEL")
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="the confusion matrix as a PNG")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Classify the takes and say how many were right."""
    if args.picture:
        check_picture(args.picture)
    found = evaluate(read_model(args.model), read_takes(args.folder))
    if args.picture:
        draw_confusion(args.picture, found.table, found.labels, f"{args.folder}, {args.model.name}")
    document: dict[str, Any] = {"model": str(args.model), "takes": str(args.folder)} | found.document()
    if args.json:
        print(msgspec.json.encode(document).decode())
        return 0
    print(f"{found.count} takes: accuracy {percent(document['accuracy'])}, macro F1 {document['macro_f1']:.3f}")
    for label, recall in document["recall"].items():
        print(f"  {label:<20} {percent(recall)}")
    null = document["null"]
    if null:
        print(
            f"{null['false_triggers']} false triggers in {60 * null['hours']:.1f} min of null, so below "
            f"{null['below_per_hour']:.3g} an hour (95 %)"
        )
    return 0
