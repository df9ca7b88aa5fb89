"""What a recording asks for, in order."""

import msgspec
import numpy as np

from armspan.errors import ConfigError
from armspan.gesture.takes import NULL
from armspan.records import Arm

PIECE = 60.0
"""Longest recording [s] of everyday motion: what an interruption can cost."""


class Recording(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A recording as it is asked for; kept in its log's header.

    ``takes`` are asked for of each of the ``gestures``, after one for practice, and ``null_s`` seconds of everyday
    motion at the end. ``wrists`` are those whose bands are recorded. With ``taps`` a double click starts and ends a
    take. ``shuffle`` mixes the gestures, drawn from ``dice``. ``first`` are the numbers of a label's first take.

    Raises:
        ConfigError: on a number of takes or seconds that cannot be.

    """

    gestures: tuple[str, ...]
    takes: int
    person: str = "p01"
    null_s: float = 0.0
    wrists: tuple[Arm, ...] = ("right", "left")
    taps: bool = False
    shuffle: bool = False
    dice: int = 0
    first: dict[str, int] = msgspec.field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.takes < 1:
            raise ConfigError(f"{self.takes} takes of a gesture: expected one at least, better three to ten")
        if not 0.0 <= self.null_s < np.inf:
            raise ConfigError(f"{self.null_s:g} s of everyday motion: expected 0 or more, better 600")
        if NULL in self.gestures:
            raise ConfigError(f"{NULL} is everyday motion and no gesture: record it with --null SECONDS")
        if not self.gestures and not self.null_s:
            raise ConfigError("nothing is to be recorded: name gestures, or seconds of everyday motion")


class Ask(msgspec.Struct, frozen=True):
    """One take to be asked for: the ``place``-th of ``of``, or everyday motion for ``seconds``."""

    label: str
    place: int = 0
    of: int = 0
    practice: bool = False
    seconds: float = 0.0
    tries: int = 0


def asks_of(recording: Recording) -> list[Ask]:
    """All takes of a recording, in order."""
    blocks = [_block(label, recording.takes) for label in recording.gestures]
    if recording.shuffle:
        asks = [block[0] for block in blocks]
        rng = np.random.default_rng(recording.dice)
        for place in range(recording.takes):
            asks += [blocks[k][1 + place] for k in rng.permutation(len(blocks))]
    else:
        asks = [ask for block in blocks for ask in block]
    return asks + _pieces(recording.null_s)


def _block(label: str, takes: int) -> list[Ask]:
    return [Ask(label, practice=True), *(Ask(label, place, takes) for place in range(1, takes + 1))]


def _pieces(seconds: float) -> list[Ask]:
    """Everyday motion in equal pieces of a minute at most."""
    count = int(np.ceil(seconds / PIECE - 1e-9))
    return [Ask(NULL, k + 1, count, seconds=seconds / count) for k in range(count)]
