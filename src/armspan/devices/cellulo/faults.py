"""What goes wrong with emulated Cellulo robots: in the radio all the time, and at told times."""

import math
import re
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from armspan.errors import ConfigError

Generation: TypeAlias = Literal["v1", "v2", "old"]
Kind: TypeAlias = Literal["link-loss", "silence", "kidnap", "blind", "load"]

QUIET_S = 1.0
"""Seconds without a packet after which a radio sniffs."""
LOAD_G = 100.0
ASIDE_S = 2.0
_TEXT = re.compile(r"([a-z-]+)(?::(\w[\w.-]*))?@([\d.]+)(?:\+([\d.]+))?(?:/([\d.]+))?")
USUAL_S = {"link-loss": 3.0, "silence": 1.0, "kidnap": ASIDE_S, "blind": 1.5, "load": 10.0}


@dataclass(frozen=True, slots=True)
class Faults:
    """What the radio and the robots do wrong all the time.

    ``latency_s`` is added each way, ``drop`` the share of what is sent to a robot that never arrives,
    ``boot_s`` how long a robot starts. What a robot tells is held up to whole ``burst_s``; the first packet each way
    after a second of silence comes up to ``sniff_s`` later; of what is sent to a robot after it started or its link
    came, the first ``deaf`` writes are lost. ``generation`` v1 has everything, v2 no keys, old (before April 2016)
    is connected and answers nothing.
    """

    latency_s: float = 0.0
    drop: float = 0.0
    boot_s: float = 1.0
    burst_s: float = 0.0
    sniff_s: float = 0.0
    deaf: int = 0
    generation: Generation = "v1"

    def __post_init__(self) -> None:
        for what, seconds in (("latency", self.latency_s), ("burst", self.burst_s), ("sniff latency", self.sniff_s)):
            if not (math.isfinite(seconds) and seconds >= 0):
                raise ConfigError(f"a {what} of {seconds} s is none; expected zero or more")
        if not 0 <= self.drop <= 1:
            raise ConfigError(f"a share of {self.drop} cannot be dropped; expected 0 to 1")
        if self.generation not in get_args(Generation):
            raise ConfigError(f"there is no generation {self.generation!r}; expected {', '.join(get_args(Generation))}")


@dataclass(frozen=True, slots=True)
class Trouble:
    """Something that happens at ``at`` [s], for ``seconds``, to one robot or to all, again ``every`` so many seconds.

    ``link-loss`` breaks the radio link, ``silence`` loses all that travels while the link looks up, ``kidnap`` lifts
    and puts down again, ``blind`` stops the camera, ``load`` lays 100 g on.
    """

    kind: Kind
    at: float
    seconds: float
    robot: str | None = None
    every: float | None = None

    def __post_init__(self) -> None:
        if self.every is not None and self.every <= self.seconds:
            raise ConfigError(f"{self.kind} of {self.seconds:g} s cannot come again every {self.every:g} s")

    @classmethod
    def parse(cls, text: str) -> "Trouble":
        """From words such as ``link-loss@5``, ``kidnap:r1@5+2`` or ``link-loss:r2@5+3/20``."""
        found = _TEXT.fullmatch(text)
        if found is None or found[1] not in get_args(Kind):
            raise ConfigError(
                f"{text!r} is no trouble; expected KIND[:ROBOT]@START[+SECONDS][/EVERY] as link-loss:r2@5+3/20, "
                f"with a kind of {', '.join(get_args(Kind))}"
            )
        kind, robot, at, seconds, every = found.groups()
        try:
            numbers = [None if number is None else float(number) for number in (at, seconds, every)]
        except ValueError:
            raise ConfigError(f"{text!r} has a number that is none") from None
        named = next(known for known in get_args(Kind) if known == kind)
        return cls(named, numbers[0] or 0.0, numbers[1] or USUAL_S[kind], robot, numbers[2])

    def turns(self, before: float, now: float) -> tuple[bool, bool]:
        """Whether it begins, and whether it ends, in the time after ``before`` up to ``now`` [s]."""
        return self._in(self.at, before, now), self._in(self.at + self.seconds, before, now)

    def _in(self, first: float, before: float, now: float) -> bool:
        if self.every is None or now < first:
            return before < first <= now
        last = first + math.floor((now - first) / self.every) * self.every
        return before < last <= now
