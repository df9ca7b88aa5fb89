"""A log as a device: its events come again, in the order in which they arrived."""

from collections.abc import AsyncGenerator, Iterable

from armspan.ports import Pace
from armspan.records import EVENTS, Command, Event, Record


async def source(records: Iterable[Record], pace: Pace, seconds: float | None = None) -> AsyncGenerator[Event, None]:
    """The events among records, up to ``seconds``; what was decided then is left out, to be decided anew."""
    for record in records:
        if isinstance(record, EVENTS) and (seconds is None or record.t <= seconds):
            await pace(record.t)
            yield record  # type: ignore[misc]


class NoSwarm:
    """Robots that are only remembered: commands go nowhere."""

    async def send(self, command: Command) -> None:
        """Take a command and do nothing."""
