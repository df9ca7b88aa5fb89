"""Pointing at known targets: what was asked, what was pointed at, what was chosen.

A trial begins with a press ``trial`` that names its target (``robot:NAME`` or ``zone:NAME``) and ends with
the next press of that name. Its spot is where the user pointed when something was chosen, else the mean over
the last half second. The target's place is a robot's own pose at that moment or a zone's middle.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from armspan.frames import Array, polygon_middle
from armspan.records import (
    Calibrated,
    Covariance2,
    Pointed,
    Press,
    Record,
    RobotState,
    Selected,
    Vec2,
    Zone,
)

_LAST = 0.5
CHI2_90 = 4.605
"""Squared Mahalanobis distance within which 90 % of two-dimensional normal spots lie."""


@dataclass(frozen=True, slots=True)
class TrialResult:
    """One trial: ``xy`` and ``spot`` [m] in ``sheet``, ``miss`` [m], ``angle`` [rad] as seen from the eye."""

    t: float
    target: str
    feedback: bool
    xy: Vec2
    spot: Vec2 | None
    covariance: Covariance2 | None
    miss: float | None
    angle: float | None
    chosen: str | None
    best: str | None
    probability: float
    seconds: float

    @property
    def decided(self) -> bool:
        """Whether something was chosen."""
        return self.chosen is not None

    @property
    def right(self) -> bool:
        """Whether the target was chosen."""
        return self.chosen == self.target

    @property
    def inside_90(self) -> bool | None:
        """Whether the target lies in the spot's own 90 % ellipse; None without a spot."""
        if self.spot is None or self.covariance is None:
            return None
        offset = np.subtract(self.xy, self.spot)
        return bool(offset @ np.linalg.solve(np.array(self.covariance), offset) < CHI2_90)


@dataclass(slots=True)
class _Open:
    t: float
    target: str
    pointed: list[Pointed] = field(default_factory=list)
    selected: Selected | None = None
    place: tuple[Vec2, float] | None = None


class TrialReader:
    """Feeds on records in order and gathers trials.

    Choices outside any trial are counted as ``unasked``, trials at what the room does not have as ``unknown``.
    """

    def __init__(self, zones: Sequence[Zone], eye_height: float, light_height: float) -> None:
        self.results: list[TrialResult] = []
        self.unasked = self.unknown = 0
        self._middles = {zone.name: zone_middle(zone) for zone in zones}
        self._eye_height, self._light_height = eye_height, light_height
        self._states: dict[str, RobotState] = {}
        self._eye: Array | None = None
        self._feedback = False
        self._open: _Open | None = None

    def take(self, record: Record) -> None:
        """Take the next record."""
        match record:
            case RobotState():
                self._states[record.robot] = record
            case Calibrated():
                self._eye = np.array(record.xyz) - [0.0, 0.0, self._eye_height]
            case Press(name="feedback"):
                self._feedback = record.value == "on"
            case Press(name="trial"):
                self._close(record.t)
                if record.value:
                    self._open = _Open(record.t, record.value)
            case Pointed() if self._open:
                self._open.pointed.append(record)
            case Selected():
                self._select(record)
            case _:
                pass

    def _select(self, record: Selected) -> None:
        if self._open is None or self._open.selected is not None:
            self.unasked += 1
            return
        self._open.selected, self._open.place = record, self._place(self._open.target)

    def _close(self, t: float) -> None:
        if self._open is None:
            return
        trial, self._open = self._open, None
        place = trial.place or self._place(trial.target)
        if place is None:
            self.unknown += 1
            return
        xy, z = place
        spot, covariance = _spot(trial)
        miss = None if spot is None else float(np.hypot(spot[0] - xy[0], spot[1] - xy[1]))
        angle = None if spot is None or self._eye is None else _angle(self._eye, spot, xy, z)
        best = _best(trial)
        ended = trial.selected.t if trial.selected else t
        self.results.append(
            TrialResult(
                trial.t,
                trial.target,
                self._feedback,
                xy,
                spot,
                covariance,
                miss,
                angle,
                _name(trial.selected.robot, trial.selected.zone) if trial.selected else None,
                _name(best.robot, best.zone) if best else None,
                trial.selected.probability if trial.selected else (best.probability if best else 0.0),
                ended - trial.t,
            )
        )

    def _place(self, target: str) -> tuple[Vec2, float] | None:
        """A target's place (2,) [m] and height [m] in ``sheet``, or None for one that this room does not have."""
        kind, _, name = target.partition(":")
        if kind == "robot" and name in self._states:
            return self._states[name].xy, -self._light_height
        if kind == "zone" and name in self._middles:
            return self._middles[name], 0.0
        return None


def read_trials(
    records: Iterable[Record], zones: Sequence[Zone], eye_height: float, light_height: float
) -> tuple[list[TrialResult], int]:
    """All trials of a session, and how many choices were made outside them."""
    reader = TrialReader(zones, eye_height, light_height)
    for record in records:
        reader.take(record)
    return reader.results, reader.unasked


def zone_middle(zone: Zone) -> Vec2:
    """The centroid [m] of a zone: where its name is printed."""
    return polygon_middle(zone.polygon)


def summary(trials: Sequence[TrialResult]) -> Mapping[str, float | int | None]:
    """Median and 90th percentile of the miss, median angle, median time, of trials that had a spot."""
    misses = [trial.miss for trial in trials if trial.miss is not None]
    angles = [trial.angle for trial in trials if trial.angle is not None]
    return {
        "trials": len(trials),
        "median_mm": _percentile(misses, 50, 1000.0),
        "p90_mm": _percentile(misses, 90, 1000.0),
        "median_deg": _percentile(angles, 50, 180.0 / np.pi),
        "median_s": _percentile([trial.seconds for trial in trials], 50, 1.0),
        "decided": sum(trial.decided for trial in trials),
        "right": sum(trial.right for trial in trials),
    }


def _percentile(values: Sequence[float], percent: float, scale: float) -> float | None:
    return round(float(np.percentile(values, percent)) * scale, 3) if values else None


def _spot(trial: _Open) -> tuple[Vec2 | None, Covariance2 | None]:
    end = trial.selected.t if trial.selected else np.inf
    seen = [p for p in trial.pointed if p.xy is not None and p.t <= end]
    if not seen:
        return None, None
    last = [p for p in seen if p.t > seen[-1].t - _LAST] if trial.selected is None else [seen[-1]]
    x, y = np.mean([p.xy for p in last if p.xy is not None], axis=0)
    return (float(x), float(y)), seen[-1].covariance


def _best(trial: _Open) -> Pointed | None:
    seen = [p for p in trial.pointed if p.xy is not None]
    return seen[-1] if seen else None


def _name(robot: str | None, zone: str | None) -> str | None:
    return f"robot:{robot}" if robot else f"zone:{zone}" if zone else None


def _angle(eye: Array, spot: Vec2, xy: Vec2, z: float) -> float:
    a, b = np.array([*spot, z]) - eye, np.array([*xy, z]) - eye
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
