"""The doors at which phones come in: Sensor Logger's pushes, and our page with its WebSocket."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TYPE_CHECKING

from armspan.devices.phone.browser import LARGEST, Browser
from armspan.devices.phone.entry import PhoneEntry
from armspan.devices.phone.sensor_logger import Message, SensorLogger, message_from_bytes
from armspan.errors import DeviceError, known_names
from armspan.links.http import Route, posting
from armspan.records import Event, Press

if TYPE_CHECKING:
    from aiohttp import web

ANSWER_S = 0.5
"""Seconds between two answers to the page, which shows them."""
BEAT_S = 5.0
STRANGERS = 16
TAKEN = 4000
"""Code with which a page's line is closed where another page took over."""
REFUSED = 1008
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self' wss:; img-src data:"
)

Tell = Callable[[list[Event]], None]


@dataclass(slots=True)
class LoggerDoor:
    """Sensor Logger's pushes, for the bands that wait for them.

    A band without a deviceId keeps to the first phone that pushes, until that has been silent. ``strangers`` are the
    devices that nobody waits for.
    """

    bands: Sequence[tuple[PhoneEntry, SensorLogger]]
    now: Callable[[], float]
    tell: Tell
    strangers: dict[str, int] = field(default_factory=dict)
    _kept: dict[str, str] = field(default_factory=dict)

    def routes(self) -> list[Route]:
        """Whatever path was typed into the app."""
        return [posting("/{path:.*}", self.push)]

    def push(self, data: bytes) -> None:
        """Take a push (DeviceError where it cannot be read, or is from a device that nobody waits for)."""
        try:
            message = message_from_bytes(data)
        except DeviceError:
            for _, logger in self.bands:
                logger.band.counters.malformed += 1
            raise
        if not message.payload:
            return  # the app's own test of the line
        wanted = [logger for entry, logger in self.bands if self._waits(entry, logger, message)]
        if not wanted:
            raise DeviceError(self._stranger(message.device))
        for logger in wanted:
            try:
                self.tell(logger.take(message, self.now()))
            except DeviceError:
                logger.band.counters.malformed += 1
                raise

    def _waits(self, entry: PhoneEntry, logger: SensorLogger, message: Message) -> bool:
        if entry.device is not None:
            return entry.device == message.device
        if any(other.device == message.device for other, _ in self.bands):
            return False
        if not logger.band.up:
            self._kept[entry.name] = message.device
        return self._kept.get(entry.name) == message.device

    def _stranger(self, device: str) -> str:
        if device in self.strangers or len(self.strangers) < STRANGERS:
            self.strangers[device] = self.strangers.get(device, 0) + 1
        return f"no band of the room waits for the device {device!r}; set device = {device!r} for one of them"


@dataclass(slots=True)
class PageDoor:
    """Our page, and the two ways in which it speaks: a WebSocket, or posts where a browser refuses that.

    Safari opens no WebSocket to a certificate that nobody vouches for, whatever its user said of the page (WebKit bug
    145819). The latest page of a band is the one that counts; one that was displaced is told so.
    """

    bands: dict[str, Browser]
    now: Callable[[], float]
    tell: Tell
    _owners: dict[str, str] = field(default_factory=dict)
    _displaced: deque[str] = field(default_factory=lambda: deque(maxlen=STRANGERS))
    _lines: "dict[str, web.WebSocketResponse]" = field(default_factory=dict)

    def routes(self) -> list[Route]:
        """The page, its line, its posts, and a stop that needs neither."""
        return [
            Route("GET", "/", self.page),
            Route("GET", "/line", self.line),
            Route("POST", "/say", self.say),
            Route("POST", "/stop", self.stop),
        ]

    async def page(self, request: "web.Request") -> "web.StreamResponse":
        """The page itself (DeviceError for a band that does not exist)."""
        from aiohttp import web

        self._band(request)
        text = files(__package__).joinpath("page.html").read_text(encoding="utf-8")
        headers = {"Content-Security-Policy": _POLICY, "Cache-Control": "no-store", "Referrer-Policy": "no-referrer"}
        return web.Response(text=text, content_type="text/html", headers=headers)

    async def stop(self, request: "web.Request") -> "web.StreamResponse":
        """A stop from a page whose line is broken."""
        from aiohttp import web

        self.tell(self._band(request).feed(b'{"stop":0}', self.now()))
        return web.Response(text="stopped\n")

    async def say(self, request: "web.Request") -> "web.StreamResponse":
        """Texts in lines, a hello first (DeviceError otherwise)."""
        from aiohttp import web

        browser = self._band(request)
        texts = (await request.read()).splitlines()
        if not self._owns(browser, self._page(browser, texts[0] if texts else b"")):
            return web.json_response({"taken": True})
        answer = self._state(browser)
        for text in texts:
            answer |= self._heard(browser, text)
        return web.json_response(answer)

    async def line(self, request: "web.Request") -> "web.StreamResponse":
        """The page's line, for as long as it lasts: its texts, a hello first."""
        from aiohttp import WSMsgType, web

        browser = self._band(request)
        line = web.WebSocketResponse(heartbeat=BEAT_S, max_msg_size=LARGEST, timeout=1.0)
        await line.prepare(request)
        page: str | None = None
        due = -math.inf
        async for message in line:
            if message.type is not WSMsgType.TEXT:
                break
            text = message.data.encode()
            if page is None:
                page = self._began(browser, line, text)
            if page is None or not self._owns(browser, page):
                await line.close(code=TAKEN if page else REFUSED)
                break
            answer = self._heard(browser, text)
            if answer or self.now() >= due:
                due = self.now() + ANSWER_S
                with suppress(ConnectionError):
                    await line.send_json(self._state(browser) | answer)
        await line.close()
        self._ended(browser, line)
        return line

    def _began(self, browser: Browser, line: "web.WebSocketResponse", text: bytes) -> str | None:
        """The page that says hello on a line; nobody where it says something else."""
        with suppress(DeviceError):  # counted by the decoder
            page = self._page(browser, text)
            self._lines[browser.band.name] = line
            return page
        return None

    def _ended(self, browser: Browser, line: "web.WebSocketResponse") -> None:
        name = browser.band.name
        if self._lines.get(name) is line:
            del self._lines[name]
            self.tell(browser.band.lose(self.now()))

    def _page(self, browser: Browser, text: bytes) -> str:
        """Which page says this hello, from now on the band's own if it was not displaced before."""
        page, name = browser.hello(text).page, browser.band.name
        if page not in self._displaced:
            before = self._owners.get(name, page)
            if before != page:
                self._displaced.append(before)
            self._owners[name] = page
        return page

    def _owns(self, browser: Browser, page: str) -> bool:
        return self._owners.get(browser.band.name) == page

    def _state(self, browser: Browser) -> dict[str, object]:
        counters = browser.band.counters
        return {"band": browser.band.name, "rate": counters.rate, "lost": counters.lost}

    def _heard(self, browser: Browser, text: bytes) -> dict[str, object]:
        """Take a text; what must be answered at once."""
        try:
            events = browser.feed(text, self.now())
        except DeviceError as error:
            return {"error": str(error)}
        self.tell(events)
        return {"stopped": True} if any(isinstance(event, Press) for event in events) else {}

    def _band(self, request: "web.Request") -> Browser:
        name = request.query.get("band")
        if name is None and len(self.bands) == 1:
            return next(iter(self.bands.values()))
        if name not in self.bands:
            raise DeviceError(known_names("band", name or "", self.bands))
        return self.bands[name]
