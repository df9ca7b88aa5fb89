"""Doors that listen: who may come in, how much they may carry, and a small server behind them.

A door binds to this machine alone unless a token or a list of addresses is set. Strangers are answered 403 and
counted, and so is a page of somebody else's that a browser on this machine was lured to; what is too large is
answered 413, what cannot be read 400 with one sentence.
"""

import asyncio
import errno
import hmac
import ipaddress
import re
import secrets
import ssl
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from armspan.errors import ConfigError, DeviceError, MissingExtra

if TYPE_CHECKING:
    from aiohttp import web

LARGEST_BODY = 1 << 20
"""Bytes of a request: ten seconds of a phone with all its sensors."""

TOKEN = re.compile(r"[A-Za-z0-9_-]{8,64}")
CLOSE_S = 0.1
"""Seconds for which what is still being answered is waited for at the end."""
_TAKEN = {errno.EADDRINUSE: "is taken by another program", errno.EACCES: "needs rights that this program has not"}


@dataclass(slots=True)
class Guard:
    """Who may use a door: those with the ``token``, and those whose address is in ``allow`` where there are any.

    ``allow`` are addresses or networks. A door with neither is for this machine alone.

    Raises:
        ConfigError: for a token that cannot stand in a URL, and for what is no address.

    """

    token: str | None = None
    allow: Iterable[str] = ()
    refused: int = 0
    too_large: int = 0
    malformed: int = 0
    _networks: list[ipaddress.IPv4Network | ipaddress.IPv6Network] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.token is not None and not TOKEN.fullmatch(self.token):
            such = secrets.token_urlsafe(9)
            raise ConfigError(f"token is {self.token!r}; expected 8 to 64 letters, digits, - or _, such as {such!r}")
        self._networks = [_network(text) for text in self.allow]

    @property
    def open(self) -> bool:
        """Whether others than this machine may come in at all."""
        return self.token is not None or bool(self._networks)

    def check(self, host: str) -> None:
        """Refuse to listen where strangers are, unless something keeps them out.

        Raises:
            ConfigError: for a ``host`` that is not this machine alone, where neither token nor addresses are set.

        """
        if not self.open and not is_loopback(host):
            raise ConfigError(
                f"listening on {host} would let anybody on the network in; add token = {secrets.token_urlsafe(9)!r} or "
                'allow = ["the address of the device"], or listen on 127.0.0.1'
            )

    def admits(self, address: str | None, token: str | None, host: str | None, origin: str | None = None) -> bool:
        """Whether a request may come in.

        ``address`` is the sender's, ``host`` and ``origin`` are what the headers of these names say.
        """
        if origin is not None and origin.partition("//")[2].lower() != (host or "").lower():
            return False  # a page of somebody else's
        if not self.open and not is_loopback(_without_port(host or "")):
            return False  # a name of somebody else's that was made to mean this machine
        if self._networks and not self._knows(address):
            return False
        return self.token is None or hmac.compare_digest(self.token.encode(), (token or "").encode(errors="replace"))

    def _knows(self, address: str | None) -> bool:
        try:
            here = ipaddress.ip_address((address or "").partition("%")[0])
        except ValueError:
            return False
        mapped = getattr(here, "ipv4_mapped", None) or here
        return any(mapped in network for network in self._networks)


def _without_port(host: str) -> str:
    return host if host.endswith("]") or ":" not in host else host.rpartition(":")[0]


def is_loopback(host: str) -> bool:
    """Whether a host is this machine and nobody else."""
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def _network(text: str) -> ipaddress.IPv4Network | ipaddress.IPv6Network:
    try:
        return ipaddress.ip_network(text, strict=False)
    except ValueError:
        raise ConfigError(
            f"allow holds {text!r}; expected an address such as '192.168.1.23' or a network such as '192.168.1.0/24'"
        ) from None


def host_and_port(text: str) -> tuple[str, int]:
    """The two halves of ``HOST:PORT``; an IPv6 host stands in brackets.

    Raises:
        ConfigError: for what is not of this form.

    """
    host, colon, port = text.rpartition(":")
    inside = host[1:-1] if host.startswith("[") and host.endswith("]") else host
    right = bool(colon and inside and port.isascii() and port.isdigit() and int(port) <= 65535)
    if not right or (":" in inside) != (inside != host):
        raise ConfigError(f"listen is {text!r}; expected HOST:PORT such as '127.0.0.1:8443' or '0.0.0.0:8443'")
    return inside, int(port)


class Route(NamedTuple):
    """What a door answers to a ``method`` at a ``path``: a DeviceError of the answer's becomes a 400."""

    method: str
    path: str
    answer: "Callable[[web.Request], Awaitable[web.StreamResponse]]"


def posting(path: str, take: Callable[[bytes], None]) -> Route:
    """A route whose bodies are handed over as they come; a DeviceError becomes a 400 with its sentence."""

    async def answer(request: "web.Request") -> "web.StreamResponse":
        from aiohttp import web

        take(await request.read())
        return web.Response(text="ok\n")

    return Route("POST", path, answer)


@asynccontextmanager
async def serving(
    routes: Sequence[Route],
    host: str,
    port: int,
    guard: Guard,
    tls: ssl.SSLContext | None = None,
    largest: int = LARGEST_BODY,
) -> AsyncIterator[int]:
    """A server as long as it is needed; gives the port, which is a free one where ``port`` is 0.

    ``largest`` is the size of the largest body that is read [bytes].

    Raises:
        ConfigError: where the guard does not suffer this host.
        DeviceError: where the port cannot be had.
        MissingExtra: without aiohttp.

    """
    guard.check(host)
    try:
        from aiohttp import web
    except ImportError:
        raise MissingExtra("aiohttp", "phone") from None
    doors = web.Application(client_max_size=largest, middlewares=[_middleware(guard)])
    for route in routes:
        doors.router.add_route(route.method, route.path, route.answer)
    runner = web.AppRunner(doors, access_log=None, shutdown_timeout=CLOSE_S, handle_signals=False)
    await runner.setup()
    try:
        site = web.TCPSite(runner, host, port, ssl_context=tls)
        try:
            await site.start()
        except OSError as error:
            raise DeviceError(_unheard(host, port, error)) from None
        yield int(runner.addresses[0][1])
    finally:
        await runner.cleanup()


def _unheard(host: str, port: int, error: OSError) -> str:
    why = _TAKEN.get(error.errno or 0, f"cannot be had ({error.strerror})")
    if error.errno == errno.EADDRNOTAVAIL or error.errno is None or error.errno < 0:
        return f"{host} is no address of this machine; listen on 127.0.0.1, or on 0.0.0.0 for all of its addresses"
    return f"port {port} of {host} {why}; end what uses it, or choose another port above 1023"


def _middleware(guard: Guard) -> "Callable[..., Awaitable[web.StreamResponse]]":
    from aiohttp import web

    @web.middleware
    async def admit(
        request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        if not guard.admits(request.remote, told_token(request), request.host, request.headers.get("Origin")):
            guard.refused += 1
            return web.Response(status=403, text="this door is closed: the token or the address is not the right one\n")
        try:
            return await handler(request)
        except web.HTTPRequestEntityTooLarge:
            guard.too_large += 1
            raise
        except DeviceError as error:
            guard.malformed += 1
            return web.Response(status=400, text=f"{error}\n")
        except (asyncio.IncompleteReadError, ConnectionError):
            guard.malformed += 1
            return web.Response(status=400, text="the request ended too early\n")

    return admit


def told_token(request: "web.Request") -> str | None:
    """The token that a request brings: ``?token=``, or ``Authorization`` with or without ``Bearer``."""
    header = request.headers.get("Authorization", "")
    return request.query.get("token") or header.removeprefix("Bearer ").strip() or None
