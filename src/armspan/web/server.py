"""The page's own server, in the session's loop."""

import asyncio
import gc
import socket
from collections.abc import AsyncGenerator, Iterator
from contextlib import asynccontextmanager, contextmanager

import uvicorn
from fastapi import FastAPI, WebSocket
from nicegui import ui

from armspan.errors import ConfigError
from armspan.web.desk import Office
from armspan.web.guard import Guard
from armspan.web.layout import root
from armspan.web.live import Live


class _Quiet(uvicorn.Server):
    """A server that leaves Ctrl-C to the session, which stops the robots first."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


def bound(host: str, port: int) -> socket.socket:
    """A socket at an address.

    Raises:
        ConfigError: somebody else sits there, or there is no such address.

    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    taken = socket.socket(family, socket.SOCK_STREAM)
    try:
        taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        taken.bind((host, port))
    except (OSError, OverflowError) as error:
        taken.close()
        why = getattr(error, "strerror", None) or str(error)
        raise ConfigError(
            f"the page cannot be served at {host}:{port} ({why}): name another --port, 0 for any that is free"
        ) from None
    return taken


def application(office: Office, live: Live, token: str | None) -> FastAPI:
    """The page as an ASGI application."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    app.add_middleware(Guard, token=token)

    @app.websocket("/live")
    async def lively(line: WebSocket) -> None:
        await live.serve(line)

    ui.run_with(
        app,
        root=lambda: root(office),
        title="Armspan",
        tailwind=False,
        show_welcome_message=False,
        reconnect_timeout=10.0,
    )
    return app


@asynccontextmanager
async def served(app: FastAPI, taken: socket.socket) -> AsyncGenerator[None, None]:
    """Serve an application on a bound socket for as long as the block lasts."""
    config = uvicorn.Config(
        app,
        log_level="error",
        access_log=False,
        ws_per_message_deflate=False,
        lifespan="on",
        timeout_graceful_shutdown=1,
    )
    server = _Quiet(config)
    serving = asyncio.create_task(server.serve([taken]))
    try:
        while not server.started and not serving.done():
            await asyncio.sleep(0.02)
        gc.collect()
        gc.freeze()  # or the collector goes through all that was loaded, again and again, and holds the loop up
        yield
    finally:
        server.should_exit = True
        await serving
        taken.close()
