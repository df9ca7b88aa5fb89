"""A central on bumble's host, for a controller that may go away and an attempt that may be given up.

The classes are made when a controller is opened, since bumble is optional.
"""

import asyncio
import logging
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, TypeAlias

from armspan.errors import MissingExtra

GONE = "the Bluetooth controller went away"
ANSWER_S = 1.0
"""The longest wait for the answer to a command on the way out [s]."""
Heard: TypeAlias = Mapping[str, tuple[Any, list[str]]]
"""By address in words: who advertised, as bumble's address with its type, and the services."""


def line_host(transport: Any, lost: Callable[[], None]) -> Any:
    """A host that knows when its controller is gone: every command fails then instead of waiting for ever."""
    from bumble.host import Host

    class LineHost(Host):
        gone = False

        def send_hci_packet(self, packet: Any) -> None:
            if self.gone:
                raise EOFError(GONE)
            super().send_hci_packet(packet)

        def on_transport_lost(self) -> None:
            self.gone = True
            lost()
            if self.pending_response is not None and not self.pending_response.done():
                self.pending_response.set_exception(EOFError(GONE))
            self.emit("flush")

    return LineHost(transport.source, transport.sink)


def line_central(host: Any, heard: Heard) -> Any:
    """A central that takes an attempt back when it is given up, and knows each address's type from hearing it."""
    from bumble.device import Device, DeviceConfiguration

    class Central(Device):
        async def connect_le(self, peer_address: Any, *more: Any, **settings: Any) -> Any:
            peer = heard.get(peer_address, (peer_address, []))[0]
            try:
                return await super().connect_le(peer, *more, **settings)
            except asyncio.CancelledError:
                if host.gone:  # bumble cancels who waits
                    raise EOFError(GONE) from None
                await _take_back(self, peer)
                raise

    settings = DeviceConfiguration(name="Armspan", gap_service_enabled=False, gatt_service_enabled=False)
    return Central(name="Armspan", config=settings, host=host)


async def _take_back(device: Any, peer: Any) -> None:
    """Cancel an attempt to connect; if it has succeeded meanwhile, disconnect."""
    bumble = bumble_modules()
    with suppress(bumble.core.BaseBumbleError, EOFError, TimeoutError):
        await device.host.send_sync_command(bumble.hci.HCI_LE_Create_Connection_Cancel_Command(), ANSWER_S)
    address = bumble.hci.Address(str(peer).split("/")[0])
    late = device.find_connection_by_bd_addr(address, bumble.core.PhysicalTransport.LE)
    if late is not None:
        with suppress(bumble.core.BaseBumbleError, EOFError):
            await late.disconnect()


async def reset(host: Any) -> None:
    """A controller keeps connections, and goes on scanning, until it is told otherwise."""
    bumble = bumble_modules()
    with suppress(bumble.core.BaseBumbleError, EOFError, TimeoutError):
        await host.send_sync_command(bumble.hci.HCI_Reset_Command(), ANSWER_S)


def bumble_modules() -> Any:
    """The package bumble with those of its modules that are used; it is silent, since what goes wrong is raised."""
    logging.getLogger("bumble").addHandler(logging.NullHandler())
    try:
        import bumble
        import bumble.core
        import bumble.device
        import bumble.hci
        import bumble.host
        import bumble.transport
    except ImportError:
        raise MissingExtra("bumble", "ble") from None
    return bumble
