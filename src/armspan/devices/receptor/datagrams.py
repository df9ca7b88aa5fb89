"""A door for datagrams."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from armspan.errors import DeviceError

Taken = Callable[[bytes, str], None]


@asynccontextmanager
async def listening(host: str, port: int, take: Taken) -> AsyncIterator[int]:
    """Hand datagrams over with their sender's address, as long as it is needed; gives the port, a free one for 0.

    Raises:
        DeviceError: where the port cannot be had.

    """
    loop = asyncio.get_running_loop()
    try:
        transport, _ = await loop.create_datagram_endpoint(lambda: _Datagrams(take), local_addr=(host, port))
    except OSError as error:
        raise DeviceError(
            f"port {port} of {host} cannot be had for datagrams ({error.strerror or error}); end what uses it, or "
            "choose another port above 1023"
        ) from None
    try:
        yield int(transport.get_extra_info("sockname")[1])
    finally:
        transport.close()


class _Datagrams(asyncio.DatagramProtocol):
    def __init__(self, take: Taken) -> None:
        self._take = take

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        """A datagram came."""
        self._take(data, addr[0])
