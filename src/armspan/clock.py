"""Device ticks to session seconds, and streams that carry no ticks: drift, wrap-around, bursts, losses. Pure.

A device's ticks are exact but of an unknown offset and a rate a few parts per million off; arrivals are on
the session's clock but late, by an unknown and varying delay that is never negative. So the earliest arrival
is the best one, and the map follows a lower envelope of (arrival - tick time).
"""

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import islice, pairwise
from statistics import median

SLOWEST = 0.5
"""A map that turns out to be late lets time go on at this share of its speed until it is right, never back."""
SILENCE_S = 0.25
"""After so long a silence samples of a stream are missing for sure."""

_MARGIN = 0.4
"""How far an arrival must be out, in periods, to show that samples were counted wrongly."""
_BELIED_S = 2.0
"""How long a count of lost samples may be taken back."""
_WHILE_S, _WHILES, _LATE = 0.25, 240, 16
"""The period is fitted to the last minute, the offset to the last four seconds, in quarters of a second."""
_CROWDED = 2.5
"""Packets in a burst, on average, from which on they are no chance."""
_NOISE_S = 0.002
"""Standard deviation of the earliest arrivals about their envelope."""


@dataclass(slots=True)
class DeviceClock:
    """Maps a device's ticks to session seconds.

    ``tick`` is the nominal length of a tick [s], ``bits`` the counter's width (None: it never wraps),
    ``drift`` the fastest drift between the two clocks that is followed [s/s]. Newer ticks are never mapped
    to earlier times; ticks from before the newest come late and are mapped to when they were counted. With
    ``spacing``, the nominal time between two packets [s], what they waited for in `Bursts` is taken off.
    """

    tick: float
    bits: int | None = None
    drift: float = 200e-6
    spacing: float | None = None
    _wraps: int = 0
    _last: int | None = None
    _offset: float | None = field(default=None)
    _since: float = 0.0
    _newest: tuple[float, float] = (-math.inf, -math.inf)
    _bursts: "Bursts | None" = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if self.spacing is not None:
            self._bursts = Bursts(self.spacing)

    def seconds(self, ticks: int, arrived: float) -> float:
        """Session time [s] at which the device counted ``ticks``, given the arrival time [s] of its packet."""
        device, waited = self._unwrapped(ticks) * self.tick, 0.0
        delay = arrived - device
        if self._offset is None:
            self._offset, self._since = delay, arrived
        else:
            allowed = self._offset + self.drift * max(0.0, arrived - self._since)
            self._offset, self._since = min(delay, allowed), max(arrived, self._since)
        if self._bursts is not None:
            self._bursts.add(arrived, delay - self._offset)
            waited = self._bursts.waited
        return self._forward(device, device + self._offset - waited)

    def _forward(self, device: float, mapped: float) -> float:
        """The mapped time [s], but after that of the newest tick before it."""
        counted, told = self._newest
        if device < counted:
            return min(mapped, told)
        if counted > -math.inf:
            mapped = max(mapped, told + SLOWEST * (device - counted))
        self._newest = device, mapped
        return mapped

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


@dataclass(slots=True)
class Bursts:
    """How long the last packet of a burst ``waited`` [s] for it.

    A radio hands over at every connection event what was measured since the last one, so the last packet of a burst
    waited for less than the ``spacing`` between two [s]. Where this wait varies, the envelope has found a packet that
    did not wait; where it does not, because the event's interval is a multiple of the spacing, nothing tells how long
    it is, and a third of what is possible is guessed: rather late than before it was measured. This is done once in
    ``window`` seconds.
    """

    spacing: float
    window: float = 10.0
    waited: float = 0.0
    _last: tuple[float, float] | None = None
    _since: float = -math.inf
    _packets: int = 0
    _lags: list[float] = field(default_factory=list, repr=False)

    def add(self, arrived: float, lag: float) -> None:
        """Take a packet's arrival [s] and how far it was behind the envelope [s]."""
        if self._last is None:
            self._since = arrived
        elif arrived - self._last[0] > self.spacing / 3:
            self._lags.append(self._last[1])
        self._packets += 1
        self._last = arrived, lag
        if arrived - self._since >= self.window:
            self._guess()
            self._since, self._packets = arrived, 0
            self._lags.clear()

    def _guess(self) -> None:
        crowded = self._packets >= _CROWDED * len(self._lags)
        lags = sorted(self._lags)
        spread = lags[int(0.9 * len(lags))] if lags else self.spacing  # a lost packet leaves a longer lag
        self.waited = max(0.0, self.spacing - spread) / 3 if crowded else 0.0


@dataclass(slots=True)
class _Earliest:
    """The earliest arrival of a while: sample ``n`` at ``arrived`` [s], with none lost since its ``stretch`` began.

    ``waits`` are those of the last packets of bursts in this while [s].
    """

    since: float
    arrived: float
    n: int
    stretch: int
    waits: list[float]


@dataclass(slots=True)
class StreamClock:
    """When the samples of a stream were measured that carries neither ticks nor numbers.

    Its device measures every ``spacing`` seconds, give or take the share ``tolerance``, and a radio hands the samples
    over in bursts. Sample n was measured at offset + n x ``period``; the period is fitted to the earliest arrivals,
    the offset is their lower envelope. A ``lost`` sample leaves no trace but arrivals that are a period later than
    the samples before allow: it is counted then and not before, and taken back where a later arrival belies it.
    Times never fall.
    """

    spacing: float = 0.01
    tolerance: float = 0.01
    lost: int = 0
    period: float = field(init=False)
    _n: int = -1
    _offset: float = 0.0
    _told: float = -math.inf
    _before: float = -math.inf
    _counted: tuple[float, int, float] = (-math.inf, 0, 0.0)
    _stretch: int = 0
    _earliest: deque[_Earliest] = field(default_factory=lambda: deque(maxlen=_WHILES), repr=False)
    _longest: float = field(init=False)
    _bursts: Bursts = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.period, self._longest, self._bursts = self.spacing, self.spacing, Bursts(self.spacing)

    def seconds(self, arrived: float) -> float:
        """Session time [s] at which the next sample was measured, given the arrival time [s] of its packet."""
        silence = arrived - self._before
        if self._n < 0:
            self._offset = arrived
        elif silence > self.spacing / 3:
            self._judge(self._before)
        self._n += 1
        if SILENCE_S < silence < math.inf:
            self._count(arrived)
        self._before = arrived
        self._believe(arrived)
        self._bursts.add(arrived, self._lag(arrived))
        measured = self._offset + self._n * self.period - self._bursts.waited
        self._told = max(measured, self._told + SLOWEST * self.period)
        return self._told

    def _lag(self, arrived: float) -> float:
        return arrived - self._offset - self._n * self.period

    def _believe(self, arrived: float) -> None:
        """No sample comes before it is measured: samples were counted that were not lost, or the map is late."""
        since, counted, offset = self._counted
        early = offset + self._n * self.period - arrived
        if counted and early > _MARGIN * self.period and arrived - since < _BELIED_S:
            back = min(counted, math.ceil(early / self.period - _MARGIN))
            self._shift(-back)
            self._counted, self._offset = (since, counted - back, offset), offset
            for earliest in self._earliest:
                if earliest.stretch == self._stretch:
                    earliest.n -= back
        self._offset += min(0.0, self._lag(arrived))

    def _judge(self, arrived: float) -> None:
        """The last packet of a burst tells whether samples were lost before it; if not, it serves the fit."""
        self._count(arrived)
        lag = self._lag(arrived)
        last = self._earliest[-1] if self._earliest else None
        if last is not None and last.stretch == self._stretch and arrived - last.since < _WHILE_S:
            last.waits.append(lag)
            if lag < self._offset_of(last) - self._offset:
                last.arrived, last.n = arrived, self._n
            return
        if last is not None:
            self._fit()
        self._earliest.append(_Earliest(arrived, arrived, self._n, self._stretch, [lag]))

    def _count(self, arrived: float) -> None:
        """Count what must have been lost if this is the last packet of a burst."""
        lag = self._lag(arrived)
        if lag > self._longest + _MARGIN * self.period:
            lost = max(1, round((lag - self._longest / 2) / self.period))
            self._shift(lost)
            self._counted = arrived, lost, self._offset
            self._stretch += 1

    def _shift(self, samples: int) -> None:
        self._n += samples
        self.lost += samples

    def _stretches(self) -> list[list[_Earliest]]:
        """Whiles between which nothing was lost, as far as is known."""
        most = self._unnoticed()
        stretches = [[self._earliest[0]]]
        for before, after in pairwise(self._earliest):
            if before.stretch != after.stretch or _slope(before, after) > most:
                stretches.append([])
            stretches[-1].append(after)
        return stretches

    def _unnoticed(self) -> float:
        """The mean period [s] between two whiles that shows a loss which was not noticed when it came.

        Where packets come one by one, most whiles have none and agree; bursts do not tell.
        """
        slopes = [_slope(*pair) for pair in pairwise(self._earliest) if pair[0].stretch == pair[1].stretch]
        bursts = sum(len(earliest.waits) for earliest in self._earliest)
        if not slopes or self._n - self._earliest[0].n > _CROWDED * bursts:
            return math.inf
        usual = median(slopes)
        spread = median(abs(slope - usual) for slope in slopes)
        return usual + 3.0 * spread + _MARGIN * self.spacing**2 / _WHILE_S

    def _lately(self) -> Iterable[_Earliest]:
        return islice(reversed(self._earliest), _LATE)

    def _offset_of(self, earliest: _Earliest) -> float:
        return earliest.arrived - earliest.n * self.period

    def _fit(self) -> None:
        """The period by least squares over stretches without losses, near the nominal one; the offset below all."""
        weight = (_NOISE_S / (self.tolerance / 2 * self.spacing)) ** 2
        products = weight * self.spacing
        for stretch in self._stretches():
            points = [(earliest.n, earliest.arrived) for earliest in stretch]
            n, at = (sum(values) / len(points) for values in zip(*points, strict=True))
            weight += sum((k - n) ** 2 for k, _ in points)
            products += sum((k - n) * (arrived - at) for k, arrived in points)
        most = 1.2 * self.tolerance * self.spacing
        self.period = min(max(products / weight, self.spacing - most), self.spacing + most)
        self._offset = min(self._offset_of(earliest) for earliest in self._lately())
        if len(self._earliest) >= _LATE // 2:
            waits = [wait for earliest in self._lately() for wait in earliest.waits]
            self._longest = self.period * covered(wait / self.period for wait in waits)


def _slope(before: _Earliest, after: _Earliest) -> float:
    return (after.arrived - before.arrived) / (after.n - before.n)


def covered(turns: Iterable[float]) -> float:
    """The share of a circle that angles [turns] cover, in tenths; what a few of them reach does not count.

    Waits that keep step with the samples cover little of a period, however many samples were lost unnoticed.
    """
    counts = [0] * 10
    for turn in turns:
        counts[int(10 * (turn % 1.0)) % 10] += 1
    few = 0.04 * sum(counts)
    empty = "".join("e" if count <= few else "f" for count in counts) * 2
    return 1.0 - min(10, max(map(len, empty.split("f")))) / 10
