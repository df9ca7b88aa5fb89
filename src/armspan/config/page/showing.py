"""A log shown again: its frames come from a process of its own."""

import asyncio
import sys
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager

import msgspec

from armspan.config.page.filming import Trouble
from armspan.errors import LogError
from armspan.web.film import RATE_HZ, Film, Opening
from armspan.web.shown import Shown


async def opening(process: Process, name: str) -> Opening:
    """What a process says first (LogError where the log cannot be read)."""
    first = await _next(process)
    if first is None:
        raise LogError(f"{name} cannot be shown: the process that reads it ended")
    if why := trouble_of(first):
        raise LogError(why)
    return msgspec.json.decode(first, type=Opening)


async def shown_again(film: Film, process: Process, shown: Shown) -> None:
    """Show a log until cancelled; its frames come from ``process``."""
    film.base = shown.room_number
    shown.film = film
    film.play(True)
    moving = asyncio.create_task(_move(film, lambda: _refresh(shown)))
    try:
        await _fill(film, process, shown)
        await moving
    finally:
        moving.cancel()
        shown.film = None


async def _fill(film: Film, process: Process, shown: Shown) -> None:
    """Take seconds as they are made; a process that breaks off leaves what there is."""
    while (data := await _next(process)) is not None:
        if why := trouble_of(data):
            raise LogError(why)
        film.add(data)
        _refresh(shown)
    film.whole = True


async def _move(film: Film, refresh: Callable[[], None]) -> None:
    """Go on with the clock."""
    while True:
        await asyncio.sleep(1 / RATE_HZ)
        if film.move():
            refresh()


def _refresh(shown: Shown) -> None:
    shown.version += 1


@asynccontextmanager
async def working(*words: str) -> AsyncGenerator[Process, None]:
    """A process that works through a log; it ends with the block."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "armspan.config.page.filming", *words, stdin=DEVNULL, stdout=PIPE, stderr=DEVNULL
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


async def _next(process: Process) -> bytes | None:
    """The next message of a process, None at its end."""
    if process.stdout is None:
        return None
    try:
        length = int.from_bytes(await process.stdout.readexactly(4), "little")
        return await process.stdout.readexactly(length)
    except asyncio.IncompleteReadError:
        return None


def trouble_of(data: bytes) -> str:
    """What a message says went wrong, nothing where it is another one."""
    if not data.startswith(b"{"):
        return ""
    try:
        return msgspec.json.decode(data, type=Trouble).trouble
    except msgspec.DecodeError:
        return ""
