"""Composes the crafts: a ``match`` over events. No clock, no network, no dice."""

import numpy as np

from armspan.conductor.arm import Arm
from armspan.conductor.changes import changed
from armspan.conductor.choice import Choice
from armspan.conductor.gestures import Gestures, with_threshold
from armspan.conductor.hits import Hits
from armspan.conductor.pointer import How, Pointer
from armspan.conductor.recorder_setup import WristSetUp
from armspan.conductor.robots_only import press_robots
from armspan.conductor.settings import Settings
from armspan.conductor.setup import SetUp, Step
from armspan.conductor.sight import Sight, look
from armspan.conductor.steering import Steering
from armspan.errors import ConfigError, ModelError
from armspan.gesture.model import GestureModel
from armspan.pointing.place import Place
from armspan.pointing.selection import Candidates
from armspan.records import (
    Calibrated,
    Event,
    Gesture,
    Hit,
    ImuSample,
    Link,
    Output,
    Pointed,
    Press,
    RobotState,
    Say,
    Selected,
    Tap,
    Tick,
    Touch,
    Vec2,
)
from armspan.swarm.director import IN_ZONES, STOP
from armspan.swarm.lights import CursorLights

_FLASH = 0.7

STOP_TAPS = 3
"""How often in a row a band's button is pressed to stop all robots."""


class Conductor:
    """The one mind of a session.

    Presses it knows: ``setup`` (begin the set-up), ``feedback`` (``on`` or ``off``: robots' lights show the cursor),
    and those of `press_robots`: ``behaviour``, ``command``, ``stop`` (latched), ``resume``, ``quit``. Others are for
    others. With a ``model``, gestures are spotted once the bands are set up and the set-up is through, and each does
    what the settings' dictionary says: with the robots that were chosen just before, or with all; in the zone that was.
    """

    def __init__(self, settings: Settings, model: GestureModel | None = None) -> None:
        self.settings, self._model = settings, model
        self.feedback = settings.feedback
        if not settings.bands:
            raise ConfigError("a conductor needs a band on the forearm; robots alone are for `RobotsOnly`")
        self._steering = Steering(settings)
        self._wear()
        self._lights = CursorLights(led_zero=settings.led_zero_deg * 0.017453292519943295)
        self._choice = Choice(settings.choice_s)
        self._silent: set[str] = set()
        self._late = False

    def _wear(self) -> None:
        """Begin with bands that nothing is known of yet."""
        settings = self.settings
        self._arm = Arm.from_settings(settings.bands, settings.body.arm)
        # A room without robots has nothing to be placed by: its set-up ends with the bands.
        set_up = SetUp if settings.robots else WristSetUp
        self._hits = Hits(settings.laser) if settings.laser else None
        self._setup = set_up(settings, self._arm, self._steering.errands, self._hits)
        self._pointer: Pointer | None = None
        self._gestures = Gestures(self._model, self._arm.wrists) if self._model is not None else None
        self._spot: Vec2 | None = None

    @property
    def model(self) -> GestureModel | None:
        """What spots gestures, with the threshold as it was set last."""
        return self._model

    @property
    def states(self) -> dict[str, RobotState]:
        """The robots as last heard."""
        return self._steering.states

    def sight(self) -> Sight:
        """What is believed now, for those who show it."""
        return look(self._arm, self.settings.body, self._setup, self._pointer, self._steering, self._silent)

    def step(self, event: Event) -> list[Output]:
        """Everything that follows from one event."""
        match event:
            case ImuSample():
                return self._feel(event)
            case Tick():
                return self._tick(event.t)
            case RobotState():
                return [*self._beware(event.t), *self._steering.robot(event)]
            case Tap():
                return self._tap(event)
            case Press():
                return self._press(event)
            case Touch(kind="long"):
                return self._stop(event.t, f"long touch on {event.robot}")
            case Link(up=False):
                return self._unlinked(event)
            case Link(fresh=True):
                return self._began_anew(event)
            case Hit():
                return self._hit(event)
            case Link() | Touch():
                return []

    def _hit(self, hit: Hit) -> list[Output]:
        if self._hits is not None:
            self._hits.take(hit)
        return []

    def _feel(self, sample: ImuSample) -> list[Output]:
        band = self._arm.by_name.get(sample.source)
        if band is not None:
            band.feel(sample)
            if self._gestures is not None:
                self._gestures.feel(sample)
        return []

    def _tick(self, t: float) -> list[Output]:
        for band in self._arm.bands:
            band.tick()
        outputs = [*self._beware(t), *self._listen(t)]
        if self._hits is not None:
            self._hits.tick(t, leading=self._setup.step is not Step.IDLE)
        for output in self._setup.tick(t, self.states):
            outputs.append(output)
            fit = self._setup.fit
            if isinstance(output, Calibrated) and fit is not None:
                place = Place.from_calibration(output, self._setup.noise().dof)
                self._pointer = Pointer(self.settings, self._arm, place, fit.rays, self._hits)
        if self._pointer is not None:
            outputs.extend(self._point(t, self._pointer))
        elif self._hits is not None and self._setup.step is Step.IDLE:
            outputs.extend(self._choose_by_hit(t, self._hits))
        outputs.extend(self._gesture(t))
        outputs.extend(self._steering.tick(t, self._spot, paused=self._late))
        return outputs

    def _beware(self, t: float) -> list[Output]:
        """Robots pause while a band is late: when it counts as lost, they have come to rest already.

        Asked whenever a robot is heard, which is more often than the clock ticks.
        """
        late = any(band.late(t) for band in self._arm.bands)
        pauses = self._steering.pause(t) if late and not self._late else []
        self._late = late
        lost = late and not self._silent and any(band.stale(t) for band in self._arm.bands)
        return [*pauses, *(self._listen(t) if lost else ())]

    def _listen(self, t: float) -> list[Output]:
        """A band that falls silent stops the robots: the arm that could stop them is not felt any more."""
        silent = set(self._arm.any_silent(t))
        heard = {name for name, band in self._arm.by_name.items() if band.heard > -np.inf}
        fresh = sorted((silent & heard) - self._silent)
        self._silent = silent
        why = f"nothing heard of {' and '.join(fresh)}"
        stops = self._steering.halt(t, why) if fresh else []
        leading = self._setup.step in (Step.DRIVE, Step.POINT)
        robot = self.settings.robots[0] if self.settings.robots else ""
        if leading and robot in self._steering.filter.waiting:
            why = f"{robot}: {self._steering.filter.waiting[robot]}"
        elif not (leading and stops):
            return stops
        self._setup.cancel()
        return [*stops, Say(t, f"The set-up was broken off ({why}); begin it again", "trouble")]

    def _unlinked(self, link: Link) -> list[Output]:
        if link.source in self.settings.robots:
            return self._steering.lost(link.t, link.source)
        worn = link.source in self._arm.by_name
        stops = self._steering.halt(link.t, f"{link.source} is out of reach") if worn else []
        return [*stops, Say(link.t, f"{link.source} is out of reach", "")]

    def _began_anew(self, link: Link) -> list[Output]:
        """A band that was heard before and has lost its heading: what was found with it holds no more."""
        band = self._arm.by_name.get(link.source)
        leading = self._setup.step is not Step.IDLE
        if band is None or band.heard == -np.inf or not (leading or band.mount):
            return []
        band.mount = None
        if link.source in self._arm.pointing:
            self._pointer, self._spot = None, None
        self._setup.cancel()
        stops = self._steering.halt(link.t, f"{link.source} began anew")
        words = f"{link.source} began anew, and nobody knows its heading any more: begin the set-up again"
        return [*stops, Say(link.t, words, "trouble")]

    def _gesture(self, t: float) -> list[Output]:
        if self._gestures is None:
            return []
        outputs: list[Output] = []
        for found in self._gestures.tick(t):
            if not isinstance(found, Gesture):
                outputs.append(found)
                continue
            behaviour = self.settings.gestures.get(found.label)
            if self._setup.step is Step.IDLE or behaviour == STOP:
                outputs.append(found)
                outputs.extend(self._behave(t, behaviour, f"gesture {found.label.replace('_', ' ')}"))
        return outputs

    def _behave(self, t: float, name: str | None, why: str) -> list[Output]:
        if name is None:
            return []
        if name == STOP:
            return self._stop(t, why)
        robots, zone = self._choice.take(t)
        asked = f"{name}@{zone}" if zone and name in IN_ZONES else name
        return self._steering.behave(t, asked, why, self._user(), robots)

    def _user(self) -> Vec2 | None:
        """Where the user stands, in ``sheet`` [m]."""
        if self._pointer is None:
            return None
        x, y = self._pointer.place.state[:2].tolist()
        return x, y

    def _point(self, t: float, pointer: Pointer) -> list[Output]:
        pointed, how = pointer.tick(t, self.states, self.feedback)
        outputs: list[Output] = [pointed, *self._spotted(pointed)]
        if how is not None:
            outputs.extend(self._choose(t, pointer, how))
        outputs.extend(self._lights.step(t, pointed.xy if self.feedback else None, self.states))
        return outputs

    def _spotted(self, pointed: Pointed) -> list[Output]:
        """Keep the spot for those who follow it; without one they are stopped."""
        had, self._spot = self._spot, pointed.xy
        if pointed.xy is None and had is not None:
            return self._steering.unsteer(pointed.t, f"no spot: {pointed.refused}")
        return []

    def _choose(self, t: float, pointer: Pointer, how: How) -> list[Output]:
        chosen = pointer.selected(t, how)
        outputs: list[Output] = [chosen]
        if self._teaches(how) and pointer.learn(chosen, self.states):
            outputs.append(pointer.place.calibrated())
        return [*outputs, *self._keep(t, chosen)]

    def _teaches(self, how: How) -> bool:
        """Shown a cursor, the person aims the cursor and not the arm: that says nothing of the heading.

        What is hit says where the beam went, and nothing of another ray.
        """
        if how == "hit":
            return self.settings.beam is not None
        return not self.feedback

    def _choose_by_hit(self, t: float, hits: Hits) -> list[Output]:
        """Without a place a hit alone chooses: the spot is where it is."""
        selection = self.settings.selection
        candidates = Candidates.on_sheet(self.settings.sheet, ()).with_robots(list(self.states.values()))
        best, probability = hits.best(candidates, selection.elsewhere)
        if probability < selection.gate or not hits.due(t, best, already=False):
            return []
        chosen = Selected(t, self._arm.forearm.settings.name, best.robot, None, probability, "hit")
        return [chosen, *self._keep(t, chosen)]

    def _keep(self, t: float, chosen: Selected) -> list[Output]:
        """Keep a choice for the next gesture, and let the robot show it."""
        if chosen.robot is not None:
            self._choice.add(t, chosen.robot)
            self._lights.flash(chosen.robot, t + _FLASH)
        elif chosen.zone is not None:
            self._choice.add_zone(t, chosen.zone)
        return []

    def _tap(self, tap: Tap) -> list[Output]:
        """A band's button: once chooses what is pointed at, three times or more stops the robots."""
        if tap.count >= STOP_TAPS:
            return self._stop(tap.t, f"{tap.source}: {tap.count} taps")
        if self._pointer is None or not self._pointer.tap():
            return []
        return self._choose(tap.t, self._pointer, "tap")

    def _press(self, press: Press) -> list[Output]:
        match press.name:
            case "setup" if self._steering.filter.stopped and self.settings.robots:
                return [Say(press.t, "The robots are stopped: let them move again, then begin the set-up", "trouble")]
            case "setup":
                self._pointer, self._spot = None, None
                halted = self._steering.halt(press.t, "the set-up begins")
                self._steering.filter.release(self.settings.robots[:1])
                return [*halted, *self._setup.begin(press.t)]
            case "stop_again":
                number = int(press.value) if press.value.isdecimal() else 0
                return self._setup.again(press.t, number)
            case "zones" | "gestures" | "body":
                return self._change(press)
            case "threshold":
                return self._set_threshold(press)
            case "feedback":
                self.feedback = press.value == "on"
                return list(self._lights.step(press.t, None, self.states)) if not self.feedback else []
            case "stop" | "quit":
                return self._stop(press.t, press.value or press.name)
        return press_robots(self._steering, press, self._user())

    def _change(self, press: Press) -> list[Output]:
        """Change the room; new measures want a new set-up, since the old one was made with the old ones."""
        try:
            settings = changed(self.settings, press.name, press.value)
            if self._model is not None:
                Gestures(self._model, Arm.from_settings(settings.bands, settings.body.arm).wrists)
        except (ConfigError, ModelError) as error:
            return [Say(press.t, f"Nothing was changed: {error}", "trouble")]
        self.settings = self._steering.settings = self._setup.settings = settings
        self._steering.director.zones = settings.zones
        if self._pointer is not None:
            self._pointer.settle(settings)
        if press.name != "body":
            return []
        halted = self._steering.halt(press.t, "the measures were changed")
        self._wear()
        return [*halted, Say(press.t, "The measures were changed: begin the set-up", "")]

    def _set_threshold(self, press: Press) -> list[Output]:
        """Change how probable a gesture must be to count."""
        try:
            self._model = with_threshold(self._model, press.value)
        except ConfigError as error:
            return [Say(press.t, f"Nothing was changed: {error}", "trouble")]
        if self._gestures is not None:
            self._gestures.obey(self._model)
        return []

    def _stop(self, t: float, why: str) -> list[Output]:
        self._setup.cancel()
        return self._steering.stop(t, why)
