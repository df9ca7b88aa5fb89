"""The radio between hosts and emulated robots: late, in order, in bursts, or lost; a time is seconds."""

import math
from heapq import heappop, heappush
from itertools import count

import numpy as np

from armspan.devices.cellulo.faults import QUIET_S, Faults
from armspan.records import Vec2

JUST = 1e-9


class Radio:
    """n links, each with its own order in each direction; ``latency`` [s] is the range of what is usual."""

    def __init__(self, n: int, latency: Vec2, faults: Faults, dice: np.random.Generator) -> None:
        self._latency, self._faults, self._dice = latency, faults, dice
        self._down, self._up = [0.0] * n, [0.0] * n
        self._air: list[tuple[float, int, int, bytes]] = []
        self._order = count()

    def down(self, t: float, robot: int) -> float | None:
        """When something sent to a robot at ``t`` arrives, None if never."""
        if self._faults.drop and self._dice.random() < self._faults.drop:
            return None
        self._down[robot] = arrival = max(t + self._late(t, self._down[robot]), self._down[robot])
        return arrival

    def up(self, t: float, robot: int, packet: bytes) -> None:
        """Send a packet to the host at ``t``."""
        arrival = max(t + self._late(t, self._up[robot]), self._up[robot])
        if self._faults.burst_s > 0:
            arrival = math.ceil(arrival / self._faults.burst_s - JUST) * self._faults.burst_s
        self._up[robot] = arrival
        heappush(self._air, (arrival, next(self._order), robot, packet))

    def arrived(self, t: float) -> list[tuple[int, bytes]]:
        """What came to the host up to ``t`` since the last call: (robot, packet), in order."""
        told = []
        while self._air and self._air[0][0] <= t + JUST:
            _, _, robot, packet = heappop(self._air)
            told.append((robot, packet))
        return told

    def _late(self, t: float, last: float) -> float:
        late = float(self._dice.uniform(*self._latency)) + self._faults.latency_s
        sniffing = self._faults.sniff_s > 0 and t - last >= QUIET_S
        return late + (float(self._dice.uniform(0.0, self._faults.sniff_s)) if sniffing else 0.0)
