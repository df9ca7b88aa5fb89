"""Agendas for arm gestures: one follows a recorder's words, one performs by itself after the pointing is done."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from armspan.errors import ConfigError
from armspan.records import Press, Record, Say
from armspan.simulation.gesture_styles import checked_label
from armspan.simulation.script import Phase, Script


class Agenda(Protocol):
    """What is asked of the person, and when: hears everybody's records, presses buttons, leaves cues."""

    @property
    def phase(self) -> Phase:
        """What the person is doing."""

    @property
    def cues(self) -> list[str]:
        """What the person was told and has not done yet."""

    def hear(self, record: Record) -> None:
        """Take note of words and choices."""

    def step(self, t: float) -> list[Press]:
        """The presses due at ``t`` [s]."""


@dataclass(slots=True)
class GestureScript:
    """Does what a recorder says: ``gesture:LABEL``, ``everyday:SECONDS``, ``relax`` and the set-up's words.

    It ends with ``done``. At ``start`` [s] it presses the button named ``button``, if one is named.
    """

    button: str | None = None
    start: float = 0.5
    phase: Phase = Phase.WAIT
    cues: list[str] = field(default_factory=list)

    def hear(self, record: Record) -> None:
        """Take note of words."""
        if not isinstance(record, Say) or not record.cue:
            return
        if record.cue == "done":
            self.phase = Phase.DONE
        elif self.phase is not Phase.DONE:
            self.phase = Phase.PERFORM
            self.cues.append(record.cue)

    def step(self, t: float) -> list[Press]:
        """The press that begins it."""
        if self.button is None or t < self.start:
            return []
        name, self.button = self.button, None
        return [Press(t, name)]


@dataclass(slots=True)
class Programme:
    """Goes through a script of pointing trials, then performs by itself and unasked.

    ``items`` are labels of gestures and ``everyday:SECONDS``; ``pause`` [s] is kept before each and at the end.

    Raises:
        ConfigError: on an item that is neither.

    """

    script: Script
    items: Sequence[str]
    pause: float = 1.5
    number: int = -1
    _performing: bool = False
    _due: float | None = None
    _over: bool = False

    def __post_init__(self) -> None:
        for item in self.items:
            _cue(item)

    @property
    def phase(self) -> Phase:
        """The script's phase; when that is done, ``PERFORM`` until the last item is over."""
        if self.script.phase is not Phase.DONE:
            return self.script.phase
        return Phase.DONE if self._over else Phase.PERFORM

    @property
    def cues(self) -> list[str]:
        """What the person was told and has not done yet."""
        return self.script.cues

    def hear(self, record: Record) -> None:
        """Take note of words, choices and the ends of gestures."""
        if isinstance(record, Press):
            if record.name == "truth" and not record.value and self._performing:
                self._performing, self._due = False, record.t + self.pause
        elif self.script.phase is not Phase.DONE or not isinstance(record, Say):
            self.script.hear(record)

    def step(self, t: float) -> list[Press]:
        """The presses due at ``t`` [s]."""
        presses = self.script.step(t)
        if self.script.phase is not Phase.DONE or self._performing or self._over:
            return presses
        if self._due is None:
            self._due = t + self.pause
            self.cues.append("hang")
        elif t >= self._due:
            self._next(t)
        return presses

    def _next(self, t: float) -> None:
        self.number += 1
        if self.number >= len(self.items):
            self._over = True
            return
        cue, seconds = _cue(self.items[self.number])
        self.cues.append(cue)
        self._performing = seconds is None
        self._due = t + (seconds or 0.0) + self.pause


def _cue(item: str) -> tuple[str, float | None]:
    """An item's cue, and how long it takes where that is known beforehand [s]."""
    verb, _, number = item.partition(":")
    if verb != "everyday":
        return f"gesture:{checked_label(item)}", None
    try:
        seconds = float(number)
    except ValueError:
        raise ConfigError(f"{item!r} is not everyday:SECONDS, such as everyday:30") from None
    if not 0.0 < seconds <= 3600.0:
        raise ConfigError(f"{item!r}: expected above 0 and up to 3600 s")
    return item, seconds
