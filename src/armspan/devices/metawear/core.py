"""The host's idea of one band, without I/O: notifications to events, commands to writes, counters for people."""

import math
from dataclasses import dataclass, field

from armspan.devices.metawear import signals
from armspan.devices.metawear.boards import HAPTIC, LED, Board
from armspan.devices.metawear.button import Button
from armspan.devices.metawear.counters import Report
from armspan.devices.metawear.decoding import decode
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.metawear.handshake import Met
from armspan.devices.metawear.notifications import LogTime, Switch
from armspan.devices.metawear.setup import SetUp
from armspan.devices.metawear.streams import FusionStream, RawStream
from armspan.errors import DeviceError, DeviceNotFound
from armspan.records import Colour, Command, Event, Haptic, Light, Link, Stop, is_finite

LONGEST_MS = 0xFFFF
FULL_LIGHT, FULL_COLOUR = 31, 255


@dataclass(slots=True)
class Band:
    """One band as its host knows it; ``met`` and ``done`` are None until it was asked and set up."""

    entry: MetaWearEntry
    met: Met | None = None
    done: SetUp | None = None
    report: Report = field(init=False)
    stream: FusionStream | RawStream = field(init=False)
    button: Button = field(init=False)
    _fresh: bool = True
    _told_up: bool | None = None
    _linked: bool = False
    _known: bool = False
    _waiting: dict[str, Command] = field(default_factory=dict)

    def __post_init__(self) -> None:
        name, rate = self.entry.name, self.entry.rate_hz
        if self.entry.profile == "raw":
            self.stream = RawStream(name, rate)
        else:
            self.stream = FusionStream(name, rate, whole=self.entry.outputs == "all")
        self.button = Button(name)
        self.report = Report(name, self.entry.address, streams={self.entry.profile: self.stream.counters})

    # --- from the band ---------------------------------------------------------------------------------

    def linked(self) -> None:
        """There is a connection; what comes of it counts once the board is known to be as it was, or set up anew."""
        self._linked, self._known = True, False
        self.report.connections += 1

    def meet(self, met: Met) -> None:
        """It told what it is."""
        self.met = met
        self.report.board, self.report.firmware = met.board.name, met.identity.firmware
        self.report.mac = met.identity.mac

    def resume(self) -> None:
        """It is as it was left."""
        self._known = True
        self.report.resumed += 1

    def begin(self, done: SetUp, clock: LogTime, now: float) -> None:
        """It was set up anew at session time [s]; its clock then was ``clock``."""
        self.done, self._fresh, self._known = done, True, True
        self.stream.renew()
        if isinstance(self.stream, RawStream):
            self.stream.refer(clock, now)

    def hear(self, data: bytes, arrived: float) -> list[Event]:
        """What a notification tells, arrived at session time [s]; nothing before the band is set up."""
        if self.met is None or self.done is None:
            return []
        try:
            notification = decode(data, self.met.board, self.done.ranges)
        except DeviceError:
            self.stream.counters.refused += 1
            return []
        if isinstance(notification, Switch):
            return [*self.button.hear(notification.state, arrived)]
        samples = self.stream.hear(notification, arrived) if self._known else []
        return [*self._came(arrived), *samples] if samples else []

    def _came(self, arrived: float) -> list[Event]:
        """Samples come: told where that is news, or where nobody knows how the band has turned meanwhile."""
        void = isinstance(self.stream, RawStream) and self.stream.void
        if self._told_up and not self._fresh and not void:
            return []
        fresh, self._fresh = self._fresh or void, False
        self._told_up = self.report.up = True
        self.report.trouble = ""
        return [Link(arrived, self.entry.name, True, fresh)]

    def silent(self, now: float, trouble: str) -> list[Event]:
        """Nothing comes, though the link may hold: told where that is news."""
        self.report.trouble, self.report.up = trouble, False
        if self._told_up is False:
            return []
        self._told_up = False
        return [*self.button.leave(), Link(now, self.entry.name, False)]

    def lost(self, now: float, trouble: str) -> list[Event]:
        """The link is gone, or none could be made."""
        self.report.links_lost += self._linked
        self._linked = False
        self._waiting.clear()
        return self.silent(now, trouble)

    # --- to it -----------------------------------------------------------------------------------------

    def take(self, command: Command) -> None:
        """Let a light or a vibration wait, the latest of each; a band that is not there takes none.

        Raises:
            DeviceNotFound: for another name.
            DeviceError: for a command that a band does not know, or a number that is not finite.

        """
        if isinstance(command, Stop):
            return
        if command.robot != self.entry.name:
            raise DeviceNotFound(f"{command.robot!r} is not the band {self.entry.name!r}")
        if not isinstance(command, Light | Haptic) or not is_finite(command):
            raise DeviceError(f"the band {self.entry.name!r} cannot do {command}; it takes a Light or a Haptic")
        if self._linked:
            self._waiting[type(command).__name__] = command

    def signs(self) -> list[bytes]:
        """The writes for what waits."""
        if self.met is None or not self._waiting:
            return []
        commands, writes = list(self._waiting.values()), list[bytes]()
        self._waiting.clear()
        for command in commands:
            if isinstance(command, Light):
                writes += light(self.met.board, command.colour)
            elif isinstance(command, Haptic):
                writes += vibration(self.met.board, command)
        return writes

    def wake(self) -> float:
        """When something is due though nothing comes [s]."""
        return self.button.wake()

    def due(self, now: float) -> list[Event]:
        """What is complete by now."""
        return [*self.button.due(now)]


def light(board: Board, colour: Colour) -> list[bytes]:
    """The writes that light the LED in a colour, or put it out where that is black."""
    if not board.has(LED):
        return []
    writes = [signals.play("stop_and_clear")]
    for name, share in zip(("red", "green", "blue"), colour, strict=True):
        level = math.ceil(max(0, min(share, FULL_COLOUR)) * FULL_LIGHT / FULL_COLOUR)
        if level:
            writes.append(signals.led_pattern(board, name, (level, level), (0, 500, 0, 1000)))
    return [*writes, signals.play("play")] if len(writes) > 1 else writes


def vibration(board: Board, haptic: Haptic) -> list[bytes]:
    """The write that lets the motor run; nothing on a board without one, or for no time at all."""
    millis = min(LONGEST_MS, round(1000 * haptic.duration))
    if not board.has(HAPTIC) or millis <= 0:
        return []
    return [signals.motor(100 * max(0.0, min(haptic.strength, 1.0)), millis)]
