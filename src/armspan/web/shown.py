"""What the page shows, gathered from a session's records: one message a frame, whatever is drawn with it.

A frame is a JSON object (numbers in SI and radians, places in ``sheet``: z into the table):

- ``t`` [s]; ``room``: the number of the room message it belongs to
- ``robots``: for each robot of the room ``[x, y, heading, state, battery, six lights]``; ``state`` is a sum of
  1 held, 2 waiting, 4 link lost, 8 not heard yet; battery -1 where unknown; a light is red * 65536 + green * 256 + blue
- ``at``: ``{xy, ellipse: [a, b, angle], robot, zone, p, decided, refused}`` or null; half axes of the 90 % ellipse
- ``arms``: ``[{side, points: [[x, y, z] * 3]}]``; ``ray``: ``[eye, end]`` or null; ``placed``: is the place known;
  ``eye``: ``[x, y, z]``; ``facing``: the yaw of ``sheet_from_user``
- ``say``, ``cue``, ``trouble``, ``stopped``, ``waiting: {robot: why}``, ``running: [[behaviour, [robots]]]``
- ``setup``: ``{step, stop, stops, seen: [[number, residual, used]], quality}``
- ``gesture``: ``{label, t}`` or null; ``chosen``: ``{name, t}`` or null; ``scores``: ``[[label, p]]``
- ``strips``: ``{band: [[t, ax, ay, az, gx, gy, gz]]}``: the last rows

The room message is ``{room: {number, sheet, table, zones, robots, bands, stops, radius, light, led_zero, simulated}}``.
"""

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec
import numpy as np

from armspan.conductor import Settings
from armspan.conductor.sight import Sight
from armspan.frames import Array, sheet_from_user
from armspan.records import (
    Gesture,
    ImuSample,
    Light,
    Link,
    Pointed,
    Record,
    RobotState,
    Say,
    Scores,
    Selected,
    Stop,
)
from armspan.swarm.lights import LEDS
from armspan.web.film import Film
from armspan.web.host import Seen

CHI90 = 4.605
"""Squared Mahalanobis radius that holds 90 % of a plane Gaussian."""

TROUBLE_STAYS = 8.0
"""Seconds for which what went wrong stays beside what is to be done now."""

STRIP_HZ = 50.0
"""Rows a second and band that are drawn."""

STRIP_ROWS = 16
"""Rows a frame carries: a third of a second, so that a slow browser misses none."""

BEFORE_TABLE = 0.35
"""Where a user whose place is not known is drawn: so far [m] before the sheet's lower edge."""

HELD, WAITING, LOST, UNHEARD = 1, 2, 4, 8
_DARK = [0] * LEDS


@dataclass(slots=True)
class Strip:
    """The last samples of one band, thinned, and how many a second there are."""

    rows: "deque[list[float]]" = field(default_factory=lambda: deque(maxlen=STRIP_ROWS))
    heard: float = -math.inf
    _due: float = -math.inf
    _times: "deque[float]" = field(default_factory=lambda: deque(maxlen=200))

    def take(self, sample: ImuSample) -> None:
        """Take a sample; one in so many is drawn."""
        self.heard = sample.t
        self._times.append(sample.t)
        if sample.t >= self._due:
            self._due = max(self._due + 1 / STRIP_HZ, sample.t)
            self.rows.append([round(v, 2) for v in (sample.t, *sample.acc, *sample.gyr)])

    @property
    def rate(self) -> float | None:
        """Samples a second, over the last ones."""
        if len(self._times) < 20 or self._times[-1] <= self._times[0]:
            return None
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])


class Shown:
    """A sink that remembers what the page needs; ``version`` grows with whatever changes a frame."""

    def __init__(self) -> None:
        self.version = 0
        self.room_number = 0
        self.film: Film | None = None  # a log that is shown instead
        self.clear(None)

    def clear(self, mind: Seen | None, *, simulated: bool = False) -> None:
        """Begin with a mind that nothing was heard of yet, or with none."""
        self.mind, self.simulated = mind, simulated
        self.t = 0.0
        self.robots: dict[str, RobotState] = {}
        self.lights: dict[str, list[int]] = {}
        self._rows: dict[str, list[float]] = {}
        self.down: set[str] = set()
        self.strips: dict[str, Strip] = {}
        self.pointed: Pointed | None = None
        self.said = self.trouble = Say(0.0, "")
        self.stopped_why = ""
        self.gesture: Gesture | None = None
        self.chosen: Selected | None = None
        self.scores: Scores | None = None
        self._settings: object = None
        self.version += 1

    def __call__(self, record: Record) -> None:
        """Take a record."""
        take = _TAKES.get(type(record))
        if record.t > self.t:
            self.t = record.t
        if take is not None:
            take(self, record)
            self.version += 1

    # --- the two messages ------------------------------------------------------------------------------

    def room(self) -> dict[str, Any] | None:
        """The room message, None where no room is open."""
        if self.film is not None:
            return self.film.room()
        if self.mind is None:
            return None
        settings = self.mind.settings
        return {
            "number": self._number(settings),
            "sheet": [settings.sheet.width_m, settings.sheet.height_m],
            "table": settings.table_height_m or 0.75,
            "zones": [{"name": zone.name, "polygon": zone.polygon} for zone in settings.zones],
            "robots": list(settings.robots),
            "bands": [
                {"name": b.name, "segment": b.segment, "arm": b.arm or settings.body.arm} for b in settings.bands
            ],
            "stops": settings.stops,
            "radius": settings.limits.body_radius_m,
            "light": settings.light_height_m,
            "led_zero": math.radians(settings.led_zero_deg),
            "simulated": self.simulated,
        }

    def _number(self, settings: Settings) -> int:
        """The number of the room as it is now: another one whenever it changed."""
        if settings is not self._settings:
            self._settings = settings
            self.room_number += 1
        return self.room_number

    def frame(self) -> dict[str, Any]:
        """The frame now."""
        if self.film is not None:
            filmed = self.film.frame()
            self.room_number = filmed["room"] or self.room_number
            return filmed
        mind = self.mind
        if mind is None:
            return {"t": 0.0, "room": 0}
        sight = mind.sight()
        frame: dict[str, Any] = {
            "t": round(self.t, 3),
            "room": self._number(mind.settings),
            "robots": self._robots(mind.settings.robots, sight.waiting if sight is not None else {}),
            "at": self._at(),
            "say": self.said.text,
            "cue": self.said.cue,
            "trouble": self.trouble.text if self.t - self.trouble.t < TROUBLE_STAYS else "",
            "gesture": {"label": self.gesture.label, "t": self.gesture.t} if self.gesture else None,
            "chosen": {"name": self.chosen.robot or self.chosen.zone, "t": self.chosen.t} if self.chosen else None,
            "scores": list(zip(self.scores.labels, self.scores.probabilities, strict=True)) if self.scores else [],
            "strips": {name: list(strip.rows) for name, strip in self.strips.items()},
        }
        return frame | (self._believed(mind, sight) if sight is not None else {})

    def _robots(self, names: tuple[str, ...], waiting: Mapping[str, str]) -> list[list[float]]:
        """The robots' rows; what can be told of a state alone was told when it was first shown."""
        rows = []
        for name in names:
            row = self._rows.get(name)
            if row is None:
                row = self._rows[name] = self._row(name)
            if name in waiting or name in self.down:
                row = [*row[:3], row[3] + WAITING * (name in waiting) + LOST * (name in self.down), *row[4:]]
            rows.append(row)
        return rows

    def _row(self, name: str) -> list[float]:
        state, lights = self.robots.get(name), self.lights.get(name, _DARK)
        if state is None:
            return [0.0, 0.0, 0.0, UNHEARD, -1.0, *lights]
        x, y = state.xy
        battery = -1.0 if state.battery is None else round(state.battery, 2)
        return [round(x, 4), round(y, 4), round(state.heading, 3), HELD * state.held, battery, *lights]

    def _at(self) -> dict[str, Any] | None:
        pointed = self.pointed
        if pointed is None:
            return None
        xy = None if pointed.xy is None else [round(pointed.xy[0], 4), round(pointed.xy[1], 4)]
        return {
            "xy": xy,
            "ellipse": None if pointed.covariance is None else ellipse(pointed.covariance),
            "robot": pointed.robot,
            "zone": pointed.zone,
            "p": round(pointed.probability, 3),
            "decided": pointed.decided,
            "refused": pointed.refused,
        }

    def _believed(self, mind: Seen, sight: Sight) -> dict[str, Any]:
        settings = mind.settings
        height = settings.table_height_m or 0.75
        assumed = (settings.sheet.width_m / 2, settings.sheet.height_m + BEFORE_TABLE, height, math.pi / 2)
        *xyz, yaw = sight.place or assumed
        placed = sheet_from_user(np.array(xyz), yaw)
        ray = None
        if sight.ray is not None:
            eye, direction = placed.points(sight.ray[0]), placed.directions(sight.ray[1])
            down = float(direction[2])
            reach = float(np.clip(-eye[2] / down, 0.3, 4.0)) if down > 0.02 else 2.0
            ray = [rounded(eye), rounded(eye + reach * direction)]
        return {
            "placed": sight.place is not None,
            "arms": [{"side": limb.side, "points": rounded(placed.points(limb.points))} for limb in sight.limbs],
            "eye": rounded(placed.points([0.0, 0.0, settings.body.eye_height_m])),
            "facing": round(yaw, 3),
            "ray": ray,
            "stopped": sight.stopped,
            "waiting": dict(sight.waiting),
            "running": sight.running,
            "setup": {
                "step": sight.step,
                "stop": sight.stop,
                "stops": sight.stops,
                "seen": [[seen.number, round(seen.residual, 4), seen.used] for seen in sight.seen],
                "quality": sight.quality,
            },
        }

    # --- records ---------------------------------------------------------------------------------------

    def _sample(self, sample: ImuSample) -> None:
        self.strips.setdefault(sample.source, Strip()).take(sample)

    def _state(self, state: RobotState) -> None:
        self.robots[state.robot] = state
        self._rows.pop(state.robot, None)

    def _light(self, light: Light) -> None:
        red, green, blue = light.colour
        lights = self.lights.setdefault(light.robot, list(_DARK))
        places = range(LEDS) if light.led is None else [light.led]
        for place in places:
            lights[place] = red * 65536 + green * 256 + blue
        self._rows.pop(light.robot, None)

    def _link(self, link: Link) -> None:
        (self.down.discard if link.up else self.down.add)(link.source)

    def _point(self, pointed: Pointed) -> None:
        self.pointed = pointed

    def _say(self, say: Say) -> None:
        if say.cue == "trouble":
            self.trouble = say
        else:
            self.said = say

    def _gesture(self, gesture: Gesture) -> None:
        self.gesture = gesture

    def _choose(self, selected: Selected) -> None:
        self.chosen = selected

    def _score(self, scores: Scores) -> None:
        self.scores = scores

    def _stop(self, stop: Stop) -> None:
        """Note why all robots stopped; what was said before holds no more."""
        if stop.robot is None:
            self.stopped_why, self.said = stop.why, Say(stop.t, "")


_TAKES: dict[type[Record], Callable[[Shown, Any], None]] = {
    ImuSample: Shown._sample,
    RobotState: Shown._state,
    Light: Shown._light,
    Link: Shown._link,
    Pointed: Shown._point,
    Say: Shown._say,
    Gesture: Shown._gesture,
    Selected: Shown._choose,
    Scores: Shown._score,
    Stop: Shown._stop,
}


def ellipse(covariance: tuple[tuple[float, float], tuple[float, float]]) -> list[float]:
    """Half axes [m] of the 90 % ellipse, the longer first, and that one's angle [rad] in ``sheet``."""
    (a, b), (_, c) = covariance
    middle, apart = (a + c) / 2, math.hypot((a - c) / 2, b)
    long, short = middle + apart, max(middle - apart, 0.0)
    return [
        round(math.sqrt(CHI90 * long), 4),
        round(math.sqrt(CHI90 * short), 4),
        round(0.5 * math.atan2(2 * b, a - c), 3),
    ]


def rounded(points: Array) -> list[Any]:
    """Points (..., 3) [m] to a tenth of a millimetre."""
    return np.round(points, 4).tolist()  # type: ignore[no-any-return]


def encode(message: dict[str, Any]) -> bytes:
    """A message as bytes."""
    return msgspec.json.encode(message)
