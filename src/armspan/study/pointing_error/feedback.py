"""What live feedback is worth: people who see where they are taken to point put it right.

Simulated people see a cursor where their arm is taken to point and correct it about twice a second.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armspan.errors import CalibrationError
from armspan.frames import Array, yaw_rotation
from armspan.pointing.calibration import Fit, calibrate
from armspan.pointing.pairs import still_pairs
from armspan.pointing.spots import spot
from armspan.simulation.person import VirtualPerson, draw_person, measured_body
from armspan.study.pointing_error.monte_carlo import TABLE, Layout, stop_shares
from armspan.study.pointing_error.virtual import HEADING, Posture, settled

LAB = Layout("floor at 2 m", 0.0, 2.0, 1.0)
"""About where the three targets of the ICRA 2019 study lay."""

CASES: tuple[tuple[Posture, Layout], ...] = (("straight", TABLE), ("natural", TABLE), ("straight", LAB))

SECONDS = np.arange(1.5, 6.01, 0.5)
"""When [s] after the word the spot is looked at."""

DRIFT = float(np.radians(2.0)) / 60.0
"""Standard deviation [rad/s] of a band's drift of heading."""

MISSED_M = 10.0

_TARGETS, _STOP_S, _SEEING = 3, 4.0, 0.2


@dataclass(frozen=True, slots=True)
class Quoted:
    """What others, or another benchmark, measured: median miss [m] and angle [rad] without and with feedback."""

    who: str
    simulated: bool
    metres: tuple[float, float]
    angles: tuple[float, float]

    def document(self) -> dict[str, object]:
        """For JSON."""
        return {
            "who": self.who,
            "simulated": self.simulated,
            "without_mm": 1000.0 * self.metres[0],
            "with_mm": 1000.0 * self.metres[1],
            "without_deg": float(np.degrees(self.angles[0])),
            "with_deg": float(np.degrees(self.angles[1])),
        }


def _quoted(who: str, simulated: bool, metres: tuple[float, float], degrees: tuple[float, float]) -> Quoted:
    without, shown = np.radians(degrees).tolist()
    return Quoted(who, simulated, metres, (without, shown))


QUOTED = (
    _quoted("10 people, laser spot (ICRA 2019, all runs)", False, (0.53, 0.055), (10.9, 0.9)),
    _quoted("Armspan's demo, straight arm, robots' lights", True, (0.037, 0.031), (2.0, 1.7)),
    _quoted("Armspan's demo, natural arm, robots' lights", True, (0.074, 0.033), (4.2, 1.9)),
)


@dataclass(frozen=True, slots=True, eq=False)
class FeedbackRow:
    """Simulated people: medians over time, ``metres`` and ``angles`` (2, times) [m, rad], without and with a cursor."""

    who: str
    gestures: int
    seconds: Array
    metres: Array
    angles: Array

    def document(self) -> dict[str, object]:
        """For JSON: what is left at the end, and the medians over time."""
        without, shown = Quoted(self.who, True, _pair(self.metres), _pair(self.angles)).document(), self.metres[1]
        return {
            **without,
            "gestures": self.gestures,
            "seconds": self.seconds.tolist(),
            "without_over_time_mm": (1000.0 * self.metres[0]).tolist(),
            "with_over_time_mm": (1000.0 * shown).tolist(),
        }


def _pair(values: Array) -> tuple[float, float]:
    return float(values[0, -1]), float(values[1, -1])


def simulated(rng: np.random.Generator, people: int = 30) -> list[FeedbackRow]:
    """New people in each case, the same three targets without and then with the cursor."""
    return [_case(posture, layout, people, rng) for posture, layout in CASES]


def _case(posture: Posture, layout: Layout, people: int, rng: np.random.Generator) -> FeedbackRow:
    found = [one for _ in range(people) if (one := _session(posture, layout, rng)) is not None]
    every = np.concatenate(found, axis=1)  # mode, gesture, time, (metres, angle)
    middle = np.median(every, axis=1)
    return FeedbackRow(f"{posture} arm, {layout.name}", every.shape[1], SECONDS, middle[..., 0], middle[..., 1])


class _Worn:
    """A virtual person with one band whose heading is off and drifts."""

    def __init__(self, posture: Posture, rng: np.random.Generator) -> None:
        person = draw_person(rng, posture=posture)
        self.body = measured_body(person, rng)
        self.someone = VirtualPerson(person, (0.0, 0.0), 0.0, rng)
        self._heading, self._drift = np.array([HEADING, DRIFT]) * rng.standard_normal(2)

    def forearm(self, t: float) -> Array:
        """The forearm's attitude (3, 3) as the band says at ``t`` [s]."""
        return np.asarray(yaw_rotation(self._heading + self._drift * t) @ self.someone.pose([t]).room_from_forearm[0])

    def stop(self, t: float) -> Array:
        """The same, over a held half second from ``t`` [s] on."""
        return np.asarray(yaw_rotation(self._heading + self._drift * t) @ settled(self.someone, t)[0])


def _session(posture: Posture, layout: Layout, rng: np.random.Generator) -> Array | None:
    """Misses (2, targets, times, 2) [m, rad] of one person; None if the calibration failed."""
    worn = _Worn(posture, rng)
    corners = layout.places(stop_shares(4))
    attitudes = []
    for number, corner in enumerate(corners):
        worn.someone.point(number * _STOP_S, corner)
        attitudes.append(worn.stop((number + 1) * _STOP_S - 1.0))
    pairs = still_pairs(np.array(attitudes), None, corners, ("1", "2", "3", "4"))
    try:
        fit = calibrate(worn.body, pairs, "head-finger", z_up=True)
    except CalibrationError:
        return None
    targets = layout.places(rng.uniform(-1.0, 1.0, (_TARGETS, 2)))
    begin = len(corners) * _STOP_S + (SECONDS[-1] + 1.0) * np.arange(2 * _TARGETS).reshape(2, _TARGETS)
    return np.array(
        [
            [_trial(worn, fit, target, t, shown) for target, t in zip(targets, times, strict=True)]
            for shown, times in zip((False, True), begin, strict=True)
        ]
    )


def _trial(worn: _Worn, fit: Fit, target: Array, t: float, shown: bool) -> Sequence[tuple[float, float]]:
    """Misses [m, rad] at `SECONDS` after the word."""
    worn.someone.point(t, target)
    found = []
    for after in SECONDS:
        at = _spot(worn, fit, t + float(after), target)
        found.append(_miss(at, target, worn.someone.pose([t + float(after)]).eye[0]))
        if shown and at is not None:
            worn.someone.correct(t + float(after) + _SEEING, at - target)
    return found


def _spot(worn: _Worn, fit: Fit, t: float, target: Array) -> Array | None:
    origin, direction = fit.rays(worn.forearm(t))
    found = spot(fit, origin, direction, float(target[2]), area=fit.area)
    return None if found.xy is None else np.array([*found.xy, target[2]])


def _miss(at: Array | None, target: Array, eye: Array) -> tuple[float, float]:
    if at is None:
        return MISSED_M, float(np.pi / 2.0)
    one, other = at - eye, target - eye
    return float(np.linalg.norm(at - target)), float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))
