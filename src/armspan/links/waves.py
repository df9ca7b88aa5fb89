"""What lies between an emulated central and its peripherals: loss, delay, connection intervals, broken links.

A link of Bluetooth LE repeats what was not acknowledged, so that nothing is lost on the air as long as the link
holds. What gets lost in practice are notifications for which the sender has no buffer left and commands that the
receiver does not keep up with, and so the faults here take exactly these: ATT notifications and ATT commands.
"""

import asyncio
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

ATT = b"\x04\x00"
"""The L2CAP channel of the attribute protocol, bytes 2 and 3 of a packet."""
NOTIFICATION, COMMAND = 0x1B, 0x52
TIMED_OUT = 0x08
"""Why a link ended: the connection timed out."""


@dataclass(frozen=True)
class LinkFaults:
    """How bad a link is; times are seconds since the peripheral was added.

    ``loss`` and ``write_loss`` are the shares of notifications and of writes without response that get lost, in runs
    of ``run`` on average. ``latency_s`` delays everything. With ``burst_s`` packets go only at connection events so far
    apart, at most ``per_event`` notifications each, of which ``buffered`` may wait and the rest is lost; a peripheral's
    wish for another interval is granted if the central ``obeys``. The link breaks at ``breaks_at`` and
    ``breaks_per_minute`` times a minute on average; then the peripheral is out of reach for ``away_s`` and both ends
    notice after ``supervision_s`` (0.42 s is Linux's default). In the ``silent`` spans, (from, to), the link holds but
    no notification and no command comes through.
    """

    loss: float = 0.0
    write_loss: float = 0.0
    run: float = 1.0
    latency_s: float = 0.0
    burst_s: float = 0.0
    obeys: bool = True
    per_event: int = 6
    buffered: int = 20
    breaks_at: tuple[float, ...] = ()
    breaks_per_minute: float = 0.0
    away_s: float = 1.0
    supervision_s: float = 0.42
    silent: tuple[tuple[float, float], ...] = ()


@dataclass(slots=True)
class Losses:
    """What a link has swallowed so far."""

    notifications: int = 0
    commands: int = 0
    breaks: int = 0


class Lane:
    """One direction of one link: packets arrive in the order in which they were sent."""

    def __init__(self, arrive_at: Callable[[float], float], per_event: int | None) -> None:
        self.waiting: deque[tuple[float, Callable[[], None]]] = deque()
        self._arrive_at, self._per_event = arrive_at, per_event
        self._timer: asyncio.TimerHandle | None = None
        self._last = -math.inf

    def send(self, arrive: Callable[[], None]) -> None:
        """Let ``arrive`` be called when the packet is through."""
        loop = asyncio.get_running_loop()
        self._last = max(self._last, self._arrive_at(loop.time()))
        self.waiting.append((self._last, arrive))
        if self._timer is None:
            self._timer = loop.call_at(self._last, self._event)

    def clear(self) -> None:
        """Forget what is on its way."""
        self.waiting.clear()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _event(self) -> None:
        """A connection event: as many packets as fit."""
        self._timer = None
        loop = asyncio.get_running_loop()
        room = self._per_event or len(self.waiting)
        due = loop.time() + 1e-6
        while self.waiting and self.waiting[0][0] <= due and room > 0:
            room -= 1
            self.waiting.popleft()[1]()
        if self.waiting:
            after = self._arrive_at(loop.time() + 2e-6) if self.waiting[0][0] <= due else self.waiting[0][0]
            self._timer = loop.call_at(after, self._event)


class Reach:
    """The link to one peripheral, with its faults and what they have cost."""

    def __init__(self, faults: LinkFaults, generator: np.random.Generator, broken: Callable[[], None]) -> None:
        self.losses = Losses()
        self.away_until, self.held = -math.inf, False
        self._generator, self._broken = generator, broken
        self._losing = {NOTIFICATION: False, COMMAND: False}
        self._timers: list[asyncio.TimerHandle] = []
        self._began = asyncio.get_running_loop().time()
        self.up, self.down = Lane(self._arrival, None), Lane(self._arrival, None)
        self.take(faults)

    def take(self, faults: LinkFaults) -> None:
        """Change the faults from now on; the times in them count from when the peripheral was added."""
        self.close()
        self.faults, self.interval, self.supervision = faults, faults.burst_s, faults.supervision_s
        self.up = Lane(self._arrival, faults.per_event if faults.burst_s else None)
        self.down = Lane(self._arrival, None)
        loop = asyncio.get_running_loop()
        self._timers = [
            loop.call_at(self._began + at, self.cut) for at in faults.breaks_at if self._began + at > loop.time()
        ]
        self._await_break()

    def close(self) -> None:
        """Stop every timer."""
        for timer in self._timers:
            timer.cancel()
        self.up.clear()
        self.down.clear()

    def ask(self, interval: float, supervision: float) -> None:
        """The peripheral wishes for another connection interval and time-out [s]."""
        if self.faults.obeys:
            self.supervision = supervision
            self.interval = max(0.0075, interval) if self.interval else 0.0

    def begin(self) -> None:
        """A new connection: what the last one had agreed on is void."""
        self.held = True
        self.interval, self.supervision = self.faults.burst_s, self.faults.supervision_s
        self.up.clear()
        self.down.clear()

    def end(self) -> None:
        """The peripheral knows that there is no connection."""
        self.held = False

    @property
    def away(self) -> bool:
        """Out of reach."""
        return asyncio.get_running_loop().time() < self.away_until

    def cut(self, away_s: float | None = None) -> None:
        """Nothing comes through for ``away_s``, and for as long as it takes to notice where there is a connection."""
        loop = asyncio.get_running_loop()
        self.losses.breaks += 1
        gone_s = self.faults.away_s if away_s is None else away_s
        if self.held:
            gone_s = max(gone_s, self.supervision)
            self._timers.append(loop.call_later(self.supervision, self._broken))
        self.away_until = max(self.away_until, loop.time() + gone_s)
        self.up.clear()
        self.down.clear()

    def carry(self, up: bool, packet: bytes | None, arrive: Callable[[], None]) -> None:
        """Carry a packet of data (or of control: None) to the central (``up``) or to the peripheral."""
        if self.away or (packet is not None and self._lost(packet)):
            return
        (self.up if up else self.down).send(arrive)

    def _lost(self, packet: bytes) -> bool:
        kind = packet[4] if packet[2:4] == ATT and len(packet) > 4 else 0
        if kind == NOTIFICATION:
            full = self.faults.burst_s > 0.0 and len(self.up.waiting) >= self.faults.buffered
            lost = full or self._silent() or self._unlucky(kind, self.faults.loss)
            self.losses.notifications += lost
            return lost
        if kind == COMMAND:
            lost = self._silent() or self._unlucky(kind, self.faults.write_loss)
            self.losses.commands += lost
            return lost
        return False

    def _unlucky(self, kind: int, share: float) -> bool:
        """A chain of two states, so that losses come in runs of the mean length asked for (Gilbert 1960)."""
        if share <= 0.0:
            return False
        end = 1.0 / max(1.0, self.faults.run)
        start = min(1.0, end * share / max(1e-9, 1.0 - share))
        chance = 1.0 - end if self._losing[kind] else start
        self._losing[kind] = bool(self._generator.random() < chance)
        return self._losing[kind]

    def _silent(self) -> bool:
        since = asyncio.get_running_loop().time() - self._began
        return any(begin <= since < end for begin, end in self.faults.silent)

    def _arrival(self, now: float) -> float:
        """When a packet sent ``now`` is through: after the next connection event."""
        if self.interval <= 0.0:
            return now + self.faults.latency_s
        event = self._began + math.ceil((now - self._began) / self.interval) * self.interval
        return event + self.faults.latency_s

    def _await_break(self) -> None:
        if self.faults.breaks_per_minute <= 0.0:
            return
        wait = float(self._generator.exponential(60.0 / self.faults.breaks_per_minute))
        self._timers.append(asyncio.get_running_loop().call_later(wait, self._break_again))

    def _break_again(self) -> None:
        self._timers = [timer for timer in self._timers if timer.when() > asyncio.get_running_loop().time()]
        self.cut()
        self._await_break()


class Waves:
    """The air as bumble's controllers see it: it takes the place of bumble's LocalLink."""

    def __init__(self, central: str) -> None:
        self.controllers: set[Any] = set()
        self.reaches: dict[str, Reach] = {}
        self._central = central

    def add_controller(self, controller: Any) -> None:
        """A controller is switched on."""
        self.controllers.add(controller)

    def remove_controller(self, controller: Any) -> None:
        """A controller is switched off."""
        self.controllers.discard(controller)

    def on_address_changed(self, controller: Any) -> None:
        """Nothing to do: addresses are looked up when they are needed."""

    def send_advertising_pdu(self, sender_controller: Any, packet: Any) -> None:
        """Everybody hears an advertisement, or an answer to one, unless its peripheral is out of reach."""
        reach = self.reaches.get(_plain(getattr(packet, "advertiser_address", "")))
        if reach is not None and reach.away:
            return
        loop = asyncio.get_running_loop()
        for controller in self.controllers - {sender_controller}:
            loop.call_soon(controller.on_ll_advertising_pdu, packet)

    def send_acl_data(self, sender_controller: Any, destination_address: Any, transport: Any, data: bytes) -> None:
        """Data of a connection."""
        source = sender_controller.random_address

        def arrive() -> None:
            receiver = self._controller(destination_address)
            if receiver is not None and source in receiver.le_connections:
                receiver.on_link_acl_data(source, transport, data)

        self._carry(source, destination_address, data, arrive)

    def send_ll_control_pdu(self, sender_address: Any, receiver_address: Any, packet: Any) -> None:
        """Control of a connection; it keeps its place behind the data that were sent before it."""

        def arrive() -> None:
            receiver = self._controller(receiver_address)
            if receiver is not None and sender_address in receiver.le_connections:
                receiver.on_ll_control_pdu(sender_address, packet)

        self._carry(sender_address, receiver_address, None, arrive)

    def _carry(self, source: Any, target: Any, data: bytes | None, arrive: Callable[[], None]) -> None:
        up = _plain(target) == self._central
        reach = self.reaches.get(_plain(source if up else target))
        if reach is not None:
            reach.carry(up, data, arrive)

    def _controller(self, address: Any) -> Any:
        return next((each for each in self.controllers if each.random_address == address), None)


def _plain(address: Any) -> str:
    """An address as bumble's or as text, without its type."""
    return str(address).split("/")[0].upper()
