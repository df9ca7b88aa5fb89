"""A MetaWear board without I/O: bytes in, bytes out, with the state that a real one keeps.

It answers as the vendor's protocol says and nothing kinder: state outlives a disconnection, streams need all of their
switches, a reset drops everything, replies carry neither numbers nor times. It knows nothing of the client: its reading
of the bytes is its own.
"""

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armspan.devices.metawear.board_chips import Feeling, Felt
from armspan.devices.metawear.board_models import (
    ACC,
    DEBUG,
    EVENT,
    FUSION,
    GYRO,
    HAPTIC,
    LED,
    LOGGING,
    MACRO,
    MAG,
    MODELS,
    PROCESSOR,
    SETTINGS,
    SWITCH,
    TEMPERATURE,
    TICK_S,
    TIMER,
    Model,
    Traits,
)
from armspan.devices.metawear.board_processors import MOST, Processors
from armspan.devices.metawear.board_sensing import Sensing
from armspan.devices.metawear.board_signals import Buzz, Lamp, buzzes
from armspan.records import Quaternion, Vec3

READ, SILENT, PROPER = 0x80, 0x40, 0x3F
PACKET = 20
REMEMBERED = 100
"""Vibrations that are kept to be looked at."""
DISCONNECTED = (SETTINGS, 0x0A)
"""The source of the event that the link is gone."""
SENSORS = (ACC, GYRO, MAG, FUSION)


@dataclass(slots=True)
class _Event:
    """When ``source`` has data, ``parameters`` are written to ``target`` (module, register)."""

    source: tuple[int, int]
    target: bytes
    parameters: bytes = b""


class MetaWearBoard:
    """An emulated board: `write`, `linked` and `press` tell it what happens, `advance` what time it is.

    ``model`` is a name in `MODELS` or a Model. What it feels comes from `sample`; without, it lies still. Everything
    waits for `advance`; after that, ``leaving`` is how long the board is out of reach [s] after it ends the link (None:
    it does not), and ``wish`` the connection interval and time-out [s] that it asks for.
    """

    def __init__(
        self,
        model: str | Model = "mmrl_current",
        traits: Traits | None = None,
        *,
        address: str = "E8:C9:8F:52:7B:07",
        generator: np.random.Generator | None = None,
    ) -> None:
        self.model = MODELS[model] if isinstance(model, str) else model
        self.traits = traits or Traits()
        self.address, self.name = address, "MetaWear"
        self.bootloader = self.traits.bootloader
        self.haptics: list[Buzz] = []
        self.leaving: float | None = None
        self.wish: tuple[float, float] | None = None
        self.reset_uid = self.traits.reset_uid
        self.up = False
        self._first_tick = self.traits.first_tick
        self._booted: float | None = None
        self._ready_at = -math.inf
        self._generator = generator or np.random.default_rng(0)
        self._feeling = Feeling(self.traits, self._generator)
        self._inbox: list[tuple[Callable[[bytes, float], None], bytes]] = []
        self._out: list[bytes] = []
        self._clear()

    def _clear(self) -> None:
        """The state at power-on."""
        self.lamp, self.pressed = Lamp(), False
        self.subscribed: set[tuple[int, int]] = set()
        self.notified: set[int] = set()
        self.stored: dict[tuple[int, int], bytes] = {}
        self.events: dict[int, _Event] = {}
        self.processors = Processors(self.model.revision(PROCESSOR), self.model.modules[PROCESSOR][2])
        self.sensing = Sensing(self.model, self.traits, self._generator, self._feeling, self._stream)
        self._draft: _Event | None = None
        self._made = {TIMER: 0, LOGGING: 0}

    # --- the world outside -------------------------------------------------------------------------------

    def write(self, data: bytes) -> None:
        """Bytes for the command characteristic."""
        self._inbox.append((self._obey, bytes(data)))

    def linked(self, up: bool) -> None:
        """The link is there, or gone: then the board does what it was told to do for that case."""
        self._inbox.append((self._link, bytes([up])))

    def press(self, down: bool = True) -> None:
        """The button goes down or up."""
        self._inbox.append((self._press, bytes([down])))

    def sample(self, t: float, acc: Vec3, gyr: Vec3, mag: Vec3 | None = None, quat: Quaternion | None = None) -> None:
        """What the board feels at ``t`` [s], as in `Felt`; what is fed ahead of time is met exactly."""
        self._feeling.feed(Felt(t, acc, gyr, quat=quat) if mag is None else Felt(t, acc, gyr, mag, quat))

    def advance(self, t: float) -> list[bytes]:
        """It is ``t`` [s] now: the notifications since the last call, in order."""
        if self._booted is None:
            self._booted = t
            self.sensing.begin(t)
        self.leaving = None
        self.sensing.advance(t)
        inbox, self._inbox = self._inbox, []
        for act, data in inbox:
            act(data, t)
        out, self._out = self._out, []
        return out

    def due(self) -> float | None:
        """When something will happen by itself [s]."""
        return self.sensing.due()

    def tick(self, t: float) -> int:
        """What the reference clock shows at ``t`` [s]."""
        since = (t - (t if self._booted is None else self._booted)) * (1.0 + self.traits.drift)
        return (self._first_tick + math.floor(since / TICK_S + 1e-6)) % 2**32

    # --- what goes out ------------------------------------------------------------------------------------

    def _tell(self, *data: int, rest: bytes = b"") -> None:
        if self.up:
            self._out.append((bytes(data) + rest)[:PACKET])

    def _stream(self, module: int, register: int, payload: bytes, t: float) -> None:
        """A source has data: for the client where it has subscribed, for processors, for events."""
        if (module, register) in self.subscribed or (module, register) in self.sensing.subscribed:
            self._tell(module, register, rest=payload)
        for number, out in self.processors.process(module, register, 0xFF, payload, t, lambda: self.tick(t)):
            if number in self.notified and (PROCESSOR, 0x03) in self.subscribed and len(out) <= MOST:
                self._tell(PROCESSOR, 0x03, number, rest=out)
        self._happen((module, register), t)

    def _happen(self, source: tuple[int, int], t: float) -> None:
        for event in list(self.events.values()):
            if event.source == source:
                self._obey(event.target + event.parameters, t)

    # --- what comes in ------------------------------------------------------------------------------------

    def _link(self, data: bytes, t: float) -> None:
        was, self.up = self.up, bool(data[0])
        if was and not self.up:
            self.wish = None
            self._happen(DISCONNECTED, t)

    def _press(self, data: bytes, t: float) -> None:
        self.pressed = bool(data[0])
        self._stream(SWITCH, 0x01, data, t)

    def _obey(self, data: bytes, t: float) -> None:
        if len(data) < 2 or self.bootloader or t < self._ready_at:
            return
        module, register, rest = data[0], data[1], data[2:]
        if register & READ:
            self._answer(module, register, rest, t)
        elif self.model.revision(module) < 0:
            return
        elif module in SENSORS:
            self.sensing.write(module, register, rest)
        elif module in _WRITES:
            _WRITES[module](self, register, rest, t)
        else:
            self.stored[module, register] = rest

    def _subscribe(self, module: int, register: int, data: bytes) -> None:
        key = (module, register)
        (self.subscribed.add if data[:1] == b"\x01" else self.subscribed.discard)(key)

    def _switch(self, register: int, data: bytes, t: float) -> None:
        self._subscribe(SWITCH, register, data)

    def _led(self, register: int, data: bytes, t: float) -> None:
        self.lamp.write(register, data)

    def _haptic(self, register: int, data: bytes, t: float) -> None:
        self.haptics.extend(buzzes(register, data, t))
        del self.haptics[:-REMEMBERED]

    def _processor(self, register: int, data: bytes, t: float) -> None:
        if register == 0x02 and (number := self.processors.create(data)) is not None:
            self._tell(PROCESSOR, 0x02, number)
        elif register == 0x03:
            self._subscribe(PROCESSOR, register, data)
        elif register == 0x07 and len(data) >= 2:
            (self.notified.add if data[1] == 1 else self.notified.discard)(data[0])
        elif register == 0x08:
            self.processors.known.clear()
            self.notified.clear()

    def _event(self, register: int, data: bytes, t: float) -> None:
        if register == 0x02 and len(data) >= 6:
            self._draft = _Event((data[0], data[1] & PROPER), data[3:5])
        elif register == 0x03 and self._draft is not None:
            number = next(each for each in range(256) if each not in self.events)
            self._draft.parameters = data
            self.events[number], self._draft = self._draft, None
            self._tell(EVENT, 0x02, number)
        elif register == 0x04 and data:
            self.events.pop(data[0], None)
        elif register == 0x05:
            self.events.clear()

    def _logging(self, register: int, data: bytes, t: float) -> None:
        if register == 0x0A:
            self._made[LOGGING] = 0
        self._make(LOGGING, register)

    def _timer(self, register: int, data: bytes, t: float) -> None:
        self._make(TIMER, register)

    def _macro(self, register: int, data: bytes, t: float) -> None:
        if register == 0x02:
            self._tell(MACRO, 0x02, 0)

    def _make(self, module: int, register: int) -> None:
        """A creation is answered with the number of what was made."""
        if register == 0x02:
            self._tell(module, 0x02, self._made[module])
            self._made[module] += 1

    def _settings(self, register: int, data: bytes, t: float) -> None:
        self.stored[SETTINGS, register] = data
        if register == 0x01:
            self.name = data.decode("ascii", errors="replace")
        elif register == 0x09 and len(data) >= 8:
            least, _, _, timeout = struct.unpack("<4H", data[:8])
            self.wish = (least * 1.25e-3, timeout * 1e-2)
        elif register in (0x11, 0x12):
            self._subscribe(SETTINGS, register, data)

    def _debug(self, register: int, data: bytes, t: float) -> None:
        if register == 0x01 or (register == 0x05 and not self.traits.ignores_collection_reset):
            self._reset(t)
        elif register == 0x02:
            self.bootloader = True
            self.leaving = self.traits.boot_s
        elif register == 0x03 and len(data) >= 2:
            self._tell(rest=data)
        elif register == 0x06:
            self.leaving = 0.0

    def _reset(self, t: float) -> None:
        """Everything is forgotten, the clock begins at zero, and the board is away while it boots."""
        self._clear()
        self.reset_uid, self._first_tick, self._booted = (self.reset_uid + 1) % 8, 0, t
        self.sensing.begin(t)
        self.leaving, self._ready_at = self.traits.boot_s, t + self.traits.boot_s

    # --- answers ------------------------------------------------------------------------------------------

    def _answer(self, module: int, register: int, data: bytes, t: float) -> None:
        proper = register & PROPER
        if proper == 0:
            known = self.model.modules.get(module, b"")
            if known or self.traits.absent == "short":
                self._tell(module, READ, rest=known)
            return
        value = self._value(module, proper, data, t) if self.model.revision(module) >= 0 else None
        if value is not None and not register & SILENT:
            self._tell(module, register, rest=value)

    def _value(self, module: int, register: int, data: bytes, t: float) -> bytes | None:
        if module in SENSORS:
            return self.sensing.read(module, register)
        if (module, register) == (SWITCH, 0x01):
            return bytes([self.pressed])
        if (module, register) == (TEMPERATURE, 0x01):
            return data[:1] + struct.pack("<h", round(8 * 24.5))
        if (module, register) == (LOGGING, 0x04):
            return struct.pack("<IB", self.tick(t), self.reset_uid)
        if (module, register) == (LOGGING, 0x05):
            return struct.pack("<I", 0)
        if (module, register) == (SETTINGS, 0x0C) and self.model.revision(SETTINGS) >= 3:
            return struct.pack("<BH", self.traits.battery, self.traits.millivolts)
        if (module, register) == (SETTINGS, 0x0B):
            address = bytes.fromhex(self.address.replace(":", ""))[::-1]
            return b"\x01" + address if self.traits.typed_mac else address
        return self.stored.get((module, register))


_WRITES: dict[int, Callable[[MetaWearBoard, int, bytes, float], None]] = {
    SWITCH: MetaWearBoard._switch,
    LED: MetaWearBoard._led,
    HAPTIC: MetaWearBoard._haptic,
    PROCESSOR: MetaWearBoard._processor,
    EVENT: MetaWearBoard._event,
    LOGGING: MetaWearBoard._logging,
    TIMER: MetaWearBoard._timer,
    MACRO: MetaWearBoard._macro,
    SETTINGS: MetaWearBoard._settings,
    DEBUG: MetaWearBoard._debug,
}
