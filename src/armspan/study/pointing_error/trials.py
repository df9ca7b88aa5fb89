"""What gestures are worth as a calibration: pick stops and repeats, fit, and see where other gestures point."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from armspan.errors import CalibrationError
from armspan.frames import Array
from armspan.pointing.calibration import Fit, calibrate
from armspan.pointing.pairs import still_pairs
from armspan.pointing.spots import spot
from armspan.records import Model
from armspan.study.pointing_error.recordings import Gestures, Rows

CORNERS, MIDDLE, EDGES = (0, 2, 6, 8), 4, (1, 3, 5, 7)

MISSED_M = 10.0
"""How far off [m] a gesture counts that has no answer."""


@dataclass(frozen=True, slots=True, eq=False)
class Misses:
    """How far from their targets gestures were taken to point: ``metres`` and, from the eye, ``angles`` [rad]."""

    metres: Array
    angles: Array

    def document(self) -> dict[str, float]:
        """For JSON, in millimetres and degrees."""
        return {
            "median_mm": 1000.0 * float(np.median(self.metres)),
            "p90_mm": 1000.0 * float(np.percentile(self.metres, 90)),
            "median_deg": float(np.degrees(np.median(self.angles))),
            "gestures": float(len(self.metres)),
        }


def together(parts: Sequence[Misses]) -> Misses:
    """All misses as one."""
    return Misses(np.concatenate([p.metres for p in parts]), np.concatenate([p.angles for p in parts]))


def pick(person: Gestures, places: Sequence[int], gestures: int, rng: np.random.Generator) -> Rows:
    """Rows of so many ``gestures`` at each of these places, drawn without putting back."""
    rows = []
    for place in places:
        here = np.flatnonzero(person.places == place)
        rows.append(rng.choice(here, min(gestures, len(here)), replace=False))
    return np.concatenate(rows)


def fitted(person: Gestures, rows: Rows, model: Model) -> Fit:
    """The place of the user from these gestures, a stop for each place (CalibrationError)."""
    stops = tuple(str(place) for place in person.places[rows])
    pairs = still_pairs(person.forearm[rows], person.upperarm[rows], person.targets[rows], stops)
    return calibrate(person.body, pairs, model, z_up=True)


def misses(person: Gestures, fit: Fit, rows: Rows, *, drawn: bool = True) -> Misses:
    """Where single gestures point, by their rays alone or ``drawn`` to the calibrated area as in use."""
    origins, directions = fit.rays(person.forearm[rows], person.upperarm[rows])
    targets = person.targets[rows]
    eye = fit.transform().points([0.0, 0.0, fit.body.eye_height_m])
    metres, angles = np.full(len(rows), MISSED_M), np.full(len(rows), np.pi / 2.0)
    for k, (origin, direction, target) in enumerate(zip(origins, directions, targets, strict=True)):
        found = spot(fit, origin, direction, float(target[2]), area=fit.area if drawn else None)
        if found.xy is not None:
            metres[k] = np.hypot(*(found.xy - target[:2]))
            angles[k] = _angle(np.array([*found.xy, target[2]]) - eye, target - eye)
    return Misses(metres, angles)


def _angle(one: Array, other: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))


def many_draws(
    people: Sequence[Gestures],
    stops: Callable[[int], Sequence[int]],
    tests: Sequence[int],
    model: Model,
    rng: np.random.Generator,
    *,
    gestures: int = 1,
    draws: int = 20,
    drawn: bool = True,
) -> Misses:
    """Calibrate on ``stops`` of each tested place, so many draws for each person, and point at that place.

    A set of stops that cannot place the user counts every gesture as missed.
    """
    found = []
    for person in people:
        for _ in range(draws):
            fits: dict[tuple[int, ...], Fit | None] = {}
            for test in tests:
                wanted = tuple(stops(test))
                if wanted not in fits:
                    fits[wanted] = _tried(person, pick(person, wanted, gestures, rng), model)
                rows, fit = np.flatnonzero(person.places == test), fits[wanted]
                found.append(_all_missed(len(rows)) if fit is None else misses(person, fit, rows, drawn=drawn))
    return together(found)


def _tried(person: Gestures, rows: Rows, model: Model) -> Fit | None:
    try:
        return fitted(person, rows, model)
    except CalibrationError:
        return None


def _all_missed(count: int) -> Misses:
    return Misses(np.full(count, MISSED_M), np.full(count, np.pi / 2.0))
