"""A line of bytes to one device: a radio socket or a serial port, open and non-blocking. POSIX.

Writing never waits. What the line does not take at once stays here and follows in order; `room` tells whether what was
written before has left, so that who writes short-lived things can wait with them instead of letting them grow old.
"""

import asyncio
import os
import struct
from collections.abc import Callable
from contextlib import suppress

ROOM = 64
"""Bytes that may wait in a serial port's own buffer and still count as having left."""


class Line:
    """A line over the file descriptor ``fd``; ``close`` is called once, when the line is closed."""

    def __init__(self, fd: int, close: Callable[[], None]) -> None:
        os.set_blocking(fd, False)
        self._fd, self._close = fd, close
        self._loop = asyncio.get_running_loop()
        self._backlog = b""
        self._waiter: asyncio.Future[None] | None = None
        self._empty = asyncio.Event()
        self._empty.set()
        self._gone = False
        self._serial = os.isatty(fd)

    async def read(self, most: int = 4096) -> bytes:
        """What arrived, one byte at least; nothing once the line is broken or closed. One reader at a time."""
        while not self._gone:
            try:
                data = os.read(self._fd, most)
            except (BlockingIOError, InterruptedError):
                await self._readable()
                continue
            except OSError:  # a serial port whose other end hung up, a radio that lost its peer
                return b""
            return data
        return b""

    def write(self, data: bytes) -> None:
        """Write without waiting; on a broken line, nothing happens."""
        if self._gone or not data:
            return
        self._backlog += data
        self._push()

    @property
    def waiting(self) -> int:
        """Bytes that were written and wait here."""
        return len(self._backlog)

    @property
    def room(self) -> bool:
        """Whether what was written before has left."""
        return not self._backlog and not self._gone and self._held() <= ROOM

    async def flushed(self) -> None:
        """Wait until all that was written has left, or the line is broken."""
        await self._empty.wait()

    def close(self) -> None:
        """Close the line; a reader is told that it has ended."""
        if self._gone and self._fd < 0:
            return
        self._end()
        with suppress(OSError):
            self._close()
        self._fd = -1

    # --- inside ----------------------------------------------------------------------------------------

    async def _readable(self) -> None:
        self._waiter = waiter = self._loop.create_future()
        self._loop.add_reader(self._fd, _wake, waiter)
        try:
            await waiter
        finally:
            self._waiter = None
            if self._fd >= 0:
                self._loop.remove_reader(self._fd)

    def _push(self) -> None:
        """Hand over as much as is taken now."""
        try:
            sent = os.write(self._fd, self._backlog)
        except (BlockingIOError, InterruptedError):
            sent = 0
        except OSError:
            self._end()
            return
        self._backlog = self._backlog[sent:]
        if self._backlog:
            self._empty.clear()
            self._loop.add_writer(self._fd, self._push)
        else:
            self._empty.set()
            self._loop.remove_writer(self._fd)

    def _held(self) -> int:
        """Bytes that a serial port has taken and not sent."""
        if not self._serial:
            return 0
        import fcntl
        import termios

        with suppress(OSError):
            (held,) = struct.unpack("i", fcntl.ioctl(self._fd, termios.TIOCOUTQ, bytes(4)))
            return int(held)
        return 0

    def _end(self) -> None:
        self._gone, self._backlog = True, b""
        self._empty.set()
        if self._fd >= 0:
            self._loop.remove_writer(self._fd)
            self._loop.remove_reader(self._fd)
        if self._waiter is not None:
            _wake(self._waiter)


def _wake(waiter: "asyncio.Future[None]") -> None:
    if not waiter.done():
        waiter.set_result(None)
