"""An emulated phone: speaks an app's bytes to a door, or lets itself be asked, and does it as badly as is wished."""

import asyncio
import heapq
import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from armspan.devices.phone.voices import LoggerVoice, PageVoice, Samples, ServerVoice, Voice, lying_still
from armspan.errors import DeviceError, MissingExtra
from armspan.links.http import Guard, Route, serving

if TYPE_CHECKING:
    import aiohttp
    from aiohttp import web

STEP = 0.005
"""Seconds between two looks at the clock."""
AGAIN_S = 0.5
POST_S = 0.02
KNOWN = ("accelerometer", "gyroscope", "game_rotation_vector", "rotation_vector")


@dataclass(frozen=True, slots=True)
class Faults:
    """What goes wrong: times in seconds since the phone began.

    A share of messages is ``lost``; each waits up to ``jitter`` [s], and where messages are requests of their own one
    may overtake another; they come together every ``burst`` [s]; ``silences`` are times and lengths in which nothing
    is said; at ``breaks`` the line breaks.
    """

    lost: float = 0.0
    jitter: float = 0.0
    burst: float = 0.0
    silences: tuple[tuple[float, float], ...] = ()
    breaks: tuple[float, ...] = ()

    def silent(self, t: float) -> bool:
        """Whether nothing is said at ``t`` [s]."""
        return any(begin <= t < begin + length for begin, length in self.silences)


@dataclass(slots=True)
class EmulatedPhone:
    """A phone in time of its own [s], without any input or output: `advance` says what leaves it.

    Messages keep their order where the app has one line (``ordered``).
    """

    voice: Voice
    samples: Samples = field(default_factory=lying_still)
    faults: Faults = Faults()
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    ordered: bool = True
    sent: int = 0
    dropped: int = 0
    _under_way: list[tuple[float, int, bytes]] = field(default_factory=list)
    _count: int = 0
    _latest: float = 0.0

    def advance(self, t: float) -> list[bytes]:
        """The messages that have left the phone by ``t`` [s]."""
        for message in self.voice.tell(self.samples(t), t):
            if self.faults.silent(t) or self.rng.uniform() < self.faults.lost:
                self.dropped += 1
            else:
                self._put(t, message)
        left = []
        while self._under_way and self._under_way[0][0] <= t:
            left.append(heapq.heappop(self._under_way)[2])
        self.sent += len(left)
        return left

    def skip(self, t: float) -> None:
        """Nobody listened until ``t`` [s]: what was to be said is lost."""
        self.dropped += len(self.advance(t)) + len(self._under_way)
        self._under_way.clear()

    def say(self, t: float, message: bytes) -> None:
        """Something else that is said, such as a stop."""
        self._put(t, message)

    def _put(self, t: float, message: bytes) -> None:
        at = t + self.faults.jitter * float(self.rng.uniform())
        if self.faults.burst:
            at = self.faults.burst * float(np.ceil(at / self.faults.burst))
        if self.ordered:
            at = self._latest = max(at, self._latest)
        heapq.heappush(self._under_way, (at, self._count, message))
        self._count += 1


async def play(phone: EmulatedPhone, url: str, seconds: float | None = None) -> None:
    """Speak to the door at ``url`` for so long, or until cancelled.

    A page opens its line again when it broke; a push that is not taken is lost, as the app's are.

    Raises:
        DeviceError: where the door refuses from the beginning.
        MissingExtra: without aiohttp.

    """
    try:
        import aiohttp
    except ImportError:
        raise MissingExtra("aiohttp", "phone") from None
    began = asyncio.get_running_loop().time()
    connector = aiohttp.TCPConnector(ssl=False)  # as a person who was warned and went on
    async with aiohttp.ClientSession(connector=connector) as session:
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                if isinstance(phone.voice, LoggerVoice):
                    await _push(phone, session, url, began)
                elif isinstance(phone.voice, PageVoice) and phone.voice.posts:
                    await _post(phone, session, _beside(url, "say"), began)
                else:
                    await _hold_lines(phone, session, _beside(url, "line"), began)


def _beside(url: str, name: str) -> str:
    """Where the page at ``url`` opens its line, or posts what it says."""
    from yarl import URL

    page = URL(url)
    return str(page.with_path(f"/{name}").with_query(page.query))


async def _post(phone: EmulatedPhone, session: "aiohttp.ClientSession", url: str, began: float) -> None:
    """Post what is due, one post after the other, as the page does."""
    from aiohttp import ClientError

    while True:
        texts = [*phone.voice.begin(), *phone.advance(asyncio.get_running_loop().time() - began)]
        with suppress(ClientError, OSError, TimeoutError):
            async with session.post(url, data=b"\n".join(texts)) as answer:
                if answer.status == 403:
                    raise DeviceError(f"the door refuses: {(await answer.text()).strip()}")
        await asyncio.sleep(POST_S)


async def _push(phone: EmulatedPhone, session: "aiohttp.ClientSession", url: str, began: float) -> None:
    from aiohttp import ClientError

    async def push(message: bytes) -> None:
        with suppress(ClientError, OSError, TimeoutError):
            async with session.post(url, data=message, headers={"Content-Type": "application/json"}) as answer:
                if answer.status == 403:
                    raise DeviceError(f"the door refuses: {(await answer.text()).strip()}")

    async with asyncio.TaskGroup() as requests:
        while True:
            for message in phone.advance(asyncio.get_running_loop().time() - began):
                requests.create_task(push(message))
            await asyncio.sleep(STEP)


async def _hold_lines(phone: EmulatedPhone, session: "aiohttp.ClientSession", url: str, began: float) -> None:
    from aiohttp import ClientError, WSServerHandshakeError

    while True:
        try:
            async with session.ws_connect(url) as line:
                await _talk(phone, line, began)
        except WSServerHandshakeError as error:
            raise DeviceError(f"the door refuses: {error.message} ({error.status})") from None
        except (ClientError, OSError, TimeoutError):
            pass
        await asyncio.sleep(AGAIN_S)


async def _talk(
    phone: EmulatedPhone, line: "aiohttp.ClientWebSocketResponse | web.WebSocketResponse", began: float
) -> None:
    """Say what is due on a line, and hear what is answered, until it breaks."""
    loop = asyncio.get_running_loop()
    since = loop.time() - began
    phone.skip(since)
    for message in phone.voice.begin():
        await line.send_str(message.decode())

    async def listen() -> None:
        async for _ in line:
            pass

    ears = asyncio.create_task(listen())
    try:
        while not ears.done():
            now = loop.time() - began
            for message in phone.advance(now):
                await line.send_str(message.decode())
            if any(since < at <= now for at in phone.faults.breaks):
                break
            await asyncio.sleep(STEP)
    finally:
        ears.cancel()
        await asyncio.gather(ears, return_exceptions=True)


async def serve(phone: EmulatedPhone, port: int, listening: Callable[[int], None], host: str = "127.0.0.1") -> None:
    """Be a phone with SensorServer until cancelled; ``listening`` is told the port."""
    from aiohttp import web

    began = asyncio.get_running_loop().time()

    async def connect(request: web.Request) -> web.StreamResponse:
        try:
            wanted = json.loads(request.query.get("types", ""))
            unknown = [name for name in wanted if name.removeprefix("android.sensor.") not in KNOWN]
        except (ValueError, TypeError, AttributeError):
            unknown = ["?"]
        line = web.WebSocketResponse(timeout=1.0)
        await line.prepare(request)
        if unknown:
            await line.close(code=1008, message=b"unknown sensor")
            return line
        phone.voice = ServerVoice(wanted)
        with suppress(ConnectionError):
            await _talk(phone, line, began)
        await line.close()
        return line

    async with serving([Route("GET", "/sensors/connect", connect)], host, port, Guard()) as at:
        listening(at)
        await asyncio.get_running_loop().create_future()
