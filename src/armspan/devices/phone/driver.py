"""Phones and watches as a source of samples: doors that listen, phones that are asked, one stream of events."""

import asyncio
from collections.abc import AsyncGenerator, Callable, Coroutine, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, suppress
from pathlib import Path
from urllib.parse import urlencode

from armspan.devices.phone.band import Band
from armspan.devices.phone.browser import Browser
from armspan.devices.phone.doors import LoggerDoor, PageDoor
from armspan.devices.phone.entry import PhoneEntry
from armspan.devices.phone.joining import join_text
from armspan.devices.phone.sensor_logger import SensorLogger
from armspan.devices.phone.sensor_server import SENSORS, SensorServer, query
from armspan.errors import ConfigError, DeviceError, MissingExtra
from armspan.links.certificate import machine_names, server_tls
from armspan.links.http import Guard, Route, serving
from armspan.records import Event

WATCH_S = 0.1
RETRY_S = 2.0
CONNECT_S = 5.0
LARGEST_TEXT = 1 << 16
LONGEST_WAIT = 0.25
"""Seconds after which the conductor takes a band for silent."""

Decoder = Browser | SensorLogger | SensorServer


class PhoneBands:
    """Bands that are phones or watches.

    ``now`` is the session's clock [s]; ``folder`` keeps the certificate of doors for browsers,
    ``~/.armspan`` where not told.

    Raises:
        ConfigError: where two bands want the same door, or the same stream of it, in different ways.

    """

    def __init__(
        self,
        entries: Sequence[PhoneEntry],
        now: Callable[[], float] | None = None,
        folder: Path | None = None,
        *,
        retry_s: float = RETRY_S,
    ) -> None:
        _check_doors(entries)
        self._entries, self._folder, self._retry = tuple(entries), folder or Path.home() / ".armspan", retry_s
        self._given, self._began = now, 0.0
        self._decoders = {entry.name: _decoder(entry) for entry in entries}
        self._guards: dict[tuple[str, int], Guard] = {
            entry.address: entry.guard() for entry in entries if entry.app != "sensor-server"
        }
        self._ports = {address: address[1] for address in self._guards}
        self._events: asyncio.Queue[Event | None] = asyncio.Queue()
        self.strangers: dict[str, int] = {}
        """Pushes from devices that no band waits for, by their deviceId."""

    async def source(self) -> AsyncGenerator[Event, None]:
        """What the phones tell, until it is closed; a phone that went away is told, and may come back.

        Raises:
            DeviceError: where a door cannot be opened.
            MissingExtra: where a package is not installed.

        """
        self._began = asyncio.get_running_loop().time()
        async with AsyncExitStack() as stack:
            for address in self._guards:
                self._ports[address] = await stack.enter_async_context(self._open(address))
            tasks = [asyncio.create_task(work) for work in (self._watch(), *self._askers())]
            for task in tasks:
                task.add_done_callback(lambda _: self._events.put_nowait(None))
            stack.push_async_callback(_ended, tasks)
            while (event := await self._events.get()) is not None:
                yield event
            await asyncio.gather(*(task for task in tasks if task.done()))

    def urls(self) -> dict[str, str]:
        """Where each band's phone has to go, by name; with the token, for the phone's owner alone."""
        return {entry.name: self._url(entry) for entry in self._entries}

    def invitation(self) -> str:
        """What to do on each phone, in words, with a QR code where a page must be opened."""
        return "\n".join(_invitation(entry, self._url(entry)) for entry in self._entries)

    def report(self) -> dict[str, dict[str, float]]:
        """The counters of each band; ``refused`` are the requests of strangers at its door."""
        found = {}
        for entry in self._entries:
            guard = None if entry.app == "sensor-server" else self._guards[entry.address]
            found[entry.name] = self._decoders[entry.name].band.report() | {"refused": guard.refused if guard else 0}
        return found

    def advice(self) -> list[str]:
        """What a person should change, in sentences; nothing where all is well."""
        found = [
            f"a phone pushes whose deviceId is {device!r}, and no band waits for it; set device = {device!r} for one"
            for device in self.strangers
        ]
        for entry in self._entries:
            band = self._decoders[entry.name].band
            if band.counters.wait > LONGEST_WAIT and entry.app == "sensor-logger":
                found.append(
                    f"{entry.name}: samples are {band.counters.wait:.1f} s old when they come, and pointing needs "
                    f"{LONGEST_WAIT:g} s; set a shorter batch period in Sensor Logger"
                )
            if not band.upright.believes:
                found.append(
                    f"{entry.name}: the app's attitude contradicts gravity, so it is reckoned here from acceleration "
                    "and rotation; leave the app's own frames and units standard"
                )
        return found

    # --- doors that listen -----------------------------------------------------------------------------

    def _open(self, address: tuple[str, int]) -> AbstractAsyncContextManager[int]:
        here = [entry for entry in self._entries if entry.app != "sensor-server" and entry.address == address]
        page = here[0].app == "browser"
        tls = server_tls(self._folder) if page else None
        return serving(self._routes(here), *address, guard=self._guards[address], tls=tls)

    def _routes(self, here: list[PhoneEntry]) -> list[Route]:
        decoders = [(entry, self._decoders[entry.name]) for entry in here]
        pages = {entry.name: decoder for entry, decoder in decoders if isinstance(decoder, Browser)}
        if pages:
            return PageDoor(pages, self._now, self._tell).routes()
        pushes = [(entry, decoder) for entry, decoder in decoders if isinstance(decoder, SensorLogger)]
        return LoggerDoor(pushes, self._now, self._tell, self.strangers).routes()

    def _url(self, entry: PhoneEntry) -> str:
        if entry.app == "sensor-server":
            return entry.url or ""
        host = entry.address[0]
        if host in ("0.0.0.0", "::"):
            host = machine_names()[0]
        host = f"[{host}]" if ":" in host else host
        asked = {"token": entry.token} if entry.token else {}
        if entry.app == "browser":
            asked["band"] = entry.name
        scheme = "https" if entry.app == "browser" else "http"
        question = f"?{urlencode(asked)}" if asked else ""
        return f"{scheme}://{host}:{self._ports[entry.address]}/{question}"

    # --- phones that are asked -------------------------------------------------------------------------

    def _askers(self) -> list[Coroutine[object, object, None]]:
        return [
            self._ask(entry.url, decoder)
            for entry in self._entries
            for decoder in [self._decoders[entry.name]]
            if isinstance(decoder, SensorServer) and entry.url is not None
        ]

    async def _ask(self, url: str, server: SensorServer) -> None:
        """Connect, listen until the link breaks, and again; ask for less where a phone refuses."""
        try:
            import aiohttp
            from yarl import URL
        except ImportError:
            raise MissingExtra("aiohttp", "phone") from None
        asked = 0
        async with aiohttp.ClientSession() as session:
            while True:
                heard = server.band.counters.samples
                with suppress(aiohttp.ClientError, OSError, TimeoutError):
                    async with asyncio.timeout(CONNECT_S):
                        address = URL(query(url, SENSORS[asked]), encoded=True)
                        line = await session.ws_connect(address, max_msg_size=LARGEST_TEXT)
                    async with line:
                        async for message in line:
                            self._heard(server, message.data)
                    if server.band.counters.samples == heard:
                        asked = (asked + 1) % len(SENSORS)
                self._tell(server.band.lose(self._now()))
                if server.band.counters.samples > heard:
                    server.begin()
                await asyncio.sleep(self._retry)

    def _heard(self, server: SensorServer, data: object) -> None:
        with suppress(DeviceError):  # counted by the decoder
            self._tell(server.feed(data.encode() if isinstance(data, str) else b"", self._now()))

    # --- what all share --------------------------------------------------------------------------------

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(WATCH_S)
            for decoder in self._decoders.values():
                self._tell(decoder.watch(self._now()))

    def _tell(self, events: list[Event]) -> None:
        for event in events:
            self._events.put_nowait(event)

    def _now(self) -> float:
        return self._given() if self._given is not None else asyncio.get_running_loop().time() - self._began


async def _ended(tasks: Sequence["asyncio.Task[None]"]) -> None:
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


def _decoder(entry: PhoneEntry) -> Decoder:
    band = Band(entry.name, entry.rate_hz)
    match entry.app:
        case "browser":
            return Browser(band)
        case "sensor-logger":
            return SensorLogger(band, watch=entry.stream == "watch")
        case "sensor-server":
            return SensorServer(band)


def _check_doors(entries: Sequence[PhoneEntry]) -> None:
    doors: dict[tuple[str, int], PhoneEntry] = {}
    streams: dict[object, str] = {}
    for entry in entries:
        stream: object = (entry.url,)
        if entry.app != "sensor-server":
            first = doors.setdefault(entry.address, entry)
            if (first.app, first.token, first.allow) != (entry.app, entry.token, entry.allow):
                raise ConfigError(
                    f"bands {first.name!r} and {entry.name!r} both listen on {entry.listen} but differ in app, token "
                    "or allow; expected the same of both, or another port for one of them"
                )
            stream = (entry.address, entry.device, entry.stream, entry.name if entry.app == "browser" else "")
        other = streams.setdefault(stream, entry.name)
        if other != entry.name:
            raise ConfigError(
                f"bands {other!r} and {entry.name!r} are the same {entry.stream}; set device = the deviceId that the "
                "app shows for each of them, or leave one out"
            )


def _invitation(entry: PhoneEntry, url: str) -> str:
    if entry.app == "browser":
        return (
            f"{entry.name}: open this page on the phone; its browser will warn that nobody vouches for this machine's "
            f"own certificate: go on.\n{join_text(url)}"
        )
    if entry.app == "sensor-logger":
        what = "wrist motion" if entry.stream == "watch" else "accelerometer, gravity, gyroscope and orientation"
        return (
            f"{entry.name}: in Sensor Logger switch on {what}, set its push URL to {url} and the shortest batch "
            "period, then begin a recording"
        )
    return f"{entry.name}: start SensorServer on the phone; it is looked for at {url}"
