"""Pairs of an arm that rests on standing robots against pairs of an arm that follows a moving one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from armspan.errors import CalibrationError
from armspan.frames import Array, yaw_rotation
from armspan.pointing.calibration import Fit, calibrate
from armspan.pointing.pairs import Pairs, moving_pairs, still_pairs
from armspan.simulation.person import VirtualPerson, draw_person, measured_body
from armspan.study.pointing_error.monte_carlo import Layout, stop_shares
from armspan.study.pointing_error.recordings import Following, Gestures, Rows
from armspan.study.pointing_error.trials import MISSED_M, misses
from armspan.study.pointing_error.virtual import HEADING, Posture, settled

SPEEDS = (0.1, 0.3)
"""How fast [m/s] the virtual robot drives round the sheet: as in the demo, and three times as fast."""

SHARES_OF_ROUND = ((0.5, "half a round"), (1.0, "one round"))
REAL_SECONDS = (5.0, 10.0, 20.0)

_RATE, _HOLD_S = 20.0, 3.0
_OVER_S = 0.3
"""Speeds are means over so many seconds."""


@dataclass(frozen=True, slots=True)
class SimulatedRow:
    """The error [m] in use after one kind of pairs: median, 90th percentile, and how long [s] they took to gather."""

    who: str
    pairs: str
    seconds: float
    median: float
    p90: float

    def document(self) -> dict[str, object]:
        """For JSON."""
        return {
            "who": self.who,
            "simulated": True,
            "pairs": self.pairs,
            "seconds": self.seconds,
            "median_mm": 1000.0 * self.median,
            "p90_mm": 1000.0 * self.p90,
        }


@dataclass(frozen=True, slots=True)
class RealRow:
    """Real sessions: which samples of a segment of ``seconds`` placed the user, and how well.

    ``fits`` were found, ``refused`` were not; ``head`` [m] is the median distance of the eye from the tracked head,
    level, and ``angle`` [rad] by how much rays miss the robot in the rest of the session (median of medians); NaN
    without a fit.
    """

    pairs: str
    seconds: float
    fits: int
    refused: int
    head: float
    angle: float

    def document(self) -> dict[str, object]:
        """For JSON."""
        return {
            "simulated": False,
            "pairs": self.pairs,
            "seconds": self.seconds,
            "fits": self.fits,
            "refused": self.refused,
            "head_mm": 1000.0 * self.head if self.fits else None,
            "rest_deg": float(np.degrees(self.angle)) if self.fits else None,
        }


def simulated(layout: Layout, rng: np.random.Generator, people: int = 30) -> list[SimulatedRow]:
    """New people: four stops, eight stops, and parts of one round of a driving robot; tested at nine places."""
    rows = []
    postures: tuple[Posture, ...] = ("straight", "natural")
    for posture in postures:
        tally: dict[tuple[str, float], list[Array]] = {}
        for _ in range(people):
            for key, errors in _one(posture, layout, rng).items():
                tally.setdefault(key, []).append(errors)
        for (pairs, seconds), parts in tally.items():
            median, high = np.percentile(np.concatenate(parts), (50, 90))
            rows.append(SimulatedRow(f"{posture} arm, {layout.name}", pairs, seconds, float(median), float(high)))
    return rows


def _one(posture: Posture, layout: Layout, rng: np.random.Generator) -> dict[tuple[str, float], Array]:
    """One person's errors (9,) [m] by kind of pairs and the time they took."""
    person = draw_person(rng, posture=posture)
    body = measured_body(person, rng)
    someone = VirtualPerson(person, (0.0, 0.0), 0.0, rng)
    turn = yaw_rotation(HEADING * rng.standard_normal())
    ring = layout.places(_ring())
    held, t = _stops(someone, ring, 0.0)
    tests = layout.places(0.8 * stop_shares(9))
    tested, t = _stops(someone, tests, t)
    pairs = _still(turn @ held, ring, 4.0 * layout.side / SPEEDS[0])
    for speed_of_robot in SPEEDS:
        times, follow, points = _round(someone, ring[::2], t, speed_of_robot)
        t = float(times[-1]) + 1.0
        pairs |= _moving(times, turn @ follow, points, speed_of_robot)
    test = Gestures(body, turn @ tested, turn @ tested, tests, np.arange(9))
    return {key: _errors(test, some) for key, some in pairs.items()}


def _ring() -> Array:
    """Shares (8, 2) of corners and edges, one after the other round the sheet."""
    x, y = stop_shares(8).T
    return np.asarray(stop_shares(8)[np.argsort(np.arctan2(y, x))])


def _still(held: Array, ring: Array, drive: float) -> dict[tuple[str, float], Pairs]:
    """Pairs of the corners alone and of the whole ring, whose robot drives for ``drive`` [s] in all."""
    some = {4: slice(0, None, 2), 8: slice(None)}
    return {
        (f"{count} stops", drive + count * _HOLD_S): still_pairs(
            held[rows], None, ring[rows], tuple(str(k) for k in range(count))
        )
        for count, rows in some.items()
    }


def _moving(times: Array, follow: Array, points: Array, pace: float) -> dict[tuple[str, float], Pairs]:
    """Pairs of parts of a round."""
    found = {}
    for share, words in SHARES_OF_ROUND:
        rows = slice(0, round(share * len(times)))
        key = (f"moving at {pace:g} m/s, {words}", share * len(times) / _RATE)
        found[key] = moving_pairs(follow[rows], None, points[rows], times[rows])
    return found


def _errors(test: Gestures, pairs: Pairs) -> Array:
    """Errors (n,) [m] of the test's gestures after a calibration on ``pairs``."""
    try:
        fit = calibrate(test.body, pairs, "head-finger", z_up=True)
    except CalibrationError:
        return np.full(len(test.targets), MISSED_M)
    return misses(test, fit, np.arange(len(test.targets))).metres


def _stops(someone: VirtualPerson, places: Array, t: float) -> tuple[Array, float]:
    """Forearms (n, 3, 3) held at places, one after the other from ``t`` [s] on, and when it was done."""
    found = []
    for place in places:
        someone.point(t, place)
        t += _HOLD_S
        found.append(settled(someone, t - 0.5)[0])
    return np.array(found), t


def _round(someone: VirtualPerson, corners: Array, t: float, pace: float) -> tuple[Array, Array, Array]:
    """Times (n,), forearms and robot's places of an arm that follows a robot once round the corners."""
    side = float(np.linalg.norm(corners[1] - corners[0]))
    someone.point(t, corners[0])
    count = round(4.0 * side / pace * _RATE)
    way = np.arange(count) / count * 4.0
    leg = way.astype(int)
    points = corners[leg] + (way - leg)[:, None] * (corners[(leg + 1) % 4] - corners[leg])
    times = t + _HOLD_S + np.arange(count) / _RATE
    forearms = []
    for at, point in zip(times, points, strict=True):
        someone.track(float(at), point)
        forearms.append(someone.pose([at]).room_from_forearm[0])
    return times, np.array(forearms), points


def real(sessions: Sequence[Following], rng: np.random.Generator, segments: int = 20) -> list[RealRow]:
    """The same random segments of the sessions, by all their samples and by some only."""
    rows = []
    for seconds in REAL_SECONDS:
        cuts = [(session, _segment(session, seconds, rng)) for session in sessions for _ in range(segments)]
        for name, choose in CHOICES:
            found = [one for session, cut in cuts if (one := _placed(session, cut, choose)) is not None]
            head, angle = np.median(found, axis=0) if found else (np.nan, np.nan)
            rows.append(RealRow(name, seconds, len(found), len(cuts) - len(found), float(head), float(angle)))
    return rows


def _segment(session: Following, seconds: float, rng: np.random.Generator) -> Rows:
    start = rng.uniform(session.times[0], session.times[-1] - seconds)
    return np.flatnonzero((session.times >= start) & (session.times < start + seconds))


def _everything(session: Following, rows: Rows) -> Rows:
    return rows


def _one_a_second(session: Following, rows: Rows) -> Rows:
    _, first = np.unique(np.floor(session.times[rows] - session.times[rows[0]]), return_index=True)
    return np.asarray(rows[first])


Pace = Callable[[Following], Array]


def _third(pace: Pace, parts: int, *, fast: bool) -> Callable[[Following, Rows], Rows]:
    """The slowest or fastest third of a segment; of each of so many ``parts`` of it, from near to far."""

    def choose(session: Following, rows: Rows) -> Rows:
        away = np.linalg.norm(session.points - session.head, axis=1)
        groups = np.array_split(rows[np.argsort(away[rows], kind="stable")], parts)
        paces = pace(session)
        thirds = [(group[np.argsort(paces[group], kind="stable")], max(1, len(group) // 3)) for group in groups]
        return np.sort(np.concatenate([group[-count:] if fast else group[:count] for group, count in thirds]))

    return choose


def speed(session: Following) -> Array:
    """How fast (n,) [rad/s] the robot crosses the person's view."""
    before, after = _about(session.points - session.head, session.times)
    across = np.linalg.norm(np.cross(before, after), axis=1)
    return np.asarray(np.arctan2(across, (before * after).sum(axis=1)) / _OVER_S)


def robot_speed(session: Following) -> Array:
    """How fast (n,) [m/s] the robot flies."""
    before, after = _about(session.points, session.times)
    return np.asarray(np.linalg.norm(after - before, axis=1) / _OVER_S)


def _about(values: Array, times: Array) -> tuple[Array, Array]:
    """Values (n, 3) a little before and a little after each time."""
    before, after = (
        np.column_stack([np.interp(times + shift, times, axis) for axis in values.T])
        for shift in (-_OVER_S / 2.0, _OVER_S / 2.0)
    )
    return before, after


CHOICES: tuple[tuple[str, Callable[[Following, Rows], Rows]], ...] = (
    ("all samples", _everything),
    ("one a second", _one_a_second),
    ("arm slowest third", _third(speed, 1, fast=False)),
    ("arm fastest third", _third(speed, 1, fast=True)),
    ("arm slowest third, like distances", _third(speed, 6, fast=False)),
    ("arm fastest third, like distances", _third(speed, 6, fast=True)),
    ("robot slowest third", _third(robot_speed, 1, fast=False)),
    ("robot fastest third", _third(robot_speed, 1, fast=True)),
)


def _placed(session: Following, cut: Rows, choose: Callable[[Following, Rows], Rows]) -> tuple[float, float] | None:
    """Error of the head [m] and of rays outside the segment [rad]; None where the pairs do not place the user."""
    if len(cut) == 0:  # the recording has a gap
        return None
    rows = choose(session, cut)
    pairs = moving_pairs(session.forearm[rows], None, session.points[rows], session.times[rows])
    try:
        fit = calibrate(session.body, pairs, "head-finger", z_up=True)
    except CalibrationError:
        return None
    rest = np.setdiff1d(np.arange(len(session.times)), cut)
    eye = fit.transform().points([0.0, 0.0, session.body.eye_height_m])
    off = float(np.hypot(*(eye - session.head[cut].mean(axis=0))[:2]))
    return off, float(np.median(_angles(session, fit, rest)))


def _angles(session: Following, fit: Fit, rows: Rows) -> Array:
    """By how much (n,) [rad] rays miss the robot."""
    origins, directions = fit.rays(session.forearm[rows])
    place = fit.transform()
    rays, seen = place.directions(directions), session.points[rows] - place.points(origins)
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(rays, seen), axis=1), (rays * seen).sum(axis=1)))


def miss_by_speed(sessions: Sequence[Following], parts: int = 3) -> list[tuple[float, float]]:
    """How fast [rad/s] the robot crossed the view, and the rays' median miss [rad], in parts from slow to fast.

    Every session is fitted as a whole.
    """
    paces, off = [], []
    for session in sessions:
        pairs = moving_pairs(session.forearm, None, session.points, session.times)
        fit = calibrate(session.body, pairs, "head-finger", z_up=True)
        off.append(_angles(session, fit, np.arange(len(session.times))))
        paces.append(speed(session))
    pace, angle = np.concatenate(paces), np.concatenate(off)
    groups = np.array_split(np.argsort(pace), parts)
    return [(float(np.median(pace[rows])), float(np.median(angle[rows]))) for rows in groups]
