"""The virtual world: a table with robots, a person before it, bands on the arm, and what passes between them.

The world's own frame is ``room``: z up, its origin on the floor below the sheet's corner, x along the sheet's
x. The person sees robots, zones and lights, hears words, and moves; nothing else comes back from the estimators.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from armspan.frames import polygon_middle
from armspan.records import COMMANDS, Calibrated, Event, Press, Record, RobotState, Say, Selected, Tick, Vec2, Zone
from armspan.simulation.bands import VirtualBand
from armspan.simulation.beam import Beam
from armspan.simulation.discs import IdealDiscs
from armspan.simulation.dot import EYE_DELAY
from armspan.simulation.gesture_script import Agenda
from armspan.simulation.guided import WISH
from armspan.simulation.person import VirtualPerson
from armspan.simulation.reading import Array, read_cursor
from armspan.simulation.robots import VirtualRobots
from armspan.simulation.script import Phase, Target
from armspan.simulation.second_arm import TwoArmedPerson

Spy: TypeAlias = Callable[[float, Array], None]
"""Hears the robots' true places (n, 2) [m] in ``sheet`` at ``t`` [s]."""

TICK = 0.05
SPIED = 5
"""How often in a tick the true places are told to a spy: every 10 ms."""

_BETWEEN = 0.65
_FIRST = 1.35
_WORTH = 0.02
_BOTH_ARMS = ("gesture", "everyday", "relax")


@dataclass(frozen=True, slots=True)
class Truth:
    """Where the user frame truly was: ``xyz`` [m] and ``yaw`` [rad] of ``sheet_from_user``, as in `Calibrated`.

    ``eye_height`` [m] is the dominant eye's above the floor at that moment.
    """

    xyz: tuple[float, float, float]
    yaw: float
    eye_height: float


class World:
    """Everything that is simulated, let run by ``advance`` and told by ``take``."""

    def __init__(
        self,
        person: VirtualPerson | None,
        bands: Sequence[VirtualBand],
        robots: VirtualRobots | IdealDiscs,
        zones: Mapping[str, Vec2],
        script: Agenda,
        rng: np.random.Generator,
        *,
        table_height: float = 0.75,
        light_height: float = 0.045,
        spy: Spy | None = None,
        beam: Beam | None = None,
    ) -> None:
        self.person, self.bands, self.robots, self.script = person, list(bands), robots, script
        self.zones, self.table_height, self.light_height = dict(zones), table_height, light_height
        self._rng = rng
        self._now = 0.0
        self._number = 0
        self._arriving: list[tuple[float, int, Event]] = []
        self._seen: deque[tuple[float, Array]] = deque()
        self._target: Target | None = None
        self._last_seen: Array | None = None
        self._corrected = 0.0
        self._heading: float | None = None
        self.truth: Truth | None = None
        self._told = 0
        self._spy, self._spied = spy, 0
        self._beam = beam

    @property
    def ended(self) -> bool:
        """Whether the script is through; without a person there is none, and the robots go on."""
        return self.person is not None and self.script.phase is Phase.DONE

    def take(self, record: Record) -> None:
        """Hear a record: a command for a robot, words or a choice for the person."""
        if isinstance(record, COMMANDS):
            self.robots.command(self._now, record)  # type: ignore[arg-type]
        elif isinstance(record, Say | Selected) or (isinstance(record, Press) and record.name == WISH):
            self.script.hear(record)
            if self.person is not None and isinstance(record, Say) and record.cue == "hang":
                self._heading = self._arm_heading(self.person)
        elif isinstance(record, Calibrated) and self.person is not None and self.truth is None:
            self.truth = self._true_place(self.person)

    def advance(self, t: float) -> list[Event]:
        """Everything that arrives up to session time ``t`` [s], in order of arrival."""
        events: list[Event] = []
        while self._now + 1e-9 < t:
            self._now = min(t, round((self._now + TICK) / TICK) * TICK)
            events.extend(self._step(self._now))
        return events

    def _step(self, t: float) -> list[Event]:
        presses = self._true_gestures(t) + self.script.step(t)
        for cue in self.script.cues:
            self._act(t, cue)
        self.script.cues.clear()
        for arrived, state in self._drive(t):
            self._post(arrived, state)
        self._look(t)
        if self.person is not None:
            for band in self.bands:
                for arrived, sample in band.advance(t, self.person):
                    self._post(arrived, sample)
            if self._beam is not None:
                for arrived, hit in self._beam.advance(t, self.person, self._light_of):
                    self._post(arrived, hit)
        for press in presses:
            self._post(t, press)
        self._post(t, Tick(t))
        here = [item for item in self._arriving if item[0] <= t + 1e-9]
        self._arriving = [item for item in self._arriving if item[0] > t + 1e-9]
        return [event for _, _, event in sorted(here, key=lambda item: item[:2])]

    def _drive(self, t: float) -> list[tuple[float, RobotState]]:
        """What the robots told up to ``t``; a spy hears on the way where they truly are."""
        told: list[tuple[float, RobotState]] = []
        while self._spy is not None and (at := self._spied * TICK / SPIED) <= t + 1e-9:
            told.extend(self.robots.advance(at))
            self._spy(at, self.robots.truth()[0])
            self._spied += 1
        return told + self.robots.advance(t)

    def _post(self, arrived: float, event: Event | Press) -> None:
        self._arriving.append((arrived, self._number, event))
        self._number += 1

    def _act(self, t: float, cue: str) -> None:
        """Do what was asked, as ``verb`` or ``point:...``."""
        verb, _, thing = cue.partition(":")
        self._target = None
        if self.person is None:
            return
        if verb == "stretch":
            self.person.stretch(t)
        elif verb == "hang":
            self.person.hang(t)
        elif verb == "rest":
            self.person.rest(t)
        elif isinstance(self.person, TwoArmedPerson) and verb in _BOTH_ARMS:
            _move_both(self.person, t, verb, thing)
        elif verb == "point":
            self._target = Target(thing if ":" in thing else f"robot:{thing}")
            self._last_seen = self._place(self._target)
            self._corrected = t + _FIRST - _BETWEEN
            self.person.point(t, self._aimed(t, self.person, self._last_seen, anew=True))

    def _true_gestures(self, t: float) -> list[Press]:
        """Notes of what was truly performed: ``truth`` with its label when it began, with nothing when it ended.

        The script hears them as soon as they are due; they belong to nobody whose guesses are to be scored.
        """
        performed = self.person.performed if isinstance(self.person, TwoArmedPerson) else []
        presses: list[Press] = []
        while self._told < 2 * len(performed):
            gesture, ended = performed[self._told // 2], self._told % 2 == 1
            at = gesture.end if ended else gesture.start
            if at > t:
                break
            presses.append(Press(at, "truth", "" if ended else gesture.label))
            self._told += 1
        for press in presses:
            self.script.hear(press)
        return presses

    def _place(self, target: Target) -> Array:
        """Where in the room (3,) [m] a person points to mean a target: a robot's light, a zone's middle."""
        if target.kind == "robot":
            return self._light_of(target.label)
        x, y = self.zones[target.label]
        return np.array([x, -y, self.table_height])

    def _light_of(self, robot: str) -> Array:
        """A robot's light (3,) [m] in the room."""
        xy, _, _ = self.robots.truth()
        x, y = xy[self.robots.names.index(robot)]
        return np.array([x, -y, self.table_height + self.light_height])

    def _look(self, t: float) -> None:
        """What the eyes take in: the target when it moves, the lights when the person is to use them."""
        if self.person is None or isinstance(self.robots, IdealDiscs):
            return  # no eyes, or no lights
        self._seen.append((t, self.robots.lights()))
        while len(self._seen) > 1 and self._seen[1][0] <= t - EYE_DELAY:
            self._seen.popleft()
        if self._target is None or self._last_seen is None:
            return
        here = self._place(self._target)
        if np.linalg.norm(here - self._last_seen) > 0.002:
            self.person.track(t, self._aimed(t, self.person, here))
            self._last_seen = here
        elif self._beam is None and self.script.phase is Phase.POINT and t - self._corrected >= _BETWEEN:
            self._correct(t, self.person, here)
        if self._beam is not None:
            self._steer(t, self.person, self._beam, here)

    def _aimed(self, t: float, person: VirtualPerson, target: Array, *, anew: bool = False) -> Array:
        """Where (3,) [m] the person aims at a target: beside it, where a beam is known to go beside the aim."""
        if self._beam is None:
            return target
        if anew:
            self._beam.dot.begin()
        return self._beam.dot.shifted(person.pose(np.array([t])).eye[0], target)

    def _steer(self, t: float, person: VirtualPerson, beam: Beam, target: Array) -> None:
        """Bring the dot onto the target, whatever the robots' lights show."""
        if t - self._corrected < _BETWEEN:
            return
        pose = person.pose(np.array([t]))
        eye, beside = pose.eye[0], beam.dot.beside(pose.eye[0], pose.shoulder[0], target)
        if person.correct(t, beside):
            self._corrected = t
            beam.dot.turn(eye, target, -person.person.feedback.gain * beside)

    def _correct(self, t: float, person: VirtualPerson, target_room: Array) -> None:
        xy, heading, _ = self.robots.truth()
        target = np.array([target_room[0], -target_room[1]])
        cursor = read_cursor(self._seen[0][1], xy, heading, target, self._rng)
        if cursor is None:
            return
        offset = np.array([cursor[0] - target[0], target[1] - cursor[1], 0.0])
        if np.linalg.norm(offset) > _WORTH:
            self._corrected = t
            person.correct(t, offset)

    def _arm_heading(self, person: VirtualPerson) -> float:
        """Where the forearm points, seen from above, [rad] in the room: the user frame's x, by definition."""
        forearm = person.pose(np.array([self._now])).room_from_forearm[0]
        return float(np.arctan2(forearm[1, 0], forearm[0, 0]))

    def _true_place(self, person: VirtualPerson) -> Truth | None:
        if self._heading is None:
            return None
        eye = person.pose(np.array([self._now])).eye[0]
        return Truth((float(eye[0]), -float(eye[1]), self.table_height), self._heading, float(eye[2]))


def _move_both(person: TwoArmedPerson, t: float, verb: str, thing: str) -> None:
    if verb == "gesture":
        person.perform(t, thing)
    elif verb == "everyday":
        person.everyday(t, float(thing))
    else:
        person.relax(t)


def zone_middles(zones: Sequence[Zone]) -> dict[str, Vec2]:
    """The middle [m] of each zone: where its name is printed, and where people point."""
    return {zone.name: polygon_middle(zone.polygon) for zone in zones}
