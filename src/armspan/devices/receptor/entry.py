"""A receptor's door in the room file."""

import math

import msgspec

from armspan.errors import ConfigError, known_names
from armspan.links.http import Guard, host_and_port

UDP_LISTEN = "127.0.0.1:47701"
HTTP_LISTEN = "127.0.0.1:47702"
LONGEST_S = 60.0


class SerialReceptor(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="serial"):
    """Receptors behind one serial port, such as a microcontroller's at ``path``.

    They may speak of ``robots``, of all where none are named. A ``lost`` counts after ``chatter_s``, unless there was a
    new ``hit``. With ``expire_s`` above 0 a hit that is not said again for so long is over.
    """

    name: str
    path: str
    baud: int = 115200
    robots: tuple[str, ...] = ()
    chatter_s: float = 0.03
    expire_s: float = 0.0

    def __post_init__(self) -> None:
        _check(self.name, self.chatter_s, self.expire_s)
        if not self.path:
            raise ConfigError(f"receptor {self.name!r}: path is empty; expected a port such as /dev/ttyUSB0")


class _Listening(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the doors that listen have in common."""

    name: str
    listen: str
    token: str | None = None
    allow: tuple[str, ...] = ()
    robots: tuple[str, ...] = ()
    chatter_s: float = 0.03
    expire_s: float = 1.0

    def __post_init__(self) -> None:
        _check(self.name, self.chatter_s, self.expire_s)
        try:
            host, _ = self.address
            self.guard().check(host)
        except ConfigError as error:
            raise ConfigError(f"receptor {self.name!r}: {error}") from None

    @property
    def address(self) -> tuple[str, int]:
        """Host and port of the door."""
        return host_and_port(self.listen)

    def guard(self) -> Guard:
        """Who may come in at the door."""
        return Guard(self.token, self.allow)


class UdpReceptor(_Listening, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="udp"):
    """Receptors that send datagrams of lines to ``listen``; with a ``token`` each line ends in ``token=...``.

    Datagrams get lost: who says ``hit`` says it again several times a second, and ``expire_s`` after the last one it is
    over.
    """

    listen: str = UDP_LISTEN


class HttpReceptor(_Listening, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="http"):
    """Receptors that POST lines to ``listen``, with a ``token`` as ``?token=...`` or as a bearer's."""

    listen: str = HTTP_LISTEN


ReceptorEntry = SerialReceptor | UdpReceptor | HttpReceptor


def _check(name: str, chatter_s: float, expire_s: float) -> None:
    if not name:
        raise ConfigError("a receptor has no name; expected one, such as 'tops'")
    for what, seconds in (("chatter_s", chatter_s), ("expire_s", expire_s)):
        if not (math.isfinite(seconds) and 0.0 <= seconds <= LONGEST_S):
            raise ConfigError(f"receptor {name!r}: {what} is {seconds}; expected seconds from 0 to {LONGEST_S:g}")
    if 0.0 < expire_s <= chatter_s:
        raise ConfigError(
            f"receptor {name!r}: expire_s is {expire_s} and chatter_s is {chatter_s}; a hit must outlast the chatter: "
            "set expire_s to several times the interval at which hits are repeated, or to 0"
        )


def robots_of(entry: ReceptorEntry, robots: tuple[str, ...]) -> tuple[str, ...]:
    """The robots that a door may speak of, in a room with these.

    Raises:
        ConfigError: where it names one that the room does not have.

    """
    for robot in entry.robots:
        if robot not in robots:
            raise ConfigError(f"receptor {entry.name!r}: {known_names('robot', robot, robots)}")
    return entry.robots or robots
