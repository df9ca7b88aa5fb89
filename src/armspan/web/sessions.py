"""The folder of sessions: what each log holds, and one of them shown again."""

from pathlib import Path
from typing import Protocol

import msgspec


class SessionLog(msgspec.Struct, frozen=True):
    """A log: when it began, its room, how long it lasts [s], its size [bytes], and its records counted by type.

    ``trouble`` tells why it is cut or cannot be read; one that is not ``readable`` cannot be shown again, but what is
    whole in it may be saved. One that is ``open`` is being written.
    """

    name: str
    began: str
    room: str
    size: int
    seconds: float | None = None
    counts: dict[str, int] = {}
    trouble: str = ""
    readable: bool = True
    open: bool = False


class Sessions(Protocol):
    """The logs of a room; they are named by their files' names."""

    async def listed(self) -> list[SessionLog]:
        """Every log, the latest first."""

    def path(self, name: str) -> Path:
        """Where a log lies (LogError where there is none of that name)."""

    async def replay(self, name: str) -> None:
        """End what runs (the robots are stopped) and show a log.

        Raises:
            LogError: no such log, or one that is being written.

        """

    async def tables(self, name: str) -> Path:
        """A ZIP file of a log's tables (LogError where it cannot be read)."""

    async def save(self, name: str) -> str:
        """Save what is whole in a damaged log as a new one, whose name is returned (LogError)."""
