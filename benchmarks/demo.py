"""The demo over many seeds: pointing error, selection, calibration error and how honest the stated odds are.

Simulated: virtual person, bands and robots. Run: python benchmarks/demo.py --seeds 100 [--first 0] [--jobs 2]
Prints Markdown tables; --json FILE gets one line a session as they end, --read FILE reports on such lines
without running anything, --figure FILE draws the reliability diagram.
"""

import argparse
import json
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from armspan.cli.play import play, read_account
from armspan.config.demo_room import demo_room
from armspan.config.house import open_house
from armspan.study.sheet_error import sheet_errors, sheet_rms

CASES = (("straight", 1), ("straight", 2), ("natural", 1), ("natural", 2))


def session(job):
    """One demo; what it showed, trial by trial."""
    posture, bands, seed = job
    house = open_house(demo_room(seed, posture=posture, bands=bands), seconds=600)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "demo.mcap"
        play(house, path, live=False)
        _, found = read_account(path, house)
    truth, calibration = house.world.truth, found.calibration
    rms = None
    if truth and calibration:
        heights = (house.settings.body.eye_height_m, truth.eye_height)
        place = (calibration.xyz, calibration.yaw)
        rms = sheet_rms(sheet_errors(place, (truth.xyz, truth.yaw), heights, house.settings.sheet))
    trials = [
        {
            "feedback": t.feedback,
            "miss": t.miss,
            "angle": t.angle,
            "decided": t.decided,
            "right": t.right,
            "best_right": t.best == t.target,
            "probability": t.probability,
            "inside": t.inside_90,
            "seconds": t.seconds,
        }
        for t in found.trials
    ]
    document = found.document()
    return {
        "arm": posture,
        "bands": bands,
        "seed": seed,
        "sheet_rms": rms,
        "fit_deg": document["calibration"]["rms_deg"],
        "violations": document["safety"]["violations"],
        "kinds": document["safety"]["kinds"],
        "unasked": document["selection"]["unasked"],
        "seconds": document["seconds"],
        "trials": trials,
    }


def row(name, sessions, feedback):
    trials = [t for s in sessions for t in s["trials"] if t["feedback"] == feedback]
    misses = np.array([t["miss"] for t in trials if t["miss"] is not None])
    angles = np.degrees([t["angle"] for t in trials if t["angle"] is not None])
    decided = [t for t in trials if t["decided"]]
    right = sum(t["right"] for t in decided)
    inside = [t["inside"] for t in trials if t["inside"] is not None]
    return (
        f"| {name} | {'cursor' if feedback else 'no cursor'} | {1000 * np.median(misses):.0f} | "
        f"{1000 * np.percentile(misses, 90):.0f} | {np.median(angles):.1f} | "
        f"{100 * len(decided) / len(trials):.1f} | {100 * right / max(1, len(decided)):.1f} | "
        f"{100 * np.mean([t['best_right'] for t in trials]):.1f} | {np.median([t['seconds'] for t in trials]):.1f} | "
        f"{100 * np.mean(inside):.0f} |"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--cases", nargs="*", default=[f"{a}{b}" for a, b in CASES])
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--read", type=Path, nargs="*")
    args = parser.parse_args()
    cases = [(a, b) for a, b in CASES if f"{a}{b}" in args.cases]
    jobs = [(a, b, seed) for seed in range(args.first, args.first + args.seeds) for a, b in cases]
    if args.read:
        sessions = [json.loads(line) for path in args.read for line in path.read_text().splitlines()]
        cases = [case for case in CASES if any((s["arm"], s["bands"]) == case for s in sessions)]
    else:
        sessions = run(jobs, args.jobs, args.json)
    report(cases, sessions)
    if args.figure:
        draw(args.figure, cases, sessions)


def run(jobs, processes, keep):
    sessions = []
    with ProcessPoolExecutor(processes) as pool:
        for number, found in enumerate(pool.map(session, jobs), 1):
            sessions.append(found)
            print(f"\r{number}/{len(jobs)}", end="", file=sys.stderr)
            if keep:
                with keep.open("a") as file:
                    file.write(json.dumps(found) + "\n")
    print(file=sys.stderr)
    return sessions


def report(cases, sessions):
    print(
        "| arm, bands | mode | median mm | p90 mm | median deg | decided % | right of decided % | best guess right % |",
        end="",
    )
    print(" seconds | target in 90 % ellipse, % |\n|" + "---|" * 10)
    for arm, bands in cases:
        group = [s for s in sessions if (s["arm"], s["bands"]) == (arm, bands)]
        for feedback in (False, True):
            print(row(f"{arm}, {bands}", group, feedback))
    print(
        "\n| arm, bands | calibrated | sheet RMS median mm | p90 mm | fit residual median deg | violations | unasked |"
    )
    print("|" + "---|" * 7)
    for arm, bands in cases:
        group = [s for s in sessions if (s["arm"], s["bands"]) == (arm, bands)]
        rms = 1000 * np.array([s["sheet_rms"] for s in group if s["sheet_rms"] is not None])
        fits = [s["fit_deg"] for s in group if s["fit_deg"] is not None]
        print(
            f"| {arm}, {bands} | {len(rms)} of {len(group)} | {np.median(rms):.0f} | {np.percentile(rms, 90):.0f} | "
            f"{np.median(fits):.1f} | {sum(s['violations'] for s in group)} | {sum(s['unasked'] for s in group)} |"
        )
    print("\nStated posterior of the best candidate at the end of a trial, and how often it was right:\n")
    print("| stated | " + " | ".join(f"{a}, {b}" for a, b in cases) + " |\n|" + "---|" * (len(cases) + 1))
    for low, high in BINS:
        cells = []
        for arm, bands in cases:
            share, count = reliability(sessions, arm, bands, low, high)
            cells.append(f"{100 * share:.0f} % of {count}" if count else "-")
        print(f"| {low:.2f}-{high:.2f} | " + " | ".join(cells) + " |")


BINS = ((0.2, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 0.9), (0.9, 0.97), (0.97, 1.0001))


def reliability(sessions, arm, bands, low, high):
    trials = [t for s in sessions if (s["arm"], s["bands"]) == (arm, bands) for t in s["trials"]]
    here = [t["best_right"] if not t["decided"] else t["right"] for t in trials if low <= t["probability"] < high]
    return (float(np.mean(here)) if here else 0.0), len(here)


def draw(path, cases, sessions):
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.5, 5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="0.7", lw=1)
    for arm, bands in cases:
        points = [(np.mean([low, min(high, 1)]), *reliability(sessions, arm, bands, low, high)) for low, high in BINS]
        points = [p for p in points if p[2] >= 20]
        axes.plot([p[0] for p in points], [p[1] for p in points], marker="o", label=f"{arm} arm, {bands} band(s)")
    axes.set(
        xlabel="stated probability", ylabel="share right", title="Selection, simulated demo", xlim=(0, 1), ylim=(0, 1)
    )
    axes.legend()
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
