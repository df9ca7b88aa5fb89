"""A general model refined by a person's own takes, on UTD-MHAD's 21 arm gestures: `refine.py [--weights 1,4,12]`.

Everybody else's takes and k own ones of each gesture, each counted `weight` times, teach; the person's last takes test.
"""

import argparse

import numpy as np
from data import load

from armspan.gesture.kernels import Kernels


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--weights", default="1,4,12")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    found = load("UTDMHAD21arm")
    parts = (found.train, found.test)
    X, y = np.concatenate([part.X for part in parts]), np.concatenate([part.y for part in parts])
    subject = np.concatenate([part.groups for part in parts if part.groups is not None])
    rank, counts = np.zeros(len(y), dtype=int), {}
    for k, key in enumerate(zip(y.tolist(), subject.tolist(), strict=True)):
        rank[k] = counts[key] = counts.get(key, -1) + 1
    last = np.array([rank[k] == counts[key] for k, key in enumerate(zip(y.tolist(), subject.tolist(), strict=True))])
    print("| an own take counts | own takes | accuracy % |\n|---|---|---|")
    for weight in map(int, args.weights.split(",")):
        for shots in (0, 1, 2, 3):
            shares = []
            for person in np.unique(subject):
                own = np.flatnonzero((subject == person) & (rank < shots) & ~last)
                chosen = np.concatenate([np.flatnonzero(subject != person), np.repeat(own, weight)])
                model = Kernels(copies=0, seed=args.seed).fit(X[chosen], y[chosen], subject[chosen])
                tried = (subject == person) & last
                shares.append(float((model.predict(X[tried]) == y[tried]).mean()))
            print(f"| {weight} | {shots} | {100 * np.mean(shares):.1f} |", flush=True)


if __name__ == "__main__":
    main()
