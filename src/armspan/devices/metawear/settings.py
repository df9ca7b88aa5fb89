"""What a MetaWear board keeps about its radio and its supply: the writes of its settings module.

Sources: MbientLab MetaWear-API, docs/protocol-reference.md; MetaWear-SDK-Cpp 0.30.0, test/test_settings.py.
"""

import re
import struct
from typing import Final

from armspan.devices.metawear.boards import SETTINGS, Board
from armspan.devices.metawear.quantities import counts, within
from armspan.devices.metawear.wire import PACKET_BYTES
from armspan.errors import DeviceError

AD_STEP_MS: Final = 0.625
CONNECTION_STEP_MS: Final = 1.25
TIMEOUT_STEP_MS: Final = 10.0
STREAMING: Final = (7.5, 7.5, 0, 6000.0)
"""Connection parameters for streams, as the vendor's examples ask."""


def connection_parameters(min_ms: float, max_ms: float, latency: int, timeout_ms: float) -> bytes:
    """Ask for an interval (7.5 to 4000 ms), events to skip (0 to 499), a supervision time (100 to 32000 ms)."""
    least = within("a connection interval in ms", min_ms, 7.5, 4000)
    most = within("a connection interval in ms", max_ms, 7.5, 4000)
    if least > most:
        raise DeviceError(f"the connection interval is from {min_ms:g} to {max_ms:g} ms; expected the shorter first")
    skipped = counts("connection latency", latency, 0, 499)
    patience = within("a supervision timeout in ms", timeout_ms, 100, 32000)
    steps = (int(least / CONNECTION_STEP_MS), int(most / CONNECTION_STEP_MS), skipped, int(patience / TIMEOUT_STEP_MS))
    return bytes((SETTINGS, 9)) + struct.pack("<4H", *steps)


def device_name(name: str) -> bytes:
    """Rename the board, with at most what one packet takes; its radio mangles other characters."""
    room = PACKET_BYTES - 2
    if not re.fullmatch(rf"[A-Za-z0-9_ -]{{1,{room}}}", name):
        raise DeviceError(f"a board cannot be named {name!r}; expected 1 to {room} of A-Z a-z 0-9 _ - and space")
    return bytes((SETTINGS, 1)) + name.encode()


def advertising_interval(board: Board, interval_ms: float, timeout_s: int = 0, kind: int = 0) -> bytes:
    """How often (20 to 10240 ms) and how long (0: always) the board is heard; its kind matters from revision 6."""
    interval = int(within("an advertising interval in ms", interval_ms, 20, 10240) / AD_STEP_MS)
    timeout = counts("an advertising time in s", timeout_s, 0, 0xFF)
    last = bytes((counts("a kind of advertisement", kind, 0, 0xFF),)) if board.revision(SETTINGS) >= 6 else b""
    return bytes((SETTINGS, 2)) + struct.pack("<HB", interval, timeout) + last


def transmit_power(dbm: int) -> bytes:
    """The radio's strength, -40 to 8 dBm."""
    return bytes((SETTINGS, 3, counts("a radio's strength in dBm", dbm, -40, 8) & 0xFF))


def force_1m_phy(board: Board, *, on: bool = True) -> bytes:
    """Keep the radio at one megabit per second (revision 10)."""
    _need(board, 10, "cannot force its radio's rate")
    return bytes((SETTINGS, 0x1D, on))


def supply_3v(board: Board, *, on: bool = True) -> bytes:
    """Power the board's 3 V regulator (revision 9)."""
    _need(board, 9, "cannot switch its 3 V supply")
    return bytes((SETTINGS, 0x1C, on))


def _need(board: Board, revision: int, lack: str) -> None:
    if not board.has(SETTINGS, revision):
        raise DeviceError(f"the {board.name} {lack}: that needs revision {revision} of its settings module")
