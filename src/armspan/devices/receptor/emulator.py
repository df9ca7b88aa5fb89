"""A receptor's own end of the line: what a lab's microcontroller would write. Bytes only, no input or output.

It says ``hit`` when it sees light and again every ``repeat`` seconds, ``lost`` when it does not any more, and at the
rim it chatters: contacts bounce, a spot trembles. It knows nothing of who listens.
"""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field

import numpy as np

from armspan.records import Hit

REPEAT_S = 0.2
BOUNCE_S = 0.005
JUST = 1e-9
"""Seconds by which rounding may be early."""


@dataclass(slots=True)
class EmulatedReceptor:
    """Writes lines about what it notices.

    ``token`` ends each line where one is set; after a change it bounces up to ``bounces`` times; a share ``lost`` of
    its messages does not arrive. ``end`` is what its lines end in.
    """

    rng: np.random.Generator
    repeat: float = REPEAT_S
    token: str | None = None
    bounces: int = 0
    lost: float = 0.0
    end: bytes = b"\r\n"
    _said: dict[str, float] = field(default_factory=dict)
    _due: list[tuple[float, str, bool]] = field(default_factory=list)

    def notice(self, t: float, robot: str, on: bool) -> None:
        """Light begins or ends on a robot at ``t`` [s]."""
        count = 2 * int(self.rng.integers(self.bounces + 1))
        self._due = [item for item in self._due if item[1] != robot]
        for number in range(count + 1):
            self._due.append((t + BOUNCE_S * number, robot, on if number % 2 == 0 else not on))

    def hear(self, hit: Hit) -> None:
        """Notice what a virtual receptor noticed."""
        self.notice(hit.t, hit.robot, hit.on)

    def advance(self, t: float) -> list[bytes]:
        """The messages written up to ``t`` [s], one line each."""
        written = []
        for at, robot, on in sorted(item for item in self._due if item[0] <= t):
            written.append(self._line(robot, on))
            if on:
                self._said[robot] = at
            else:
                self._said.pop(robot, None)
        self._due = [item for item in self._due if item[0] > t]
        for robot, said in sorted(self._said.items()):
            if self.repeat > 0.0 and t - said >= self.repeat - JUST:
                self._said[robot] = t
                written.append(self._line(robot, True))
        return [line for line in written if float(self.rng.uniform()) >= self.lost]

    def _line(self, robot: str, on: bool) -> bytes:
        token = f" token={self.token}" if self.token else ""
        return f"{'hit' if on else 'lost'} {robot}{token}".encode() + self.end


async def write_on(
    receptor: EmulatedReceptor,
    write: Callable[[bytes], None],
    now: Callable[[], float],
    pause: Callable[[float], Awaitable[None]],
) -> None:
    """Write what is due, for ever."""
    while True:
        for line in receptor.advance(now()):
            write(line)
        await pause(BOUNCE_S)
