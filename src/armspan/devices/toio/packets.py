"""Every packet of a toio cube: its characteristic, its first bytes, its fields.

A packet begins with its type, but for the battery's, which has none (toio core cube specification,
toio.github.io/toio-spec, BLE protocol 2.0 to 2.5).
"""

from collections.abc import Mapping
from dataclasses import dataclass

from armspan.devices.toio.fields import (
    Field,
    constant,
    flag,
    keys_of,
    octets,
    one_of,
    real,
    steps,
    target_angle,
    text,
    wheel,
    whole,
)

SERVICE = "10b20100-5b3b-4571-9508-cf3efcd7bbae"
UUIDS: Mapping[str, str] = {
    name: SERVICE.replace("10b20100", f"10b201{number:02x}")
    for name, number in {
        "id": 0x01,
        "motor": 0x02,
        "light": 0x03,
        "sound": 0x04,
        "sensor": 0x06,
        "button": 0x07,
        "battery": 0x08,
        "configuration": 0xFF,
    }.items()
}
"""The characteristics by name."""
RESULTS = (
    "reached",
    "time-out",
    "off the mat",
    "no target",
    "switched off",
    "another command came",
    "not supported",
    "cannot be added",
)
POSTURES = ("", "upright", "upside down", "on its front", "on its back", "on its left side", "on its right side")


@dataclass(frozen=True, slots=True)
class Layout:
    """A kind of packet: its first bytes, its fields, and for some a list ``many`` of ``group`` s, ``most`` at most.

    ``counted`` lists have their length before them.
    """

    name: str
    characteristic: str
    head: bytes
    fields: tuple[Field, ...] = ()
    many: str = ""
    group: tuple[Field, ...] = ()
    most: int = 0
    counted: bool = False

    @property
    def arguments(self) -> tuple[str, ...]:
        """The names of its arguments."""
        return keys_of(self.fields) + ((self.many,) if self.many else ())


WHEELS = (wheel("left", 1), wheel("right", 2))
_DURATION = steps("duration_ms", 10)
_LAMP = (constant(1), constant(1), whole("red"), whole("green"), whole("blue"))
_SPOT = (whole("x", 0, 0xFFFF, "H"), whole("y", 0, 0xFFFF, "H"), target_angle())
_AIM = (
    whole("id"),
    whole("timeout_s"),
    whole("movement", 0, 2),
    whole("max_speed", 10),
    whole("change", 0, 3),
    constant(0),
)
_FORM = whole("form", 1, 3)
_WHEN = one_of("condition", 0, 1)
_COMMANDS = (
    Layout("motor", "motor", b"\x01", WHEELS),
    Layout("motorTimed", "motor", b"\x02", (*WHEELS, _DURATION)),
    Layout("motorTarget", "motor", b"\x03", (*_AIM, *_SPOT)),
    Layout("motorTargets", "motor", b"\x04", (*_AIM, flag("add")), "targets", _SPOT, 29),
    Layout(
        "motorAcceleration",
        "motor",
        b"\x05",
        (
            whole("speed"),
            whole("acceleration"),
            whole("turn_deg_s", 0, 0xFFFF, "H"),
            flag("turn_back"),
            flag("back"),
            flag("turn_first"),
            _DURATION,
        ),
    ),
    Layout("light", "light", b"\x03", (_DURATION, *_LAMP)),
    Layout(
        "lightSequence",
        "light",
        b"\x04",
        (whole("repeat"),),
        "operations",
        (steps("duration_ms", 10, 1), *_LAMP),
        29,
        True,
    ),
    Layout("lightsOff", "light", b"\x01"),
    Layout("lightOff", "light", b"\x02\x01\x01"),
    Layout("soundEffect", "sound", b"\x02", (whole("effect", 0, 10), whole("volume"))),
    Layout(
        "soundNotes",
        "sound",
        b"\x03",
        (whole("repeat"),),
        "notes",
        (steps("duration_ms", 10, 1), whole("note", 0, 128), whole("volume")),
        59,
        True,
    ),
    Layout("soundStop", "sound", b"\x01"),
    Layout("requestMotion", "sensor", b"\x81"),
    Layout("requestMagnet", "sensor", b"\x82"),
    Layout("requestPosture", "sensor", b"\x83", (_FORM,)),
    Layout("requestVersion", "configuration", b"\x01\x00"),
    Layout("setHorizontalThreshold", "configuration", b"\x05\x00", (whole("threshold_deg", 1, 45),)),
    Layout("setCollisionThreshold", "configuration", b"\x06\x00", (whole("level", 1, 10),)),
    Layout("setDoubleTapInterval", "configuration", b"\x17\x00", (whole("level", 0, 7),)),
    Layout(
        "setIdNotification",
        "configuration",
        b"\x18\x00",
        (steps("interval_ms", 10), one_of("condition", 0, 1, 255)),
    ),
    Layout("setIdMissed", "configuration", b"\x19\x00", (steps("sensitivity_ms", 10),)),
    Layout("setMagnet", "configuration", b"\x1b\x00", (whole("mode", 0, 2), steps("interval_ms", 20), _WHEN)),
    Layout("setMotorSpeed", "configuration", b"\x1c\x00", (flag("enabled"),)),
    Layout("setPosture", "configuration", b"\x1d\x00", (_FORM, steps("interval_ms", 10), _WHEN)),
    Layout("setSerialized", "configuration", b"\x1e\x00", (steps("interval_ms", 10), _WHEN)),
    Layout(
        "setConnectionInterval",
        "configuration",
        b"\x30\x00",
        (whole("least", 6, 0xFFFF, "H"), whole("most", 6, 0xFFFF, "H")),
    ),
    Layout("requestWantedInterval", "configuration", b"\x31\x00"),
    Layout("requestInterval", "configuration", b"\x32\x00"),
    Layout("powerOff", "configuration", b"\x34\x00", (whole("after_s"),)),
)
_RESULT = whole("result")
_REPLY = (whole("id"), whole("result", 0, len(RESULTS) - 1))
_TURNED = ("angle_deg", 0, 360, "H")
_EULER = ("roll_deg", "pitch_deg", "yaw_deg")
_EVENTS = (
    Layout(
        "idPosition",
        "id",
        b"\x01",
        (
            *_SPOT[:2],
            whole(*_TURNED),
            whole("sensor_x", 0, 0xFFFF, "H"),
            whole("sensor_y", 0, 0xFFFF, "H"),
            whole("sensor_angle_deg", 0, 360, "H"),
        ),
    ),
    Layout("idStandard", "id", b"\x02", (whole("value", 0, 0xFFFFFFFF, "I"), whole(*_TURNED))),
    Layout("idMissed", "id", b"\x03"),
    Layout("standardMissed", "id", b"\x04"),
    Layout("motorReply", "motor", b"\x83", _REPLY),
    Layout("motorTargetsReply", "motor", b"\x84", _REPLY),
    Layout("motorSpeeds", "motor", b"\xe0", (whole("left"), whole("right"))),
    Layout(
        "motion",
        "sensor",
        b"\x01",
        (
            flag("horizontal"),
            flag("collision"),
            flag("double_tap"),
            whole("posture", 1, len(POSTURES) - 1),
            whole("shake", 0, 10),
        ),
    ),
    Layout(
        "magnet",
        "sensor",
        b"\x02",
        (whole("state", 0, 6), whole("strength"), *(whole(axis, -10, 10, "b") for axis in "xyz")),
    ),
    Layout("postureEuler", "sensor", b"\x03\x01", tuple(whole(angle, -180, 180, "h") for angle in _EULER)),
    Layout("postureQuaternion", "sensor", b"\x03\x02", tuple(real(part, 1.001) for part in "wxyz")),
    Layout("postureEulerFine", "sensor", b"\x03\x03", tuple(real(angle, 180.0) for angle in _EULER)),
    Layout("button", "button", b"\x01", (flag("pressed", 0x80),)),
    Layout("battery", "battery", b"", (whole("percent", 0, 100),)),
    Layout("version", "configuration", b"\x81\x00", (text("version", 5),)),
    *(
        Layout(name, "configuration", bytes((number, 0)), (_RESULT,))
        for name, number in {
            "idNotificationSet": 0x98,
            "idMissedSet": 0x99,
            "magnetSet": 0x9B,
            "motorSpeedSet": 0x9C,
            "postureSet": 0x9D,
            "serializedSet": 0x9E,
            "connectionIntervalSet": 0xB0,
            "poweringOff": 0xB4,
        }.items()
    ),
    Layout(
        "wantedInterval",
        "configuration",
        b"\xb1\x00",
        (whole("least", 0, 0xFFFF, "H"), whole("most", 0, 0xFFFF, "H")),
    ),
    Layout("interval", "configuration", b"\xb2\x00", (whole("units", 0, 0xFFFF, "H"),)),
    Layout("serialized", "configuration", b"\xf0", (octets("data", 19),)),
)
COMMANDS: Mapping[str, Layout] = {layout.name: layout for layout in _COMMANDS}
"""Host to cube, by name."""
EVENTS: Mapping[str, Layout] = {layout.name: layout for layout in _EVENTS}
"""Cube to host, by name: notified, or read."""
ALL: Mapping[str, Layout] = {**COMMANDS, **EVENTS}
"""Both ways."""
