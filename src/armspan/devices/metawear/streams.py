"""A band's notifications as samples, without I/O.

A stream of the fusion carries orientations and nothing else: no number, no time, and the radio is too narrow for more.
Their times come from `StreamClock`, their rate from how the orientation turns, and the specific force is gravity as the
orientation says, so that an arm that is shaken does not show in it. Raw samples carry the board's clock.
"""

import math
from collections import deque
from dataclasses import dataclass, field

from armspan.clock import DeviceClock, StreamClock
from armspan.devices.metawear.counters import StreamCounters
from armspan.devices.metawear.notifications import TICK_S, Corrected, Fused, LogTime, Notification
from armspan.devices.metawear.notifications import Quaternion as Orientation
from armspan.records import ImuSample, Quaternion, Vec3

GRAVITY_M_S2 = 9.80665
TICK_BITS = 32
WIDTH = 4
"""A rate is that over so many samples: a lost one adds a quarter to it, and what trembles does not turn."""
VOID_S = 0.25
"""After a longer gap in raw samples nobody knows where the arm has turned."""


@dataclass(slots=True)
class FusionStream:
    """Orientations of the board's fusion, nominally ``rate`` a second [Hz]; ``whole`` where acc and gyro come too."""

    source: str
    rate: float = 100.0
    whole: bool = False
    counters: StreamCounters = field(default_factory=StreamCounters)
    last: float = -math.inf
    heard: float = -math.inf
    _clock: StreamClock = field(init=False)
    _turns: deque[tuple[int, Quaternion]] = field(default_factory=lambda: deque(maxlen=WIDTH + 1))
    _acc: Vec3 | None = None
    _gyr: Vec3 | None = None
    _mag: Vec3 | None = None
    _n: int = 0

    def __post_init__(self) -> None:
        self._clock = StreamClock(1.0 / self.rate)

    def renew(self) -> None:
        """The board began anew: its rhythm and heading are other ones; times go on."""
        self._clock = StreamClock(1.0 / self.rate)
        self._turns.clear()
        self.heard = -math.inf
        self._acc = self._gyr = self._mag = None

    def hear(self, notification: Notification, arrived: float) -> list[ImuSample]:
        """The sample that a notification completes, arrived at session time [s]."""
        match notification:
            case Corrected(output="corrected_acc"):
                self._acc = _scaled(notification.vector, GRAVITY_M_S2)
            case Corrected(output="corrected_gyro"):
                self._gyr = _scaled(notification.vector, math.pi / 180)
            case Corrected(output="corrected_mag"):
                self._mag = notification.vector
            case Orientation():
                return self._turn(notification, arrived)
        return []

    def _turn(self, orientation: Orientation, arrived: float) -> list[ImuSample]:
        quat = _unit((orientation.w, orientation.x, orientation.y, orientation.z))
        if quat is None:
            self.counters.refused += 1  # zeros: a fusion that has not come to life
            return []
        t = self._time(arrived)
        if self._turns and self._n - self._turns[-1][0] > VOID_S * self.rate:
            self._turns.clear()
        self._turns.append((self._n, quat))
        if self.whole:
            acc, gyr = self._acc, self._gyr
        else:
            acc, gyr = gravity_in_sensor(quat), self._rate()
        if acc is None or gyr is None:
            return []  # the first of a stretch: nothing tells yet how fast it turns
        self.counters.samples += 1
        return [ImuSample(t, self.source, acc, gyr, self._mag, quat)]

    def _time(self, arrived: float) -> float:
        before, lost = self.last, self._clock.lost
        t = max(self._clock.seconds(arrived), before)
        missing = self._clock.lost - lost
        if missing > 0:
            self.counters.gap(t, t - before, missing)
        elif missing < 0:
            self.counters.take_back(-missing)
        self._n += 1 + missing
        self.last, self.heard = t, arrived
        return t

    def _rate(self) -> Vec3 | None:
        """How fast the orientation turns [rad/s], in ``sensor``."""
        if len(self._turns) < 2:
            return None
        (before, old), (after, new) = self._turns[0], self._turns[-1]
        return turned(old, new, max(1, after - before) * self._clock.period)


@dataclass(slots=True)
class RawStream:
    """Acceleration and angular velocity of one instant with the board's clock, nominally ``rate`` a second [Hz]."""

    source: str
    rate: float = 100.0
    counters: StreamCounters = field(default_factory=StreamCounters)
    last: float = -math.inf
    heard: float = -math.inf
    void: bool = False
    _clock: DeviceClock = field(init=False)
    _tick: int | None = None
    _period: float = 0.0

    def __post_init__(self) -> None:
        self._clock = self._new_clock()

    def renew(self) -> None:
        """The board began anew, and so did its clock; session times go on."""
        self._clock, self._tick, self._period = self._new_clock(), None, 0.0
        self.heard = -math.inf

    def refer(self, reference: LogTime, arrived: float) -> None:
        """The board told its clock: the first samples of a burst need not."""
        self._clock.seconds(reference.tick, arrived)

    def hear(self, notification: Notification, arrived: float) -> list[ImuSample]:
        """The sample that a notification carries, arrived at session time [s]; ``void`` tells of a gap before it."""
        if not isinstance(notification, Fused):
            return []
        if self._tick is not None and (notification.tick - self._tick) % (1 << TICK_BITS) == 0:
            self.counters.refused += 1
            return []
        t = max(self._clock.seconds(notification.tick, arrived), self.last)
        self._miss(notification.tick, t)
        self.last, self.heard, self._tick = t, arrived, notification.tick
        self.counters.samples += 1
        acc, gyr = _scaled(notification.acc, GRAVITY_M_S2), _scaled(notification.gyro, math.pi / 180)
        return [ImuSample(t, self.source, acc, gyr)]

    def _miss(self, tick: int, t: float) -> None:
        """Count what is missing between two ticks; the chip's own rate is learnt from those that follow each other."""
        self.void = False
        if self._tick is None:
            return
        step = (tick - self._tick) % (1 << TICK_BITS) * TICK_S
        nominal = self._period or 1.0 / self.rate
        missing = round(step / nominal) - 1
        if missing > 0:
            self.counters.gap(t, step, missing)
        elif missing == 0:
            self._period = nominal + (step - nominal) / 256
        self.void = step > VOID_S

    def _new_clock(self) -> DeviceClock:
        return DeviceClock(TICK_S, bits=TICK_BITS, spacing=1.0 / self.rate)


def gravity_in_sensor(quat: Quaternion) -> Vec3:
    """The specific force of a sensor at rest [m/s²], in ``sensor``; ``quat`` is earth_from_sensor."""
    w, x, y, z = quat
    up = (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z)
    return _scaled(up, GRAVITY_M_S2)


def turned(old: Quaternion, new: Quaternion, seconds: float) -> Vec3:
    """The mean rate [rad/s], in ``sensor``, that turns one orientation (earth_from_sensor) into another."""
    a, b, c, d = old
    w, x, y, z = new
    real = a * w + b * x + c * y + d * z
    vector = (a * x - b * w - c * z + d * y, a * y + b * z - c * w - d * x, a * z - b * y + c * x - d * w)
    sine = math.hypot(*vector)
    if sine < 1e-12:
        return (0.0, 0.0, 0.0)
    angle = 2.0 * math.atan2(sine, abs(real))
    return _scaled(vector, math.copysign(angle / sine / seconds, real))


def _unit(quat: Quaternion) -> Quaternion | None:
    length = math.hypot(*quat)
    if not 0.9 < length < 1.1:
        return None
    w, x, y, z = quat
    return w / length, x / length, y / length, z / length


def _scaled(vector: Vec3, factor: float) -> Vec3:
    x, y, z = vector
    return x * factor, y * factor, z * factor
