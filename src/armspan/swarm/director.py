"""Which behaviours go on, with which robots: begun by name, in the place of what these robots did before."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from armspan.errors import ConfigError, known_names
from armspan.records import Drive, GoTo, RobotState, Sheet, Vec2, Zone
from armspan.swarm.behaviours.come import come
from armspan.swarm.behaviours.disperse import disperse
from armspan.swarm.behaviours.follow import Follow
from armspan.swarm.behaviours.formation import FormationAt
from armspan.swarm.behaviours.gather import Gather
from armspan.swarm.behaviours.leader import Leader
from armspan.swarm.behaviours.lloyd import Lloyd
from armspan.swarm.behaviours.patrol import Patrol
from armspan.swarm.behaviours.potential import Potential
from armspan.swarm.behaviours.protocol import Behaviour, Stage
from armspan.swarm.behaviours.random_walk import RandomWalk
from armspan.swarm.behaviours.rotate import Rotate
from armspan.swarm.behaviours.split import Merge, split
from armspan.swarm.behaviours.sweep import Sweep
from armspan.swarm.limits import Limits

STOP = "stop"


class Maker(Protocol):
    """How a behaviour is made."""

    def __call__(self, stage: Stage, states: Mapping[str, RobotState]) -> Behaviour:
        """Begin it with these robots, all of which can drive."""


MAKERS: dict[str, Maker] = {
    "random-walk": RandomWalk,
    "sweep": Sweep,
    "deploy": Lloyd,
    "deploy-field": Potential,
    "gather": Gather,
    "disperse": disperse,
    "follow": Follow,
    "formation": FormationAt,
    "rotate-left": partial(Rotate, turn=1),
    "rotate-right": partial(Rotate, turn=-1),
    "split": split,
    "merge": Merge,
    "patrol": Patrol,
    "leader": Leader,
    "come": come,
}
"""Every behaviour but ``stop``: adding one is one file, and one line here."""

BEHAVIOURS = (STOP, *MAKERS)

IN_ZONES: dict[str, Callable[[Stage, Mapping[str, RobotState], tuple[Vec2, ...]], Behaviour]] = {
    "sweep": Sweep,
    "deploy": Lloyd,
}
"""Behaviours that can be told which part of the sheet they are for."""

POINTED = ("follow", "leader")
"""Behaviours that the arm steers all the time: they end when it is known no longer where it points."""

DICTIONARY: dict[str, str] = {
    "stop": STOP,
    "mixing": "random-walk",
    "breaststroke": "sweep",
    "raise_both": "gather",
    "arms_to_ground": "disperse",
    "x_left_high": "rotate-left",
    "x_right_high": "rotate-right",
}
"""Gesture -> behaviour, where a room does not say otherwise."""


def behaviour_name(text: str) -> str:
    """The name of a behaviour, however its words are joined.

    Raises:
        ConfigError: there is no such behaviour; those that exist are told.

    """
    name = text.strip().lower().replace(" ", "-").replace("_", "-")
    if name not in BEHAVIOURS:
        raise ConfigError(known_names("behaviour", text, BEHAVIOURS))
    return name


def order_name(text: str) -> str:
    """A behaviour, and after an ``@`` the zone that it is for, in the words that are compared.

    Raises:
        ConfigError: there is no such behaviour, or it knows no zones.

    """
    asked, at, zone = text.partition("@")
    name = behaviour_name(asked)
    if at and name not in IN_ZONES:
        raise ConfigError(f"{text!r}: {name} knows no zones; {' and '.join(IN_ZONES)} do")
    return f"{name}@{zone.strip()}" if at else name


@dataclass(slots=True)
class Running:
    """A behaviour that goes on, and the robots that take part; ``order`` names the zone too that it is for."""

    order: str
    robots: set[str]
    behaviour: Behaviour

    @property
    def name(self) -> str:
        """The behaviour alone."""
        return self.order.partition("@")[0]


class Director:
    """Runs behaviours side by side; every robot takes part in one at most."""

    def __init__(self, limits: Limits, sheet: Sheet, zones: tuple[Zone, ...], rng: np.random.Generator) -> None:
        self.zones = zones
        self._stage: Callable[[Vec2 | None], Stage] = lambda user: Stage(
            sheet, limits, rng.spawn(1)[0], self.zones, user
        )
        self.running: list[Running] = []

    @property
    def busy(self) -> set[str]:
        """The robots that take part in anything."""
        return {robot for running in self.running for robot in running.robots}

    def begin(self, order: str, states: Mapping[str, RobotState], user: Vec2 | None = None) -> None:
        """Begin what `order_name` knows with the robots of ``states``; they leave what they did before.

        Raises:
            ConfigError: there is no such behaviour, or it cannot be done with these robots here.

        """
        order = order_name(order)
        name = order.partition("@")[0]
        behaviour = self._made(order, states, user) if name != STOP else None
        self.leave(states)
        if behaviour is not None and states:
            self.running.append(Running(order, set(states), behaviour))

    def _made(self, order: str, states: Mapping[str, RobotState], user: Vec2 | None) -> Behaviour:
        stage = self._stage(user)
        name, at, zone = order.partition("@")
        if not at:
            return MAKERS[name](stage, states)
        polygons = {known.name: known.polygon for known in stage.zones}
        if zone not in polygons:
            raise ConfigError(known_names("zone", zone, polygons))
        return IN_ZONES[name](stage, states, polygons[zone])

    def leave(self, robots: Collection[str]) -> None:
        """These robots take part in nothing any more."""
        for running in self.running:
            running.robots -= set(robots)
        self.running = [running for running in self.running if running.robots]

    def cancel(self) -> None:
        """End everything."""
        self.running.clear()

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[GoTo | Drive]:
        """The wishes of all robots at ``t`` [s]; ``states`` are of those that can drive now.

        Robots whose behaviour is done hold their places as long as others go on.
        """
        wishes: list[GoTo | Drive] = []
        for running in self.running:
            taking_part = {robot: state for robot, state in states.items() if robot in running.robots}
            wishes.extend(wish for wish in running.behaviour.step(t, taking_part, pointed) if wish.robot in taking_part)
        if all(running.behaviour.done for running in self.running):
            self.running.clear()
        return wishes
