"""A behaviour's run played: a mind for robots alone, watched, behind the doors of a plant or of real robots."""

import asyncio
import math
from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import aclosing

import numpy as np

from armspan.conductor.robots_only import RobotsOnly
from armspan.config.doors import Doors
from armspan.config.fleet import Fleet
from armspan.config.swarm_run import DISC, RADIO, SwarmRun
from armspan.devices import simulated
from armspan.devices.cellulo.driver import CelluloRelay
from armspan.errors import ConfigError, DeviceNotFound
from armspan.ports import Sink, Source
from armspan.records import Event, Output, Press, Record, RobotState, Say, Tick, Vec2
from armspan.session import FastPace, Session, ticks
from armspan.simulation.bodies import Plant
from armspan.simulation.discs import IdealDiscs
from armspan.simulation.robots import VirtualRobots
from armspan.simulation.script import Script
from armspan.simulation.world import World

HEARD = 10.0
"""Seconds within which all robots must be heard."""


class Act:
    """A run's mind, watched: the presses that begin it, the wishes for its account, when it was done.

    ``began`` [s] is when the behaviour was asked for, ``finished`` [s] when it had nothing left to do.
    """

    def __init__(self, run: SwarmRun) -> None:
        self.run, self.account = run, run.account()
        self.mind = RobotsOnly(run.settings)
        self.states: dict[str, RobotState] = {}
        self.began: float | None = None
        self.finished: float | None = None
        self._spot: Vec2 | None = None
        self._asked = False

    @property
    def missing(self) -> list[str]:
        """The robots that nothing was heard of yet."""
        return [robot for robot in self.run.settings.robots if robot not in self.states]

    def step(self, event: Event) -> list[Output]:
        """Everything that follows from one event.

        Raises:
            ConfigError: where the behaviour cannot be begun.

        """
        outputs = self.mind.step(event)
        if isinstance(event, RobotState):
            self.states[event.robot] = event
        elif isinstance(event, Tick):
            self._watch(event.t)
        elif isinstance(event, Press) and event.name == "behaviour":
            self.began = event.t
            for output in outputs:
                if isinstance(output, Say) and output.cue == "trouble":
                    raise ConfigError(output.text)
        return outputs

    def _watch(self, t: float) -> None:
        steering = self.mind.steering
        self.account.want(t, steering.wishes)
        idle = self.began is not None and not steering.director.running
        if idle and not steering.filter.waiting and self.finished is None:
            self.finished = t

    def presses(self, t: float) -> list[Press]:
        """What is pressed at ``t`` [s]: who points where, and the behaviour once all robots were heard."""
        presses: list[Press] = []
        spot = self._pointed(t)
        if spot is not None and spot != self._spot:
            presses.append(Press(t, "point", f"{spot[0]:.6f} {spot[1]:.6f}"))
            self._spot = spot
        if not self._asked and not self.missing:
            self._asked = True
            user = self.run.wanted.user
            if user is not None:
                presses.append(Press(t, "user", f"{user[0]:.6f} {user[1]:.6f}"))
            presses.append(Press(t, "behaviour", self.run.behaviour))
        return presses

    def _pointed(self, t: float) -> Vec2 | None:
        """Where the run points at ``t``: from one spot to the next in equal times."""
        points = self.run.wanted.points
        if len(points) < 2:
            return points[0] if points else None
        since = t - self.began if self.began is not None else 0.0
        along = min(max(since, 0.0) / self.run.wanted.seconds, 1.0) * (len(points) - 1)
        number = np.arange(len(points))
        x, y = (float(np.interp(along, number, [point[axis] for point in points])) for axis in (0, 1))
        return x, y


async def _prompted(source: Source, act: Act) -> AsyncGenerator[Event, None]:
    """A source's events, and after each tick what is then pressed."""
    async with aclosing(source):
        async for event in source:
            yield event
            if isinstance(event, Tick):
                for press in act.presses(event.t):
                    yield press


# --- simulated -------------------------------------------------------------------------------------------


async def simulate(act: Act, sinks: Sequence[Sink] = ()) -> None:
    """Play a run with simulated robots, as fast as it goes; its account is of their true places."""
    run = act.run
    world = World(
        None,
        [],
        plant_of(run),
        {},
        Script((), start=math.inf),  # nobody is there to be asked for anything
        np.random.default_rng([run.wanted.seed, 3]),
        spy=act.account.take,
    )
    session = Session(act, simulated.SimulatedSwarm(world), [*sinks, act.account.hear])
    door = FastPace(session).door()
    source = simulated.source(world, door, run.wanted.seconds)
    await session.run([door.through(_prompted(source, act))])


def plant_of(run: SwarmRun) -> VirtualRobots | IdealDiscs:
    """The robots that a run is simulated with."""
    settings, added = run.settings, run.wanted.latency
    if run.wanted.plant == "disc":
        speed = settings.limits.speed_m_s
        return IdealDiscs(settings.robots, run.starts, settings.sheet, added, DISC, speed)
    plant = Plant(latency=(0.005 + added, RADIO + added))
    rng = np.random.default_rng([run.wanted.seed, 2])
    return VirtualRobots(settings.robots, run.starts, run.headings, settings.sheet, rng, plant)


# --- real robots, or emulated ones -----------------------------------------------------------------------


async def drive(act: Act, doors: Doors, now: Callable[[], float], where: str, sinks: Sequence[Sink] = ()) -> None:
    """Play a run in real time with the robots behind ``doors``; its account is of what they tell.

    ``where`` says in words where they were looked for.

    Raises:
        DeviceNotFound: where robots are not heard.

    """
    session = Session(act, Fleet(doors.commanded), [*sinks, act.account.hear, _Places(act)])
    loop = asyncio.get_running_loop()
    try:
        async with asyncio.timeout(HEARD) as patience:

            def extend(record: Record) -> None:
                if isinstance(record, Press) and record.name == "behaviour":
                    patience.reschedule(loop.time() + act.run.wanted.seconds)

            session.sinks.append(extend)
            await session.run([_prompted(ticks(now), act)], [driver.source() for driver in doors.drivers])
    except TimeoutError:
        if not patience.expired():
            raise
    if act.missing:
        silent = ", ".join(act.missing)
        raise DeviceNotFound(
            f"{silent} not heard within {HEARD:g} s {where}; see that they are on, and that these are their addresses"
        )


def behind_relay(act: Act, host: str, port: int, macs: Sequence[str], now: Callable[[], float]) -> Doors:
    """The door to Cellulo robots with these addresses, in the order of the run's (ConfigError)."""
    settings = act.run.settings
    named = dict(zip(settings.robots, macs, strict=True))
    relay = CelluloRelay(named, host, port, origin_m=settings.sheet.origin_m, now=now)
    return Doors([relay], dict.fromkeys(settings.robots, relay))


class _Places:
    """A sink that gives the account the robots' places as last told, at every tick from when all were heard."""

    def __init__(self, act: Act) -> None:
        self._act = act

    def __call__(self, record: Record) -> None:
        """Hear a record."""
        act = self._act
        if isinstance(record, Tick) and not act.missing:
            told = [act.states[robot] for robot in act.run.settings.robots]
            act.account.take(record.t, [(np.nan, np.nan) if state.held else state.xy for state in told])
