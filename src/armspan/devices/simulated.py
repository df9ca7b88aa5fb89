"""The virtual world as a device: its events come in like any other's, its robots take commands like any other's."""

from collections.abc import AsyncGenerator
from typing import Protocol

from armspan.ports import Pace
from armspan.records import Command, Event, Record

STEP = 0.05
"""Seconds of world between two waits: the interval of a tick."""


class World(Protocol):
    """A world that can be let run, and that takes what was decided."""

    @property
    def ended(self) -> bool:
        """Whether nothing more will happen."""

    def advance(self, t: float) -> list[Event]:
        """Everything that arrives up to session time ``t`` [s], in order of arrival."""

    def take(self, record: Record) -> None:
        """Hear a record: a command for a robot, words for the person."""


async def source(world: World, pace: Pace, seconds: float | None = None) -> AsyncGenerator[Event, None]:
    """The world's events until it ends, or until ``seconds`` have passed."""
    steps = 0
    while not world.ended and (seconds is None or steps * STEP < seconds - 1e-9):
        steps += 1
        t = steps * STEP
        await pace(t)
        for event in world.advance(t):
            yield event
    await pace((steps + 1) * STEP)


class SimulatedSwarm:
    """The virtual robots' door for commands."""

    def __init__(self, world: World) -> None:
        self._world = world

    async def send(self, command: Command) -> None:
        """Take a command; it reaches its robot after the virtual radio's latency."""
        self._world.take(command)
