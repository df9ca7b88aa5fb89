"""Gestures of a session against what was truly made, where the log tells it (presses ``truth``)."""

from collections.abc import Iterable
from dataclasses import dataclass

import msgspec

from armspan.gesture.decision import Spotted
from armspan.gesture.scoring import EventScore, Truth, score_events
from armspan.records import Gesture, ImuSample, Press, Record


@dataclass(frozen=True, slots=True)
class GestureAccount:
    """What was made, what was recognised, and how the two go together; ``score`` is None without a truth."""

    made: list[Truth]
    found: list[Gesture]
    score: EventScore | None

    def document(self) -> dict[str, object]:
        """As plain values."""
        score = msgspec.to_builtins(self.score) if self.score is not None else None
        return {"made": len(self.made), "recognised": len(self.found), "score": score}


def gestures_of(records: Iterable[Record]) -> GestureAccount:
    """Account of the gestures in a session: each ``truth`` press begins one, or ends it where it names none."""
    made: list[Truth] = []
    found: list[Gesture] = []
    begun: Press | None = None
    last = 0.0
    for record in records:
        match record:
            case Press(name="truth", value=""):
                if begun is not None:
                    made.append(Truth(begun.t, record.t, begun.value))
                begun = None
            case Press(name="truth"):
                begun = record
            case Gesture():
                found.append(record)
            case ImuSample():
                last = max(last, record.t)
    events = [Spotted(record.t, record.started, None, record.label, record.score) for record in found]
    return GestureAccount(made, found, score_events(events, made, last) if made else None)
