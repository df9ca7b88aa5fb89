"""A mind without an arm: robots steered by presses alone, as from a page, a script or the command line."""

from collections.abc import Sequence

from armspan.conductor.settings import Settings
from armspan.conductor.steering import Steering
from armspan.records import Event, Link, Output, Press, RobotState, Say, Tick, Touch, Vec2

FAR = 20.0
"""A spot or a user farther away than this [m] is a mistake."""


class RobotsOnly:
    """Steers robots; presses are those of the `Conductor` that concern robots, and two that stand for an arm.

    ``point`` carries the pointed spot as "x y" [m] in ``sheet``, ``user`` where the user stands; nothing takes it back.
    """

    def __init__(self, settings: Settings) -> None:
        self.steering = Steering(settings)
        self.spot: Vec2 | None = None
        self.user: Vec2 | None = None

    def step(self, event: Event) -> list[Output]:
        """Everything that follows from one event."""
        match event:
            case RobotState():
                return self.steering.robot(event)
            case Tick():
                return self.steering.tick(event.t, self.spot)
            case Press(name="point" | "user"):
                return self._place(event)
            case Press():
                return press_robots(self.steering, event, self.user)
            case Touch(kind="long"):
                return self.steering.stop(event.t, f"long touch on {event.robot}")
            case Link(up=False) if event.source in self.steering.settings.robots:
                return self.steering.lost(event.t, event.source)
            case _:
                return []

    def _place(self, press: Press) -> list[Output]:
        """Take where is pointed, or where the user stands; a spot that is taken back steers nobody any more."""
        try:
            xy = _xy(press.value)
        except ValueError:
            wrong = f'{press.name}: {press.value!r} is no place; expected "x y" in metres, each at most {FAR:g}'
            return [Say(press.t, wrong, "trouble")]
        if press.name == "user":
            self.user = xy
            return []
        self.spot = xy
        return [] if xy is not None else self.steering.unsteer(press.t, "nobody points any more")


def _xy(text: str) -> Vec2 | None:
    """A place from its words, None from nothing; ValueError for what is none."""
    if not text.strip():
        return None
    x, y = map(float, text.split())
    if not (abs(x) <= FAR and abs(y) <= FAR):  # not a number is none either
        raise ValueError
    return x, y


def press_robots(steering: Steering, press: Press, user: tuple[float, float] | None) -> list[Output]:
    """What follows from a press that concerns robots.

    ``behaviour`` carries a name and, after a colon, the robots that it is for; ``command`` one command as JSON;
    ``resume`` a robot's name, or nothing for all; ``stop`` and ``quit`` nothing.
    """
    match press.name:
        case "behaviour":
            name, _, robots = press.value.partition(":")
            return steering.behave(press.t, name, "asked for", user, _named(robots, steering.settings.robots))
        case "command":
            return steering.command(press)
        case "stop" | "quit":
            return steering.stop(press.t, press.value or press.name)
        case "resume":
            return steering.resume(press.t, press.value)
        case _:
            return []


def _named(text: str, known: Sequence[str]) -> list[str]:
    """The robots that a text names, apart by commas or spaces; a robot whose name has a space needs the commas."""
    if text.strip() in known:
        return [text.strip()]
    return [name.strip() for name in text.split(",")] if "," in text else text.split()
