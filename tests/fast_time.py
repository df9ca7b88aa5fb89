"""Time that passes only while everybody waits, and then ten times as fast.

What runs in one event loop, a host and its emulated robots with real bytes between them, then takes a tenth of the
time, and however busy the machine is, nobody is ever late.
"""

import asyncio
import selectors
import time
from types import SimpleNamespace

FASTER = 10.0
START = 100.0
MODULES = ("armspan.devices.cellulo.emulator", "armspan.session")


class FastLoop(asyncio.SelectorEventLoop):
    """An event loop with such a time."""

    def __init__(self):
        super().__init__(_Waits())

    def time(self):
        return self._selector.waited


class _Waits(selectors.SelectSelector):
    """Sockets first; where none has anything to tell, a tenth of the time that somebody has still to wait."""

    def __init__(self):
        super().__init__()
        self.waited = START

    def select(self, timeout=None):
        ready = super().select(None if timeout is None else max(timeout, 0.0) / FASTER)
        if not ready and timeout is not None:
            self.waited += max(timeout, 0.0)
        return ready


def now():
    """The running loop's time [s]."""
    return asyncio.get_running_loop().time()


def run(scene, seconds=20.0):
    """Play a scene, a coroutine function, in fast time."""
    with asyncio.Runner(loop_factory=FastLoop) as runner:
        return runner.run(asyncio.wait_for(scene(), seconds))


def hasten(monkeypatch):
    """Emulator and session live by the running loop's time, as drivers do anyway."""
    for module in MODULES:
        monkeypatch.setattr(f"{module}.time", SimpleNamespace(monotonic=now, perf_counter_ns=time.perf_counter_ns))
