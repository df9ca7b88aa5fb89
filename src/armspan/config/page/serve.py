"""The page opened: a room behind it, a door before it."""

import asyncio
import secrets
import socket
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


def own_address(host: str) -> str:
    """This machine's address in its network; ``host`` where it has none."""
    family, far = (socket.AF_INET6, "2001:db8::1") if ":" in host else (socket.AF_INET, "192.0.2.1")
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((far, 9))  # nothing is sent: it only asks which way such a packet would take
            return str(probe.getsockname()[0])
        except OSError:
            return host


def address(host: str, port: int, token: str | None) -> str:
    """The address to open in a browser, from another device where the page is served everywhere."""
    told = own_address(host) if host in ("0.0.0.0", "::") else host
    name = f"[{told}]" if ":" in told else told
    return f"http://{name}:{port}/" + (f"?token={token}" if token else "")
