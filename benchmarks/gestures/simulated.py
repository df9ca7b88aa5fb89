"""Simulated takes as a recorder would have written them: bands mounted by the two poses, brought onto one clock."""

from collections.abc import Iterator, Sequence

import numpy as np

from armspan.conductor.arm import Band
from armspan.conductor.settings import BandSettings
from armspan.conductor.wrist import WRIST, wrist_row
from armspan.frames import rotation_from_quaternion
from armspan.gesture.takes import Take
from armspan.orientation import mount_from_poses
from armspan.records import ImuSample
from armspan.simulation.takes import SimulatedTake

RATE = 100.0


def as_take(made: SimulatedTake) -> Take:
    """A simulated take in the recorder's columns, on one clock of 100 Hz that starts at zero."""
    sides = {name: _rows(name, samples, made) for name, samples in made.samples.items()}
    start = max(times[0] for times, _ in sides.values())
    end = min(times[-1] for times, _ in sides.values())
    clock = np.arange(start, end, 1 / RATE)
    columns = [np.interp(clock, times, column) for times, rows in sides.values() for column in rows.T]
    names = tuple(f"{name}_{column}" for name in sides for column in WRIST)
    gesture = (made.start - start, made.end - start) if made.label != "null" else None
    values = np.stack(columns, axis=1)
    practice = made.number == 0 and gesture is not None
    return Take(made.label, f"v{made.person}", made.number, names, clock - start, values, practice, gesture)


def _rows(name: str, samples: Sequence[ImuSample], made: SimulatedTake) -> tuple[np.ndarray, np.ndarray]:
    band = Band.from_settings(BandSettings(name))
    band.mount = mount_from_poses(*(_attitudes(getattr(made.setup, pose)[name]) for pose in ("stretched", "hanging")))
    found = [(sample.t, row) for sample, row in _felt(band, samples)]
    times, rows = np.array([t for t, _ in found]), np.array([row for _, row in found])
    flips = np.cumprod(np.where((rows[1:, :4] * rows[:-1, :4]).sum(1) < 0, -1.0, 1.0))
    rows[1:, :4] *= flips[:, None]
    return times, rows


def _felt(band: Band, samples: Sequence[ImuSample]) -> Iterator[tuple[ImuSample, tuple[float, ...]]]:
    for sample in samples:
        band.feel(sample)
        row = wrist_row(band, sample)
        if row is not None:
            yield sample, row


def _attitudes(samples: Sequence[ImuSample]) -> np.ndarray:
    return rotation_from_quaternion(np.array([sample.quat for sample in samples]))
