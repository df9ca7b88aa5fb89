"""One phone or watch as a band: what it told, checked, in order, with its link and its counters."""

import math
from dataclasses import asdict, dataclass, field

from armspan.devices.phone.readings import FASTEST, STRONGEST, turned, vector
from armspan.devices.phone.upright import Upright
from armspan.records import Event, ImuSample, Link, Quaternion, Vec3

SILENCE = 1.0
"""Seconds without a sample after which a band is down; three batches where batches are longer."""
_GAP = 2.5
_SHORTEST_GAP = 0.03
_MEMORY = 0.02
_BRIDGED = 0.25


@dataclass(slots=True)
class Counters:
    """What came and what did not: ``lost`` by the app's own numbers, ``gaps`` by time, the ``longest`` of them [s].

    ``late`` samples were older than what had been told; ``malformed`` messages could not be read; ``steps`` are those
    of the phone's clock; ``wait`` [s] is how long the oldest sample of a batch had waited at most; ``rate`` [Hz].
    """

    samples: int = 0
    lost: int = 0
    late: int = 0
    gaps: int = 0
    longest: float = 0.0
    malformed: int = 0
    steps: int = 0
    losses_of_link: int = 0
    wait: float = 0.0
    rate: float = 0.0


@dataclass(slots=True)
class Band:
    """Turns what an app told into a band's records.

    ``upright`` finds the sign of the app's acceleration; an attitude that gravity speaks against is left out, and
    what was known of the heading is then void.
    """

    name: str
    rate_hz: float = 60.0
    upright: Upright = field(default_factory=Upright)
    counters: Counters = field(default_factory=Counters)
    last: float = -math.inf
    arrived: float = -math.inf
    up: bool = False
    _interval: float = 0.0
    _linked: float = -math.inf
    _batch: float = 0.0
    _attitude: Quaternion | None = None
    _read: float = -math.inf
    _turned: float = -math.inf
    _believed: bool | None = None
    _fresh: bool = False

    def __post_init__(self) -> None:
        self._interval = 1.0 / self.rate_hz

    def feel(self, t: float, told: Vec3, gyr: Vec3, attitude: Quaternion | None) -> list[Event]:
        """A sample taken at session time ``t`` [s]: acceleration with gravity [m/s²], rate [rad/s].

        The acceleration is in the app's own sign. Where the attitude stayed away for a moment, the last one turns on.

        Raises:
            DeviceError: for numbers that no sensor tells.

        """
        vector(told, "the acceleration", STRONGEST)
        vector(gyr, "the rate of turn", FASTEST)
        if t <= self.last:
            self.counters.late += 1
            return []
        self._time(t)
        if attitude is not None:
            self.upright.feel(told, attitude)
            self._attitude, self._read = attitude, t
        elif self._attitude is not None and t - self._read < _BRIDGED:
            attitude = self._attitude = turned(self._attitude, gyr, t - self._turned)
        self._turned = t
        believed = attitude is not None and self.upright.believes
        changed = self._believed is not None and believed != self._believed
        self._believed = believed
        sample = ImuSample(t, self.name, self.upright.force(told), gyr, None, attitude if believed else None)
        return [*self._links(t, changed), sample]

    def begin(self) -> None:
        """The app began anew: its heading is another one."""
        self._fresh, self._attitude = True, None

    def batch(self, arrived: float, span: float = 0.0) -> None:
        """Something arrived at session time [s] that took ``span`` [s] to be gathered."""
        if self.last > -math.inf:
            wait = max(0.0, arrived - self.arrived) if self.arrived > -math.inf else 0.0
            if wait < 10 * SILENCE:
                self._batch = max(wait, span, self._batch * 0.9)
        self.arrived = arrived

    def watch(self, now: float) -> list[Event]:
        """The link's end, where nothing came for too long."""
        if not self.up or now - self.arrived <= max(SILENCE, 3.0 * min(self._batch, SILENCE)):
            return []
        return self.lose(now)

    def lose(self, now: float) -> list[Event]:
        """The link ended."""
        if not self.up:
            return []
        self.up = False
        self.counters.losses_of_link += 1
        self._linked = max(now, self._linked)
        return [Link(self._linked, self.name, up=False)]

    def report(self) -> dict[str, float]:
        """The counters by name."""
        return asdict(self.counters)

    def _links(self, t: float, changed: bool) -> list[Event]:
        if self.up and not (changed or self._fresh):
            return []
        fresh = changed or self._fresh
        self.up, self._fresh = True, False
        self._linked = max(t, self._linked)  # what was measured before the link's end may come after it
        return [Link(self._linked, self.name, up=True, fresh=fresh)]

    def _time(self, t: float) -> None:
        counters, since = self.counters, t - self.last
        counters.samples += 1
        self.last = t
        if not math.isfinite(since):
            return
        if since > max(_GAP * self._interval, _SHORTEST_GAP):
            counters.gaps += 1
            counters.longest = max(counters.longest, since)
        self._interval += _MEMORY * (min(since, _GAP * self._interval) - self._interval)
        counters.rate = 1.0 / self._interval
