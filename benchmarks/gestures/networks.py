"""The convolution network on the public sets: `networks.py [SET,...] [SEEDS]`, then `networks.py refine`.

Prints a Markdown table: accuracy, macro F1 (mean over seeds), training CPU seconds, median latency of one window in
NumPy; for both recipes. `refine` leaves one person out of UTD-MHAD's 21 arm gestures and gives their first takes back.
"""

import sys
import time
from typing import Any

import numpy as np
from data import NAMES, load

from armspan.gesture.cnn import Cnn
from armspan.gesture.recipes import Report, Standard
from armspan.gesture.scoring import accuracy, confusion, macro_f1

RECIPES = {"standard": Standard, "report": Report}


def latency_ms(model: Any, windows: np.ndarray, repeats: int = 200) -> float:
    spent = []
    for k in range(repeats):
        window = windows[k % len(windows)][None]
        start = time.perf_counter()
        model.decision_function(window)
        spent.append(time.perf_counter() - start)
    return 1e3 * float(np.median(spent))


def measure(name: str, recipe: str, seed: int) -> tuple[float, float, float, float]:
    """Accuracy [%], macro F1 [%], training CPU seconds and latency [ms] on the set's stated split."""
    data = load(name)
    front = RECIPES[recipe]().fit(data.train.X)
    train, test = front.transform(data.train.X), front.transform(data.test.X)
    start = time.process_time()
    model = Cnn(seed=seed).fit(train, data.train.y, data.train.groups)
    spent = time.process_time() - start
    labels = tuple(model.classes_.tolist())
    table = confusion(data.test.y.tolist(), model.predict(test).tolist(), labels)
    return 100 * accuracy(table), 100 * macro_f1(table), spent, latency_ms(model, test)


def print_sets(names: list[str], seeds: int) -> None:
    print("| set | recipe | accuracy % | sd | each seed | macro F1 % | training CPU s | latency ms |")
    print("|---|---|---|---|---|---|---|---|")
    for name in names:
        for recipe in RECIPES:
            rows = np.array([measure(name, recipe, seed) for seed in range(seeds)])
            mean, each = rows.mean(axis=0), " ".join(f"{a:.1f}" for a in rows[:, 0])
            sd = rows[:, 0].std(ddof=1) if seeds > 1 else np.nan
            print(
                f"| {name} | {recipe} | {mean[0]:.1f} | {sd:.1f} | {each} | {mean[1]:.1f} | {mean[2]:.1f} | "
                f"{mean[3]:.2f} |",
                flush=True,
            )


def print_refined(weight: float = 50.0) -> None:
    """Own takes are each person's first of every gesture; what is counted are their last, the same for all shots."""
    data = load("UTDMHAD21arm")
    X, y = np.concatenate([data.train.X, data.test.X]), np.concatenate([data.train.y, data.test.y])
    people = np.concatenate([data.train.groups, data.test.groups])
    print("| person | 0 takes | 1 take | 2 takes | 3 takes |\n|---|---|---|---|---|")
    shares = []
    for person in np.unique(people):
        others, own = people != person, np.flatnonzero(people == person)
        turn = np.array([np.count_nonzero(y[own[:k]] == y[own[k]]) for k in range(len(own))])
        last = np.array([turn[k] == np.count_nonzero(y[own] == y[own[k]]) - 1 for k in range(len(own))])
        model, row = Cnn().fit(X[others], y[others]), []
        for shots in range(4):
            given = own[(turn < shots) & ~last]
            used = model.refine(X[given], y[given], weight) if shots else model
            row.append(100 * used.score(X[own[last]], y[own[last]]))
        shares.append(row)
        print(f"| {person} | " + " | ".join(f"{a:.1f}" for a in row) + " |", flush=True)
    print("| mean | " + " | ".join(f"{a:.1f}" for a in np.mean(shares, axis=0)) + " |")


if __name__ == "__main__":
    if sys.argv[1:] == ["refine"]:
        print_refined()
    else:
        chosen = sys.argv[1].split(",") if len(sys.argv) > 1 else list(NAMES)
        print_sets(chosen, int(sys.argv[2]) if len(sys.argv) > 2 else 5)
