"""Composes the crafts: a ``match`` over events. No clock, no network, no dice."""

import numpy as np

from armspan.conductor.arm import Arm
from armspan.conductor.gestures import Gestures
from armspan.conductor.pointer import Pointer
from armspan.conductor.recorder_setup import WristSetUp
from armspan.conductor.settings import Settings
from armspan.conductor.setup import SetUp, Step
from armspan.gesture.model import GestureModel
from armspan.pointing.place import Place
from armspan.records import (
    Calibrated,
    Command,
    Event,
    Gesture,
    Hit,
    ImuSample,
    Link,
    Output,
    Press,
    RobotState,
    Say,
    Stop,
    Tap,
    Tick,
    Touch,
)
from armspan.swarm.behaviours import BEHAVIOURS, STOP, Behaviours
from armspan.swarm.errands import Errands
from armspan.swarm.lights import CursorLights
from armspan.swarm.safety import SafetyFilter

_FLASH = 0.7


class Conductor:
    """The one mind of a session.

    Presses it knows: ``setup`` (begin the set-up), ``feedback`` (``on`` or ``off``: robots' lights show the
    cursor), ``behaviour`` (of the swarm, by name), ``stop`` (latched), ``resume``, ``quit``. Others are for others.
    With a ``model``, gestures are spotted once the bands are set up and the set-up is through, and each does what the
    settings' dictionary says.
    """

    def __init__(self, settings: Settings, model: GestureModel | None = None) -> None:
        self.settings = settings
        self.feedback = settings.feedback
        self.states: dict[str, RobotState] = {}
        self._arm = Arm.from_settings(settings.bands, settings.body.arm)
        self._errands = Errands(settings.limits, settings.sheet)
        self._filter = SafetyFilter(settings.limits, settings.sheet)
        # A room without robots has nothing to be placed by: its set-up ends with the bands.
        set_up = SetUp if settings.robots else WristSetUp
        self._setup = set_up(settings, self._arm, self._errands)
        self._lights = CursorLights(led_zero=settings.led_zero_deg * 0.017453292519943295)
        self._pointer: Pointer | None = None
        self._gestures = Gestures(model, self._arm.wrists) if model is not None else None
        rng = np.random.default_rng(settings.dice)
        self._behaviours = Behaviours(settings.limits, settings.sheet, self._errands, rng)

    def step(self, event: Event) -> list[Output]:
        """Everything that follows from one event."""
        match event:
            case ImuSample():
                band = self._arm.by_name.get(event.source)
                if band is not None:
                    band.feel(event)
                    if self._gestures is not None:
                        self._gestures.feel(event)
                return []
            case Tick():
                return self._tick(event.t)
            case RobotState():
                return self._robot(event)
            case Tap():
                return self._tap(event)
            case Press():
                return self._press(event)
            case Touch(kind="long"):
                return self._stop(event.t, f"long touch on {event.robot}")
            case Link(up=False):
                return [Say(event.t, f"{event.source} is out of reach", "")]
            case Link() | Touch() | Hit():
                return []

    def _tick(self, t: float) -> list[Output]:
        for band in self._arm.bands:
            band.tick()
        outputs: list[Output] = []
        for output in self._setup.tick(t, self.states):
            outputs.append(output)
            fit = self._setup.fit
            if isinstance(output, Calibrated) and fit is not None:
                place = Place.from_calibration(output, self._setup.noise().dof)
                self._pointer = Pointer(self.settings, self._arm, place, fit.rays)
        if self._pointer is not None:
            outputs.extend(self._point(t, self._pointer))
        outputs.extend(self._gesture(t))
        self._behaviours.step(t, self.states)
        outputs.extend(self._safely(list(self._errands.step(t, self.states))))
        return outputs

    def _gesture(self, t: float) -> list[Output]:
        if self._gestures is None:
            return []
        outputs: list[Output] = []
        for found in self._gestures.tick(t):
            if not isinstance(found, Gesture):
                outputs.append(found)
            elif self._setup.step is Step.IDLE or self.settings.gestures.get(found.label) == STOP:
                outputs.append(found)
                outputs.extend(self._behave(t, self.settings.gestures.get(found.label), f"gesture {found.label}"))
        return outputs

    def _behave(self, t: float, name: str | None, why: str) -> list[Output]:
        """Begin a behaviour; a Stop is latched, and nothing begins before an explicit resume."""
        if name is None:
            return []
        if name == STOP:
            return self._stop(t, why)
        if name not in BEHAVIOURS:
            return [Say(t, f"Robots know no behaviour {name!r}; they know {', '.join(BEHAVIOURS)}", "")]
        if self._filter.stopped:
            return [Say(t, f"{name}: the robots are stopped; resume first", "")]
        self._behaviours.begin(name, t, self.states)
        return [Say(t, f"{why}: {name}", "")]

    def _point(self, t: float, pointer: Pointer) -> list[Output]:
        pointed, dwelt = pointer.tick(t, self.states, self.feedback)
        outputs: list[Output] = [pointed]
        if dwelt:
            outputs.extend(self._choose(t, pointer, "dwell"))
        outputs.extend(self._lights.step(t, pointed.xy if self.feedback else None, self.states))
        return outputs

    def _choose(self, t: float, pointer: Pointer, how: str) -> list[Output]:
        chosen = pointer.selected(t, how)
        outputs: list[Output] = [chosen]
        # Shown a cursor, the person aims the cursor and not the arm: nothing can be learnt of the heading then.
        if not self.feedback and pointer.learn(chosen, self.states):
            outputs.append(pointer.place.calibrated())
        if chosen.robot is not None:
            self._lights.flash(chosen.robot, t + _FLASH)
        return outputs

    def _tap(self, tap: Tap) -> list[Output]:
        if self._pointer is None or not self._pointer.tap():
            return []
        return self._choose(tap.t, self._pointer, "tap")

    def _robot(self, state: RobotState) -> list[Output]:
        known = self.states.get(state.robot)
        self.states[state.robot] = state
        if state.held and (known is None or not known.held):
            self._errands.goals.pop(state.robot, None)
            return self._safely([Stop(state.t, state.robot, "lifted or off the sheet")])
        return []

    def _press(self, press: Press) -> list[Output]:
        match press.name:
            case "setup":
                self._pointer = None
                self._behaviours.cancel()
                return self._setup.begin(press.t)
            case "feedback":
                self.feedback = press.value == "on"
                return list(self._lights.step(press.t, None, self.states)) if not self.feedback else []
            case "behaviour":
                return self._behave(press.t, press.value, "asked for")
            case "stop" | "quit":
                return self._stop(press.t, press.name)
            case "resume":
                self._filter.resume()
                return [Say(press.t, "Robots may move again", "")]
        return []

    def _stop(self, t: float, why: str) -> list[Output]:
        self._behaviours.cancel()
        self._errands.cancel()
        self._setup.cancel()
        return self._safely([Stop(t, None, why)])

    def _safely(self, commands: list[Command]) -> list[Output]:
        passed = (self._filter.admit(command, self.states) for command in commands)
        return [command for command in passed if command is not None]
