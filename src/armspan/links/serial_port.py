"""Serial ports by their path: a cable, ``/dev/rfcommN`` that the system bound to a radio, a pseudo-terminal. POSIX.

The operating system's own ``termios`` is all that is needed: raw bytes, eight bits, no parity, no flow control.
"""

import errno
import os
import sys
from contextlib import suppress

from armspan.errors import DeviceError, DeviceNotFound
from armspan.links.line import Line

BAUD = 115200

_TRY = {
    errno.ENOENT: "see how it is called (ls /dev/tty* /dev/rfcomm*), and that it is plugged in or bound (rfcomm bind)",
    errno.EACCES: "this user may not: add it to the port's group, often dialout, and log in again",
    errno.EPERM: "this user may not: add it to the port's group, often dialout, and log in again",
    errno.EBUSY: "another program has it: close that one",
    errno.EISDIR: "that is a folder: name the port itself",
}


async def opened(path: str, baud: int = BAUD) -> Line:
    """Open a port for raw bytes at ``baud``; that of a radio or a pseudo-terminal does not matter.

    Raises:
        DeviceNotFound: where there is none at the path, or it does not answer just now.
        DeviceError: where it may not be opened, or is no serial port.

    """
    if sys.platform == "win32":
        raise DeviceError(f"{path} cannot be opened: serial ports need POSIX; use Linux, macOS, or the TCP relay")
    try:
        fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise _explained(path, error) from None
    try:
        _make_raw(path, fd, baud)
    except BaseException:
        os.close(fd)
        raise
    return Line(fd, lambda: os.close(fd))


def _make_raw(path: str, fd: int, baud: int) -> None:
    """Let bytes pass as they are; what waited from before is thrown away."""
    import termios
    import tty

    speed = getattr(termios, f"B{baud}", None)
    if speed is None:
        raise DeviceError(f"{path} cannot have {baud} baud; expected a usual rate such as 9600, 115200 or 921600")
    try:
        tty.setraw(fd)
        settings = termios.tcgetattr(fd)
        settings[2] = (settings[2] | termios.CLOCAL | termios.CREAD) & ~termios.CRTSCTS
        settings[4] = settings[5] = speed
        termios.tcsetattr(fd, termios.TCSANOW, settings)
        with suppress(termios.error):
            termios.tcflush(fd, termios.TCIOFLUSH)
    except termios.error:
        raise DeviceError(f"{path} is not a serial port; expected one such as /dev/rfcomm0 or /dev/ttyUSB0") from None


def _explained(path: str, error: OSError) -> DeviceError:
    number = error.errno or 0
    what = f"{path} cannot be opened: {error.strerror or error}"
    if number in (errno.EACCES, errno.EPERM, errno.EBUSY, errno.EISDIR):
        return DeviceError(f"{what}; {_TRY[number]}")
    return DeviceNotFound(f"{what}; {_TRY.get(number, 'see that the device is on and near')}")
