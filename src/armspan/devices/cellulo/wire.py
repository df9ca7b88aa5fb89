"""The bytes between a Cellulo robot and its host, without I/O: both directions, and the relay's own packets.

A packet is 01, a type, and a payload whose length the type tells; there is no checksum and no escape. Names and
arguments are EPFL's (chili-epfl/CelluloV2, CelluloBluetoothSharedDefs.h, CelluloBluetoothPacket.cpp).
"""

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import msgspec

from armspan.devices.cellulo import quantities as q
from armspan.devices.cellulo.quantities import Quantity, Value
from armspan.errors import DeviceError, known_names

START = 1
LED_TOP = 5  # the robot writes outside its array beyond that
BATTERY = ("discharging", "low", "charging", "charged", "not charging", "error")
GESTURES = ("none", "hold")


class Packet(msgspec.Struct, frozen=True):
    """A packet's meaning: ``args`` in the units that their names tell, ``raw`` the numbers that travelled."""

    name: str
    args: dict[str, Value]
    raw: tuple[int | float | bytes, ...]


@dataclass(frozen=True, slots=True)
class Layout:
    """A type of packet: its number in EPFL's list, its character, its fields in order."""

    number: int
    name: str
    char: str
    fields: tuple[tuple[str, Quantity], ...]

    @property
    def form(self) -> str:
        """The payload for `struct`."""
        return ">" + "".join(quantity.code for _, quantity in self.fields)

    @property
    def length(self) -> int:
        """Bytes of payload."""
        return struct.calcsize(self.form)


_X, _Y, _THETA = ("x_mm", q.POSITION), ("y_mm", q.POSITION), ("theta_deg", q.ANGLE)
_VMAX, _WMAX = ("v_max_mm_s", q.SPEED), ("w_max_rad_s", q.SPEED)
_CURVE = (
    *((f"{axis}{k}_mm", q.CONTROL) for k in (1, 2) for axis in "xy"),
    ("x3_mm", q.KNOT),
    ("y3_mm", q.KNOT),
)
_COMMANDS = (
    ("ping", "P", ()),
    ("setPoseBcastPeriod", "D", (("period_ms", q.PERIOD),)),
    ("setTimestampingEnabled", "T", (("enabled", q.FLAG),)),
    ("requestFrame", "F", ()),
    ("setExposureTime", "*", (("pixels", q.EXPOSURE),)),
    ("queryBatteryState", "B", ()),
    ("setLEDResponseMode", "L", (("mode", q.whole("B", 0, 2)),)),
    ("setLocomotionInteractivityMode", "I", (("mode", q.FLAG),)),
    ("setGestureEnabled", "U", (("enabled", q.FLAG),)),
    ("setCasualBackdriveAssistEnabled", "K", (("enabled", q.FLAG),)),
    ("setHapticBackdriveAssist", "Y", tuple((f"{axis}_coeff", q.VELOCITY) for axis in ("x", "y", "theta"))),
    (
        "setVisualEffect",
        "E",
        (("effect", q.whole("B", 0, 9)), *((shade, q.SHADE) for shade in ("red", "green", "blue", "value"))),
    ),
    ("setMotorOutput", "M", (("motor", q.whole("B", 1, 3)), ("output", q.PWM))),
    ("setAllMotorOutputs", "A", (("m1", q.PWM), ("m2", q.PWM), ("m3", q.PWM))),
    ("setGoalVelocity", "C", tuple((name, q.VELOCITY) for name in ("vx_mm_s", "vy_mm_s", "w_rad_s"))),
    ("setGoalPose", "G", (_X, _Y, _THETA, _VMAX, _WMAX)),
    ("setGoalPosition", "N", (_X, _Y, _VMAX)),
    ("setGoalXCoordinate", "-", (_X, _VMAX)),
    ("setGoalYCoordinate", "|", (_Y, _VMAX)),
    ("setGoalOrientation", "O", (_THETA, _WMAX)),
    ("setGoalXThetaCoordinate", "\\", (_X, _THETA, _VMAX, _WMAX)),
    ("setGoalYThetaCoordinate", "/", (_Y, _THETA, _VMAX, _WMAX)),
    ("clearTracking", "X", ()),
    (
        "simpleVibrate",
        "V",
        (*((f"i_{axis}", q.SPEED) for axis in ("x", "y", "theta")), ("period_ms", q.PERIOD), ("duration_ms", q.PERIOD)),
    ),
    ("vibrateOnMotion", "Z", (("coeff", q.SPEED), ("period_ms", q.PERIOD))),
    ("clearHapticFeedback", "H", ()),
    ("polyBezierInit", ".", (("x0_mm", q.KNOT), ("y0_mm", q.KNOT))),
    ("polyBezierAppend", "~", _CURVE),
    ("setGoalPolyBezier", "J", (("v_mm_s", q.SPEED), ("w_rad_s", q.VELOCITY))),
    ("setGoalPolyBezierAligned", "Q", (("v_mm_s", q.SPEED), _THETA, _WMAX)),
    ("reset", "R", ()),
    ("shutdown", "S", ()),
    ("SetAddress", "@", (("mac", q.MAC),)),
    ("SetConnectionStatus", "!", (("status", q.whole("B", 0, 2)), ("local_adapter", q.MAC))),
    ("Heartbeat", "&", ()),
)
_KEY = (("key", q.whole("B", 0, 5)),)
_COUNTS = q.whole("I", 0, 0xFFFFFFFF)
_POSE = (("x_raw", _COUNTS), ("y_raw", _COUNTS), ("theta_raw", q.whole("H", 0, q.COUNTS_PER_TURN - 1)))
_EVENTS = (
    ("bootComplete", "O", ()),
    ("shuttingDown", "D", ()),
    ("lowBattery", "W", ()),
    ("batteryStateChanged", "B", (("state", q.whole("B", 0, 5)),)),
    ("touchBegan", "T", _KEY),
    ("longTouch", "L", _KEY),
    ("touchReleased", "R", _KEY),
    ("gestureChanged", "H", (("gesture", q.FLAG),)),
    ("poseChanged", "P", _POSE),
    ("poseChangedTimestamped", "S", (*_POSE, ("timestamp_ms", _COUNTS))),
    ("kidnapChanged", "K", (("kidnapped", q.FLAG),)),
    ("trackingGoalReached", "G", ()),
    ("acknowledged", "A", ()),
    ("frameLine", "C", (("line", q.whole("H", 0, 119)), ("pixels", q.PIXELS))),
    ("debug", "E", (("a", _COUNTS), ("b", _COUNTS))),
    ("SetAddress", "@", (("mac", q.MAC),)),
    ("AnnounceConnectionStatus", "!", (("status", q.whole("B", 0, 2)), ("local_adapter", q.MAC))),
    ("AnnounceLocalAdapter", ">", (("added", q.FLAG), ("local_adapter", q.MAC))),
    ("Heartbeat", "&", ()),
)


@dataclass(frozen=True, slots=True)
class Direction:
    """All packets that travel one way, by name and by the character of their type."""

    what: str
    by_name: Mapping[str, Layout]
    by_char: Mapping[int, Layout]
    lengths: Mapping[int, int] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "lengths", {char: layout.length for char, layout in self.by_char.items()})

    def encode(self, name: str, **args: Value) -> bytes:
        """The bytes of a packet; what a number may be and how it is clamped is told by its quantity.

        Raises:
            DeviceError: for a name or an argument that does not exist or is missing, or a number that must not
                reach the wire.

        """
        layout = self.by_name.get(name)
        if layout is None:
            raise DeviceError(known_names(f"Cellulo {self.what}", name, self.by_name))
        _check_arguments(layout, args)
        raw = [_packed(layout, key, quantity, args[key]) for key, quantity in layout.fields]
        if name == "setVisualEffect":
            raw[4] = _existing_led(raw[0], raw[4])
        return bytes((START, ord(layout.char))) + struct.pack(layout.form, *raw)

    def decode(self, packet: bytes) -> Packet:
        """The meaning of one whole packet.

        Raises:
            DeviceError: where it is not one, or carries a number that cannot be (a heading of 360 degrees).

        """
        layout = self.by_char.get(packet[1]) if len(packet) > 1 and packet[0] == START else None
        if layout is None or len(packet) != 2 + layout.length:
            raise DeviceError(f"{packet[:20].hex() or 'nothing'} is not one Cellulo {self.what}: 01, type, payload")
        raw = struct.unpack(layout.form, packet[2:])
        args: dict[str, Value] = {}
        for (key, quantity), number in zip(layout.fields, raw, strict=True):
            try:
                args[key] = quantity.unpack(number)
            except ValueError as error:
                raise DeviceError(f"a Cellulo {self.what} {layout.name} has {key} {number}; expected {error}") from None
            args.update(_in_words(key, number))
        return Packet(layout.name, args, raw)


def _direction(what: str, rows: Iterable[tuple[str, str, tuple[tuple[str, Quantity], ...]]]) -> Direction:
    layouts = [Layout(number, *row) for number, row in enumerate(rows)]
    return Direction(what, {lay.name: lay for lay in layouts}, {ord(lay.char): lay for lay in layouts})


COMMANDS = _direction("command", _COMMANDS)
"""Host to robot; the relay's own three with them."""
EVENTS = _direction("event", _EVENTS)
"""Robot to host; the relay's own four with them."""
RELAY_ONLY = frozenset(b"@!>&")


class Framer:
    """Cuts a stream of bytes into whole packets, as the robot's and EPFL's receivers do.

    Bytes are skipped up to a 01; an unknown type is skipped with its 01; a payload is taken as it comes. On a
    robot's own link the relay's types are unknown.
    """

    def __init__(self, direction: Direction, *, relay: bool = False) -> None:
        lengths = direction.lengths
        self._lengths = {char: n for char, n in lengths.items() if relay or char not in RELAY_ONLY}
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """The packets that are complete now."""
        stream, at, packets = self._rest + data, 0, []
        while (start := stream.find(START, at)) >= 0 and start + 1 < len(stream):
            length = self._lengths.get(stream[start + 1], -1)
            end = start + 2 + length
            if end > len(stream):
                break
            if length >= 0:
                packets.append(stream[start:end])
            at = end if length >= 0 else start + 2
        self._rest = stream[start:] if start >= 0 else b""
        return packets


class Decoder:
    """A robot's link as one end hears it; ``refused`` counts packets that carried an impossible number."""

    def __init__(self, direction: Direction) -> None:
        self.refused = 0
        self._direction, self._framer = direction, Framer(direction)

    def feed(self, data: bytes) -> list[Packet]:
        """The packets that are complete now, without those that cannot be."""
        packets = []
        for whole_packet in self._framer.feed(data):
            try:
                packets.append(self._direction.decode(whole_packet))
            except DeviceError:
                self.refused += 1
        return packets


def _check_arguments(layout: Layout, args: Mapping[str, Value]) -> None:
    wanted = [key for key, _ in layout.fields]
    missing = [key for key in wanted if key not in args]
    if missing:
        raise DeviceError(f"{layout.name} needs {', '.join(missing)}; its arguments are {', '.join(wanted)}")
    for key in args:
        if key not in wanted:
            raise DeviceError(known_names(f"{layout.name}'s argument", key, wanted))


def _packed(layout: Layout, key: str, quantity: Quantity, value: Value) -> int | float | bytes:
    try:
        return quantity.pack(value)
    except ValueError as error:
        raise DeviceError(f"{layout.name}'s {key} is {value!r}; expected {error}") from None


def _existing_led(effect: int | float | bytes, value: int | float | bytes) -> int:
    """The effect's value with a light that the robot has."""
    number = int(value)
    if effect == 1:
        return min(number, LED_TOP)
    return (number & 0xF0) | min(number & 0x0F, LED_TOP) if effect == 3 else number


def _in_words(key: str, number: int) -> dict[str, Value]:
    """What an event's raw number means, beside it."""
    if key in ("x_raw", "y_raw"):
        return {key.replace("raw", "mm"): number * q.MM_PER_COUNT}
    if key == "theta_raw":
        return {"theta_deg": number / 100}
    if key == "kidnapped":
        return {key: bool(number)}
    if key == "state":
        return {"state_name": BATTERY[number]}
    return {"gesture_name": GESTURES[number]} if key == "gesture" else {}
