"""EPFL's relay ("robot pool", "robot hub"): several robots over one stream, both ends, without I/O.

A robot's packet passes through unchanged; an address goes before it only where it differs from the one before,
in each direction separately (chili-epfl/CelluloV2, qml-plugin/src/comm/relay).
"""

from armspan.devices.cellulo.quantities import mac_text
from armspan.devices.cellulo.wire import COMMANDS, EVENTS, Direction, Framer

PORT = 2556
BEAT_S = 1.5
"""Between two heartbeats, each way."""
SILENCE_S = 6.0
"""Without a heartbeat the other end counts as gone."""
RETRY_S = 5.0
"""From a lost link to the next attempt, as EPFL's client waits."""

DISCONNECTED, CONNECTING, CONNECTED = 0, 1, 2

ADDRESS, STATUS, ADAPTER, BEAT = b"@!>&"


class Stream:
    """One end of a relay's link; addresses are text as ``00:06:66:E7:8A:D8``.

    ``heard`` is the time [s] at which the last heartbeat, or the link itself, came.
    """

    def __init__(self, says: Direction, hears: Direction, now: float = 0.0) -> None:
        self.heard = now
        self._beaten = now
        self._says, self._framer = says, Framer(hears, relay=True)
        self._to: str | None = None
        self._from: str | None = None

    def pack(self, mac: str, packet: bytes) -> bytes:
        """The bytes that bring one robot's packet across."""
        if mac == self._to:
            return packet
        address = self.address(mac)
        return address + packet

    def address(self, mac: str) -> bytes:
        """The bytes that say whom the next packets belong to."""
        packet = self._says.encode("SetAddress", mac=mac)
        self._to = mac
        return packet

    def status(self, mac: str, status: int, adapter: str | None = None) -> bytes:
        """The bytes that ask for, or announce, a robot's connection; the next packet tells its address again."""
        name = "SetConnectionStatus" if self._says is COMMANDS else "AnnounceConnectionStatus"
        told = self.pack(mac, self._says.encode(name, status=status, local_adapter=adapter))
        self._to = None
        return told

    def beat(self, now: float) -> bytes:
        """A heartbeat if one is due, else nothing."""
        if now - self._beaten < BEAT_S:
            return b""
        self._beaten = now
        return self._says.encode("Heartbeat")

    def silent(self, now: float) -> bool:
        """Whether the other end has to be given up."""
        return now - self.heard >= SILENCE_S

    def feed(self, data: bytes, now: float) -> list[tuple[str, bytes]]:
        """What arrived for robots, or from them: (mac, whole packet), `STATUS` packets with them.

        Heartbeats and addresses are digested here; what comes before any address is dropped.
        """
        packets: list[tuple[str, bytes]] = []
        for packet in self._framer.feed(data):
            kind = packet[1]
            if kind == BEAT:
                self.heard = now
            elif kind == ADDRESS:
                self._from = mac_text(packet[2:])
            elif self._from is not None and kind != ADAPTER:
                packets.append((self._from, packet))
                if kind == STATUS and self._says is EVENTS:
                    self._from = None  # the client tells the address anew
        return packets


def client_side(now: float = 0.0) -> Stream:
    """The host's end."""
    return Stream(COMMANDS, EVENTS, now)


def server_side(now: float = 0.0) -> Stream:
    """The relay's end."""
    return Stream(EVENTS, COMMANDS, now)
