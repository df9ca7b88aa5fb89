"""An agenda for a virtual person whom somebody leads from outside, as the page does."""

from dataclasses import dataclass, field

from armspan.records import Press, Record, Say
from armspan.simulation.script import Phase

WISH = "wish"
"""The press that tells a virtual person what to do: ``robot:NAME`` and ``zone:NAME`` to point at, ``gesture:LABEL``,
``everyday:SECONDS``, ``rest``."""


@dataclass(slots=True)
class Guided:
    """Does what the set-up's words say, and what is wished, until something else is; it never ends by itself."""

    phase: Phase = Phase.WAIT
    cues: list[str] = field(default_factory=list)

    def hear(self, record: Record) -> None:
        """Take note of words and wishes."""
        if isinstance(record, Press) and record.name == WISH:
            kind = record.value.partition(":")[0]
            self.phase = Phase.POINT if kind in ("robot", "zone") else Phase.PERFORM
            self.cues.append(f"point:{record.value}" if self.phase is Phase.POINT else record.value)
        elif isinstance(record, Say) and record.cue:
            ready = record.cue == "ready"
            self.phase = Phase.REST if ready else Phase.SET_UP
            self.cues.append("rest" if ready else record.cue)

    def step(self, t: float) -> list[Press]:
        """Such a person presses nothing."""
        return []
