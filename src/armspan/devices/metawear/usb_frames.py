"""A MetaMotion S's packets on a USB cable: ``1f``, length, payload, ``0a``.

Source: MbientLab MetaWear-API, docs/usb-transport.md.
"""

from typing import Final

from armspan.errors import DeviceError

START: Final = 0x1F
END: Final = 0x0A
IDENTIFY: Final = b"?\n"


def usb_frame(payload: bytes) -> bytes:
    """A packet as the cable carries it.

    Raises:
        DeviceError: for an empty one or one of more than 255 bytes.

    """
    if not 1 <= len(payload) <= 0xFF:
        raise DeviceError(f"a USB frame carries {len(payload)} bytes; expected 1 to 255")
    return bytes((START, len(payload))) + payload + bytes((END,))


class UsbFramer:
    """Cuts a cable's stream into payloads; a frame without its end is searched again from its second byte."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """The payloads that are complete now."""
        stream, at, payloads = self._rest + data, 0, []
        while (start := stream.find(START, at)) >= 0 and start + 1 < len(stream):
            end = start + 2 + stream[start + 1]
            if end >= len(stream):
                break
            sound = end > start + 2 and stream[end] == END
            if sound:
                payloads.append(stream[start + 2 : end])
            at = end + 1 if sound else start + 1
        self._rest = stream[start:] if start >= 0 else b""
        return payloads
