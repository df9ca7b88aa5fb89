"""Takes of two bands as a recorder writes them, made of formulas: the forearms rise and fall once."""

from pathlib import Path

import numpy as np

from armspan.config.take_files import COLUMNS, Sidecar, write_take
from armspan.gesture.takes import Take

SPAN = (1.0, 3.0)
"""Start and end [s] of the gesture, in takes of four seconds."""


def two_band_take(label="mixing", person="ada", number=1, *, practice=False) -> Take:
    """The right forearm turns from hanging to straight up and back, about y; the left one from hanging to the front."""
    times = np.arange(401) / 100.0
    share = 0.5 - 0.5 * np.cos(2 * np.pi * np.clip((times - SPAN[0]) / (SPAN[1] - SPAN[0]), 0.0, 1.0))
    values = np.zeros((len(times), len(COLUMNS)))
    for place, way in ((0, np.pi), (10, np.pi / 2)):
        turn = np.pi / 2 - way * share  # about y: a quarter turn points down, none to the front, minus a quarter up
        values[:, place + 1], values[:, place + 3] = np.sin(turn / 2), np.cos(turn / 2)
        values[:, place + 4] = np.gradient(np.gradient(share, times), times)
        values[:, place + 8] = np.gradient(turn, times)
    return Take(label, person, number, COLUMNS, times, values, practice, SPAN)


def wrote(folder: Path, label="mixing", person="ada", number=1, *, practice=False, note="") -> Path:
    """Such a take in its file, with a sidecar that says it was simulated."""
    take = two_band_take(label, person, number, practice=practice)
    side = Sidecar(
        label=label,
        person=person,
        number=number,
        practice=practice,
        rate_hz=100.0,
        gesture_s=SPAN,
        simulated=True,
        note=note,
    )
    return write_take(folder, take, side)
