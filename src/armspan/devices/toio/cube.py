"""An emulated toio cube, without I/O and without a body: bytes written to it, bytes that it notifies.

It obeys the toio core cube specification (toio.github.io/toio-spec, BLE protocol 2.4): a write of the wrong length or
out of range is thrown away in silence, settings are forgotten when the link ends, a timed command ends by itself and
an untimed one never does, connected or not. Of its sensors it emulates position, button, battery and wheel speeds.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from armspan.devices.toio.aim import Aim
from armspan.devices.toio.fields import Value
from armspan.devices.toio.quantities import MOST, SPEED_M_S, WHEELS_APART_M
from armspan.devices.toio.wire import COMMANDS, Packet, decode, encode
from armspan.errors import DeviceError

VERSION = "2.4.0"
BATTERY_S, SPEEDS_S, CALM_S, ACCELERATE_S = 5.0, 0.1, 0.3, 0.1
REPLACED, UNSUPPORTED, NO_TARGET, FULL = 5, 6, 3, 7

Sight = tuple[int, int, int]
"""What the camera reads: x and y in position IDs, the angle in degrees."""
Note = tuple[str, bytes]
"""A notification: its characteristic's name, and its bytes."""


@dataclass(slots=True)
class Settings:
    """What a host may set, and what holds when none did."""

    interval_s: float = 0.01
    condition: int = 255
    missed_s: float = 0.07
    speeds: bool = False
    wanted: tuple[int, int] = (8, 80)


@dataclass(slots=True)
class Ramp:
    """A speed that grows to what was told (motor control with acceleration)."""

    goal: float
    turn: float
    rate: float
    turn_first: bool
    speed: float

    def wheels(self, seconds: float) -> tuple[int, int]:
        """Both speed values after another ``seconds``."""
        step = self.rate * seconds / ACCELERATE_S if self.rate else math.inf
        self.speed += min(max(self.goal - self.speed, -step), step)
        speed, turn = self.speed, self.turn
        over = abs(speed) + abs(turn) - MOST
        if over > 0 and self.turn_first:
            speed = math.copysign(max(abs(speed) - over, 0.0), speed)
        elif over > 0:
            turn = math.copysign(max(abs(turn) - over, 0.0), turn)
        return round(speed + turn), round(speed - turn)


@dataclass(slots=True)
class Cube:
    """One cube: ``wheels`` are the speed values that its motors are told now."""

    battery: int = 100
    settings: Settings = field(default_factory=Settings)
    wheels: tuple[int, int] = (0, 0)
    light: tuple[int, int, int] = (0, 0, 0)
    sounds: int = 0
    pressed: bool = False
    _end: float = math.inf
    _aim: Aim | None = None
    _next: Aim | None = None
    _ramp: Ramp | None = None
    _now: float = 0.0
    _sight: Sight | None = None
    _seen: float = -math.inf
    _told: tuple[float, Sight | None] = (-math.inf, None)
    _missed: bool = True
    _power: float = 0.0
    _speeds: tuple[float, tuple[int, int]] = (0.0, (0, 0))
    _light_end: float = math.inf
    _notes: list[Note] = field(default_factory=list)
    _last: dict[str, bytes] = field(default_factory=dict)

    def write(self, t: float, characteristic: str, data: bytes) -> None:
        """Take what a host writes at ``t`` [s]; what is wrong is thrown away."""
        try:
            packet = decode(characteristic, data)
        except DeviceError:
            if characteristic == "motor" and len(data) == 13 and data[0] == 3 and data[4] < 10:
                self._reply("motorReply", data[1], UNSUPPORTED)
            return
        if packet.name in COMMANDS:
            self._now = max(self._now, t)
            obey: Callable[[Packet], None] | None = {
                "motor": self._motor,
                "light": self._light,
                "sound": self._sound,
                "configuration": self._configure,
                "sensor": self._sense,
            }.get(characteristic)
            if obey is not None:
                obey(packet)

    def read(self, characteristic: str) -> bytes:
        """What a host reads of a characteristic."""
        if characteristic == "battery":
            return encode("battery", percent=self.battery)[1]
        if characteristic == "button":
            return encode("button", pressed=self.pressed)[1]
        if characteristic == "id":
            return self._position(self._sight) if self._sight else encode("idMissed")[1]
        return self._last.get(characteristic, b"")

    def press(self, down: bool) -> None:
        """The button is pressed, or let go."""
        self.pressed = down
        self._note(*encode("button", pressed=down))

    def unlinked(self) -> None:
        """The link ended: settings are forgotten, and nothing else happens."""
        self.settings = Settings()
        self._notes.clear()

    def frame(self, t: float, sight: Sight | None) -> list[Note]:
        """A hundredth of a second has passed and the camera reads ``sight``: what is notified."""
        seconds, self._now = max(t - self._now, 0.0), max(t, self._now)
        self._look(sight)
        if t >= self._end:
            self._run((0, 0))
        elif self._ramp is not None:
            self.wheels = self._ramp.wheels(seconds)
        elif self._aim is not None:
            self._follow(self._aim)
        if t >= self._light_end:
            self.light, self._light_end = (0, 0, 0), math.inf
        self._tell()
        notes, self._notes = self._notes, []
        return notes

    # --- motors ----------------------------------------------------------------------------------------

    def _motor(self, packet: Packet) -> None:
        args = packet.args
        if packet.name in ("motorTarget", "motorTargets"):
            self._target(packet)
            return
        self._replaced()
        duration = _int(args.get("duration_ms")) / 1000
        end = self._now + duration if duration else math.inf
        if packet.name == "motorAcceleration":
            running = self._ramp.speed if self._ramp else None
            self._run((0, 0), end)
            self._ramp = _ramp(args, running)
        else:
            self._run((_int(args["left"]), _int(args["right"])), end)

    def _run(self, wheels: tuple[int, int], end: float = math.inf) -> None:
        self.wheels, self._end = wheels, end
        self._aim = self._next = self._ramp = None

    def _target(self, packet: Packet) -> None:
        aim = Aim.of(packet, self._now, self._sight)
        reply = "motorTargetsReply" if packet.name == "motorTargets" else "motorReply"
        number = _int(packet.args["id"])
        if aim is None:
            self._reply(reply, number, NO_TARGET)
        elif packet.args.get("add") and self._aim is not None and self._aim.many:
            if self._next is not None:
                self._reply(reply, number, FULL)
            else:
                self._next = aim
        else:
            self._replaced()
            self._run((0, 0))
            self._aim = aim

    def _follow(self, aim: Aim) -> None:
        self.wheels, result = aim.drive(self._now, self._sight)
        if result is not None:
            following = self._next
            self._run((0, 0))
            self._reply(aim.reply, aim.number, result)
            if result == 0 and following is not None:
                following.begun = self._now
                self._aim = following

    def _replaced(self) -> None:
        for aim in (self._aim, self._next):
            if aim is not None:
                self._reply(aim.reply, aim.number, REPLACED)
        self._aim = self._next = None

    def _reply(self, name: str, number: int, result: int) -> None:
        self._note(*encode(name, id=number, result=result))

    # --- the rest --------------------------------------------------------------------------------------

    def _light(self, packet: Packet) -> None:
        if packet.name in ("lightOff", "lightsOff"):
            self.light, self._light_end = (0, 0, 0), math.inf
        elif packet.name == "light":
            red, green, blue = (_int(packet.args[shade]) for shade in ("red", "green", "blue"))
            ms = _int(packet.args["duration_ms"])
            self.light, self._light_end = (red, green, blue), self._now + ms / 1000 if ms else math.inf

    def _sound(self, packet: Packet) -> None:
        self.sounds += packet.name != "soundStop"

    def _sense(self, packet: Packet) -> None:
        if packet.name == "requestMotion":
            upright = {"horizontal": True, "collision": False, "double_tap": False, "posture": 1, "shake": 0}
            self._note(*encode("motion", **upright))

    def _configure(self, packet: Packet) -> None:
        args, settings = packet.args, self.settings
        match packet.name:
            case "requestVersion":
                self._note(*encode("version", version=VERSION))
            case "setIdNotification":
                settings.interval_s = _int(args["interval_ms"]) / 1000
                settings.condition = _int(args["condition"])
                self._note(*encode("idNotificationSet", result=0))
            case "setIdMissed":
                settings.missed_s = _int(args["sensitivity_ms"]) / 1000
                self._note(*encode("idMissedSet", result=0))
            case "setMotorSpeed":
                settings.speeds = bool(args["enabled"])
                self._note(*encode("motorSpeedSet", result=0))
            case "setMagnet":
                self._note(*encode("magnetSet", result=0))
            case "setPosture":
                self._note(*encode("postureSet", result=0))
            case "setConnectionInterval":
                settings.wanted = _int(args["least"]), _int(args["most"])
                self._note(*encode("connectionIntervalSet", result=0))
            case "requestWantedInterval":
                self._note(*encode("wantedInterval", least=settings.wanted[0], most=settings.wanted[1]))
            case "requestInterval":
                self._note(*encode("interval", units=24))

    def _look(self, sight: Sight | None) -> None:
        self._sight = sight
        if sight is not None:
            self._seen, self._missed = self._now, False
        elif not self._missed and self._now - self._seen >= self.settings.missed_s:
            self._missed = True
            self._told = (-math.inf, None)
            self._note(*encode("idMissed"))

    def _tell(self) -> None:
        """Notify the place, the battery and the wheels' speeds where that is due."""
        at, before = self._told
        due = self._now - at >= self.settings.interval_s - 1e-6
        if self._sight is not None and due and self._changed(before, self._now - at):
            self._note("id", self._position(self._sight))
            self._told = (self._now, self._sight)
        if self._now >= self._power:
            self._power = self._now + BATTERY_S
            self._note(*encode("battery", percent=self.battery))
        if self.settings.speeds and self._now - self._speeds[0] >= SPEEDS_S and self._speeds[1] != self.wheels:
            self._speeds = (self._now, self.wheels)
            left, right = (min(abs(value), MOST) for value in self.wheels)
            self._note(*encode("motorSpeeds", left=left, right=right))

    def _changed(self, before: Sight | None, since: float) -> bool:
        """Whether a place is told under the condition that was set."""
        sight, condition = self._sight, self.settings.condition
        if before is None or sight is None or condition == 0:
            return True
        if condition == 255:
            return sight != before or since >= CALM_S
        turned = abs((sight[2] - before[2] + 180) % 360 - 180)
        return max(abs(sight[0] - before[0]), abs(sight[1] - before[1])) >= 2 or turned >= 3

    def _position(self, sight: Sight) -> bytes:
        x, y, angle = sight
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        back, aside = 8, 5  # the camera looks down from behind the middle, left of it: the specification's example
        sensor = round(max(x - back * c + aside * s, 0)), round(max(y - back * s - aside * c, 0))
        where = {"sensor_x": sensor[0], "sensor_y": sensor[1], "sensor_angle_deg": angle}
        return encode("idPosition", x=x, y=y, angle_deg=angle, **where)[1]

    def _note(self, characteristic: str, data: bytes) -> None:
        self._last[characteristic] = data
        self._notes.append((characteristic, data))


def _int(value: object) -> int:
    return int(value) if isinstance(value, int | float) else 0


def _ramp(args: Mapping[str, Value], running: float | None) -> Ramp:
    speed = float(_int(args["speed"])) * (-1 if args["back"] else 1)
    turn = math.radians(_int(args["turn_deg_s"])) * WHEELS_APART_M / 2 / SPEED_M_S * (-1 if args["turn_back"] else 1)
    rate = float(_int(args["acceleration"])) if running is not None else 0.0
    return Ramp(speed, turn, rate, bool(args["turn_first"]), running if running is not None else speed)
