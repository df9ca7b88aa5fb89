"""Virtual bands on UTD-MHAD's skeletons held against the real wrist sensor: `python benchmarks/gestures/skeletons.py`.

The two files hold the same recordings in the same order. Each real recording was stretched to 128 samples; its length
at 50 Hz is kept. The skeletons' stated 30 frames a second cannot be true: over the same recording there are 2.6 sensor
samples a frame, not 1.67, and the sensor's own rates and forces agree at 50 Hz (`sensor_rate`). So frames were lost,
and each recording's frames are spread evenly over its sensor's time: about 19 a second.
"""
# ruff: noqa: E402 - the number of threads is set before NumPy is loaded

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np
from data import FOLDER
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt
from scipy.signal.windows import hann
from scipy.spatial.transform import Rotation
from sklearn.pipeline import make_pipeline

from armspan.gesture.kernels import Kernels
from armspan.gesture.recipes import Standard
from armspan.simulation.skeleton_bands import CUTOFF, virtual_bands, wrist_felt

Array = NDArray[np.float64]
GRAVITY, SENSOR_HZ, STATED_HZ, SPLIT_HZ = 9.80665, 50.0, 30.0, 3.0
SHIFTS = np.arange(-0.5, 0.501, 0.02)  # s
TRAIN = (1, 3, 5, 7)
TRUSTED = np.deg2rad(900.0)  # below the gyroscope's end of scale


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """One recording: `real` and `left`, `right` (128, 6) felt at a wrist [m/s², rad/s], at `times` (128,) [s]."""

    label: str
    subject: int
    frames: Array
    times: Array
    real: Array
    left: Array
    right: Array
    rate: float


def felt(joints: Array, rate: float, times: Array, shift: float = 0.0) -> dict[str, Array]:
    """Virtual bands at the sensor's times, `shift` later; held at the ends of the skeleton."""
    clock = np.arange(len(joints)) / rate + shift
    bands = virtual_bands(joints, rate)
    return {
        side: np.stack([np.interp(times, clock, column) for column in wrist_felt(band).T], axis=1)
        for side, band in bands.items()
    }


def recordings() -> list[Recording]:
    with np.load(FOLDER / "UTDMHAD_skel_arms.npz") as file:
        cuts = np.split(file["X"].astype(float), np.cumsum(file["lengths"])[:-1])
        arms = np.flatnonzero(file["y"] < 21)
        who = np.stack([file["y"][arms], file["subject"][arms]])
    with np.load(FOLDER / "UTDMHAD21arm.npz") as file:
        X, y, subject, lengths, classes = (file[k] for k in ("X", "y", "subject", "orig_len", "classes"))
    if not np.array_equal(who, np.stack([y, subject])):
        raise ValueError("the two files do not list the same recordings in the same order")
    found = []
    for k, arm in enumerate(arms):
        joints, seconds = cuts[arm], (lengths[k] - 1) / SENSOR_HZ
        times, rate = np.linspace(0.0, seconds, X.shape[2]), (len(joints) - 1) / seconds
        acc, gyr = X[k, :3].T.astype(float) * GRAVITY, np.deg2rad(X[k, 3:].T.astype(float))
        sides = felt(joints, rate, times)
        found.append(
            Recording(str(classes[y[k]]), int(subject[k]), joints, times, np.hstack([acc, gyr]), **sides, rate=rate)
        )
    return found


def sensor_rate(made: Sequence[Recording]) -> float:
    """The rate [Hz] at which the real gyroscope turns the real forces into one frame best (median of recordings)."""
    scales, best = np.arange(0.7, 1.51, 0.02), []
    for one in made:
        rates = one.real[:, 3:]
        if np.abs(rates).max() > TRUSTED:
            continue
        steps = (rates[1:] + rates[:-1]) / 2 * np.diff(one.times)[:, None]
        turns = np.broadcast_to(np.eye(3), (len(scales), 3, 3))
        forces = [turns @ one.real[0, :3]]
        for step, force in zip(steps, one.real[1:, :3], strict=True):
            turns = turns @ Rotation.from_rotvec(step / scales[:, None]).as_matrix()
            forces.append(turns @ force)
        best.append(SENSOR_HZ * scales[np.argmin(np.var(forces, axis=0).sum(axis=1))])
    return float(np.median(best))


def magnitudes(felt_wrist: Array) -> Array:
    """Of specific force and angular rate (n, 2): free of mounting, roll and heading."""
    return np.stack([np.linalg.norm(felt_wrist[:, :3], axis=1), np.linalg.norm(felt_wrist[:, 3:], axis=1)], axis=1)


def compared(one: Recording, rate: float, cutoff: float = CUTOFF) -> dict[str, float]:
    """Magnitudes of the virtual right wrist against the real ones, after the shift with the largest correlations."""
    real, clock = magnitudes(one.real), np.arange(len(one.frames)) / rate
    own = magnitudes(wrist_felt(virtual_bands(one.frames, rate, cutoff_hz=cutoff)["right"]))
    trials = []
    for shift in SHIFTS:
        kept = (one.times >= shift) & (one.times <= clock[-1] + shift)
        virtual = np.stack([np.interp(one.times[kept], clock + shift, column) for column in own.T], axis=1)
        trials.append((float(shift), virtual, real[kept], _correlations(virtual, real[kept])))
    shift, virtual, there, r = max(trials, key=lambda trial: sum(trial[3]))
    unshifted = min(trials, key=lambda trial: abs(trial[0]))[3]
    rms = np.sqrt(np.mean((virtual - there) ** 2, axis=0))
    step = one.times[1] - one.times[0]
    fast = [_fast(a, step) / _fast(b, step) for a, b in zip(virtual.T, there.T, strict=True)]
    size = virtual.std(axis=0) / there.std(axis=0)
    parts = {"r": r, "r0": unshifted, "rms": rms, "fast": fast, "size": size}
    return {"shift": shift} | {
        f"{n}_{k}": float(v[i]) for n, v in parts.items() for i, k in enumerate(("force", "rate"))
    }


def _correlations(a: Array, b: Array) -> list[float]:
    """Of two arrays (n, c), column by column."""
    return [float(np.corrcoef(x, y)[0, 1]) for x, y in zip(a.T, b.T, strict=True)]


def _fast(values: Array, step: float) -> float:
    """Power above `SPLIT_HZ`."""
    power = np.abs(np.fft.rfft((values - values.mean()) * hann(len(values)))) ** 2
    return float(power[np.fft.rfftfreq(len(values), step) > SPLIT_HZ].sum())


def mounting(made: Sequence[Recording], shifts: Sequence[float]) -> tuple[Rotation, float]:
    """`real_from_virtual` of one person's recordings by least squares, and the share of variance that it explains."""
    scale = np.array([GRAVITY, 3.0])  # rates of 3 rad/s weigh as much as gravity
    virtual, real = [], []
    for one, shift in zip(made, shifts, strict=True):
        own = felt(one.frames, one.rate, one.times, shift)["right"]
        for values, kept in ((own, virtual), (one.real, real)):
            kept.append((values.reshape(-1, 2, 3) / scale[:, None]).reshape(-1, 3))
    a, b = np.concatenate(virtual), np.concatenate(real)
    turn, _ = Rotation.align_vectors(b, a)
    return turn, float(1.0 - np.sum((b - turn.apply(a)) ** 2) / np.sum(b**2))


def turned(felt_wrist: Array, turn: Rotation) -> Array:
    return np.hstack([turn.apply(felt_wrist[:, :3]), turn.apply(felt_wrist[:, 3:])])


def softened(one: Recording) -> Array:
    """The real sensor (128, 6) through the low-pass that the skeleton went through."""
    low = butter(2, CUTOFF, fs=1.0 / (one.times[1] - one.times[0]), output="sos")
    return np.asarray(sosfiltfilt(low, one.real, axis=0))


def roll_free(felt_wrist: Array) -> Array:
    """Force along the forearm and across it, rate across it (n, 3): what a turn about the forearm leaves."""
    across = np.hypot(felt_wrist[:, [1, 4]], felt_wrist[:, [2, 5]])
    return np.column_stack([felt_wrist[:, 0], across])


def views(made: Sequence[Recording], mounts: dict[int, Rotation]) -> dict[str, Array]:
    """The recordings in many ways, each (n, c, 128)."""

    def of(told: Callable[[Recording], Array]) -> Array:
        return np.stack([told(one).T for one in made])

    soft = {id(one): softened(one) for one in made}
    return {
        "real": of(lambda one: one.real),
        "real 3 Hz": of(lambda one: soft[id(one)]),
        "mounted": of(lambda one: turned(one.right, mounts[one.subject])),
        "virtual": of(lambda one: one.right),
        "left": of(lambda one: one.left),
        "both": of(lambda one: np.hstack([one.right, one.left])),
        "|real|": of(lambda one: magnitudes(one.real)),
        "|real 3 Hz|": of(lambda one: magnitudes(soft[id(one)])),
        "|virtual|": of(lambda one: magnitudes(one.right)),
        "roll-free real": of(lambda one: roll_free(turned(soft[id(one)], mounts[one.subject].inv()))),
        "roll-free virtual": of(lambda one: roll_free(one.right)),
    }


SENSORS, TWO, FREE = (0, 0, 0, 1, 1, 1), (0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3), (0, 0, 1)
PLAN: tuple[tuple[str, tuple[str, ...], str, tuple[int, ...]], ...] = (
    ("2 magnitudes: real -> real", ("|real|",), "|real|", (0, 1)),
    ("2 magnitudes: virtual -> virtual", ("|virtual|",), "|virtual|", (0, 1)),
    ("2 magnitudes: virtual -> real", ("|virtual|",), "|real|", (0, 1)),
    ("2 magnitudes: virtual -> real, 3 Hz", ("|virtual|",), "|real 3 Hz|", (0, 1)),
    ("6 channels: real -> real", ("real",), "real", SENSORS),
    ("6 channels: real, 3 Hz -> real, 3 Hz", ("real 3 Hz",), "real 3 Hz", SENSORS),
    ("6 channels: virtual, mounted -> virtual, mounted", ("mounted",), "mounted", SENSORS),
    ("6 channels: virtual, mounted -> real", ("mounted",), "real", SENSORS),
    ("6 channels: virtual, mounted -> real, 3 Hz", ("mounted",), "real 3 Hz", SENSORS),
    ("6 channels: virtual, not mounted -> real", ("virtual",), "real", SENSORS),
    ("6 channels: real + virtual, mounted -> real", ("real", "mounted"), "real", SENSORS),
    ("3 roll-free, forearm's axes: virtual -> real, 3 Hz", ("roll-free virtual",), "roll-free real", FREE),
    ("3 roll-free, forearm's axes: real, 3 Hz -> real, 3 Hz", ("roll-free real",), "roll-free real", FREE),
    ("virtual only: right band", ("virtual",), "virtual", SENSORS),
    ("virtual only: left band", ("left",), "left", SENSORS),
    ("virtual only: two bands", ("both",), "both", TWO),
)
"""What trains, on the odd people, and what is asked, of the even people."""


def accuracies(made: Sequence[Recording], mounts: dict[int, Rotation], seeds: int) -> dict[str, list[float]]:
    """Accuracy [%] on the even people, by seed."""
    y, people = np.array([one.label for one in made]), np.array([one.subject for one in made])
    train, found = np.isin(people, TRAIN), views(made, mounts)
    out = {}
    for name, taught, asked, sensors in PLAN:
        X, again = np.concatenate([found[view][train] for view in taught]), len(taught)
        learnt = (X, np.tile(y[train], again), np.tile(people[train], again))
        out[name] = [_accuracy(*learnt, found[asked][~train], y[~train], sensors, seed) for seed in range(seeds)]
    both = [one_real_person(made, mounts, seed) for seed in range(seeds)]
    out["6 channels: one real person -> real (mean of 4)"] = [one for one, _ in both]
    out["6 channels: the same + virtual of all 4, on that person's mounting"] = [more for _, more in both]
    return out


def one_real_person(made: Sequence[Recording], mounts: dict[int, Rotation], seed: int) -> tuple[float, float]:
    """Accuracy [%] on the even people where one odd person wore the sensor: without, and with, virtual bands."""
    y, people = np.array([one.label for one in made]), np.array([one.subject for one in made])
    train, real, hits = np.isin(people, TRAIN), np.stack([one.real.T for one in made]), []
    for person in TRAIN:
        own = people == person
        virtual = np.stack([turned(one.right, mounts[person]).T for one in made if one.subject in TRAIN])
        mixed = (np.concatenate([real[own], virtual]), np.r_[y[own], y[train]], np.r_[people[own], people[train]])
        test = (real[~train], y[~train], SENSORS, seed)
        hits.append((_accuracy(real[own], y[own], None, *test), _accuracy(*mixed, *test)))
    without, beside = np.mean(hits, axis=0)
    return float(without), float(beside)


def _accuracy(X: Any, y: Any, people: Any, asked: Any, truth: Any, sensors: tuple[int, ...], seed: int) -> float:
    model = make_pipeline(Standard(sensors), Kernels(seed=seed)).fit(X, y, kernels__groups=people)
    return float(100 * np.mean(model.predict(asked) == truth))


def line(cells: Sequence[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


MEASURES = {
    "r_force": "r force",
    "r_rate": "r rate",
    "rms_force": "RMS force m/s²",
    "rms_rate": "RMS rate rad/s",
    "fast_force": "power > 3 Hz, force",
    "fast_rate": "power > 3 Hz, rate",
    "size_force": "size force",
    "size_rate": "size rate",
    "shift": "shift s",
    "r0_force": "r force, no shift",
    "r0_rate": "r rate, no shift",
}
CUTOFFS = (2.0, 2.5, 3.0, 4.0, 5.0)


def grid(head: Sequence[object], rows: Sequence[Sequence[object]]) -> list[str]:
    return ["", line(head), line(["---"] * len(head)), *(line(row) for row in rows)]


def medians(found: Sequence[dict[str, float]]) -> dict[str, float]:
    return {"n": len(found), **{key: float(np.median([one[key] for one in found])) for key in MEASURES}}


def magnitudes_compared(made: Sequence[Recording], found: Sequence[dict[str, float]]) -> dict[str, dict[str, float]]:
    """Medians by gesture, over all, at the rate that is stated, and by low-pass for the people that train."""
    labels, odd = sorted({one.label for one in made}), [one for one in made if one.subject in TRAIN]
    rows = {label: [f for f, one in zip(found, made, strict=True) if one.label == label] for label in labels}
    rows |= {"all": list(found), "all, at the stated 30 Hz": [compared(one, STATED_HZ) for one in made]}
    rows |= {f"odd people, low-pass {hz:g} Hz": [compared(one, one.rate, hz) for one in odd] for hz in CUTOFFS}
    return {name: medians(part) for name, part in rows.items()}


def mountings(
    made: Sequence[Recording], found: Sequence[dict[str, float]]
) -> tuple[dict[int, Rotation], list[dict[str, float]]]:
    """Each person's mounting, and how far it is from the mean, and what it explains."""
    own = {person: [k for k, one in enumerate(made) if one.subject == person] for person in (1, 2, 3, 4, 5, 6, 7, 8)}
    fits = {p: mounting([made[k] for k in rows], [found[k]["shift"] for k in rows]) for p, rows in own.items()}
    mean = Rotation.concatenate([turn for turn, _ in fits.values()]).mean()
    told = [
        {"person": p, "from_mean_deg": float(np.rad2deg((mean.inv() * turn).magnitude())), "explained": explained}
        for p, (turn, explained) in fits.items()
    ]
    return {p: turn for p, (turn, _) in fits.items()}, told


def measured(seeds: int) -> dict[str, Any]:
    made = recordings()
    found = [compared(one, one.rate) for one in made]
    mounts, told = mountings(made, found)
    return {
        "sensor_hz": sensor_rate(made),
        "frames_hz": float(np.median([one.rate for one in made])),
        "cutoff_hz": CUTOFF,
        "magnitudes": magnitudes_compared(made, found),
        "mountings": told,
        "accuracy": accuracies(made, mounts, seeds),
    }


def tables(out: dict[str, Any]) -> list[str]:
    """Power and size are the virtual band's over the real sensor's."""
    rows = [(name, row["n"], *(f"{row[key]:.2f}" for key in MEASURES)) for name, row in out["magnitudes"].items()]
    people = [(row["person"], f"{row['from_mean_deg']:.0f}", f"{row['explained']:.2f}") for row in out["mountings"]]
    scores = [(name, f"{np.mean(a):.1f}", f"{min(a):.1f}") for name, a in out["accuracy"].items()]
    return [
        f"Sensor's own rate {out['sensor_hz']:.0f} Hz; skeleton {out['frames_hz']:.1f} frames a second, smoothed at "
        f"{out['cutoff_hz']:g} Hz; medians by recording.",
        *grid(("gesture", "n", *MEASURES.values()), rows),
        *grid(("person", "mounting from the mean, deg", "variance explained"), people),
        *grid(("people 1, 3, 5, 7 -> 2, 4, 6, 8", "accuracy %", "least seed"), scores),
    ]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="also write the numbers here")
    parser.add_argument("--seeds", type=int, default=5)
    asked = parser.parse_args()
    if not FOLDER.is_dir():
        print(f"no gesture sets at {FOLDER}: they lie next to the checkout, see data.py", file=sys.stderr)
        return 2
    start = time.process_time()
    out = measured(asked.seeds)
    print("\n".join(tables(out)))
    print(f"{time.process_time() - start:.0f} CPU s", file=sys.stderr)
    if asked.json:
        asked.json.write_text(json.dumps(out, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
