"""A set of recordings as folders of takes, as `armspan record` would write them: `as_takes.py SET.npz DIR`.

Writes DIR/train and DIR/test (the set's own split), each LABEL/PERSON_NN.csv.
"""

import sys
from pathlib import Path

import numpy as np

from armspan.config.take_files import write_take
from armspan.gesture.takes import Take

COLUMNS = {
    3: ("right_ax", "right_ay", "right_az"),
    6: ("right_ax", "right_ay", "right_az", "right_gx", "right_gy", "right_gz"),
}
TWO_WRISTS = ("left_ax", "left_ay", "left_az", "right_ax", "right_ay", "right_az")


def columns_of(name: str, channels: int) -> tuple[str, ...]:
    if name.startswith("Berkeley"):
        return TWO_WRISTS
    return COLUMNS.get(channels) or tuple(f"arm_c{k}" for k in range(channels))


def main(source: Path, folder: Path) -> None:
    with np.load(source) as file:
        X, y, classes = file["X"], file["y"], [str(c) for c in file["classes"]]
        subject, train, rate = file["subject"], file["train"], max(1.0, float(file["rate"]))
    columns = columns_of(source.stem, X.shape[1])
    counts: dict[tuple[bool, int, int], int] = {}
    for values, label, person, used in zip(X, y.tolist(), subject.tolist(), train.tolist(), strict=True):
        key = (used, label, person)
        counts[key] = number = counts.get(key, 0) + 1
        times = np.arange(values.shape[1]) / rate
        name = classes[label] if not classes[label][0].isdigit() else f"class_{classes[label].replace('.', '_')}"
        take = Take(name, f"s{person}", number, columns, times, values.T.astype(float))
        write_take(folder / ("train" if used else "test"), take)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
