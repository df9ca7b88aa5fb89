"""The game master's list: activities one after the other, the same in every browser."""

from collections.abc import Sequence
from typing import Literal, Protocol, TypeAlias

import msgspec

from armspan.records import Zone
from armspan.swarm.words import order_words

Turn: TypeAlias = Literal["start", "pause", "next", "previous"]


class Act(msgspec.Struct, frozen=True):
    """One activity: its name, a behaviour (with ``@`` and a zone where it is for one), and its robots, none: all."""

    name: str
    order: str
    robots: tuple[str, ...] = ()


class Agenda(msgspec.Struct, frozen=True):
    """The list, whose turn it is (``place``, from 0), whether that has begun, and the robots that are left out."""

    acts: tuple[Act, ...] = ()
    place: int = 0
    state: Literal["ready", "begun", "paused"] = "ready"
    out: tuple[str, ...] = ()
    note: str = ""


class Activities(Protocol):
    """Leads the list; what cannot be is a ConfigError, and changes nothing."""

    @property
    def agenda(self) -> Agenda:
        """The list now."""

    async def arrange(self, acts: Sequence[Act]) -> None:
        """Put another list in its place; it is kept for the next time."""

    async def lead(self, turn: Turn) -> None:
        """Begin the activity whose turn it is, let its robots rest, or go to another one and begin it."""

    async def choose(self, place: int) -> None:
        """Begin the activity at a place."""

    async def behave(self, order: str) -> None:
        """Let the robots that take part do something that is not in the list."""

    async def leave_out(self, robot: str, out: bool) -> None:
        """Let a robot take part no more (it comes to rest), or again."""

    async def rezone(self, zones: Sequence[Zone], renamed: tuple[str, str] | None = None) -> None:
        """Change the room's zones; activities for a ``renamed`` (old, new) zone are for the new name."""


def in_words(order: str) -> str:
    """A behaviour, and the zone that it is for, as an activity's name."""
    words = order_words(order)
    return words[:1].upper() + words[1:]
