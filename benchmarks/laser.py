"""A laser on the wrist and receptors on the robots, against the same people without: the demo's room over many seeds.

Simulated: virtual person, band, laser, receptors and robots. Run: python benchmarks/laser.py [--seeds 20] [--first 1]
Prints a Markdown table; --json FILE gets one line a session as they end, --read FILE... reports on such lines alone.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import numpy as np

from armspan.cli.play import play, read_account
from armspan.config.demo_room import demo_room
from armspan.config.house import open_house
from armspan.log import read
from armspan.pointing.laser import LaserSettings
from armspan.records import Press, Say, Selected

UNDER = LaserSettings()
ALONG = LaserSettings(position_m=(0.0, 0.0, 0.035), direction_deg=(0.0, 0.0))
"""Under the wrist and tilted down, as it is by default; on its back and along the forearm."""

CASES = {
    "straight, no laser": ("straight", 1, None),
    "straight, laser": ("straight", 1, UNDER),
    "straight, laser along the forearm": ("straight", 1, ALONG),
    "natural, no laser": ("natural", 1, None),
    "natural, laser": ("natural", 1, UNDER),
    "natural, laser along the forearm": ("natural", 1, ALONG),
    "natural, two bands, laser": ("natural", 2, UNDER),
}


def session(case, seed):
    """One demo; what it showed, trial by trial."""
    posture, bands, laser = CASES[case]
    feedback = "both" if laser is None else "off"
    house = open_house(demo_room(seed, posture=posture, bands=bands, feedback=feedback, laser=laser), seconds=600)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "demo.mcap"
        play(house, path, live=False)
        _, found = read_account(path, house)
        records = read(path).records
    ready = [record.t for record in records if isinstance(record, Say) and record.cue == "ready"]
    chosen = {record.t: record.how for record in records if isinstance(record, Selected)}
    trials = [
        {
            "target": t.target,
            "cursor": t.feedback,
            "decided": t.decided,
            "right": t.right,
            "how": chosen.get(round(t.t + t.seconds, 9)) or nearest(chosen, t.t + t.seconds),
            "seconds": t.seconds,
            "miss": t.miss,
        }
        for t in found.trials
    ]
    return {"case": case, "seed": seed, "ready": ready[:1], "strays": strays(records), "trials": trials}


def nearest(chosen, t):
    return chosen[min(chosen, key=lambda at: abs(at - t))] if chosen else None


def strays(records):
    """Choices of what was neither asked for nor was asked for last."""
    wanted, count = None, 0
    for record in records:
        if isinstance(record, Press) and record.name == "trial" and record.value:
            wanted = record.value
        elif isinstance(record, Selected):
            count += wanted != (f"robot:{record.robot}" if record.robot else f"zone:{record.zone}")
    return count


def row(name, sessions, cursor, kind):
    trials = [t for s in sessions for t in s["trials"] if t["cursor"] == cursor and t["target"].startswith(kind)]
    if not trials:
        return None
    decided = [t for t in trials if t["decided"]]
    right = [t for t in decided if t["right"]]
    misses = [1000 * t["miss"] for t in trials if t["miss"] is not None]
    hit = sum(t["how"] == "hit" for t in decided)
    seconds = np.median([t["seconds"] for t in right]) if right else np.nan
    return (
        f"| {name} | {kind}s | {len(trials)} | {100 * len(decided) / len(trials):.1f} | "
        f"{100 * len(right) / max(1, len(decided)):.1f} | {len(decided) - len(right)} | {hit} | {seconds:.2f} | "
        f"{np.median(misses):.0f} |"
    )


def report(sessions):
    print("| arm | targets | asked | decided % | right of decided % | wrong | chosen by hit | seconds | spot off, mm |")
    print("|" + "---|" * 9)
    for case in CASES:
        group = [s for s in sessions if s["case"] == case]
        for cursor in (False, True):
            for kind in ("robot", "zone"):
                line = row(case + (", cursor" if cursor else ""), group, cursor, kind)
                if line:
                    print(line)
    print("\n| arm | sessions | set up | set-up took s | choices not asked for |\n|" + "---|" * 5)
    for case in CASES:
        group = [s for s in sessions if s["case"] == case]
        if group:
            took = [s["ready"][0] for s in group if s["ready"]]
            print(
                f"| {case} | {len(group)} | {len(took)} | {np.median(took) if took else np.nan:.0f} | "
                f"{sum(s['strays'] for s in group)} |"
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--cases", nargs="*", default=list(CASES))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--read", type=Path, nargs="*")
    args = parser.parse_args()
    if args.read:
        report([json.loads(line) for path in args.read for line in path.read_text().splitlines()])
        return
    sessions = []
    for seed in range(args.first, args.first + args.seeds):
        for case in args.cases:
            sessions.append(session(case, seed))
            print(f"\r{len(sessions)}", end="", file=sys.stderr)
            if args.json:
                with args.json.open("a") as file:
                    file.write(json.dumps(sessions[-1]) + "\n")
    print(file=sys.stderr)
    report(sessions)


if __name__ == "__main__":
    main()
