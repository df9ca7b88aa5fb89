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
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np
from data import FOLDER
from numpy.typing import NDArray
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
SENSORS = (0, 0, 0, 1, 1, 1)


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


def felt(joints: Array, rate: float, times: Array, cutoff: float, shift: float = 0.0) -> dict[str, Array]:
    """Virtual bands at the sensor's times, `shift` later; held at the ends of the skeleton."""
    clock = np.arange(len(joints)) / rate + shift
    bands = virtual_bands(joints, rate, cutoff_hz=cutoff)
    return {
        side: np.stack([np.interp(times, clock, column) for column in wrist_felt(band).T], axis=1)
        for side, band in bands.items()
    }


def recordings(cutoff: float) -> list[Recording]:
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
        sides = felt(joints, rate, times, cutoff)
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


def compared(one: Recording, rate: float, cutoff: float) -> dict[str, float]:
    """Magnitudes of the virtual right wrist against the real ones, after the shift with the largest correlations."""
    real, clock = magnitudes(one.real), np.arange(len(one.frames)) / rate
    own = magnitudes(wrist_felt(virtual_bands(one.frames, rate, cutoff_hz=cutoff)["right"]))
    trials = []
    for shift in SHIFTS:
        kept = (one.times >= shift) & (one.times <= clock[-1] + shift)
        virtual = np.stack([np.interp(one.times[kept], clock + shift, column) for column in own.T], axis=1)
        trials.append((float(shift), virtual, real[kept], [_correlation(a, b) for a, b in zip(virtual.T, real[kept].T)]))
    shift, virtual, there, r = max(trials, key=lambda trial: sum(trial[3]))
    unshifted = min(trials, key=lambda trial: abs(trial[0]))[3]
    rms = np.sqrt(np.mean((virtual - there) ** 2, axis=0))
    step = one.times[1] - one.times[0]
    fast = [_fast(a, step) / _fast(b, step) for a, b in zip(virtual.T, there.T, strict=True)]
    size = virtual.std(axis=0) / there.std(axis=0)
    parts = {"r": r, "r0": unshifted, "rms": rms, "fast": fast, "size": size}
    return {"shift": shift} | {f"{n}_{k}": float(v[i]) for n, v in parts.items() for i, k in enumerate(("force", "rate"))}


def _correlation(a: Array, b: Array) -> float:
    return float(np.corrcoef(a, b)[0, 1])


def _fast(values: Array, step: float) -> float:
    """Power above `SPLIT_HZ`."""
    power = np.abs(np.fft.rfft((values - values.mean()) * hann(len(values)))) ** 2
    return float(power[np.fft.rfftfreq(len(values), step) > SPLIT_HZ].sum())


def mounting(made: Sequence[Recording], shifts: Sequence[float], cutoff: float) -> tuple[Rotation, float]:
    """`real_from_virtual` of one person's recordings by least squares, and the share of variance that it explains."""
    scale = np.array([GRAVITY, 3.0])  # rates of 3 rad/s weigh as much as gravity
    virtual, real = [], []
    for one, shift in zip(made, shifts, strict=True):
        own = felt(one.frames, one.rate, one.times, cutoff, shift)["right"]
        for values, kept in ((own, virtual), (one.real, real)):
            kept.append((values.reshape(-1, 2, 3) / scale[:, None]).reshape(-1, 3))
    a, b = np.concatenate(virtual), np.concatenate(real)
    turn, _ = Rotation.align_vectors(b, a)
    return turn, float(1.0 - np.sum((b - turn.apply(a)) ** 2) / np.sum(b**2))


def turned(felt_wrist: Array, turn: Rotation) -> Array:
    return np.hstack([turn.apply(felt_wrist[:, :3]), turn.apply(felt_wrist[:, 3:])])


def studies(made: Sequence[Recording], mounts: dict[int, Rotation]) -> dict[str, tuple[Array, Array, tuple[int, ...]]]:
    """What trains (n, c, 128) and what tests, by name, and each channel's sensor."""
    real = np.stack([one.real.T for one in made])
    virtual = np.stack([turned(one.right, mounts[one.subject]).T for one in made])
    plain, other = (np.stack([getattr(one, side).T for one in made]) for side in ("right", "left"))
    size = {
        k: np.stack([magnitudes(take.T).T for take in takes]) for k, takes in (("real", real), ("virtual", virtual))
    }
    both, two = np.concatenate([plain, other], axis=1), (*SENSORS, *(k + 2 for k in SENSORS))
    return {
        "2 magnitudes: real -> real": (size["real"], size["real"], (0, 1)),
        "2 magnitudes: virtual -> virtual": (size["virtual"], size["virtual"], (0, 1)),
        "2 magnitudes: virtual -> real": (size["virtual"], size["real"], (0, 1)),
        "6 channels: real -> real": (real, real, SENSORS),
        "6 channels: virtual -> virtual": (virtual, virtual, SENSORS),
        "6 channels: virtual, mounted -> real": (virtual, real, SENSORS),
        "6 channels: virtual, not mounted -> real": (plain, real, SENSORS),
        "one virtual band, right": (plain, plain, SENSORS),
        "one virtual band, left": (other, other, SENSORS),
        "two virtual bands": (both, both, two),
    }


def accuracies(made: Sequence[Recording], mounts: dict[int, Rotation], seeds: int) -> dict[str, list[float]]:
    """Accuracy [%] on the even people by seed."""
    y, people = np.array([one.label for one in made]), np.array([one.subject for one in made])
    train, test, out = np.isin(people, TRAIN), ~np.isin(people, TRAIN), {}
    found = studies(made, mounts)
    for name, (learnt, asked, sensors) in found.items():
        out[name] = [_accuracy(learnt[train], y[train], people[train], asked[test], y[test], sensors, seed)
                     for seed in range(seeds)]
    learnt, asked, _ = found["6 channels: virtual, mounted -> real"]
    mixed, labels, groups = np.concatenate([asked[train], learnt[train]]), np.tile(y[train], 2), np.tile(people[train], 2)
    out["6 channels: real and virtual -> real"] = [
        _accuracy(mixed, labels, groups, asked[test], y[test], SENSORS, seed) for seed in range(seeds)
    ]
    return out


def _accuracy(X: Any, y: Any, people: Any, asked: Any, truth: Any, sensors: tuple[int, ...], seed: int) -> float:
    model = make_pipeline(Standard(sensors), Kernels(seed=seed)).fit(X, y, kernels__groups=people)
    return float(100 * np.mean(model.predict(asked) == truth))


def line(cells: Sequence[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


MEASURES = {
    "r force": "r_force",
    "r rate": "r_rate",
    "RMS force m/s²": "rms_force",
    "RMS rate rad/s": "rms_rate",
    "power > 3 Hz, force": "fast_force",
    "power > 3 Hz, rate": "fast_rate",
    "size force": "size_force",
    "size rate": "size_rate",
    "shift s": "shift",
    "r force, no shift": "r0_force",
    "r rate, no shift": "r0_rate",
}


def table(rows: dict[str, list[dict[str, float]]]) -> list[str]:
    """Medians by gesture; power and size are virtual over real."""
    lines = [line(("gesture", "n", *MEASURES)), line(["---"] * (2 + len(MEASURES)))]
    for name, found in rows.items():
        medians = (np.median([one[key] for one in found]) for key in MEASURES.values())
        lines.append(line((name, len(found), *(f"{value:.2f}" for value in medians))))
    return lines


def measured(seeds: int, cutoff: float) -> tuple[dict[str, Any], list[str]]:
    made = recordings(cutoff)
    found = [compared(one, one.rate, cutoff) for one in made]
    stated = [compared(one, STATED_HZ, cutoff) for one in made]
    rows = {label: [f for f, one in zip(found, made, strict=True) if one.label == label] for label in _labels(made)}
    lines = table({**rows, "all": found, "all, at the stated 30 Hz": stated})
    mounts, explained = {}, {}
    for person in sorted({one.subject for one in made}):
        own = [k for k, one in enumerate(made) if one.subject == person]
        shifts = [found[k]["shift"] for k in own]
        mounts[person], explained[person] = mounting([made[k] for k in own], shifts, cutoff)
    mean = Rotation.concatenate(list(mounts.values())).mean()
    apart = {p: float(np.rad2deg((mean.inv() * turn).magnitude())) for p, turn in mounts.items()}
    rate = sensor_rate(made)
    frames = float(np.median([one.rate for one in made]))
    accuracy = accuracies(made, mounts, seeds)
    lines += ["", f"Sensor's own rate {rate:.0f} Hz; skeleton {frames:.1f} frames a second, smoothed at {cutoff:g} Hz.", ""]
    lines += [line(("person", "mounting from the mean, deg", "variance explained")), line(["---"] * 3)]
    lines += [line((p, f"{apart[p]:.0f}", f"{explained[p]:.2f}")) for p in mounts]
    lines += ["", line(("people 1, 3, 5, 7 -> 2, 4, 6, 8", "accuracy %", "least seed")), line(["---"] * 3)]
    lines += [line((name, f"{np.mean(a):.1f}", f"{min(a):.1f}")) for name, a in accuracy.items()]
    medians = {label: {k: float(np.median([f[k] for f in part])) for k in part[0]}
               for label, part in {**rows, "all": found, "stated_30_hz": stated}.items()}
    out = {"medians": medians, "sensor_hz": rate, "frames_hz": frames, "cutoff_hz": cutoff,
           "mounting_deg": apart, "explained": explained, "accuracy": accuracy}
    return out, lines


def _labels(made: Sequence[Recording]) -> list[str]:
    return sorted({one.label for one in made})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="also write the numbers here")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--cutoff", type=float, default=CUTOFF, help="low-pass of the joints [Hz]")
    asked = parser.parse_args()
    if not FOLDER.is_dir():
        print(f"no gesture sets at {FOLDER}: they lie next to the checkout, see data.py", file=sys.stderr)
        return 2
    start = time.process_time()
    out, lines = measured(asked.seeds, asked.cutoff)
    print("\n".join(lines))
    print(f"{time.process_time() - start:.0f} CPU s", file=sys.stderr)
    if asked.json:
        asked.json.write_text(json.dumps(out, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
