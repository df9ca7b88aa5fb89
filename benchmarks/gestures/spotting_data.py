"""The continuous recordings as takes, null recordings and a stream to spot in."""

from pathlib import Path

import numpy as np

from armspan.gesture.scoring import Truth
from armspan.gesture.takes import NULL, Take

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "gestures"
WRIST = tuple(f"wrist_{name}" for name in ("ax", "ay", "az", "gx", "gy"))
ROLL = 1.0


def actrectut(path: Path = DATA) -> tuple[list[Take], Take, list[Truth], Take]:
    """ActRecTut, person 1: takes and null of the first half; stream and truth of the second; walking to test on.

    The first half are rounds 1-13; the wrist is the lower-arm IMU, channels 5-9.
    """
    with np.load(path / "ActRecTut_stream_s1.npz") as file:
        X, y, rate = file["X"][:, 5:10].astype(float), file["y"], float(file["rate"])
        classes = [str(name) for name in file["classes"]]
    times = np.arange(len(y)) / rate
    runs = _runs(y)
    counts: dict[int, int] = {}
    takes: list[Take] = []
    rounds = []
    for label, _, _ in runs:
        counts[label] = counts.get(label, 0) + 1
        rounds.append(counts[label] if label else 0)
    cut_at = max(end for (label, _, end), n in zip(runs, rounds, strict=True) if label and n <= 13)
    cut = times[cut_at]
    whole = Take(NULL, "s1", 0, WRIST, times, X)
    for (label, start, end), n in zip(runs, rounds, strict=True):
        a, b = times[start], times[end - 1]
        if b > cut:
            continue
        if label == 0:
            part = whole.between(a, b)
            if part.seconds >= 1.0:
                takes.append(_take(part, NULL, len(takes), None))
        else:
            part = whole.between(max(0.0, a - ROLL), min(cut, b + ROLL))
            takes.append(_take(part, classes[label], n, (a, b)))
    stream = whole.between(cut + 0.01, times[-1])
    truth = [Truth(times[s], times[e - 1], classes[label]) for label, s, e in runs if label and times[s] > cut]
    with np.load(path / "ActRecTut_walkstream_s1.npz") as file:
        walk = file["X"][:, 6:11].astype(float)  # six channels an IMU there: the second one's first five
        walk_times = np.arange(len(walk)) / float(file["rate"])
    everyday = Take(NULL, "s1", 900, WRIST, walk_times, walk)
    half = walk_times[len(walk) // 2]
    takes.append(everyday.between(0.0, half))
    return takes, stream, truth, everyday.between(half + 0.01, np.inf)


def _take(part: Take, label: str, number: int, gesture: tuple[float, float] | None) -> Take:
    return Take(label, "s1", number, part.columns, part.times, part.values, False, gesture)


def _runs(y: np.ndarray) -> list[tuple[int, int, int]]:
    edges = np.flatnonzero(np.diff(y)) + 1
    starts, ends = np.concatenate([[0], edges]), np.concatenate([edges, [len(y)]])
    return [(int(y[s]), int(s), int(e)) for s, e in zip(starts, ends, strict=True)]


TWO_WRISTS = tuple(f"{side}_{axis}" for side in ("left", "right") for axis in ("ax", "ay", "az"))


def openpack(path: Path = DATA) -> tuple[list[Take], Take, Take]:
    """Berkeley MHAD's takes of people 1-7 (two wrists, [g]); the first and second half of OpenPack's work as null."""
    takes: list[Take] = []
    with np.load(path / "BerkeleyMHAD2w.npz") as file:
        classes, rate = [str(name) for name in file["classes"]], float(file["rate"])
        chosen = zip(file["X"], file["y"].tolist(), file["subject"].tolist(), file["train"].tolist(), strict=True)
        for values, label, person, used in chosen:
            if used:
                times = np.arange(values.shape[1]) / rate
                take = Take(classes[label], f"s{person}", len(takes), TWO_WRISTS, times, values.T.astype(float))
                takes.append(take)
    with np.load(path / "OpenPack_U0209_S0500_2wrist.npz") as file:
        names = [str(name) for name in file["columns"]]
        places = [names.index(f"{side}_acc_{axis}") for side in ("left", "right") for axis in "xyz"]
        times, values = file["t_ms"].astype(float) / 1000, file["X"][:, places].astype(float)
    work = Take(NULL, "packer", 1, TWO_WRISTS, times - times[0], values)
    middle = work.seconds / 2
    return takes, work.between(0.0, middle), work.between(middle + 0.01, np.inf)
