"""Cellulo robots in a room file: what a lab tells of each, and the doors to them all."""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from typing import TypeAlias

import msgspec

from armspan.devices.cellulo.driver import CelluloRelay
from armspan.devices.cellulo.flock import Traits
from armspan.devices.cellulo.quantities import mac_octets
from armspan.devices.cellulo.ring import Ring, Turn
from armspan.devices.cellulo.sockets import CelluloSockets, Line, Way
from armspan.errors import ConfigError
from armspan.links import rfcomm, serial_port
from armspan.records import Vec2

RELAY = "127.0.0.1:2556"
PICONET = 7
"""Robots that one Bluetooth adapter can hold; EPFL advises five."""
_HOST_PORT = re.compile(r"(.+):(\d{1,5})")

Driver: TypeAlias = CelluloRelay | CelluloSockets


class CelluloEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="cellulo"):
    """A Cellulo robot: its ``name``, its Bluetooth ``address``, and the ``door`` to it.

    ``door`` is ``rfcomm``, a Bluetooth socket, from the local ``adapter`` with that address or from any; ``relay``,
    EPFL's at ``relay`` (host:port); or the path of a serial port, as ``/dev/rfcomm0``. ``led_zero_deg`` is where
    its own light 0 sits, clockwise from straight ahead seen from above, and ``led_turn`` which way its numbers go
    round; ``scale`` is what a metre of its own is on the sheet.

    Raises:
        ConfigError: for a value that cannot be.

    """

    name: str
    address: str | None = None
    door: str = "rfcomm"
    adapter: str | None = None
    relay: str | None = None
    led_zero_deg: float = 0.0
    led_turn: Turn = "clockwise"
    scale: float = 1.0

    def __post_init__(self) -> None:
        if self.door not in ("rfcomm", "relay") and not self.is_serial:
            raise ConfigError(
                f"robot {self.name!r} has the door {self.door!r}; expected 'rfcomm', 'relay', or a serial port's path "
                "such as '/dev/rfcomm0'"
            )
        if not self.is_serial or self.address is not None:
            self._check_mac("address", self.address)
        if self.adapter is not None:
            self._check_mac("adapter", self.adapter)
        if self.adapter is not None and self.is_serial:
            raise ConfigError(
                f"robot {self.name!r} has an adapter and the door {self.door}: rfcomm bind chose that one"
            )
        if self.relay is not None and self.door != "relay":
            raise ConfigError(f"robot {self.name!r} has a relay and the door {self.door!r}; expected door = 'relay'")
        try:
            _ = self.traits, self.relay_at
        except ConfigError as error:
            raise ConfigError(f"robot {self.name!r}: {error}") from None

    @property
    def is_serial(self) -> bool:
        """Whether the door is a serial port's path."""
        return "/" in self.door or re.fullmatch(r"COM\d+", self.door) is not None

    @property
    def traits(self) -> Traits:
        """What the driver has to know of it."""
        return Traits(self.scale, Ring(self.led_zero_deg, self.led_turn), self.adapter)

    @property
    def relay_at(self) -> tuple[str, int]:
        """Host and port of its relay."""
        text = self.relay or RELAY
        found = _HOST_PORT.fullmatch(text)
        if found is None or not 0 < int(found[2]) < 1 << 16:
            raise ConfigError(f"{text!r} is not a relay; expected host:port as {RELAY}")
        return found[1], int(found[2])

    def _check_mac(self, what: str, text: str | None) -> None:
        try:
            mac_octets(text or "")
        except ValueError as error:
            has = f"has the {what} {text!r}" if text else f"has no {what}"
            raise ConfigError(f"robot {self.name!r} {has}; expected {error}") from None


def check_cellulos(entries: Sequence[CelluloEntry]) -> None:
    """See that robots do not get in each other's way.

    Raises:
        ConfigError: for two with one address or one serial port, or more on an adapter than it can hold.

    """
    for what, taken in (("address", _address), ("door", lambda entry: entry.door if entry.is_serial else None)):
        first: dict[str, str] = {}
        for entry in entries:
            own = taken(entry)
            if own is not None and own in first:
                raise ConfigError(
                    f"robots {first[own]!r} and {entry.name!r} both have the {what} {own}; each robot has its own"
                )
            if own is not None:
                first[own] = entry.name
    radios = [entry for entry in entries if entry.door == "rfcomm" or entry.adapter is not None]
    held = Counter(entry.adapter and entry.adapter.upper() for entry in radios)
    for adapter, n in held.items():
        if n > PICONET:
            raise ConfigError(
                f"{n} robots are on {f'the adapter {adapter}' if adapter else 'one Bluetooth adapter'}, which holds "
                f"{PICONET}; give some of them the address of a second adapter (adapter = ...), or use a relay"
            )


def open_cellulos(
    entries: Sequence[CelluloEntry],
    sheet_origin_m: Vec2 = (0.0, 0.0),
    now: Callable[[], float] | None = None,
    way: Callable[[CelluloEntry], Way] | None = None,
) -> list[Driver]:
    """Drivers for all robots, none of them open yet: one for each relay, and one for all that are reached directly.

    ``sheet_origin_m`` is where the sheet's corner lies in the robots' own coordinates, ``now`` the session's clock;
    ``way`` replaces how a robot is reached directly.

    Raises:
        ConfigError: for robots that get in each other's way.

    """
    check_cellulos(entries)
    drivers: list[Driver] = []
    for host, port in dict.fromkeys(entry.relay_at for entry in entries if entry.door == "relay"):
        behind = [entry for entry in entries if entry.door == "relay" and entry.relay_at == (host, port)]
        macs = {entry.name: entry.address or "" for entry in behind}
        traits = {entry.name: entry.traits for entry in behind}
        drivers.append(CelluloRelay(macs, host, port, origin_m=sheet_origin_m, traits=traits, now=now))
    direct = [entry for entry in entries if entry.door != "relay"]
    if direct:
        ways = {entry.name: (way or way_to)(entry) for entry in direct}
        traits = {entry.name: entry.traits for entry in direct}
        drivers.append(CelluloSockets(ways, origin_m=sheet_origin_m, traits=traits, now=now))
    return drivers


def way_to(entry: CelluloEntry) -> Way:
    """How a robot is reached directly."""

    async def by_radio() -> Line:
        return await rfcomm.connected(entry.address or "", entry.adapter)

    async def by_port() -> Line:
        return await serial_port.opened(entry.door)

    return (
        Way(by_port, entry.door, carrier=False) if entry.is_serial else Way(by_radio, (entry.adapter or "any").upper())
    )


def _address(entry: CelluloEntry) -> str | None:
    return entry.address.upper() if entry.address is not None else None
