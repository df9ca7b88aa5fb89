"""The robots of one driver: what they tell waits in a queue, what they are told in their outboxes.

The session never waits for the radio: a command goes into its robot's outbox, where the latest motion wins. What
a killed process cannot do, its goals do: they lie a short way ahead, and the robots rest there.
"""

import asyncio
import math
from collections.abc import AsyncGenerator, Awaitable, Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field

from armspan.devices.cellulo.ring import Ring
from armspan.devices.cellulo.robot import STOPS, Placement, Robot
from armspan.errors import ConfigError, DeviceError, DeviceNotFound, known_names
from armspan.records import Command, Event, Vec2

PACE_S = 0.005
"""Between two bursts to a robot, which reads its 256 bytes once in ten milliseconds."""
WATCH_S = 0.25
CLOSE_S = 0.5
OPENING_S = 30.0
"""Seconds from the start in which a robot that never answered ends the session; later it only counts as lost."""


@dataclass(frozen=True, slots=True)
class Traits:
    """What a lab tells of one robot: the pattern's ``scale`` under it, its ``ring``, the ``adapter`` to reach it by."""

    scale: float = 1.0
    ring: Ring = field(default_factory=Ring)
    adapter: str | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.scale) and self.scale > 0):
            raise ConfigError(
                f"scale is {self.scale}; expected a number above zero, 1 where the pattern was printed true"
            )


class Flock:
    """Robots by name, each with its traits; ``origin_m`` is where the sheet's corner lies in their coordinates."""

    def __init__(self, traits: Mapping[str, Traits], origin_m: Vec2, now: Callable[[], float] | None) -> None:
        self.robots = {
            name: Robot(name, Placement(origin_m, trait.scale), trait.ring) for name, trait in traits.items()
        }
        self._now, self._zero = now, math.nan
        self.closed = False
        self._began = math.inf
        self.news = asyncio.Event()
        self._events: asyncio.Queue[Event | None] = asyncio.Queue()

    def now(self) -> float:
        """The session's time [s]; where nobody tells it, the running loop's since it was first asked for."""
        if self._now is not None:
            return self._now()
        time = asyncio.get_running_loop().time()
        if math.isnan(self._zero):
            self._zero = time
        return time - self._zero

    def __iter__(self) -> Iterator[Robot]:
        return iter(self.robots.values())

    def take(self, command: Command) -> None:
        """Put a command into the outboxes of those that it is for; nothing once the flock was told to stop.

        Raises:
            DeviceNotFound: for a robot that does not exist.
            DeviceError: for a velocity, or a number that must not reach the wire.

        """
        if self.closed:
            return
        now = self.now()
        for robot in self._addressed(command.robot):
            robot.take(command, now)

    def _addressed(self, name: str | None) -> list[Robot]:
        if name is None:
            return list(self.robots.values())
        if name not in self.robots:
            raise DeviceNotFound(known_names("robot", name, self.robots))
        return [self.robots[name]]

    def tell(self, events: Iterable[Event]) -> None:
        """Let events be told."""
        for event in events:
            self._events.put_nowait(event)

    def watch(self, robot: Robot) -> None:
        """Ask a silent robot whether it is there, and tell of one that is not.

        Raises:
            DeviceError: for one that never answered anything, though its link is up, and the session has just begun.

        """
        now = self.now()
        self.tell(robot.watch(now))
        if robot.mute and now < self._began + OPENING_S:
            raise DeviceError(
                f"robot {robot.name!r} is connected and answers nothing, not even a ping; firmware from before April "
                "2016 speaks another language, and one that hangs is silent too: switch it off and on, or give it "
                "the firmware of chili-epfl/CelluloV1 or CelluloV2"
            )

    async def pause(self, wake: float) -> None:
        """Wait for news until ``wake`` [s], a quarter of a second at most."""
        with suppress(TimeoutError):
            async with asyncio.timeout(min(max(wake - self.now(), 0.0), WATCH_S)):
                await self.news.wait()
        self.news.clear()

    async def heard(
        self, keep: Callable[[], Awaitable[None]], close: Callable[[], Awaitable[None]]
    ) -> AsyncGenerator[Event, None]:
        """What is told while ``keep`` goes on; then, on every way out, ``close``."""
        self._began = self.now()
        keeper = asyncio.ensure_future(keep())
        keeper.add_done_callback(lambda _: self._events.put_nowait(None))
        try:
            while (event := await self._events.get()) is not None:
                yield event
            await keeper
        finally:
            self.closed = True
            try:
                await close()
            finally:
                keeper.cancel()
                with suppress(asyncio.CancelledError, Exception):
                    await keeper


async def stop_repeatedly(stop: Callable[[], bool], flush: Callable[[], Awaitable[None]]) -> None:
    """Call ``stop`` three times, the first time before anything waits, while it finds somebody to tell; then flush."""
    for before, after in zip(STOPS, (*STOPS[1:], STOPS[-1]), strict=True):
        if not stop():
            return
        await asyncio.sleep(after - before)
    with suppress(OSError, TimeoutError):
        async with asyncio.timeout(CLOSE_S):
            await flush()
