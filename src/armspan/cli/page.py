"""The page from the command line: opened, told of, closed by Ctrl-C with the robots stopped."""

import asyncio
import sys
import webbrowser
from pathlib import Path

from armspan.cli.play import stop_on_signals
from armspan.config.demo_room import page_room
from armspan.config.room_file import read_room
from armspan.devices.phone.joining import join_text


def open_page(room: Path | None, host: str, port: int, *, speed: float = 1.0, browser: bool = True) -> int:
    """Serve a room's page until Ctrl-C; without a room file a simulated one.

    Raises:
        ConfigError: the room file, or the address, cannot be had.
        KeyboardInterrupt: after Ctrl-C or SIGTERM, when all is closed.

    """
    read, name = (page_room(1), "simulated room") if room is None else (read_room(room), room.stem)
    folder = room.parent if room is not None else Path()

    def opened(address: str) -> None:
        shown = join_text(address) if "token=" in address and sys.stdout.isatty() else address
        print(shown, flush=True)
        print("The page is open; Ctrl-C stops the robots and ends it", file=sys.stderr)
        if browser and sys.stdout.isatty():
            webbrowser.open(address)

    async def serve() -> None:
        from armspan.config.page.serve import serve_page  # NiceGUI takes a second to load

        task = asyncio.ensure_future(
            serve_page(
                read,
                name,
                folder=folder,
                host=host,
                port=port,
                sessions=Path("sessions"),
                speed=speed,
                opened=opened,
            )
        )
        stop_on_signals(task)
        try:
            await task
        except asyncio.CancelledError:
            raise KeyboardInterrupt from None

    asyncio.run(serve())
    return 0
