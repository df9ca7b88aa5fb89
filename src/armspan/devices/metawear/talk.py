"""Questions to a board and its answers, over whatever carries the bytes.

Nothing on the wire tells which question an answer belongs to but the register it comes from, so one question at a
time is open for each. Writes are not acknowledged: what must be known to have arrived is asked back.
"""

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Protocol

from armspan.errors import DeviceLost

ANSWER_S = 1.0
"""The longest wait for an answer: at a connection interval of 50 ms one takes 0.1 to 0.15 s."""


class Carrier(Protocol):
    """Bluetooth LE, or a cable."""

    @property
    def services(self) -> frozenset[str] | None:
        """The GATT services in lower case; None on a cable, which has none."""

    async def write(self, data: bytes, response: bool = False) -> None:
        """Write to the command characteristic."""

    async def read(self, uuid: str) -> bytes:
        """Read a characteristic's value."""

    async def listen(self, heard: Callable[[bytes], None]) -> None:
        """Let notifications come to ``heard``."""


class Talk:
    """A conversation with one board; what is no answer goes to ``heard``. ``hang_up`` ends it from any side."""

    def __init__(self, carrier: Carrier, name: str, heard: Callable[[bytes], None]) -> None:
        self.carrier, self.name = carrier, name
        self._heard = heard
        self._open: dict[tuple[int, int], asyncio.Future[bytes]] = {}
        self._turns: dict[tuple[int, int], asyncio.Lock] = {}
        self._news = asyncio.Event()
        self._ended = False

    def hear(self, data: bytes) -> None:
        """A notification came."""
        answer = self._open.get((data[0], data[1])) if len(data) >= 2 else None
        if answer is not None and not answer.done():
            answer.set_result(data)
        else:
            self._heard(data)

    def hang_up(self) -> None:
        """The link is gone: everybody who waits is told."""
        self._ended = True
        self._news.set()
        for answer in self._open.values():
            if not answer.done():
                answer.set_exception(self._lost())

    def wake(self) -> None:
        """End a pause: there is something to do."""
        self._news.set()

    async def pause(self, seconds: float) -> None:
        """Wait, but no longer than there is nothing to do.

        Raises:
            DeviceLost: when the link is gone.

        """
        with suppress(TimeoutError):
            async with asyncio.timeout(max(0.0, seconds)):
                await self._news.wait()
        self._news.clear()
        self._check()

    async def wait(self, seconds: float) -> None:
        """Wait for the whole time.

        Raises:
            DeviceLost: when the link is gone.

        """
        loop = asyncio.get_running_loop()
        end = loop.time() + seconds
        while (left := end - loop.time()) > 0:
            await self.pause(left)

    async def tell(self, *writes: bytes | Sequence[bytes]) -> None:
        """Write, in order."""
        for write in writes:
            for data in (write,) if isinstance(write, bytes) else write:
                self._check()
                await self.carrier.write(data, response=data[0] == _MACRO)

    async def ask(
        self,
        question: bytes,
        answers: tuple[int, int] | None = None,
        *,
        tries: int = 3,
        seconds: float = ANSWER_S,
        rest: Sequence[bytes] = (),
    ) -> bytes | None:
        """The answer to a question, from the register asked unless told; None where none comes.

        What is asked may be lost on the way, and so may the answer, so it is asked ``tries`` times. ``rest`` are writes
        that belong to the question.
        """
        key = answers or (question[0], question[1])
        async with self._turns.setdefault(key, asyncio.Lock()):
            for _ in range(tries):
                answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
                self._open[key] = answer
                try:
                    await self.tell(question, rest)
                    async with asyncio.timeout(seconds):
                        return await answer
                except TimeoutError:
                    continue
                finally:
                    del self._open[key]
                    answer.cancel()
        return None

    async def learn(self, question: bytes, tries: int = 3) -> bytes:
        """The answer to a question that every such board answers.

        Raises:
            DeviceLost: where none comes.

        """
        answer = await self.ask(question, tries=tries)
        if answer is None:
            raise DeviceLost(f"{self.name} did not answer when asked {question.hex()}")
        return answer

    def _check(self) -> None:
        if self._ended:
            raise self._lost()

    def _lost(self) -> DeviceLost:
        return DeviceLost(f"the link to {self.name} broke")


_MACRO = 0x0F
