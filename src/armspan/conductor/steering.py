"""The swarm's part of the mind: behaviours and errands, watched and filtered, and every way to stop."""

import math
from collections.abc import Mapping, Sequence

import msgspec
import numpy as np

from armspan.conductor.settings import Settings
from armspan.errors import ConfigError, known_names
from armspan.records import COMMANDS, Command, Drive, GoTo, Haptic, Light, Output, Press, RobotState, Say, Stop, Vec2
from armspan.swarm.director import POINTED, STOP, Director, order_name
from armspan.swarm.errands import Errands
from armspan.swarm.fitness import unfit
from armspan.swarm.lights import LEDS
from armspan.swarm.safety import SafetyFilter
from armspan.swarm.words import order_words

_COMMAND: "msgspec.json.Decoder[Command]" = msgspec.json.Decoder(Command)


class Steering:
    """Robots and what they do; every motion leaves by the one `SafetyFilter`.

    ``states`` are the robots as last heard, ``errands`` what single robots were sent to do, ``wishes`` what the
    behaviours wished for at the last tick.
    """

    def __init__(self, settings: Settings) -> None:
        dice = np.random.default_rng(settings.dice)
        walk, avoid = dice.spawn(2)
        self.settings = settings
        self.states: dict[str, RobotState] = {}
        self.errands = Errands(settings.limits, settings.sheet)
        self.filter = SafetyFilter(settings.limits, settings.sheet, avoid)
        self.director = Director(settings.limits, settings.sheet, settings.zones, walk)
        self.wishes: list[GoTo | Drive] = []
        self._raw: list[Command] = []

    # --- what happens ----------------------------------------------------------------------------------

    def robot(self, state: RobotState) -> list[Output]:
        """A robot was heard of: one that must not be driven is stopped at once."""
        self.states[state.robot] = state
        return self._watch(state.t, {state.robot: state})

    def lost(self, t: float, robot: str) -> list[Output]:
        """A robot's link is down."""
        self._leave(robot)
        return [self.filter.hold(t, robot, "its link is down"), Say(t, f"{robot} is out of reach", "")]

    def pause(self, t: float) -> list[Output]:
        """Robots that drive come to rest; what they do goes on with the next tick that is not paused."""
        return [Stop(t, robot, "a band is late") for robot in sorted(self.filter.driven)]

    def tick(self, t: float, pointed: Vec2 | None, *, paused: bool = False) -> list[Output]:
        """What is due at ``t`` [s]: stops first, then the motions of all robots, made safe together."""
        outputs = self._watch(t, self.states)
        if paused:
            return outputs
        able = {name: state for name, state in self.states.items() if name not in self.filter.waiting}
        self.wishes = self.director.step(t, able, pointed)
        commands: list[Command] = [*self.wishes, *self.errands.step(t, self.states), *self._raw]
        self._raw = []
        outputs.extend(self.filter.admit(t, commands, self.states))
        return outputs

    # --- what is asked ---------------------------------------------------------------------------------

    def behave(self, t: float, asked: str, why: str, user: Vec2 | None, robots: Sequence[str] = ()) -> list[Output]:
        """Begin a behaviour, for some ``robots`` only or for all; nothing begins between a Stop and a resume.

        A zone may be asked for after an ``@``: ``sweep@garden`` covers the zone and not the sheet.
        """
        try:
            order = order_name(asked)
            strange = [robot for robot in robots if robot not in self.settings.robots]
            if strange:
                raise ConfigError(known_names("robot", strange[0], self.settings.robots))
            if order == STOP:
                return self.stop(t, why) if not robots else self._halt(t, robots, why)
            if self.filter.stopped:
                return [Say(t, f"{order}: the robots are stopped; resume first", "")]
            return self._begin(t, order, why, user, robots)
        except ConfigError as error:
            return [Say(t, f"{asked}: {error}", "trouble")]

    def command(self, press: Press) -> list[Output]:
        """A single command, as JSON, from a page or a script: filtered like any other."""
        try:
            command = _sound(_COMMAND.decode(press.value))
        except (ConfigError, ValueError, TypeError, RecursionError) as error:
            kinds = ", ".join(kind.__name__ for kind in COMMANDS)
            return [Say(press.t, f"That is no command ({error}); expected JSON with a type of {kinds}", "trouble")]
        if command.robot is not None and command.robot not in self.settings.robots:
            return [Say(press.t, known_names("robot", command.robot, self.settings.robots), "trouble")]
        if isinstance(command, Stop):
            why = command.why or "asked for"
            return self.stop(press.t, why) if command.robot is None else self._halt(press.t, [command.robot], why)
        if isinstance(command, GoTo | Drive):
            self.director.leave([command.robot])
        self._raw.append(msgspec.structs.replace(command, t=press.t))
        return []

    def stop(self, t: float, why: str) -> list[Output]:
        """All robots stop, at once and latched."""
        self.director.cancel()
        self.errands.cancel()
        self._raw = []
        return list(self.filter.admit(t, [Stop(t, None, why)], self.states))

    def halt(self, t: float, why: str) -> list[Output]:
        """All robots that do anything stop, and wait for a new command; nothing is latched."""
        return self._halt(t, sorted(self.director.busy | set(self.errands.goals) | self.filter.driven), why)

    def unsteer(self, t: float, why: str) -> list[Output]:
        """The arm points nowhere any more: the robots that it steers stop."""
        steered = [running for running in self.director.running if running.name in POINTED]
        return self._halt(t, sorted({robot for running in steered for robot in running.robots}), why)

    def resume(self, t: float, robot: str = "") -> list[Output]:
        """Robots may move again, all or one, once something new is asked of them."""
        if robot and robot not in self.settings.robots:
            return [Say(t, known_names("robot", robot, self.settings.robots), "trouble")]
        if robot and self.filter.stopped:
            return [Say(t, f"{robot}: all robots are stopped; resume without a name first", "trouble")]
        if not robot:
            self.filter.resume()
        self.filter.release([robot] if robot else list(self.filter.waiting))
        return [Say(t, f"{robot or 'Robots'} may move again", "")]

    # --- details ---------------------------------------------------------------------------------------

    def _begin(self, t: float, order: str, why: str, user: Vec2 | None, robots: Sequence[str]) -> list[Output]:
        wanted = robots or self.settings.robots
        able = {
            robot: state
            for robot, state in self.states.items()
            if robot in wanted and unfit(t, state, self.settings.sheet, self.settings.limits) is None
        }
        if not able:
            return [Say(t, f"{order}: no robot can drive now", "trouble")]
        self.director.begin(order, able, user)  # what cannot be begun changes nothing
        self.filter.release(able)
        for robot in able:
            self.errands.goals.pop(robot, None)
        only = f" ({', '.join(able)})" if robots else ""
        return [Say(t, f"{why}: {order_words(order)}{only}", "")]

    def _halt(self, t: float, robots: Sequence[str], why: str) -> list[Output]:
        for robot in robots:
            self._leave(robot)
        return [self.filter.hold(t, robot, why) for robot in robots]

    def _leave(self, robot: str) -> None:
        self.director.leave([robot])
        self.errands.goals.pop(robot, None)
        self._raw = [command for command in self._raw if command.robot != robot]

    def _watch(self, t: float, states: Mapping[str, RobotState]) -> list[Output]:
        stops = self.filter.watch(t, states)
        for stop in stops:
            if stop.robot is not None and stop.robot in self.filter.waiting:
                self._leave(stop.robot)
        return list(stops)


def _sound(command: Command) -> Command:
    """A command that any robot can be told; what no robot has is refused (ConfigError)."""
    match command:
        case Light(colour=colour, led=led):
            if not all(0 <= shade <= 255 for shade in colour) or not (led is None or 0 <= led < LEDS):
                raise ConfigError(
                    f"a light of {colour} at {led}: colours go from 0 to 255, lights from 0 to {LEDS - 1}"
                )
        case Haptic(strength=strength, duration=duration):
            if not (0 <= strength <= 1 and 0 <= duration <= 60):
                raise ConfigError(f"a haptic of {strength} for {duration} s: strength goes to 1, duration to 60 s")
        case GoTo(heading=float(heading)) if math.isfinite(heading):
            return msgspec.structs.replace(command, heading=math.remainder(heading, 2 * math.pi))
        case _:
            pass
    return command
