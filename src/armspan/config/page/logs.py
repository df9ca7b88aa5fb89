"""The folder of sessions behind the page: listed without reading every record, and one log shown again."""

import asyncio
import tempfile
from contextlib import AsyncExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from armspan.config.page.log_facts import looked_into, named, short
from armspan.config.page.showing import opening, shown_again, trouble_of, working
from armspan.errors import LogError, known_names
from armspan.log import recover
from armspan.web.film import Film
from armspan.web.sessions import SessionLog

if TYPE_CHECKING:
    from armspan.config.page.host import PageHost


class LogShelf:
    """The logs of one folder; what was found in a file holds until it changes."""

    def __init__(self, page: "PageHost") -> None:
        self._page, self.folder = page, page.sessions
        self._known: dict[tuple[str, int, int], SessionLog] = {}
        self._tables: tempfile.TemporaryDirectory[str] | None = None

    async def listed(self) -> list[SessionLog]:
        """Every log, the latest first."""
        return await asyncio.to_thread(self.look, self._open())

    def look(self, open_log: str = "") -> list[SessionLog]:
        """Every log, the latest first; the one that is being written is not read."""
        found = {}
        for path in self.folder.glob("*.mcap"):
            try:
                facts = path.stat()
            except OSError:  # gone meanwhile
                continue
            key = (path.name, facts.st_mtime_ns, facts.st_size)
            if path.name == open_log:
                found[key] = msgspec.structs.replace(named(path, facts.st_mtime, facts.st_size), open=True)
            else:
                found[key] = self._known.get(key) or looked_into(path)
        self._known = {key: log for key, log in found.items() if not log.open}
        return sorted(found.values(), key=lambda log: (log.began, log.name), reverse=True)

    def path(self, name: str) -> Path:
        """Where a log lies (LogError where there is none of that name)."""
        there = sorted(path.name for path in self.folder.glob("*.mcap"))
        if name not in there:
            raise LogError(known_names("log", name, there))
        return self.folder / name

    async def replay(self, name: str) -> None:
        """End what runs and show a log."""
        path = self.path(name)
        if name == self._open():
            raise LogError(f"{name} is being written: it can be shown when its session has ended")

        begun = self._page.begun
        stack = AsyncExitStack()
        process = await stack.enter_async_context(working("frames", str(path)))
        try:
            film = Film(await opening(process, name))
        except LogError as error:  # what runs goes on
            await stack.aclose()
            why = short(str(error), path)
            self._mark(path, why)
            raise LogError(why) from None
        if self._page.begun != begun:
            await stack.aclose()
            raise LogError(f"{name} is not shown: something else was opened while it was read")

        async def show() -> None:
            self._page.tell(log=str(path), simulated=film.opening.simulated)
            async with stack:
                await shown_again(film, process, self._page.shown)

        await self._page.begin("replaying", show)

    async def tables(self, name: str) -> Path:
        """A ZIP file of a log's tables; it is made anew where the log has changed."""
        path = self.path(name)
        if self._tables is None:
            self._tables = tempfile.TemporaryDirectory(prefix="armspan-tables-")
        target = Path(self._tables.name) / f"{path.stem}_{path.stat().st_mtime_ns}.zip"
        if not target.exists():
            half = target.with_suffix(".half")
            async with working("tables", str(path), str(half)) as process:
                said = await process.stdout.read() if process.stdout is not None else b""
                code = await process.wait()
            if said or code:
                raise LogError(short(trouble_of(said[4:]), path) or f"{name}: its tables could not be made")
            half.rename(target)
        return target

    def close(self) -> None:
        """Delete the tables that were made."""
        if self._tables is not None:
            self._tables.cleanup()
            self._tables = None

    async def save(self, name: str) -> str:
        """Save what is whole in a damaged log as a new one, whose name is returned."""
        path = self.path(name)
        target = path.with_name(f"{path.stem}_recovered.mcap")
        await asyncio.to_thread(recover, path, target)
        return target.name

    def _mark(self, path: Path, why: str) -> None:
        """Remember that a log which looked whole is damaged."""
        facts = path.stat()
        key = (path.name, facts.st_mtime_ns, facts.st_size)
        if key in self._known:
            self._known[key] = msgspec.structs.replace(self._known[key], trouble=why, readable=False)

    def _open(self) -> str:
        """The name of the log that is being written."""
        return Path(self._page.status.log).name if self._page.session is not None else ""
