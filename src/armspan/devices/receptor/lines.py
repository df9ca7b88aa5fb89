"""Lines of a receptor: ``hit ROBOT`` and ``lost ROBOT``, read from bytes that come as they come. No input or output.

Whatever else comes is counted and costs nothing more. A name that no robot has is told once, in a sentence.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from armspan.errors import known_names

LONGEST = 160
"""Bytes of a line; what is longer is no line."""

STRANGERS = 16
"""Names of robots that do not exist that are told; more are counted."""

_VERBS = {"hit": True, "lost": False}
TOKEN = "token="


@dataclass(frozen=True, slots=True)
class Line:
    """What one line says: is this robot hit? ``token`` is what it brings along to be let in."""

    robot: str
    on: bool
    token: str | None = None


@dataclass(slots=True)
class Counters:
    """What was read: good ``lines``, those of ``unknown`` robots, ``malformed`` and ``too_long`` ones."""

    lines: int = 0
    unknown: int = 0
    malformed: int = 0
    too_long: int = 0


@dataclass(slots=True)
class Reader:
    """Reads lines about ``robots``; ``told`` are the sentences about what was wrong, each once."""

    robots: Sequence[str]
    counters: Counters = field(default_factory=Counters)
    told: list[str] = field(default_factory=list)
    _rest: bytes = b""
    _skipping: bool = False
    _strangers: set[str] = field(default_factory=set)

    def feed(self, data: bytes) -> list[Line]:
        """The lines that end in these bytes of a stream; their beginnings may have come before."""
        lines: list[Line] = []
        *ended, rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        for part in ended:
            if self._skipping:
                self._skipping = False
            else:
                lines.extend(self._line(part))
        if self._skipping or len(rest) > LONGEST:
            self.counters.too_long += not self._skipping
            self._skipping, rest = True, b""
        self._rest = rest
        return lines

    def whole(self, message: bytes) -> list[Line]:
        """The lines of a message, whose last one needs no end."""
        return [line for part in message.replace(b"\r", b"\n").split(b"\n") for line in self._line(part)]

    def begin(self) -> None:
        """The stream begins anew: what was left of the old one is no line."""
        self._rest, self._skipping = b"", False

    def _line(self, data: bytes) -> list[Line]:
        if len(data) > LONGEST:
            self.counters.too_long += 1
            return []
        try:
            words = data.decode("ascii").split()
        except UnicodeDecodeError:
            words = [""]
        if not words:
            return []
        verb, *rest = words
        token = rest.pop().removeprefix(TOKEN) if rest and rest[-1].startswith(TOKEN) else None
        if verb.lower() not in _VERBS or not rest:
            self.counters.malformed += 1
            return []
        robot = " ".join(rest)
        if robot not in self.robots:
            self._stranger(robot)
            return []
        self.counters.lines += 1
        return [Line(robot, _VERBS[verb.lower()], token)]

    def _stranger(self, robot: str) -> None:
        self.counters.unknown += 1
        if robot not in self._strangers and len(self._strangers) < STRANGERS:
            self._strangers.add(robot)
            self.told.append(known_names("robot", robot, self.robots))
