"""A page of ours served in this process, and viewers in others, for a while."""

import asyncio
import json
import signal
import sys
import time
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

from nicegui import ui

from armspan.web import layout
from armspan.web.desk import Desk, Office
from armspan.web.host import Host
from armspan.web.live import Live
from armspan.web.lively import Lively
from armspan.web.server import application, bound, served
from armspan.web.shown import Shown

VIEWERS = Path(__file__).with_name("viewers.py")
NOBODY = ("nobody",)


@dataclass(frozen=True, slots=True)
class Watched:
    """One span: the process's CPU share, frames made a second, and a viewer's frames, drawn, bytes a second (mean)."""

    cpu: float
    made: float
    received: float
    drawn: float
    size: float


def _all(_: Desk) -> None:
    """Whatever moves, on one page."""
    with ui.element("div").classes("side"):
        Lively("space", "The scene").classes("panel tall")
        Lively("plan", "The sheet").classes("panel tall")
        Lively("strips", "The signals").classes("panel tall")


def _flat(_: Desk) -> None:
    """What is drawn without a graphics card."""
    with ui.element("div").classes("side"):
        Lively("plan", "The sheet").classes("panel tall")
        Lively("strips", "The signals").classes("panel tall")


@asynccontextmanager
async def page(host: Host, shown: Shown, stop: Callable[[], Awaitable[None]]) -> AsyncGenerator[tuple[Live, str], None]:
    """The page on a free port, with two views of the benchmark's own; its live line and its address."""
    layout.VIEWS.update({"/all": ("All", _all), "/flat": ("Flat", _flat)})
    taken = bound("127.0.0.1", 0)
    live = Live(shown, stop)
    async with served(application(Office(host, shown), live, None), taken):
        yield live, f"http://127.0.0.1:{taken.getsockname()[1]}/"


async def watch(live: Live, address: str, viewers: tuple[str, ...], seconds: float) -> Watched:
    """Let viewers (the words of ``viewers.py``, or `NOBODY`) look for so long, and measure this process meanwhile."""
    process = None
    if viewers != NOBODY:
        process = await asyncio.create_subprocess_exec(
            sys.executable, VIEWERS, viewers[0], address, *viewers[1:], stdout=asyncio.subprocess.PIPE
        )
        assert process.stdout is not None
        await asyncio.wait_for(process.stdout.readline(), 60)
    await asyncio.sleep(1)
    began, cpu, made = time.monotonic(), time.process_time(), live.made
    await asyncio.sleep(seconds)
    took, cpu, made = time.monotonic() - began, time.process_time() - cpu, live.made - made
    told: list[list[float]] = []
    if process is not None:
        process.send_signal(signal.SIGINT)
        out, _ = await process.communicate()
        told = [json.loads(line) for line in out.splitlines()]
    received, drawn, size = (sum(column) / len(told) for column in zip(*told, strict=True)) if told else (0.0, 0.0, 0.0)
    return Watched(cpu / took, made / took, received, drawn, size)
