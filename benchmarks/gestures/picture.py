"""The benchmarks' picture: `picture.py --sets SETS.json --networks NETWORKS.md --spotting SPOT.json -o FILE.png`.

Reads what `sets.py --json`, `networks.py` (its table) and `spotting.py --json` wrote.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from sets import ANCHORS

COLOURS = {"kernels": "#1b6ca8", "cnn standard": "#e08214", "cnn report": "#fdc38d", "dtw": "#b0b0b0"}


def accuracies(sets: Path, networks: Path) -> dict[str, dict[str, float]]:
    """Mean accuracy [%] by set and model."""
    found: dict[str, dict[str, float]] = {}
    for row in json.loads(sets.read_text())["sets"]:
        found.setdefault(row["dataset"], {})[row["model"]] = float(np.mean(row["accuracy"]))
    for line in networks.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) >= 3 and cells[0] in ANCHORS:
            found.setdefault(cells[0], {})[f"cnn {cells[1]}"] = float(cells[2])
    return found


def main() -> None:
    parser = argparse.ArgumentParser()
    for name in ("sets", "networks", "spotting"):
        parser.add_argument(f"--{name}", type=Path, required=True)
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    figure = Figure(figsize=(12, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.9, 1))
    found = accuracies(args.sets, args.networks)
    for place, (name, models) in enumerate(found.items()):
        for k, (model, colour) in enumerate(COLOURS.items()):
            if model in models:
                left.bar(place + 0.2 * (k - 1.5), models[model] - 60, 0.19, 60, color=colour, label=model)
        left.hlines(ANCHORS[name].best, place - 0.42, place + 0.42, color="black", lw=1.6)
    handles = dict(zip(*reversed(left.get_legend_handles_labels()), strict=True))
    left.legend(handles.values(), handles.keys(), loc="lower right", ncols=2, fontsize=8)
    left.set_xticks(range(len(found)), [name.replace("_", "\n") for name in found], rotation=35, ha="right", fontsize=8)
    left.set_ylim(60, 101)
    left.set_ylabel("accuracy, % (from 60)")
    left.set_title("Whole takes, real recordings; the line is the best known", fontsize=10)
    rows = json.loads(args.spotting.read_text())["actrectut"]
    names = list(dict.fromkeys(row["what"] for row in rows))
    for place, name in enumerate(reversed(names)):
        own = [row for row in rows if row["what"] == name]
        f1, per_hour = [row["event_f1"] for row in own], np.mean([float(row["per_h"]) for row in own])
        right.barh(place, np.mean(f1), 0.6, color="#b0b0b0" if "report" in name else "#1b6ca8")
        right.plot(f1, [place] * len(f1), "k.", ms=4)
        right.text(
            0.02, place, f"{np.mean(f1):.3f}, {per_hour:.0f} insertions/h", va="center", color="white", fontsize=8
        )
    right.set_yticks(range(len(names)), [name.replace(", ", ",\n") for name in reversed(names)], fontsize=8)
    right.set_xlim(0, 1)
    right.set_xlabel("event F1")
    right.set_title("Spotting in 17 minutes of a real stream, one wrist", fontsize=10)
    figure.savefig(args.output, dpi=110)


if __name__ == "__main__":
    main()
