"""The emulated air for another process: its central's controller, given out as HCI packets on a TCP port.

bumble's controller does the work. What it lacks is done here: a reset that forgets, an attempt to connect that can be
taken back, an answer to a scan, a client that is gone.
"""

import asyncio
import dataclasses
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from armspan.errors import DeviceError
from armspan.links.ble_emulated import Air
from armspan.links.waves import TIMED_OUT

HOST = "127.0.0.1"
COMMAND, EVENT, META = 0x01, 0x04, 0x3E
RESET, SET_RANDOM_ADDRESS, CANCEL = 0x0C03, 0x2005, 0x200E
"""Commands: OGF << 10 | OCF (Core 5.4, volume 4, part E, 7)."""
REPORT, ANSWER = 0x0D, 0x08
"""An extended advertising report, and what marks it as the answer to a scan."""
NOT_CONNECTED = 0x02
"""Unknown connection identifier: how a controller says that an attempt was taken back."""
NAME = 0x09


@asynccontextmanager
async def serve_air(air: Air, port: int) -> AsyncIterator[int]:
    """Give the air's central to who connects to ``port`` (0: any that is free) of this machine; gives the port.

    One client at a time. When it goes away its links break as if the central had gone out of reach. Meanwhile
    ``air.radio`` must not be used.

    Raises:
        DeviceError: for a port that is taken.

    """
    desk = _Desk(air)
    try:
        server = await asyncio.start_server(desk.serve, HOST, port)
    except OSError as error:
        raise DeviceError(
            f"port {port} of {HOST} cannot be opened ({error.strerror}): another emulator may listen there; choose "
            "another with --port, or 0 for any that is free"
        ) from None
    own, desk.controller.host = desk.controller.host, None
    try:
        yield server.sockets[0].getsockname()[1]
    finally:
        server.close()
        await desk.close()
        await server.wait_closed()
        desk.controller.host = own


class _Desk:
    """The counter between one client and the central's controller; it is the controller's host."""

    def __init__(self, air: Air) -> None:
        self._air, self.controller = air, air.central.host.controller
        self._address = bytes(air.central.random_address)
        self._client: asyncio.StreamWriter | None = None
        self._serving: asyncio.Task[None] | None = None

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a client until it goes; a second one is sent away."""
        if self._client is None:
            self._client, self._serving = writer, asyncio.current_task()
            try:
                await self._talk(reader)
            except asyncio.CancelledError:
                pass  # the desk is closed
            finally:
                self._vanish()
                self._client = self._serving = None
        writer.close()

    async def close(self) -> None:
        """Send the client away."""
        if self._serving is not None:
            self._serving.cancel()
            await asyncio.gather(self._serving, return_exceptions=True)

    async def _talk(self, reader: asyncio.StreamReader) -> None:
        from bumble.core import InvalidPacketError
        from bumble.transport.common import PacketParser

        parser = PacketParser(_Inbox(self))
        self.controller.host = self
        try:
            while data := await reader.read(4096):
                parser.feed_data(data)
        except (ConnectionError, InvalidPacketError):
            pass  # it is gone, or speaks something else

    # --- the client to the controller ---------------------------------------------------------------------

    def obey(self, packet: bytes) -> None:
        """A packet of the client."""
        command = int.from_bytes(packet[1:3], "little") if packet[0] == COMMAND else None
        if command == RESET:
            self._vanish()
            self.controller.host = self
        elif command == SET_RANDOM_ADDRESS:
            packet = packet[:4] + self._address  # the air knows its central by it
        self.controller.on_packet(packet)
        if command == CANCEL:
            self._take_back()

    def _vanish(self) -> None:
        """The central forgets everything without a word to anybody; the peripherals notice when nothing comes."""
        controller = self.controller
        controller.host, controller.pending_le_connection, controller.le_scan_enable = None, None, False
        for connection in list(controller.le_connections.values()):
            controller.on_le_disconnected(connection, TIMED_OUT)
            reach = self._air.waves.reaches.get(str(connection.peer_address).split("/")[0].upper())
            if reach is not None:
                reach.cut(0.0)

    def _take_back(self) -> None:
        from bumble import hci

        pending, self.controller.pending_le_connection = self.controller.pending_le_connection, None
        if pending is not None:
            self.controller.send_hci_packet(
                hci.HCI_LE_Connection_Complete_Event(
                    status=NOT_CONNECTED,
                    connection_handle=0,
                    role=hci.Role.CENTRAL,
                    peer_address_type=pending.peer_address_type,
                    peer_address=pending.peer_address,
                    connection_interval=0,
                    peripheral_latency=0,
                    supervision_timeout=0,
                    central_clock_accuracy=0,
                )
            )

    # --- the controller to the client ---------------------------------------------------------------------

    def on_packet(self, packet: bytes) -> None:
        """A packet of the controller."""
        if self._client is None or self._client.is_closing():
            return
        if packet[:2] == bytes([EVENT, META]) and packet[3] == REPORT and packet[5] & ANSWER:
            packet = self._answered(packet)
        self._client.write(packet)

    def _answered(self, packet: bytes) -> bytes:
        """The answer to a scan holds the whole name; bumble's repeats the advertisement."""
        from bumble import hci

        event: Any = hci.HCI_Packet.from_bytes(packet)
        (report,) = event.reports
        return bytes(type(event)([dataclasses.replace(report, data=self._name(report.address))]))

    def _name(self, address: Any) -> bytes:
        name = (self._air.answer_to_a_scan(str(address).split("/")[0]) or "").encode()[:29]
        return bytes([1 + len(name), NAME]) + name if name else b""


class _Inbox:
    """Where bumble's parser puts the client's packets."""

    def __init__(self, desk: _Desk) -> None:
        self._desk = desk

    def on_packet(self, packet: bytes) -> None:
        """One packet."""
        self._desk.obey(packet)
