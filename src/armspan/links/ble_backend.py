"""bleak's scanner and client for the emulated air; the classes are made when an air is opened, since bleak is optional.

They behave as bleak's BlueZ backend does where it matters: a second connection attempt at the same time is refused, an
operation on a broken link raises BleakError, the GATT table is kept between connections, the callback for a
disconnection is called whoever disconnected.
"""

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from armspan.errors import MissingExtra
from armspan.links.ble import Radio

if TYPE_CHECKING:
    from armspan.links.ble_emulated import Air

COMMAND = 0x52
CCC = "00002902-0000-1000-8000-00805f9b34fb"
RSSI = -50
UNNAMED = "0000{}-0000-1000-8000-00805f9b34fb"


def radio_of(air: "Air") -> Radio:
    """The radio with which bleak talks into an emulated air."""
    try:
        import bleak  # noqa: F401
    except ImportError:
        raise MissingExtra("bleak", "ble") from None
    return Radio(scanner=_scanner(air), client=_client(air))


def fields(data: bytes) -> list[tuple[int, bytes]]:
    """The fields of an advertisement: (type, value)."""
    found = []
    while len(data) > 1 and data[0] > 0:
        found.append((data[1], data[2 : 1 + data[0]]))
        data = data[1 + data[0] :]
    return found


def uuids(told: list[tuple[int, bytes]]) -> list[str]:
    """The services of an advertisement, of 128 bits."""
    short = [value[i : i + 2] for kind, value in told if kind in (2, 3) for i in range(0, len(value), 2)]
    long = [value[i : i + 16] for kind, value in told if kind in (6, 7) for i in range(0, len(value), 16)]
    texts = [each[::-1].hex() for each in long]
    return [UNNAMED.format(each[::-1].hex()) for each in short] + [
        "-".join((text[:8], text[8:12], text[12:16], text[16:20], text[20:])) for text in texts
    ]


def _scanner(air: "Air") -> type[Any]:
    from bleak.backends.scanner import AdvertisementData, BaseBleakScanner

    class AirScanner(BaseBleakScanner):
        """Hears what the central hears."""

        def __init__(self, detection_callback: Any, service_uuids: Any, scanning_mode: str, **_: Any) -> None:
            super().__init__(detection_callback, service_uuids)

        async def start(self) -> None:
            self.seen_devices = {}
            air.central.on("advertisement", self._heard)
            if not air.central.scanning:
                await air.central.start_scanning(filter_duplicates=False)

        async def stop(self) -> None:
            air.central.remove_listener("advertisement", self._heard)
            if not air.central.listeners("advertisement"):
                await air.central.stop_scanning()

        def _heard(self, advertisement: Any) -> None:
            told = fields(bytes(advertisement.data_bytes))
            services = uuids(told)
            if not self.is_allowed_uuid(services):
                return
            address = str(advertisement.address).split("/")[0]
            name = next((value.decode(errors="replace") for kind, value in told if kind == 9), None)
            name = name or air.answer_to_a_scan(address)
            facts = AdvertisementData(name, {}, {}, services, None, getattr(advertisement, "rssi", RSSI), ())
            device = self.create_or_update_device(address, address, name, advertisement.address, facts)
            self.call_detection_callbacks(device, facts)

    return AirScanner


def _client(air: "Air") -> type[Any]:
    from bleak.backends.characteristic import BleakGATTCharacteristic
    from bleak.backends.client import BaseBleakClient
    from bleak.backends.descriptor import BleakGATTDescriptor
    from bleak.exc import BleakError, BleakGATTProtocolError

    class AirClient(BaseBleakClient):
        """One connection of the central."""

        def __init__(self, address_or_ble_device: Any, **kwargs: Any) -> None:
            wanted = {name: kwargs[name] for name in ("disconnected_callback", "timeout")}
            super().__init__(address_or_ble_device, **wanted)
            self._connection: Any = None

        @property
        def name(self) -> str:
            return self.address.replace(":", "-")

        @property
        def mtu_size(self) -> int:
            return int(self._connection.att_mtu) if self.is_connected else 23

        @property
        def is_connected(self) -> bool:
            return self._connection is not None

        async def connect(self, pair: bool, **_: Any) -> None:
            if air.central.is_le_connecting:
                raise BleakError("[org.bluez.Error.InProgress] Operation already in progress")
            async with asyncio.timeout(self._timeout):
                connection = await self._open()
                connection.on("disconnection", self._on_disconnection)
                self._connection = connection
                try:
                    self.services = await self._asked(discovered(air, connection, self.address))
                except BaseException:
                    await self.disconnect()
                    raise

        async def _open(self) -> Any:
            controller = air.central.host.controller
            try:
                return await air.central.connect_le(self.address, timeout=None)
            finally:
                controller.pending_le_connection = None  # bumble leaves it there when an attempt is given up

        def _on_disconnection(self, _reason: int) -> None:
            self._connection = None
            if self._disconnected_callback is not None:
                asyncio.get_running_loop().call_soon(self._disconnected_callback)

        async def disconnect(self) -> None:
            if self._connection is not None:
                await self._connection.disconnect()

        async def pair(self, *args: Any, **kwargs: Any) -> None:
            raise NotImplementedError("the emulated air does not pair")

        async def unpair(self) -> None:
            raise NotImplementedError("the emulated air does not pair")

        async def read_gatt_char(
            self, characteristic: BleakGATTCharacteristic, *, use_cached: bool = False, **_: Any
        ) -> bytearray:
            return bytearray(await self._asked(self._gatt().read_value(characteristic.handle)))

        async def read_gatt_descriptor(
            self, descriptor: BleakGATTDescriptor, *, use_cached: bool = False, **_: Any
        ) -> bytearray:
            return bytearray(await self._asked(self._gatt().read_value(descriptor.handle)))

        async def write_gatt_char(self, characteristic: BleakGATTCharacteristic, data: Any, response: bool) -> None:
            value = bytes(data)
            if len(value) > self.mtu_size - 3:
                raise BleakError(f"{len(value)} bytes do not fit in a packet: at most {self.mtu_size - 3}")
            if response:
                await self._asked(self._gatt().write_value(characteristic.handle, value, with_response=True))
            else:
                self._gatt().send_gatt_pdu(bytes([COMMAND, *characteristic.handle.to_bytes(2, "little")]) + value)
                await asyncio.sleep(0)

        async def write_gatt_descriptor(self, descriptor: BleakGATTDescriptor, data: Any) -> None:
            await self._asked(self._gatt().write_value(descriptor.handle, bytes(data), with_response=True))

        async def start_notify(
            self, characteristic: BleakGATTCharacteristic, callback: Callable[[bytearray], None], **_: Any
        ) -> None:
            gatt = self._gatt()
            gatt.notification_subscribers[characteristic.handle] = {lambda data: callback(bytearray(data))}
            await self._subscribe(characteristic, b"\x01\x00")

        async def stop_notify(self, characteristic: BleakGATTCharacteristic) -> None:
            await self._subscribe(characteristic, b"\x00\x00")
            self._gatt().notification_subscribers.pop(characteristic.handle, None)

        async def _subscribe(self, characteristic: BleakGATTCharacteristic, value: bytes) -> None:
            switch = characteristic.get_descriptor(CCC)
            if switch is None:
                raise BleakError(f"{characteristic.uuid} does not notify")
            await self.write_gatt_descriptor(switch, value)

        def _gatt(self) -> Any:
            if self._connection is None:
                raise BleakError("Not connected")
            return self._connection.gatt_client

        async def _asked(self, answer: Any) -> Any:
            """An answer. When the link breaks, bumble cancels who waits for one: that is not our own end."""
            from bumble.att import ATT_Error

            try:
                return await answer
            except asyncio.CancelledError:
                task = asyncio.current_task()
                if self._connection is not None or (task is not None and task.cancelling()):
                    raise
                raise BleakError("Not connected") from None
            except ATT_Error as error:
                raise BleakGATTProtocolError(error.error_code) from None

    return AirClient


async def discovered(air: "Air", connection: Any, address: str) -> Any:
    """The services of a peripheral, from the air where they have been asked for before (as BlueZ keeps them)."""
    from bumble.device import Peer

    peer: Any = Peer(connection)
    if address not in air.tables:
        await peer.discover_all()
        air.tables[address] = _table(peer)
    return air.tables[address]


def _table(peer: Any) -> Any:
    from bleak.backends.characteristic import BleakGATTCharacteristic
    from bleak.backends.descriptor import BleakGATTDescriptor
    from bleak.backends.service import BleakGATTService, BleakGATTServiceCollection

    table = BleakGATTServiceCollection()
    for service in peer.services:
        told = BleakGATTService(service, service.handle, _text(service.uuid))
        table.add_service(told)
        for value in service.characteristics:
            found = BleakGATTCharacteristic(
                value, value.handle, _text(value.uuid), _properties(value), lambda: 20, told
            )
            table.add_characteristic(found)
            for each in value.descriptors:
                table.add_descriptor(BleakGATTDescriptor(each, each.handle, _text(each.type), found))
    return table


def _properties(value: Any) -> Any:
    words = ("broadcast", "read", "write-without-response", "write", "notify", "indicate")
    return [word for bit, word in enumerate(words) if int(value.properties) & (1 << bit)]


def _text(uuid: Any) -> str:
    return (
        str(uuid.to_hex_str("-")).lower() if len(uuid.to_bytes()) == 16 else UNNAMED.format(uuid.to_hex_str().lower())
    )
