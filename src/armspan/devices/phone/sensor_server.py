"""SensorServer's WebSocket on Android: texts in, records out.

A text is ``{type, values, timestamp [ns since the phone began], accuracy}``. The acceleration has gravity in it and
points up at rest; a rotation vector is x, y, z, w, and its length is one (facts: its README; Android's SensorEvent).
The game rotation vector is taken where there is one, since iron and robots turn a magnet.
"""

import json
from dataclasses import dataclass, field
from urllib.parse import quote

import msgspec

from armspan.devices.phone.band import Band
from armspan.devices.phone.readings import FASTEST, STRONGEST, quaternion, vector
from armspan.devices.phone.timeline import STEP_NS, Timeline
from armspan.devices.phone.weave import Weave
from armspan.errors import DeviceError
from armspan.records import Event

_KIND = "android.sensor."
FORCE, RATE = _KIND + "accelerometer", _KIND + "gyroscope"
GAME, MAGNETIC = _KIND + "game_rotation_vector", _KIND + "rotation_vector"
SENSORS: tuple[tuple[str, ...], ...] = ((FORCE, RATE, GAME), (FORCE, RATE, MAGNETIC), (FORCE, RATE))
"""What is asked for, the best first: a phone that has not all of them refuses the whole question."""


def query(base: str, sensors: tuple[str, ...]) -> str:
    """Where to ask for these sensors, at a phone's ``ws://HOST:PORT``."""
    return f"{base.rstrip('/')}/sensors/connect?types={quote(json.dumps(sensors, separators=(',', ':')))}"


class _Text(msgspec.Struct, frozen=True):
    values: tuple[float, ...]
    timestamp: int
    type: str


_DECODER = msgspec.json.Decoder(_Text)


@dataclass(slots=True)
class SensorServer:
    """One phone's texts as a band."""

    band: Band
    _timeline: Timeline = field(default_factory=Timeline)
    _weave: Weave = field(default_factory=lambda: Weave(RATE))
    _newest: int = 0

    def begin(self) -> None:
        """A new connection: Android starts the sensors anew, and the heading with them."""
        self._weave.begin()
        self.band.begin()

    def feed(self, data: bytes, arrived: float) -> list[Event]:
        """What a text that arrived at session time [s] tells.

        Raises:
            DeviceError: for a text that cannot be read.

        """
        try:
            text = _decoded(data)
            values = _values(text)
        except DeviceError:
            self.band.counters.malformed += 1
            raise
        if values is None:
            return []
        self.band.batch(arrived)
        if text.timestamp < self._newest - STEP_NS:
            self._weave.begin()
        self._newest = text.timestamp
        self._weave.put(text.type, text.timestamp, values)
        return self._told(arrived)

    def watch(self, now: float) -> list[Event]:
        """The link's end, where nothing came for too long."""
        return self.band.watch(now)

    def _told(self, arrived: float) -> list[Event]:
        complete = self._weave.take()
        times = self._timeline.seconds([taken for taken, _ in complete], arrived)
        self.band.counters.steps = self._timeline.steps
        events: list[Event] = []
        for t, (_, told) in zip(times, complete, strict=True):
            if FORCE in told:
                (ax, ay, az), (x, y, z) = told[FORCE], told[RATE]
                turn = told.get(GAME) or told.get(MAGNETIC)
                events += self.band.feel(t, (ax, ay, az), (x, y, z), quaternion(*turn) if turn else None)
        return events


def _decoded(data: bytes) -> _Text:
    try:
        text = _DECODER.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise DeviceError(f"this is no text of SensorServer: {error}") from None
    if not 0 <= text.timestamp < 2**63:
        raise DeviceError(f"the timestamp is {text.timestamp}; expected nanoseconds since the phone began")
    return text


def _values(text: _Text) -> tuple[float, ...] | None:
    """A sensor's values, scalar first where they are an attitude; None of a sensor that was not asked for."""
    match text.type:
        case "android.sensor.accelerometer":
            return vector(text.values, "the acceleration", STRONGEST)
        case "android.sensor.gyroscope":
            return vector(text.values, "the rate of turn", FASTEST)
        case "android.sensor.game_rotation_vector" | "android.sensor.rotation_vector":
            return _attitude(text.values)
    return None


def _attitude(values: tuple[float, ...]) -> tuple[float, ...]:
    if len(values) < 3:
        raise DeviceError(f"a rotation vector has {len(values)} numbers; expected x, y, z and w")
    x, y, z = values[:3]
    rest = 1.0 - (x * x + y * y + z * z)
    w = values[3] if len(values) > 3 else max(rest, 0.0) ** 0.5  # left out by the oldest of Androids
    return quaternion(w, x, y, z)
