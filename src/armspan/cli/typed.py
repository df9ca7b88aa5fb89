"""What somebody types during a session of real devices: each line is a press, as the page's buttons will be."""

import asyncio
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from armspan.errors import known_names

PRESSES = {
    "setup": "begin the set-up again",
    "stop": "stop all robots (also: an empty line)",
    "resume": "go on after a stop; resume NAME for one robot",
    "behaviour": "begin one, as: behaviour sweep",
    "feedback": "on or off: the robots' lights show the cursor",
    "quit": "end the session",
}


@contextmanager
def typed(press: Callable[[str, str], None]) -> Iterator[None]:
    """Hand each typed line on as a press, while there is a terminal to type in."""
    if not sys.stdin or not sys.stdin.isatty():
        yield
        return
    loop, lines = asyncio.get_running_loop(), Lines(press)
    descriptor = sys.stdin.fileno()
    print(f"Type {', '.join(PRESSES)} and Enter; Enter alone stops all robots", file=sys.stderr)
    loop.add_reader(descriptor, lambda: lines.feed(os.read(descriptor, 4096)))
    try:
        yield
    finally:
        loop.remove_reader(descriptor)


class Lines:
    """Typed bytes to presses; what is no press is answered with those that exist, and an empty line stops."""

    def __init__(self, press: Callable[[str, str], None]) -> None:
        self._press, self._rest = press, b""

    def feed(self, data: bytes) -> None:
        """Take what was typed."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            name, _, value = line.decode("utf-8", "replace").strip().partition(" ")
            if not name:
                self._press("stop", "")
            elif name in PRESSES:
                self._press(name, value.strip())
            else:
                print(known_names("press", name, PRESSES), file=sys.stderr)
