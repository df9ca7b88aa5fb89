"""A private message bus with a mock BlueZ and a MetaWear board on its second adapter.

BlueZoo (GPL) plays BlueZ in a process of its own and is never imported; the board's GATT application is served by
dbus-fast, which comes with bleak.
"""

import asyncio
import os
import shutil
import subprocess
import sys
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path

from armspan.devices.metawear.peripheral import BATTERY, COMMAND, NOTIFY, SERVICE

OURS, THEIRS = "00:00:00:11:00:00", "E8:C9:8F:52:7B:07"
ROOT = "/org/armspan/board"


def missing():
    """Why this cannot run here; None where it can."""
    if not sys.platform.startswith("linux"):
        return "BlueZ is Linux's"
    if shutil.which("dbus-daemon") is None:
        return "dbus-daemon is not installed (apt-get install dbus)"
    if not bluezoo().exists():
        return "bluezoo is not installed (pip install bluezoo==1.0.2; GPL, for this test only)"
    return None


def bluezoo():
    return Path(sys.executable).parent / "bluezoo"


@contextmanager
def private_bus():
    """The address of a message bus of its own."""
    command = ["dbus-daemon", "--session", "--nofork", "--nopidfile", "--print-address=1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as daemon:
        try:
            yield daemon.stdout.readline().strip()
        finally:
            daemon.terminate()


@contextmanager
def mock_bluez(bus, *more):
    """BlueZoo on that bus, with two adapters."""
    command = [str(bluezoo()), "-q", "-q", "--scan-interval", "1", *more, "-a", OURS, "-a", THEIRS]
    environment = os.environ | {"DBUS_SYSTEM_BUS_ADDRESS": bus}
    with subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL) as process:
        try:
            yield process
        finally:
            process.terminate()


@asynccontextmanager
async def served(board, bus, adapter="hci1"):
    """The board's service on the mock's adapter."""
    from dbus_fast.aio import MessageBus

    connection = await MessageBus(bus_address=bus).connect()
    await named(connection)
    notify = application(board, connection)
    for call in (("RegisterApplication", "GattManager1"), ("RegisterAdvertisement", "LEAdvertisingManager1")):
        await register(connection, adapter, *call)
    beat = asyncio.create_task(beating(board, notify))
    try:
        yield
    finally:
        beat.cancel()
        await asyncio.gather(beat, return_exceptions=True)
        connection.disconnect()
        await connection.wait_for_disconnect()


async def dropped(bus, adapter, address):
    """Somebody else ends the link."""
    from dbus_fast import Message
    from dbus_fast.aio import MessageBus

    connection = await MessageBus(bus_address=bus).connect()
    path = f"/org/bluez/{adapter}/dev_{address.replace(':', '_')}"
    await connection.call(Message("org.bluez", path, "org.bluez.Device1", "Disconnect"))
    connection.disconnect()
    await connection.wait_for_disconnect()


async def named(connection):
    """Wait until the mock is there."""
    from dbus_fast import Message

    for _ in range(100):
        asked = Message("org.freedesktop.DBus", "/org/freedesktop/DBus", "org.freedesktop.DBus", "NameHasOwner")
        asked.signature, asked.body = "s", ["org.bluez"]
        if (await connection.call(asked)).body[0]:
            return
        await asyncio.sleep(0.05)
    raise TimeoutError("the mock BlueZ did not come up")


async def register(connection, adapter, member, interface):
    from dbus_fast import Message, MessageType

    path = ROOT if member == "RegisterApplication" else f"{ROOT}/advertisement"
    asked = Message("org.bluez", f"/org/bluez/{adapter}", f"org.bluez.{interface}", member)
    asked.signature, asked.body = "oa{sv}", [path, {}]
    answer = await connection.call(asked)
    if answer.message_type is not MessageType.METHOD_RETURN:
        raise RuntimeError(f"{member}: {answer.body}")


async def beating(board, notify):
    """The board's time goes on."""
    loop = asyncio.get_running_loop()
    while True:
        for packet in board.advance(loop.time()):
            notify(packet)
        await asyncio.sleep(0.002)


def application(board, connection):
    """Export the GATT table; what notifies is returned."""
    from dbus_fast import PropertyAccess
    from dbus_fast.service import ServiceInterface, dbus_method, dbus_property

    read_only = PropertyAccess.READ

    class Service(ServiceInterface):
        def __init__(self, uuid, handle):
            super().__init__("org.bluez.GattService1")
            self.uuid, self.handle = uuid, handle

        @dbus_property(access=read_only)
        def UUID(self) -> "s":  # noqa: F821
            return self.uuid

        @dbus_property(access=read_only)
        def Primary(self) -> "b":  # noqa: F821
            return True

        @dbus_property(access=read_only)
        def Handle(self) -> "q":  # noqa: F821
            return self.handle

    class Value(ServiceInterface):
        def __init__(self, uuid, service, handle, flags, reading=bytes):
            super().__init__("org.bluez.GattCharacteristic1")
            self.uuid, self.service, self.handle, self.flags, self.reading = uuid, service, handle, flags, reading
            self.notifying = False

        @dbus_property(access=read_only)
        def UUID(self) -> "s":  # noqa: F821
            return self.uuid

        @dbus_property(access=read_only)
        def Service(self) -> "o":  # noqa: F821
            return self.service

        @dbus_property(access=read_only)
        def Flags(self) -> "as":  # noqa: F722
            return self.flags

        @dbus_property(access=read_only)
        def Handle(self) -> "q":  # noqa: F821
            return self.handle

        @dbus_property(access=read_only)
        def Notifying(self) -> "b":  # noqa: F821
            return self.notifying

        @dbus_property(access=read_only)
        def Value(self) -> "ay":  # noqa: F821
            return self.reading()

        @dbus_method()
        def ReadValue(self, options: "a{sv}") -> "ay":  # noqa: F722, F821
            return self.reading()

        @dbus_method()
        def WriteValue(self, value: "ay", options: "a{sv}"):  # noqa: F722, F821
            board.write(value)

        @dbus_method()
        def StartNotify(self):
            self.notifying = True
            board.linked(True)

        @dbus_method()
        def StopNotify(self):
            self.notifying = False

        @dbus_method()
        def Confirm(self):
            pass

    class Advertisement(ServiceInterface):
        def __init__(self):
            super().__init__("org.bluez.LEAdvertisement1")

        @dbus_property(access=read_only)
        def Type(self) -> "s":  # noqa: F821
            return "peripheral"

        @dbus_property(access=read_only)
        def ServiceUUIDs(self) -> "as":  # noqa: F722
            return [SERVICE]

        @dbus_property(access=read_only)
        def LocalName(self) -> "s":  # noqa: F821
            return board.name

        @dbus_property(access=read_only)
        def Discoverable(self) -> "b":  # noqa: F821
            return True

        @dbus_method()
        def Release(self):
            pass

    main, power = f"{ROOT}/service001d", f"{ROOT}/service000e"
    told = Value(NOTIFY, main, 0x21, ["read", "notify"])
    level = Value(BATTERY, power, 0x10, ["read"], lambda: bytes([board.traits.battery]))
    command = Value(COMMAND, main, 0x1F, ["read", "write-without-response", "write"])
    for path, interface in (
        (power, Service("0000180f-0000-1000-8000-00805f9b34fb", 0x0E)),
        (f"{power}/char0010", level),
        (main, Service(SERVICE, 0x1D)),
        (f"{main}/char001f", command),
        (f"{main}/char0021", told),
        (f"{ROOT}/advertisement", Advertisement()),
    ):
        connection.export(path, interface)

    def notify(packet):
        if told.notifying:
            told.emit_properties_changed({"Value": packet})

    return notify
