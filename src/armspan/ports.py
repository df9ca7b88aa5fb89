"""The shapes of doors: types only."""

from collections.abc import AsyncGenerator, Awaitable, Callable
from typing import Protocol, TypeAlias

from armspan.records import Command, Event, Record

Source: TypeAlias = AsyncGenerator[Event, None]
"""A door that lets events in: cancelling it closes it, a lost link is told with ``Link(up=False)``."""

Sink: TypeAlias = Callable[[Record], None]
"""A door that lets records out: it returns at once."""

Pace: TypeAlias = Callable[[float], Awaitable[None]]
"""Waits until session time ``t``: live sleeps, fast only lets the others catch up."""


class Swarm(Protocol):
    """The robots: the latest command of each kind wins."""

    async def send(self, command: Command) -> None:
        """Take one command; it is valid until its lease ends."""
