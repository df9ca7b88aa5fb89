"""What a Bluetooth LE peripheral is to the emulated air: a GATT table, an advertisement, and what may happen to it."""

from dataclasses import dataclass
from typing import Protocol

FLAGS = bytes([2, 0x01, 0x06])
"""Advertised: found by anybody, no classic Bluetooth."""
ROOM = 31
"""Bytes of an advertisement."""


@dataclass(frozen=True)
class Characteristic:
    """A value in a GATT table.

    ``properties`` are bleak's words (read, write, write-without-response, notify, indicate); a ``value`` that is told
    is constant, otherwise the peripheral is asked.
    """

    uuid: str
    properties: tuple[str, ...]
    value: bytes | None = None


@dataclass(frozen=True)
class Service:
    """A service in a GATT table; handles count from 1 in the order in which everything is told."""

    uuid: str
    characteristics: tuple[Characteristic, ...] = ()


class Handle(Protocol):
    """What a peripheral holds of the air."""

    def notify(self, uuid: str, data: bytes) -> bool:
        """Notify the central; False where it has not subscribed or is not there."""

    def drop(self, quiet_s: float = 0.0) -> None:
        """Disconnect, and do not advertise for ``quiet_s``."""

    def ask(self, interval_s: float, supervision_s: float) -> None:
        """Wish for another connection interval and supervision time-out."""

    def renew(self) -> None:
        """Begin anew with what ``services`` and ``table`` say now."""


class Peripheral(Protocol):
    """A device on the air, without I/O: the air calls it, and it answers through its handle.

    ``services`` are advertised (all of them incompletely listed), with ``name`` where there is room.
    """

    @property
    def address(self) -> str:
        """As advertised."""

    @property
    def name(self) -> str:
        """As advertised."""

    @property
    def services(self) -> tuple[str, ...]:
        """As advertised, of 128 bits."""

    def table(self) -> tuple[Service, ...]:
        """The GATT table."""

    def attach(self, handle: Handle) -> None:
        """Here is the handle to notify through."""

    def read(self, uuid: str) -> bytes:
        """Somebody reads a value."""

    def written(self, uuid: str, data: bytes) -> None:
        """Somebody wrote a value."""

    def connected(self) -> None:
        """A central is there."""

    def disconnected(self) -> None:
        """The central is gone."""

    def advance(self, t: float) -> float | None:
        """It is time ``t`` [s]: notify what is due, and say when to be called again (None: when something happens)."""


def advertisement(name: str, services: tuple[str, ...]) -> bytes:
    """What is advertised: flags, 128-bit services (type 6, incomplete), the name (9; 8 where it is cut)."""
    listed = b"".join(bytes.fromhex(uuid.replace("-", ""))[::-1] for uuid in services)
    data = FLAGS + (bytes([1 + len(listed), 0x06]) + listed if listed else b"")
    text = name.encode()
    room = max(0, ROOM - len(data) - 2)
    if room == 0 or not text:
        return data
    return data + bytes([1 + len(text[:room]), 0x09 if len(text) <= room else 0x08]) + text[:room]
