"""Sensor Logger's HTTP push: bytes in, records out.

A message is ``{messageId, sessionId, deviceId, payload: [{name, time [ns UTC], values}]}``; messages hold a batch
and may overtake each other (facts and units: awesome-sensor-logger, PUSHING.md, UNITS.md, COORDINATES.md). From the
phone ``accelerometer`` is without gravity, ``gravity`` is apart and ``totalacceleration``, on Android only, is the
two together, all in m/s²; from the watch everything is in one reading, in g from Apple's unless its units are
standardised.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import msgspec

from armspan.devices.phone.band import Band
from armspan.devices.phone.readings import FASTEST, GRAVITY, STRONGEST, quaternion, vector
from armspan.devices.phone.timeline import STEP_NS, Timeline
from armspan.devices.phone.weave import Weave
from armspan.errors import DeviceError
from armspan.records import Event, Vec3

PATIENCE = 0.5
"""Seconds for which a message that was overtaken is waited for."""
HELD = 64
"""Messages that may wait for one that was overtaken."""
_IN_G = 3.0
"""A gravity [in its unit] below this is told in g."""

T = TypeVar("T")


class Reading(NamedTuple):
    """What a ``sensor`` said, in SI units, at its time [ns]."""

    taken: int
    sensor: str
    values: tuple[float, ...]


class _Item(msgspec.Struct, frozen=True):
    name: str
    time: int | float
    values: msgspec.Raw = msgspec.Raw(b"{}")


class Message(msgspec.Struct, frozen=True):
    """A push; its readings are looked at only where they are wanted."""

    payload: tuple[_Item, ...] = ()
    message: int = msgspec.field(default=0, name="messageId")
    session: str = msgspec.field(default="", name="sessionId")
    device: str = msgspec.field(default="", name="deviceId")


class _Three(msgspec.Struct, frozen=True):
    x: float
    y: float
    z: float


class _Attitude(msgspec.Struct, frozen=True):
    qw: float
    qx: float
    qy: float
    qz: float


class _Wrist(msgspec.Struct, frozen=True, rename="camel"):
    rotation_rate_x: float
    rotation_rate_y: float
    rotation_rate_z: float
    gravity_x: float
    gravity_y: float
    gravity_z: float
    acceleration_x: float
    acceleration_y: float
    acceleration_z: float
    quaternion_w: float | None = None
    quaternion_x: float | None = None
    quaternion_y: float | None = None
    quaternion_z: float | None = None


_MESSAGE = msgspec.json.Decoder(Message)
_THREE = msgspec.json.Decoder(_Three)
_ATTITUDE = msgspec.json.Decoder(_Attitude)
_WRIST = msgspec.json.Decoder(_Wrist)
_GYRO, _ATTITUDE_OF, _SIGN = "gyroscope", "attitude", "sign"
_FORCES = {"accelerometer": "motion", "gravity": "gravity", "totalacceleration": "total"}
_WRISTS = ("wristmotion",)


def message_from_bytes(data: bytes) -> Message:
    """A push, as far as it concerns everybody.

    Raises:
        DeviceError: for what is not of its form.

    """
    return _decoded(_MESSAGE.decode, data, "a push of Sensor Logger")


def _decoded(decode: Callable[[bytes], T], data: bytes | msgspec.Raw, what: str) -> T:
    try:
        return decode(bytes(data))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise DeviceError(f"this is not {what}: {error}") from None


def _nanoseconds(item: _Item) -> int:
    if not 0 <= item.time < 2**63:
        raise DeviceError(f"{item.name} has the time {item.time}; expected nanoseconds since 1970")
    return int(item.time)


def _plain(name: str) -> str:
    return name.lower().replace(" ", "").replace("_", "")


@dataclass(slots=True)
class _Order:
    """Messages in the order of their numbers; those that stay away are skipped after a while, and counted."""

    lost: int = 0
    _next: int | None = None
    _waiting: dict[int, tuple[float, list[Reading]]] = field(default_factory=dict)

    def feed(self, number: int, readings: list[Reading], arrived: float) -> list[Reading]:
        """What may be told now that a message came."""
        if self._next is None:
            self._next = number
        if number >= self._next:
            self._waiting.setdefault(number, (arrived, readings))
        return self.due(arrived)

    def due(self, now: float) -> list[Reading]:
        """What may be told at session time ``now`` [s]."""
        ready: list[Reading] = []
        while self._waiting and self._next is not None:
            if self._next not in self._waiting:
                first = min(self._waiting)
                if now - self._waiting[first][0] < PATIENCE and len(self._waiting) < HELD:
                    break
                self.lost += first - self._next
                self._next = first
            ready += self._waiting.pop(self._next)[1]
            self._next += 1
        return ready


class SensorLogger:
    """One band of a phone's or a watch's pushes, from its bytes.

    ``watch`` takes the watch's ``wrist motion``, else the phone's own sensors are taken.
    """

    def __init__(self, band: Band, *, watch: bool = False) -> None:
        self.band, self._watch = band, watch
        self._session: str | None = None
        self._order, self._timeline, self._weave = _Order(), Timeline(), Weave(_GYRO)
        self._newest = 0

    def feed(self, data: bytes, arrived: float) -> list[Event]:
        """What a push that arrived at session time [s] tells.

        Raises:
            DeviceError: for a push that cannot be read; nothing of it is told.

        """
        try:
            return self.take(message_from_bytes(data), arrived)
        except DeviceError:
            self.band.counters.malformed += 1
            raise

    def take(self, message: Message, arrived: float) -> list[Event]:
        """What a push tells that has been looked at already (DeviceError for readings that cannot be)."""
        readings = [
            Reading(_nanoseconds(item), sensor, values)
            for item in message.payload
            for sensor, values in _values(_plain(item.name), item.values, self._watch)
        ]
        if message.session != self._session:
            self._began(message.session)
        events = self._told(self._order.feed(message.message, readings, arrived), arrived)
        if readings:
            self.band.batch(arrived, (max(readings).taken - min(readings).taken) * 1e-9)
        return events

    def watch(self, now: float) -> list[Event]:
        """What follows from the time that passed: overtaken messages given up, the link's end."""
        return [*self._told(self._order.due(now), now), *self.band.watch(now)]

    def _began(self, session: str) -> None:
        """A new recording: other numbers, and on a watch another heading."""
        if self._session is not None:
            self.band.begin()
        self._session, self._order = session, _Order(self._order.lost)

    def _told(self, readings: list[Reading], arrived: float) -> list[Event]:
        readings = sorted(readings)
        if readings and readings[-1].taken < self._newest - STEP_NS:
            self._weave.begin()
        for taken, sensor, values in readings:
            self._newest = taken
            if sensor == _SIGN:
                self.band.upright.assume(values[0])
            else:
                self._weave.put(sensor, taken, values)
        complete = self._weave.take()
        times = self._timeline.seconds([taken for taken, _ in complete], arrived)
        events = [event for t, (_, told) in zip(times, complete, strict=True) for event in self._feel(t, told, arrived)]
        self.band.counters.lost, self.band.counters.steps = self._order.lost, self._timeline.steps
        return events

    def _feel(self, t: float, told: dict[str, tuple[float, ...]], arrived: float) -> list[Event]:
        force = _force(told)
        if force is None:
            return []
        counters = self.band.counters
        counters.wait = max(counters.wait, arrived - t)
        x, y, z = told[_GYRO]
        attitude = quaternion(*told[_ATTITUDE_OF]) if _ATTITUDE_OF in told else None
        return self.band.feel(t, force, (x, y, z), attitude)


def _force(told: dict[str, tuple[float, ...]]) -> Vec3 | None:
    """Acceleration with gravity [m/s²] in the app's own sign; both of its parts have the same."""
    if "total" in told:
        x, y, z = told["total"]
    elif "motion" in told and "gravity" in told:
        x, y, z = (a + b for a, b in zip(told["motion"], told["gravity"], strict=True))
    else:
        return None
    return (x, y, z)


def _values(name: str, raw: msgspec.Raw, watch: bool) -> list[tuple[str, tuple[float, ...]]]:
    """What a reading means: sensors and their values, of those that are wanted."""
    if watch:
        return _of_wrist(_decoded(_WRIST.decode, raw, "wrist motion")) if name in _WRISTS else []
    if name in _FORCES or name == _GYRO:
        three = _decoded(_THREE.decode, raw, name)
        most = FASTEST if name == _GYRO else STRONGEST
        return [(_FORCES.get(name, name), vector((three.x, three.y, three.z), name, most))]
    if name == "orientation":
        q = _decoded(_ATTITUDE.decode, raw, name)
        return [(_ATTITUDE_OF, quaternion(q.qw, q.qx, q.qy, q.qz))]
    return []


def _of_wrist(told: _Wrist) -> list[tuple[str, tuple[float, ...]]]:
    gravity = (told.gravity_x, told.gravity_y, told.gravity_z)
    motion = (told.acceleration_x, told.acceleration_y, told.acceleration_z)
    apple = sum(value * value for value in gravity) < _IN_G**2
    unit = GRAVITY if apple else 1.0
    total = [unit * (a + b) for a, b in zip(gravity, motion, strict=True)]
    rate = (told.rotation_rate_x, told.rotation_rate_y, told.rotation_rate_z)
    found: list[tuple[str, tuple[float, ...]]] = [
        ("total", vector(total, "wrist motion", STRONGEST)),
        (_GYRO, vector(rate, "wrist motion", FASTEST)),
        (_SIGN, (-1.0 if apple else 1.0,)),
    ]
    w, x, y, z = told.quaternion_w, told.quaternion_x, told.quaternion_y, told.quaternion_z
    if w is not None and x is not None and y is not None and z is not None:
        found.append((_ATTITUDE_OF, quaternion(w, x, y, z)))
    return found
