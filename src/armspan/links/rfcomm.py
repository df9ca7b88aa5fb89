"""Bluetooth Classic's serial port profile: an RFCOMM socket of the standard library to one device. Linux.

Python has these sockets only where it was compiled beside BlueZ's headers: Debian's own has them, one built by pyenv
or uv often has not. Each error that a person can mend says how.
"""

import asyncio
import errno
import os
import socket
from contextlib import suppress

from armspan.errors import DeviceError, DeviceNotFound
from armspan.links.line import Line

CHANNEL = 1
CONNECT_S = 12.0
"""Seconds for one attempt; a device that is away is noticed after five."""
KERNEL_BYTES = 2304
"""What the system may hold back of ours, as little as it allows: old commands must not wait in a stuck link."""

OTHER_DOORS = "or reach the device through /dev/rfcommN (rfcomm bind) or EPFL's TCP relay"


def available() -> bool:
    """Whether this Python has Bluetooth sockets that an event loop can wait for."""
    return os.name == "posix" and hasattr(socket, "AF_BLUETOOTH") and hasattr(socket, "BTPROTO_RFCOMM")


async def connected(
    address: str, adapter: str | None = None, *, channel: int = CHANNEL, seconds: float = CONNECT_S
) -> Line:
    """Connect to a device by its address, from the local ``adapter`` with that address, or from any.

    One attempt, which must not be made beside another one of the same adapter.

    Raises:
        DeviceNotFound: where the device does not answer: off, away, or held by another host. Worth another try.
        DeviceError: for what a person must mend: a Python without such sockets, no adapter, no permission.

    """
    sock = open_socket()
    try:
        sock.setblocking(False)
        with suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, KERNEL_BYTES)
        if adapter is not None:
            sock.bind((adapter, 0))
        async with asyncio.timeout(seconds):
            await asyncio.get_running_loop().sock_connect(sock, (address, channel))
    except OSError as error:  # TimeoutError is one
        sock.close()
        raise explained(error, address, adapter) from None
    except BaseException:
        sock.close()
        raise
    return Line(sock.fileno(), sock.close)


def open_socket() -> socket.socket:
    """An RFCOMM socket; DeviceError where there can be none."""
    if not available():
        raise DeviceError(
            "this Python has no Bluetooth sockets (socket.AF_BLUETOOTH is missing); use the system's own, on Debian "
            f"/usr/bin/python3 (python3 -m venv --system-site-packages), {OTHER_DOORS}"
        )
    try:
        return socket.socket(socket.AF_BLUETOOTH, socket.SOCK_STREAM, socket.BTPROTO_RFCOMM)  # type: ignore[attr-defined, unused-ignore]
    except OSError as error:
        raise explained(error, "any device", None) from None


def explained(error: OSError, address: str, adapter: str | None) -> DeviceError:
    """What an error of such a socket means: DeviceNotFound where another try may help."""
    number, own = error.errno or 0, f"the Bluetooth adapter {adapter}" if adapter else "a Bluetooth adapter"
    if number in (errno.EAFNOSUPPORT, errno.EPROTONOSUPPORT, errno.ESOCKTNOSUPPORT):
        return DeviceError(f"the system has no Bluetooth: load its modules (sudo modprobe rfcomm), {OTHER_DOORS}")
    if number in (errno.EPERM, errno.EACCES):
        return DeviceError(
            f"{address} may not be reached by Bluetooth: this user or container has no permission; run on the host, "
            f"{OTHER_DOORS}"
        )
    if number in (errno.EHOSTUNREACH, errno.ENODEV, errno.ENETDOWN, errno.ENETUNREACH, errno.EADDRNOTAVAIL):
        return DeviceError(
            f"{own} is not there or is off, so {address} cannot be reached; see bluetoothctl list, rfkill list and "
            "hciconfig, and switch it on (bluetoothctl power on)"
        )
    why = "no answer" if isinstance(error, TimeoutError) and not number else error.strerror or str(error)
    return DeviceNotFound(
        f"{address} does not answer over Bluetooth ({why}); see that it is on, charged and near, that no other host "
        "holds it, and that it is paired (bluetoothctl pair) where it asks for that"
    )
