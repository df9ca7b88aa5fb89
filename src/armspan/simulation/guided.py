"""An agenda for a virtual person whom somebody leads from outside, as the page does."""

from dataclasses import dataclass, field

from armspan.records import Press, Record, Say, Selected
from armspan.simulation.script import Phase

WISH = "wish"
"""The press that tells a virtual person what to do: ``robot:NAME`` and ``zone:NAME`` to point at, ``gesture:LABEL``,
``everyday:SECONDS``, ``rest``."""


@dataclass(slots=True)
class Guided:
    """Does what the set-up's words say, and what is wished; it never ends by itself.

    Having chosen what was wished for, the person lowers the arm.
    """

    phase: Phase = Phase.WAIT
    cues: list[str] = field(default_factory=list)

    def hear(self, record: Record) -> None:
        """Take note of words, wishes and choices."""
        if isinstance(record, Press) and record.name == WISH:
            kind = record.value.partition(":")[0]
            self.phase = Phase.POINT if kind in ("robot", "zone") else Phase.PERFORM
            self.cues.append(f"point:{record.value}" if self.phase is Phase.POINT else record.value)
        elif isinstance(record, Selected) and self.phase is Phase.POINT:
            self._rest()
        elif isinstance(record, Say) and record.cue:
            if record.cue == "ready":
                self._rest()
            else:
                self.phase = Phase.SET_UP
                self.cues.append(record.cue)

    def step(self, t: float) -> list[Press]:
        """Such a person presses nothing."""
        return []

    def _rest(self) -> None:
        self.phase = Phase.REST
        self.cues.append("rest")
