"""The host's idea of one Cellulo robot, without I/O: packets to records, commands to an outbox.

What the firmware lacks is made up for here: it has no dead-man and resumes its goal when put down, so tracking is
cleared when a robot comes, is lifted, is put down, and when a motion's lease ends; nothing is acknowledged, so
a stop is sent three times; nothing is checked on the way, so a pose that jumps counts only once another agrees.
"""

import math
from dataclasses import dataclass, field
from typing import Literal

from armspan.clock import DeviceClock
from armspan.devices.cellulo.ring import Ring
from armspan.devices.cellulo.track import Track
from armspan.devices.cellulo.wire import COMMANDS, Packet
from armspan.errors import DeviceError
from armspan.records import Command, Drive, Event, GoTo, Haptic, Light, Link, RobotState, Stop, Touch, Vec2, is_finite

BROADCAST_MS = 20
STOPS = (0.0, 0.03, 0.06)
"""Seconds after a stop at which it is sent."""
PING_S, LOST_S, ASK_AGAIN_S = 1.0, 3.0, 2.0
KEEP_ALIVE_S = 4.0
"""Without anything sent to a robot that is there, it is pinged, as EPFL's client does."""
TURN_RAD_S = 7.5
"""EPFL's recommended limit, for goals with a heading."""
SHAKE_MM_S, SHAKE_MS = 60.0, 20.0
"""A haptic at full strength."""
BATTERY = {0: 0.5, 1: 0.02, 2: 0.5, 3: 1.0}
"""Shares, roughly: the robot tells no more than discharging, low, charging, charged."""
MODULE_ESCAPE = 0x24
"""Three of them in a row at the start of a write would have the radio module itself listen."""

CLEAR = COMMANDS.encode("clearTracking")
PING = COMMANDS.encode("ping")
ASK_BATTERY = COMMANDS.encode("queryBatteryState")
SETTINGS = (
    COMMANDS.encode("setPoseBcastPeriod", period_ms=BROADCAST_MS),
    COMMANDS.encode("setTimestampingEnabled", enabled=1),
)


@dataclass(frozen=True, slots=True)
class Placement:
    """Where the sheet lies in the robots' own coordinates: sheet = device x ``scale`` - ``origin`` [m]."""

    origin: Vec2 = (0.0, 0.0)
    scale: float = 1.0

    def sheet_from_mm(self, x_mm: float, y_mm: float) -> Vec2:
        """A device's place, on the sheet [m]."""
        return (x_mm / 1000 * self.scale - self.origin[0], y_mm / 1000 * self.scale - self.origin[1])

    def mm_from_sheet(self, xy: Vec2) -> Vec2:
        """A place on the sheet [m], in the device's millimetres."""
        return (1000 * (xy[0] + self.origin[0]) / self.scale, 1000 * (xy[1] + self.origin[1]) / self.scale)


class Outbox:
    """What waits for one robot: stops first, then the latest motion, then lights and the rest; late motions never.

    ``wrote`` [s] is when something was last due.
    """

    def __init__(self) -> None:
        self._stops: list[float] = []
        self._motion: tuple[bytes, float] | None = None
        self._lease: float | None = None
        self._rest: dict[object, bytes] = {}
        self.wrote = -math.inf

    def stop(self, now: float) -> None:
        """Clear tracking now and twice again; a motion that waits is void."""
        self._motion = self._lease = None
        self._stops = [now + after for after in STOPS]

    def move(self, packet: bytes, until: float, now: float) -> None:
        """Let the latest motion wait, void after ``until`` [s]; it ends the repeats of an older stop."""
        self._stops = [at for at in self._stops if at <= now]
        self._motion = packet, until

    def put(self, slot: object, packet: bytes) -> None:
        """Let another packet wait; the latest in a slot wins."""
        self._rest.pop(slot, None)
        self._rest[slot] = packet

    def due(self, now: float) -> list[bytes]:
        """What is to be written now, in order."""
        renewed = self._motion is not None and now < self._motion[1]
        if self._lease is not None and now >= self._lease and not renewed:
            self.stop(now)
        packets = [CLEAR] if self._stops and self._stops[0] <= now else []
        self._stops = [at for at in self._stops if at > now]
        if self._motion is not None and now < self._motion[1]:
            packets.append(self._motion[0])
            self._lease = self._motion[1]
        self._motion = None
        packets += self._rest.values()
        self._rest.clear()
        if packets:
            self.wrote = now
        return packets

    def wake(self) -> float:
        """When something is due again [s] though nothing new is put in."""
        times = [*self._stops[:1], *([self._lease] if self._lease is not None else [])]
        return min(times, default=math.inf)


@dataclass(slots=True)
class Robot:
    """One robot as its host knows it; ``up`` is None until its link is known.

    ``heard`` [s] is when it last told anything, or its link came; ``mute`` that its link came and nothing else ever.
    """

    name: str
    placement: Placement
    ring: Ring = field(default_factory=Ring)
    up: bool | None = None
    heard: float = -math.inf
    mute: bool = False
    outbox: Outbox = field(default_factory=Outbox)
    track: Track = field(default_factory=Track)
    _clock: DeviceClock = field(default_factory=lambda: DeviceClock(0.001, bits=32))
    _state: RobotState | None = None
    _battery: float | None = None
    _asked: float = -math.inf
    _pinged: float = -math.inf
    _met: bool = False

    # --- from the robot --------------------------------------------------------------------------------

    def linked(self, now: float, up: bool) -> list[Event]:
        """Its link came or went: told where that is news; who comes is stopped and set up before anything else."""
        news = up is not self.up
        self.up = up
        self.heard = now
        if not up:
            self.outbox = Outbox()
        elif news:
            self._meet()
            self.outbox.stop(now)
            self._set_up(now)
        return [Link(now, self.name, up)] if news else []

    def watch(self, now: float) -> list[Event]:
        """Ask a silent robot whether it is there; one that does not answer is lost until it is heard again."""
        if self.up is None:
            return []
        if now - self.heard >= PING_S or now - self.outbox.wrote >= KEEP_ALIVE_S:
            self.knock(now)
        if not self.up:
            return []
        if now - self.heard >= LOST_S:
            self.mute = not self._met
            return self.linked(now, False)
        if self._battery is None and now - self._asked >= ASK_AGAIN_S:
            self._set_up(now)
        return []

    def knock(self, now: float) -> None:
        """Ask whether it is there, once a second at most."""
        if now - self._pinged >= PING_S:
            self._pinged = now
            self.outbox.put("ping", PING)

    def hear(self, packet: Packet, arrived: float) -> list[Event]:
        """What a packet tells, arrived at session time [s]."""
        self._met = True
        events = self.linked(arrived, True) if not self.up else []
        self.heard = arrived
        match packet.name:
            case "poseChangedTimestamped" | "poseChanged":
                events += self._pose(packet, arrived)
            case "kidnapChanged":
                events += self._kidnap(bool(packet.args["kidnapped"]), arrived)
            case "touchBegan" | "longTouch" | "touchReleased":
                events.append(_touch(self.name, self.ring, packet, arrived))
            case "batteryStateChanged":
                self._battery = BATTERY.get(_whole(packet, "state"))
            case "lowBattery":
                self._battery = 0.0
            case "bootComplete":
                self._meet()
                self._set_up(arrived)
        return events

    def _meet(self) -> None:
        self.track.forget()
        self._clock = DeviceClock(0.001, bits=32)

    def _set_up(self, now: float) -> None:
        self._asked = now
        for slot, packet in enumerate((*SETTINGS, ASK_BATTERY)):
            self.outbox.put(slot, packet)

    def _pose(self, packet: Packet, arrived: float) -> list[Event]:
        numbers = [float(value) for value in packet.args.values() if isinstance(value, int | float)]
        _, x_mm, _, y_mm, _, theta_deg = numbers[:6]
        xy = self.placement.sheet_from_mm(x_mm, y_mm)
        ticks = _whole(packet, "timestamp_ms") if "timestamp_ms" in packet.args else None
        jumped = ticks is not None and self.track.clock_jumped(arrived, ticks)
        if not self.track.takes(arrived, xy, ticks):
            return []
        if jumped:
            self._clock = DeviceClock(0.001, bits=32)
        if ticks is None and arrived - self._asked >= ASK_AGAIN_S / 4:
            self._set_up(arrived)  # it was told to send time stamps: that packet was lost
        t = arrived if ticks is None else self._clock.seconds(ticks, arrived)
        t = max(t, self._state.t) if self._state is not None else t
        self._state = RobotState(t, self.name, xy, math.radians(theta_deg), False, self._battery)
        return [self._state]

    def _kidnap(self, held: bool, arrived: float) -> list[Event]:
        self.outbox.stop(arrived)
        self.track.forget()
        if self._state is None or not held:
            return []
        state = self._state
        t = max(arrived, state.t)
        self._state = RobotState(t, self.name, state.xy, state.heading, True, self._battery)
        return [self._state]

    # --- to it -----------------------------------------------------------------------------------------

    def take(self, command: Command, now: float) -> None:
        """Put a command into the outbox; a robot that is gone takes nothing.

        Raises:
            DeviceError: for a velocity, which the firmware would keep for ever, or a number that must not reach
                the wire.

        """
        if not is_finite(command):
            raise DeviceError(f"{command} has a number that is not finite; a robot would keep such a goal for ever")
        match command:
            case Stop():
                self.outbox.stop(now)
            case GoTo():
                packet = self._goal(command)
                if self.up:
                    self.outbox.move(packet, command.until, now)
            case Drive():
                raise DeviceError(
                    f"{self.name!r} was told a velocity, which a Cellulo keeps for ever once its host is gone; "
                    "send GoTo, a short way ahead"
                )
            case Light() | Haptic():
                slot, packet = _sign(command, self.ring)
                if self.up:
                    self.outbox.put(slot, packet)

    def _goal(self, command: GoTo) -> bytes:
        x_mm, y_mm = self.placement.mm_from_sheet(command.xy)
        v = 1000 * command.speed / self.placement.scale
        if command.heading is None:
            return COMMANDS.encode("setGoalPosition", x_mm=x_mm, y_mm=y_mm, v_max_mm_s=v)
        theta = math.degrees(command.heading)
        return COMMANDS.encode(
            "setGoalPose", x_mm=x_mm, y_mm=y_mm, theta_deg=theta, v_max_mm_s=v, w_max_rad_s=TURN_RAD_S
        )


def _sign(command: Light | Haptic, ring: Ring) -> tuple[object, bytes]:
    """The slot and the bytes of a light or a vibration."""
    if isinstance(command, Light):
        red, green, blue = command.colour
        if red == green == blue == MODULE_ESCAPE:
            blue += 1
        effect, value = (0, 0) if command.led is None else (1, ring.robots_own(command.led))
        args = {"effect": effect, "red": red, "green": green, "blue": blue, "value": value}
        return ("light", command.led), COMMANDS.encode("setVisualEffect", **args)
    push = SHAKE_MM_S * min(command.strength, 1.0)
    duration = max(1.0, 1000 * command.duration)  # 0 would be for ever
    shake = {"i_x": push, "i_y": push, "i_theta": 0, "period_ms": SHAKE_MS, "duration_ms": duration}
    return "haptic", COMMANDS.encode("simpleVibrate", **shake)


def _whole(packet: Packet, key: str) -> int:
    value = packet.args[key]
    return value if isinstance(value, int) else 0


def _touch(name: str, ring: Ring, packet: Packet, arrived: float) -> Touch:
    kinds: dict[str, Literal["began", "long"]] = {"touchBegan": "began", "longTouch": "long"}
    return Touch(arrived, name, ring.armspans(_whole(packet, "key")), kinds.get(packet.name, "released"))
