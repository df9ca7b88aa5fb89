"""Device ticks to session seconds: drift, wrap-around, late packets. Pure.

A device's ticks are exact but of an unknown offset and a rate a few parts per million off; arrivals are on
the session's clock but late, by an unknown and varying delay that is never negative. So the earliest arrival
is the best one, and the map follows a lower envelope of (arrival - tick time).
"""

from dataclasses import dataclass, field


@dataclass(slots=True)
class DeviceClock:
    """Maps a device's ticks to session seconds.

    ``tick`` is the nominal length of a tick [s], ``bits`` the counter's width (None: it never wraps),
    ``drift`` the fastest drift between the two clocks that is followed [s/s].
    """

    tick: float
    bits: int | None = None
    drift: float = 200e-6
    _wraps: int = 0
    _last: int | None = None
    _offset: float | None = field(default=None)
    _since: float = 0.0

    def seconds(self, ticks: int, arrived: float) -> float:
        """Session time [s] at which the device counted ``ticks``, given the arrival time [s] of its packet."""
        device = self._unwrapped(ticks) * self.tick
        delay = arrived - device
        if self._offset is None:
            self._offset, self._since = delay, arrived
        else:
            allowed = self._offset + self.drift * max(0.0, arrived - self._since)
            self._offset, self._since = min(delay, allowed), max(arrived, self._since)
        return device + self._offset

    def _unwrapped(self, ticks: int) -> int:
        if self.bits is None:
            return ticks
        span = 1 << self.bits
        if self._last is not None:
            step = (ticks - self._last) % span
            late = step > span // 2  # an old packet, not a jump of half the counter
            if not late and ticks < self._last:
                self._wraps += 1
            elif late and ticks > self._last:
                return ticks + (self._wraps - 1) * span
            if late:
                return ticks + self._wraps * span
        self._last = ticks
        return ticks + self._wraps * span
