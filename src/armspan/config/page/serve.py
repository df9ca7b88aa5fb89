"""The page opened: a room behind it, a door before it."""

import asyncio
import secrets
from collections.abc import Callable
from pathlib import Path

from armspan.config.page.host import PageHost
from armspan.config.room_file import RoomFile
from armspan.web.desk import Office
from armspan.web.live import Live
from armspan.web.server import application, bound, served

LOOPBACK = ("127.0.0.1", "localhost", "::1")


async def serve_page(
    room: RoomFile,
    name: str,
    *,
    folder: Path,
    host: str,
    port: int,
    sessions: Path,
    speed: float,
    opened: Callable[[str], None],
) -> None:
    """Serve a room's page until cancelled; ``opened`` is told its address. The robots are stopped on every way out.

    Raises:
        ConfigError: the address cannot be had.

    """
    taken = bound(host, port)
    token = None if host in LOOPBACK else secrets.token_urlsafe(16)
    page = PageHost(room, name, folder=folder, sessions=sessions, speed=speed)
    live = Live(page.shown, lambda: page.press("stop"))
    app = application(Office(page, page.shown), live, token)
    try:
        async with served(app, taken):
            opened(address(host, taken.getsockname()[1], token))
            await page.steer()
            await asyncio.Event().wait()
    finally:
        await asyncio.shield(page.close())


def address(host: str, port: int, token: str | None) -> str:
    """The address to open in a browser."""
    name = f"[{host}]" if ":" in host else host
    return f"http://{name}:{port}/" + (f"?token={token}" if token else "")
