"""Our own page's texts: what the page says, what it is answered, and the records in it.

A text is one of

* ``{"hello": {"page": ID, "apple": true or false}}``, first on each connection; another ID is another page,
* ``{"n": k, "t": ms, "a": [x, y, z], "r": [x, y, z], ...}``, a sample: its number, its time since the page's time
  origin, acceleration with gravity [m/s²], rate of turn [deg/s] as alpha, beta, gamma, which browsers turn about x, y
  and z in this order (w3c/deviceorientation, issue 44); and the attitude, as the ``RelativeOrientationSensor``'s
  ``"q": [x, y, z, w]`` or as ``"o": [alpha, beta, gamma]`` [deg], with the time ``"u"`` [ms] it was read at,
* ``{"stop": k}`` and ``{"tap": count}``.
"""

import math
from dataclasses import dataclass, field

import msgspec

from armspan.devices.phone.band import Band
from armspan.devices.phone.readings import FASTEST, STRONGEST, quaternion, quaternion_from_angles, turned, vector
from armspan.devices.phone.timeline import Timeline
from armspan.errors import DeviceError
from armspan.records import Event, Press, Quaternion, Tap, Vec3

LARGEST = 4096
"""Bytes of a text."""
_OLDEST_ATTITUDE = 0.1
_MOST_TAPS = 9


class Hello(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Which page it is, and whether it is on a system that counts acceleration the other way round."""

    page: str
    apple: bool = False


class Text(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What the page may say; see the module."""

    hello: Hello | None = None
    n: int | None = None
    t: float | None = None
    a: Vec3 | None = None
    r: Vec3 | None = None
    q: tuple[float, float, float, float] | None = None
    o: Vec3 | None = None
    u: float | None = None
    stop: int | None = None
    tap: int | None = None


_DECODER = msgspec.json.Decoder(Text)


@dataclass(slots=True)
class Browser:
    """One phone's page as a band."""

    band: Band
    _timeline: Timeline = field(default_factory=Timeline)
    _page: str | None = None
    _number: int | None = None

    def feed(self, data: bytes, arrived: float) -> list[Event]:
        """What a text that arrived at session time [s] tells.

        Raises:
            DeviceError: for a text that cannot be read.

        """
        try:
            return self._take(_decoded(data), arrived)
        except DeviceError:
            self.band.counters.malformed += 1
            raise

    def hello(self, data: bytes) -> Hello:
        """What a page says first (DeviceError for anything else, counted)."""
        try:
            found = _decoded(data).hello
            if found is None:
                raise DeviceError("the page does not begin with hello; load it again")
        except DeviceError:
            self.band.counters.malformed += 1
            raise
        return found

    def watch(self, now: float) -> list[Event]:
        """The link's end, where nothing came for too long."""
        return self.band.watch(now)

    def _take(self, text: Text, arrived: float) -> list[Event]:
        if text.hello is not None:
            return self._hello(text.hello)
        if text.stop is not None:
            return [Press(arrived, "stop", self.band.name)]
        if text.tap is not None:
            if not 1 <= text.tap <= _MOST_TAPS:
                raise DeviceError(f"the page says {text.tap} taps in a row; expected 1 to {_MOST_TAPS}")
            return [Tap(arrived, self.band.name, text.tap)]
        return self._sample(text, arrived)

    def _hello(self, hello: Hello) -> list[Event]:
        if hello.page != self._page:
            if self._page is not None:
                self.band.begin()
            self._page, self._number, self._timeline = hello.page, None, Timeline(self._timeline.steps)
            self.band.upright.assume(-1.0 if hello.apple else 1.0)
        return []

    def _sample(self, text: Text, arrived: float) -> list[Event]:
        if text.n is None or text.t is None or text.a is None or text.r is None:
            raise DeviceError("the page says neither hello, stop, tap nor a sample with n, t, a and r")
        if not (0 <= text.n < 2**53 and 0 <= text.t < 1e12):
            raise DeviceError(f"the page's sample has n = {text.n} and t = {text.t}; expected a count and milliseconds")
        acc = vector(text.a, "the acceleration", STRONGEST)
        x, y, z = (math.radians(value) for value in vector(text.r, "the rate of turn", math.degrees(FASTEST)))
        attitude = self._attitude(text, (x, y, z))
        self._count(text.n)
        [t] = self._timeline.seconds([round(text.t * 1e6)], arrived)
        self.band.counters.steps = self._timeline.steps
        self.band.batch(arrived)
        self.band.counters.wait = max(self.band.counters.wait, arrived - t)
        return self.band.feel(t, acc, (x, y, z), attitude)

    def _attitude(self, text: Text, gyr: Vec3) -> Quaternion | None:
        """The attitude at the sample's time: browsers tell the two at times of their own."""
        if text.q is not None:
            x, y, z, w = text.q
            attitude = quaternion(w, x, y, z)
        elif text.o is not None:
            attitude = quaternion_from_angles(*vector(text.o, "the orientation", 720.0))
        else:
            return None
        age = 0.0 if text.u is None or text.t is None else (text.t - text.u) / 1000.0
        if not abs(age) <= _OLDEST_ATTITUDE:
            return None
        return turned(attitude, gyr, age)

    def _count(self, number: int) -> None:
        if self._number is not None:
            self.band.counters.lost += max(0, number - self._number - 1)
        self._number = number if self._number is None else max(self._number, number)


def _decoded(data: bytes) -> Text:
    if len(data) > LARGEST:
        raise DeviceError(f"the page's text has {len(data)} bytes; expected {LARGEST} at most")
    try:
        return _DECODER.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise DeviceError(f"this is no text of our page: {error}") from None
