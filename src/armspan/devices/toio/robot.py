"""The host's idea of one toio cube, without I/O: packets to records, commands to packets.

A cube obeys its last untimed command for ever, so it is never told one, but for standstill: it is driven by pulses
that end by themselves within 0.2 s, planned anew twenty times a second as long as a lease lasts. A dead process or link
leaves it at rest. A stop is sent three times, as its writes are not acknowledged.
"""

import math
from dataclasses import dataclass, field

from armspan.devices.toio.pilot import HOLD_S, TICK_S, Pilot
from armspan.devices.toio.quantities import UNIT_M
from armspan.devices.toio.reckoning import REST, Pulse, Reckoning, wrapped
from armspan.devices.toio.wire import Packet, encode
from armspan.errors import DeviceError
from armspan.records import Command, Drive, Event, GoTo, Haptic, Light, Link, RobotState, Stop, Touch, Vec2, is_finite

PLACES_MS = 20
"""How often a cube tells its place, changed or not: from one that is silent nothing is known."""
OLDEST_VERSION = (2, 2)
STOPS = (0.0, 0.03, 0.06)
"""Seconds after a stop at which it is sent."""
REFRESH_S, SOONEST_S = 0.05, 0.02
"""Between two pulses for a goal, and the least where the goal is new."""
BLIND_S, LOST_S, LONG_S = 0.25, 3.0, 1.0
"""A cube whose place is older is not driven; one that is silent for longer is lost; a long touch."""
NOTE, FULL_VOLUME = 45, 255
JUMP_M, FASTEST_M_S = 0.03, 0.5
PUSHED_M, TRUST, TRUST_HEADING = 0.01, 0.2, 0.4
"""How much of a place and a heading that a cube tells is taken; where it is farther off than that, all of it."""
JUST = 1e-6
"""So that a moment counts as come in spite of rounding [s]."""

Write = tuple[str, bytes]
"""A characteristic's name, and what to write to it."""
STANDSTILL = encode("motor", left=0, right=0)
SETTINGS = (
    encode("setIdNotification", interval_ms=PLACES_MS, condition=0),
    encode("requestVersion"),
)


@dataclass(frozen=True, slots=True)
class Placement:
    """Where the sheet lies: position IDs of the mat's ``corner``, and the sheet's ``origin`` [m] from there."""

    corner: Vec2 = (45.0, 45.0)
    origin: Vec2 = (0.0, 0.0)

    def sheet_from_ids(self, x: float, y: float) -> Vec2:
        """A place in position IDs, on the sheet [m]."""
        return (x - self.corner[0]) * UNIT_M - self.origin[0], (y - self.corner[1]) * UNIT_M - self.origin[1]


@dataclass(slots=True)
class Robot:
    """One cube as its host knows it; ``up`` is None until its link is known."""

    name: str
    placement: Placement
    up: bool | None = None
    pilot: Pilot = field(default_factory=Pilot)
    reckoning: Reckoning = field(default_factory=Reckoning)
    _state: RobotState | None = None
    _battery: float | None = None
    _heard: float = -math.inf
    _pressed: float = math.inf
    _goal: GoTo | None = None
    _due: float = math.inf
    _written: float = -math.inf
    _stops: list[float] = field(default_factory=list)
    _signs: dict[str, Write] = field(default_factory=dict)
    _lamps: dict[int, tuple[int, int, int]] = field(default_factory=dict)

    # --- from the cube ---------------------------------------------------------------------------------

    def linked(self, now: float, up: bool) -> list[Event]:
        """Its link came or went: told where that is news; one that comes stands still first."""
        news, self.up, self._heard = up is not self.up, up, now
        if news:
            self._goal, self._due, self._stops, self._signs = None, math.inf, [], {}
            self._pressed, self.pilot, self.reckoning = math.inf, Pilot(), Reckoning()
        if news and up:
            self.stop(now)
        return [Link(now, self.name, up)] if news else []

    def watch(self, now: float) -> list[Event]:
        """A button that is held becomes a long touch; a cube that is silent is lost."""
        if self.up and now - self._heard >= LOST_S:
            return self.linked(now, False)
        if now + JUST >= self._pressed + LONG_S:
            self._pressed = math.inf
            return [Touch(now, self.name, 0, "long")]
        return []

    def hear(self, packet: Packet, arrived: float) -> list[Event]:
        """What a packet tells, arrived at session time [s].

        Raises:
            DeviceError: for a cube whose system software is too old.

        """
        events = self.linked(arrived, True) if not self.up else []
        self._heard = arrived
        match packet.name:
            case "idPosition":
                events.append(self._place(packet, arrived))
            case "idMissed" | "idStandard" | "standardMissed":
                events += self._lifted(arrived)
            case "button":
                events += self._touch(bool(packet.args["pressed"]), arrived)
            case "battery":
                self._battery = _number(packet, "percent") / 100
            case "version":
                self._check_version(str(packet.args["version"]))
        return events

    def _place(self, packet: Packet, arrived: float) -> RobotState:
        """Where a cube is: what it tells, and what its wheels were told, since a position ID is coarse."""
        x, y = self.placement.sheet_from_ids(_number(packet, "x"), _number(packet, "y"))
        heading, old = math.radians(_number(packet, "angle_deg")), self._state
        t = arrived if old is None else max(arrived, old.t)
        if old is not None:
            guess = self.reckoning.carried((*old.xy, old.heading), t)
            off = math.dist(guess[:2], (x, y))
            if not old.held and off > JUMP_M + FASTEST_M_S * (t - old.t):
                self.stop(arrived)  # carried elsewhere too quickly to be missed: its goal is void
            elif not old.held and off < PUSHED_M:
                x, y = guess[0] + TRUST * (x - guess[0]), guess[1] + TRUST * (y - guess[1])
                heading = guess[2] + TRUST_HEADING * wrapped(heading - guess[2])
        self._state = RobotState(t, self.name, (x, y), heading % (2 * math.pi), False, self._battery)
        return self._state

    def _lifted(self, arrived: float) -> list[Event]:
        self.stop(arrived)
        if self._state is None or self._state.held:
            return []
        old = self._state
        self._state = RobotState(max(arrived, old.t), self.name, old.xy, old.heading, True, self._battery)
        return [self._state]

    def _touch(self, pressed: bool, arrived: float) -> list[Event]:
        self._pressed = arrived if pressed else math.inf
        return [Touch(arrived, self.name, 0, "began" if pressed else "released")]

    def _check_version(self, text: str) -> None:
        parts = text.split(".")
        if not all(part.isdigit() for part in parts) or tuple(map(int, parts[:2])) < OLDEST_VERSION:
            oldest = ".".join(map(str, OLDEST_VERSION))
            raise DeviceError(
                f"robot {self.name!r} is a toio cube that speaks protocol {text}; {oldest} or later was expected, "
                "which tells places while it stands still: update its system software with the toio app"
            )

    # --- to it -----------------------------------------------------------------------------------------

    def stop(self, now: float) -> None:
        """Stand still now, told again twice; a goal that is driven to is void."""
        self._goal, self._due = None, math.inf
        self._stops = [now + after for after in STOPS]

    def take(self, command: Command, now: float) -> None:
        """Take a command; a cube that is gone takes nothing.

        Raises:
            DeviceError: for a velocity, or a number that must not reach the wire.

        """
        if not is_finite(command):
            raise DeviceError(f"{command} has a number that is not finite; send one whose numbers all are")
        match command:
            case Stop():
                self.stop(now)
            case GoTo():
                if self.up and self._state is not None:  # from where nobody knows, there is no way
                    self._go(command, now)
            case Drive():
                raise DeviceError(
                    f"{self.name!r} was told a velocity, but a toio cube cannot drive sideways; "
                    "send GoTo, a short way ahead"
                )
            case Light():
                self._light(command)
            case Haptic():
                self._hum(command)

    def _go(self, command: GoTo, now: float) -> None:
        self._stops = [at for at in self._stops if at <= now]
        self._goal = command
        self._due = min(self._due, max(now, self._written + SOONEST_S))

    def _light(self, light: Light) -> None:
        """Show a colour: of six lights on other robots, the brightest."""
        if not all(0 <= shade <= 255 for shade in light.colour):
            raise DeviceError(f"a light's colour {light.colour} is not made of numbers from 0 to 255")
        if light.led is None:
            self._lamps.clear()
        self._lamps[-1 if light.led is None else light.led] = light.colour
        red, green, blue = max(self._lamps.values(), key=sum)
        if self.up:
            self._signs["light"] = encode("light", duration_ms=0, red=red, green=green, blue=blue)

    def _hum(self, haptic: Haptic) -> None:
        """A cube cannot shake: it hums as long."""
        if self.up and haptic.strength > 0 and haptic.duration > 0:
            tone = {"duration_ms": min(max(1000 * haptic.duration, 10), 2550), "note": NOTE, "volume": FULL_VOLUME}
            self._signs["sound"] = encode("soundNotes", repeat=1, notes=[tone])

    def motion(self, now: float) -> list[Write]:
        """What the motors are to be told now, if anything: a stop first."""
        state, by = self._state, now + JUST
        if self._goal is not None and by >= self._goal.until:
            self.stop(now)
        if self._stops and self._stops[0] <= by:
            self._stops = [at for at in self._stops if at > by]
            return [self._told(now, REST)]
        if self._goal is None or state is None or by < self._due:
            return []
        self._due = now + REFRESH_S
        return [self._pulse(self._goal, state, now)]

    def signs(self) -> list[Write]:
        """Lights and sounds that wait to be shown; the latest of each."""
        writes = list(self._signs.values())
        self._signs.clear()
        return writes

    def _pulse(self, goal: GoTo, state: RobotState, now: float) -> Write:
        if state.held or now - state.t > BLIND_S:
            return self._told(now, REST)
        here, rest = self.reckoning.forecast((*state.xy, state.heading), now)
        pulse = self.pilot.plan(here, rest, goal.xy, goal.heading, goal.speed)
        lasts = min(pulse.seconds, HOLD_S, goal.until - now)
        return self._told(now, Pulse(pulse.left, pulse.right, lasts) if lasts >= TICK_S else REST)

    def _told(self, now: float, pulse: Pulse) -> Write:
        """A pulse as it is written: never without an end, but for standstill."""
        self.reckoning.note(now, pulse)
        self._written = now
        if pulse.seconds <= 0 or (pulse.left, pulse.right) == (0, 0):
            return STANDSTILL
        return encode("motorTimed", left=pulse.left, right=pulse.right, duration_ms=round(1000 * pulse.seconds))

    def wake(self) -> float:
        """When something is due again [s] though nothing new is told."""
        lease = self._goal.until if self._goal is not None else math.inf
        return min([*self._stops[:1], self._due, lease, self._pressed + LONG_S])


def _number(packet: Packet, key: str) -> float:
    value = packet.args[key]
    return float(value) if isinstance(value, int | float) else 0.0
