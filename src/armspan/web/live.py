"""The live line to a browser: the latest frame, and never more than it can draw."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass, field

from fastapi import WebSocket, WebSocketDisconnect

from armspan.web.shown import Shown, encode

RATE_HZ = 50.0
"""Frames a second at most."""

IN_FLIGHT = 2
"""Frames that a browser may have and not have drawn yet; the next one waits, and is the latest when it goes."""

ALIVE = 0.4
"""Seconds after which a frame goes out although nothing changed: the browser takes a silent line to be lost."""


@dataclass(slots=True, eq=False)
class Viewer:
    """One browser's line: frames sent and drawn, bytes sent, the number of the frame it got last."""

    sent: int = 0
    drawn: int = 0
    bytes_sent: int = 0
    room: int = -1
    made: int = 0
    wake: asyncio.Event = field(default_factory=asyncio.Event)


class Live:
    """Sends what ``shown`` holds to every browser that is connected.

    A frame is made once for all browsers, and only while one is connected; a slow one misses frames and never holds
    the others up. The text ``stop`` from any browser calls ``stop``; any other text says that one frame was drawn.
    """

    def __init__(self, shown: Shown, stop: Callable[[], Awaitable[None]]) -> None:
        self.shown, self._stop = shown, stop
        self.viewers: set[Viewer] = set()
        self.made = 0
        self._frame = self._room = b""
        self._version = self._room_number = -1
        self._ticking: asyncio.Task[None] | None = None

    async def serve(self, line: WebSocket) -> None:
        """Talk to one browser until it goes."""
        await line.accept()
        viewer = Viewer()
        self.viewers.add(viewer)
        if self._ticking is None:
            self._ticking = asyncio.create_task(self._tick())
        sending = asyncio.create_task(self._send(line, viewer))
        try:
            while True:
                await self._hear(await line.receive_text(), viewer)
        except (WebSocketDisconnect, RuntimeError):  # it went
            pass
        finally:
            sending.cancel()
            self.viewers.discard(viewer)
            if not self.viewers and self._ticking is not None:
                self._ticking.cancel()
                self._ticking = None

    async def _hear(self, text: str, viewer: Viewer) -> None:
        if text == "stop":
            await self._stop()
            return
        viewer.drawn = min(viewer.drawn + 1, viewer.sent)
        viewer.wake.set()

    async def _tick(self) -> None:
        """Make the frames, at most so many a second."""
        loop = asyncio.get_running_loop()
        due, last = loop.time(), -ALIVE
        while True:
            now = loop.time()
            if self._version != self.shown.version or now - last >= ALIVE:
                last = now
                self.make()
                for viewer in self.viewers:
                    viewer.wake.set()
            due = max(due + 1 / RATE_HZ, loop.time())
            await asyncio.sleep(due - loop.time())

    def make(self) -> None:
        """Make the latest frame, and the room message where the room is another one."""
        self._version = self.shown.version
        self._frame = encode(self.shown.frame())
        self.made += 1
        if self._room_number != self.shown.room_number:
            self._room_number = self.shown.room_number
            self._room = encode({"room": self.shown.room()})

    async def _send(self, line: WebSocket, viewer: Viewer) -> None:
        with suppress(WebSocketDisconnect, RuntimeError):  # it went while something was on its way to it
            await self._send_latest(line, viewer)

    async def _send_latest(self, line: WebSocket, viewer: Viewer) -> None:
        while True:
            await viewer.wake.wait()
            viewer.wake.clear()
            if viewer.made == self.made or viewer.sent - viewer.drawn >= IN_FLIGHT:
                continue
            viewer.made = self.made
            if viewer.room != self._room_number:
                viewer.room = self._room_number
                viewer.bytes_sent += len(self._room)
                await line.send_bytes(self._room)
            frame = self._frame
            viewer.sent += 1
            viewer.bytes_sent += len(frame)
            await line.send_bytes(frame)
