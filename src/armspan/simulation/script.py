"""The experimenter and the person's agenda: what is asked of the person, and when."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

import msgspec

from armspan.records import Press, Record, Say, Selected


class Target(msgspec.Struct, frozen=True):
    """Something to point at: a robot or a zone, as ``robot:NAME`` or ``zone:NAME``."""

    name: str

    @property
    def kind(self) -> str:
        """``robot`` or ``zone``."""
        return self.name.partition(":")[0]

    @property
    def label(self) -> str:
        """The name alone."""
        return self.name.partition(":")[2]


@dataclass(frozen=True, slots=True)
class Trial:
    """One target, with the cursor shown or not."""

    target: Target
    feedback: bool


class Phase(Enum):
    """What the person is doing."""

    WAIT = "wait"
    SET_UP = "set up"
    POINT = "point"
    REST = "rest"
    PERFORM = "perform"
    DONE = "done"


@dataclass(slots=True)
class Script:
    """Begins the set-up, then goes through the trials: each ends with a choice or after ``patience`` seconds.

    The script hears what everybody hears (words, choices) and presses what an experimenter would press.
    """

    trials: Sequence[Trial]
    start: float = 0.5
    patience: float = 6.0
    rest: float = 0.7
    phase: Phase = Phase.WAIT
    number: int = -1
    began: float = 0.0
    _ready: bool = False
    _chosen: bool = False
    _shown: bool | None = None
    cues: list[str] = field(default_factory=list)

    def hear(self, record: Record) -> None:
        """Take note of words and choices."""
        if isinstance(record, Say) and record.cue:
            if record.cue == "ready":
                self._ready = True
            else:
                self.cues.append(record.cue)
        elif isinstance(record, Selected) and self.phase is Phase.POINT and record.t > self.began:
            self._chosen = True

    def step(self, t: float) -> list[Press]:
        """The presses due at ``t`` [s]."""
        if self.phase is Phase.WAIT and t >= self.start:
            self.phase = Phase.SET_UP
            return [Press(t, "setup")]
        if self.phase is Phase.SET_UP and self._ready:
            self._rest(t)
        elif self.phase is Phase.POINT and (self._chosen or t - self.began > self.patience):
            self._rest(t)
            return [Press(t, "trial", "")]
        elif self.phase is Phase.REST and t - self.began > self.rest:
            return self._next(t)
        return []

    def _rest(self, t: float) -> None:
        self.phase, self.began = Phase.REST, t
        self.cues.append("rest")

    def _next(self, t: float) -> list[Press]:
        self.number += 1
        if self.number >= len(self.trials):
            self.phase = Phase.DONE
            return []
        trial = self.trials[self.number]
        self.phase, self.began, self._chosen = Phase.POINT, t, False
        self.cues.append(f"point:{trial.target.name}")
        presses = [Press(t, "trial", trial.target.name)]
        if trial.feedback != self._shown:
            self._shown = trial.feedback
            presses.insert(0, Press(t, "feedback", "on" if trial.feedback else "off"))
        return presses
