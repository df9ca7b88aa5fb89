"""The product killed at full speed: how soon the emulated robots are slow, at rest, and how far they get.

Runs the processes of tests/cli/test_swarm_killed.py (an emulator and `armspan swarm random-walk --relay`, in real time)
again and again, and prints a Markdown table with the worst robot of all runs. Run: python benchmarks/swarm/killed.py
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[2] / "tests"), str(Path(__file__).parents[2] / "tests" / "cli")]

from test_swarm_killed import ENDINGS, NAMES, Room, last, read, way  # noqa: E402

WORDS = {
    "kill": "kill -9",
    "freeze": "frozen, its socket left open",
    "terminate": "SIGTERM",
    "raise": "an exception in a behaviour",
}


def once(ending, folder):
    """The four robots of one run: (4, 4) speed at the end [m/s], seconds to 25 and to 2 mm/s, way [m]."""
    room = Room(Path(folder), ending)
    try:
        room.open()
        ended = room.end()
        time.sleep(1.8)
    finally:
        room.close()
    run = read(room.truth, ended, ending)
    robots = range(len(NAMES))
    return np.array([(run.speed[run.k, r], last(run, r, 0.025), last(run, r, 0.002), way(run, r)) for r in robots])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5, help="of each ending")
    args = parser.parse_args()
    print("| ending | robots | speed before, mm/s | below 25 mm/s after | at rest (2 mm/s) after | way, all worst |")
    print("|---|---|---|---|---|---|")
    for ending in ENDINGS:
        with tempfile.TemporaryDirectory() as folder:
            rows = np.concatenate([once(ending, folder) for _ in range(args.runs)])
        low, high = 1000 * rows[:, 0].min(), 1000 * rows[:, 0].max()
        slow, rest, far = rows[:, 1].max(), rows[:, 2].max(), 1000 * rows[:, 3].max()
        print(
            f"| {WORDS[ending]} | {len(rows)} | {low:.0f} to {high:.0f} | {slow:.2f} s | {rest:.2f} s | {far:.0f} mm |"
        )


if __name__ == "__main__":
    main()
