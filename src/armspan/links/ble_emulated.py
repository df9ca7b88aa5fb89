"""An emulated Bluetooth LE: peripherals, one central and the air between them, in one process, on bumble.

Above it everything is real: bleak's own client and scanner, the attribute protocol with its handles and its 23 bytes,
advertisements, one central per peripheral. Below it `armspan.links.waves` decides what gets through and when. bumble
and bleak are imported only when an emulated radio is opened.
"""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import numpy as np

from armspan.errors import MissingExtra
from armspan.links.ble import Radio, checked_address
from armspan.links.peripherals import Characteristic, Handle, Peripheral, Service, advertisement
from armspan.links.waves import NOTIFICATION, TIMED_OUT, LinkFaults, Losses, Reach, Waves

__all__ = ["Air", "Characteristic", "Handle", "LinkFaults", "Peripheral", "Service", "advertisement", "emulated_radio"]

CENTRAL = "F0:0D:CA:FE:00:01"


@asynccontextmanager
async def emulated_radio(generator: np.random.Generator | None = None) -> AsyncIterator["Air"]:
    """An air of its own: add peripherals, and use its ``radio`` with `armspan.links.ble`.

    ``generator`` draws what gets lost. What a peripheral raises comes out at the end.
    """
    air = Air(generator or np.random.default_rng(0))
    await air.open()
    try:
        yield air
    finally:
        await air.close()
    if air.failures:
        raise air.failures[0]


class Air:
    """The emulated air; ``radio`` is what the client's side uses."""

    def __init__(self, generator: np.random.Generator) -> None:
        logging.getLogger("bumble").propagate = False  # faults are meant here; bumble warns of each
        logging.getLogger("bumble").addHandler(logging.NullHandler())
        _bumble()
        from armspan.links.ble_backend import radio_of

        self.waves = Waves(CENTRAL)
        self.failures: list[Exception] = []
        self.radio: Radio = radio_of(self)
        self.central: Any = None
        self.tables: dict[str, Any] = {}
        self._generator = generator
        self._stations: dict[str, _Station] = {}

    async def open(self) -> None:
        """Switch the central on."""
        self.central = _device(self.waves, CENTRAL, "central")
        await self.central.power_on()

    async def close(self) -> None:
        """Switch everything off."""
        for address in list(self._stations):
            await self.remove(address)
        for connection in list(self.central.connections.values()):
            await connection.disconnect()
        await self.central.power_off()

    async def add(
        self, peripheral: Peripheral, faults: LinkFaults | None = None, advertising_s: float = 0.4175
    ) -> None:
        """Bring a peripheral into reach; it advertises every ``advertising_s`` while nobody is connected."""
        address = checked_address(peripheral.address)
        station = _Station(self, peripheral, advertising_s)
        seed = np.random.default_rng(self._generator.integers(2**63))
        self.waves.reaches[address] = Reach(faults or LinkFaults(), seed, station.timed_out)
        self._stations[address] = station
        await station.open()

    async def remove(self, address: str) -> None:
        """Take a peripheral away; its link breaks at once."""
        address = checked_address(address)
        station = self._stations.pop(address)
        await station.close()
        self.waves.reaches.pop(address).close()

    def answer_to_a_scan(self, address: str) -> str | None:
        """The whole name, as an active scan gets it where an advertisement has no room (bumble does not carry it)."""
        station = self._stations.get(checked_address(address))
        return None if station is None else station.name

    def now(self) -> float:
        """The time that peripherals are told [s]."""
        return asyncio.get_running_loop().time()

    def cut(self, address: str, away_s: float | None = None) -> None:
        """Break a link now, as if the peripheral were carried out of reach for ``away_s``."""
        self.waves.reaches[checked_address(address)].cut(away_s)

    def worsen(self, address: str, faults: LinkFaults) -> None:
        """Change a link's faults from now on."""
        self.waves.reaches[checked_address(address)].take(faults)

    def losses(self, address: str) -> Losses:
        """What a link has swallowed so far."""
        return self.waves.reaches[checked_address(address)].losses

    def wake(self, address: str) -> None:
        """Let a peripheral's time go on now, for instance because somebody fed its core by another door."""
        self._stations[checked_address(address)].tick()


class _Station:
    """A peripheral on the air: bumble's device around it, its clock and its handle."""

    def __init__(self, air: Air, peripheral: Peripheral, advertising_s: float) -> None:
        self._air, self._peripheral, self._advertising_s = air, peripheral, advertising_s
        self._device: Any = None
        self._connection: Any = None
        self._values: dict[str, Any] = {}
        self._timer: asyncio.TimerHandle | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self._quiet_s, self._closing = 0.0, False

    @property
    def name(self) -> str:
        return self._peripheral.name

    async def open(self) -> None:
        peripheral = self._peripheral
        self._device = _device(self._air.waves, peripheral.address, peripheral.name)
        self._fill(peripheral.table())
        self._device.on("connection", self._on_connection)
        await self._device.power_on()
        peripheral.attach(self)
        self.tick()
        await self._advertise(0.0)

    async def close(self) -> None:
        self._closing = True
        self.timed_out()
        while self._connection is not None:
            await asyncio.sleep(0)
        if self._timer is not None:
            self._timer.cancel()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self._device.stop_advertising()
        await self._device.power_off()
        self._air.waves.remove_controller(self._device.host.controller)

    # --- what the peripheral does -----------------------------------------------------------------------

    def notify(self, uuid: str, data: bytes) -> bool:
        connection, value = self._connection, self._values[uuid]
        wanted = self._device.gatt_server.subscribers.get(connection, {}).get(value.handle, b"\0\0")
        if connection is None or not wanted[0] & 1:
            return False
        packet = bytes([NOTIFICATION, *value.handle.to_bytes(2, "little")]) + data[: connection.att_mtu - 3]
        self._device.gatt_server.send_gatt_pdu(connection, packet)
        return True

    def drop(self, quiet_s: float = 0.0) -> None:
        self._quiet_s = quiet_s
        if self._connection is not None:
            self._run(self._connection.disconnect())

    def ask(self, interval_s: float, supervision_s: float) -> None:
        self._reach().ask(interval_s, supervision_s)

    def renew(self) -> None:
        self._run(self._renew())

    async def _renew(self) -> None:
        if self._connection is not None:
            await self._connection.disconnect()
        self._air.tables.pop(checked_address(self._peripheral.address), None)
        self._device.gatt_server.services.clear()
        self._device.gatt_server.attributes.clear()
        self._device.gatt_server.attributes_by_handle.clear()
        self._fill(self._peripheral.table())

    # --- what happens to it -----------------------------------------------------------------------------

    def tick(self) -> None:
        """Let the peripheral's time go on, now and again when it says."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        loop = asyncio.get_running_loop()
        again = self._guarded(self._peripheral.advance, loop.time())
        if again is not None and self._timer is None:
            self._timer = loop.call_at(again, self.tick)

    def timed_out(self) -> None:
        """The link was silent for too long: each end that is still connected notices."""
        peripheral, central = self._device.host.controller, self._air.central.host.controller
        for controller, other in ((peripheral, central.random_address), (central, peripheral.random_address)):
            connection = controller.le_connections.get(other)
            if connection is not None:
                controller.on_le_disconnected(connection, TIMED_OUT)

    def _on_connection(self, connection: Any) -> None:
        self._connection, self._quiet_s = connection, 0.0
        self._reach().begin()
        connection.on("disconnection", self._on_disconnection)
        self._guarded(self._peripheral.connected)
        self.tick()

    def _on_disconnection(self, _reason: int) -> None:
        self._connection = None
        self._reach().end()
        self._guarded(self._peripheral.disconnected)
        self.tick()
        if not self._closing:
            self._run(self._advertise(self._quiet_s))

    async def _advertise(self, quiet_s: float) -> None:
        await asyncio.sleep(quiet_s)
        peripheral, interval_ms = self._peripheral, self._advertising_s * 1000.0
        await self._device.start_advertising(
            advertising_data=advertisement(peripheral.name, peripheral.services),
            advertising_interval_min=interval_ms,
            advertising_interval_max=interval_ms,
        )

    def _read(self, uuid: str) -> bytes:
        return self._guarded(self._peripheral.read, uuid) or b""

    def _written(self, uuid: str, data: bytes) -> None:
        self._guarded(self._peripheral.written, uuid, bytes(data))
        self.tick()

    def _guarded(self, act: Any, *given: Any) -> Any:
        """Bumble would only log what the peripheral raises."""
        try:
            return act(*given)
        except Exception as error:
            self._air.failures.append(error)
            return None

    # --- bumble -----------------------------------------------------------------------------------------

    def _fill(self, table: tuple[Service, ...]) -> None:
        gatt = _bumble().gatt
        for service in table:
            values = [self._value(each) for each in service.characteristics]
            self._device.gatt_server.add_service(gatt.Service(_uuid(service.uuid), values))

    def _value(self, told: Characteristic) -> Any:
        gatt, uuid = _bumble().gatt, told.uuid
        asked = gatt.CharacteristicValue(
            read=lambda _: self._read(uuid), write=lambda _, data: self._written(uuid, data)
        )
        words = ",".join(word.upper().replace("-", "_") for word in told.properties)
        value = gatt.Characteristic(
            _uuid(uuid),
            gatt.Characteristic.Properties.from_string(words),
            gatt.Characteristic.READABLE | gatt.Characteristic.WRITEABLE,
            asked if told.value is None else told.value,
        )
        self._values[uuid] = value
        return value

    def _reach(self) -> Reach:
        return self._air.waves.reaches[checked_address(self._peripheral.address)]

    def _run(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _device(waves: Waves, address: str, name: str) -> Any:
    bumble = _bumble()
    settings = bumble.device.DeviceConfiguration(name=name, gap_service_enabled=False, gatt_service_enabled=False)
    controller = bumble.controller.Controller(name, link=waves)
    host = bumble.host.Host(controller_source=controller, controller_sink=controller)
    return bumble.device.Device(name=name, address=bumble.hci.Address(address), config=settings, host=host)


def _uuid(text: str) -> Any:
    """A UUID of 16 bits where it is one."""
    low = text.lower()
    short = low[4:8] if low.startswith("0000") and low.endswith("-0000-1000-8000-00805f9b34fb") else low
    return _bumble().core.UUID(short.upper())


def _bumble() -> Any:
    try:
        import bumble
        import bumble.controller
        import bumble.core
        import bumble.device
        import bumble.gatt
        import bumble.hci
        import bumble.host
    except ImportError:
        raise MissingExtra("bumble", "ble") from None
    return bumble
