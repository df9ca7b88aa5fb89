"""From probabilities, hop by hop, to one event per gesture: smoothing, thresholds, agreement, re-arming."""

from dataclasses import dataclass, field

import msgspec
import numpy as np

from armspan.frames import Array


class Rule(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """When a gesture counts as made.

    A label fires once its smoothed probability has been at or above ``threshold`` for ``agree`` hops; labels in
    ``early`` have a threshold and an agreement of their own, and fire even while another gesture is not over. After
    an event nothing else fires before its label has been below ``release`` times its threshold for ``rest`` hops.
    """

    threshold: float = 0.6
    agree: int = 3
    smoothing: float = 0.5
    release: float = 0.7
    rest: int = 3
    early: dict[str, tuple[float, int]] = {}

    def of(self, label: str) -> tuple[float, int]:
        """Threshold and agreement of a label."""
        return self.early.get(label, (self.threshold, self.agree))

    def at(self, threshold: float) -> "Rule":
        """The rule with another threshold; those of the early labels move in proportion."""
        share = threshold / self.threshold
        early = {label: (round(value * share, 4), agree) for label, (value, agree) in self.early.items()}
        return msgspec.structs.replace(self, threshold=threshold, early=early)


class Spotted(msgspec.Struct, frozen=True):
    """A gesture found: it fired at ``t`` [s], began at about ``start`` and was over at ``end`` (None: not yet)."""

    t: float
    start: float
    end: float | None
    label: str
    score: float


@dataclass(slots=True)
class Decision:
    """Goes along a stream: feed it the probabilities of each hop.

    ``labels`` are the gestures, in the order of the probabilities' columns; the last column is null's. ``lead`` [s] is
    how long before it is noticed each gesture begins.
    """

    labels: tuple[str, ...]
    rule: Rule
    lead: dict[str, float]
    smooth: Array | None = None
    _streak: tuple[int, int, float] = (-1, 0, 0.0)
    _fired: int | None = None
    _quiet: int = 0
    _open: Spotted | None = None
    closed: list[Spotted] = field(default_factory=list)

    def step(self, t: float, probabilities: Array) -> Spotted | None:
        """What fires at ``t`` [s] with ``probabilities`` (labels + 1,)."""
        share = self.rule.smoothing
        self.smooth = probabilities if self.smooth is None else share * probabilities + (1 - share) * self.smooth
        gestures = self.smooth[: len(self.labels)]
        best = int(np.argmax(gestures))
        self._rearm(t, gestures)
        threshold, agree = self.rule.of(self.labels[best])
        if gestures[best] < threshold:
            self._streak = (-1, 0, t)
            return None
        which, count, since = self._streak
        self._streak = (best, count + 1, since) if which == best else (best, 1, t)
        if self._streak[1] < agree or not self._may_fire(best):
            return None
        return self._fire(t, best, float(gestures[best]))

    def interrupt(self, t: float) -> None:
        """The stream has a gap: begin anew."""
        self._close(t)
        self.smooth, self._streak, self._fired, self._quiet = None, (-1, 0, t), None, 0

    def _may_fire(self, best: int) -> bool:
        return self._fired is None or (self.labels[best] in self.rule.early and self._fired != best)

    def _fire(self, t: float, best: int, score: float) -> Spotted:
        self._close(t)
        label = self.labels[best]
        self._fired, self._quiet = best, 0
        self._open = Spotted(t, max(0.0, self._streak[2] - self.lead.get(label, 0.0)), None, label, score)
        return self._open

    def _rearm(self, t: float, gestures: Array) -> None:
        if self._fired is None:
            return
        low = self.rule.release * self.rule.of(self.labels[self._fired])[0]
        self._quiet = self._quiet + 1 if gestures[self._fired] < low else 0
        if self._quiet >= self.rule.rest:
            self._close(t)
            self._fired, self._quiet = None, 0

    def _close(self, t: float) -> None:
        if self._open is not None:
            self.closed.append(msgspec.structs.replace(self._open, end=t))
            self._open = None

    def finish(self, t: float) -> list[Spotted]:
        """All events of the stream, which ends at ``t`` [s]."""
        self._close(t)
        return self.closed
