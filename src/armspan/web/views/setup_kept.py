"""What the set-up keeps for a browser: where it is, what was typed, and the time since it began."""

from dataclasses import dataclass, field, replace

from armspan.conductor.sight import Sight
from armspan.records import Body, Say
from armspan.web.desk import Desk
from armspan.web.host import Measures, Portrait
from armspan.web.views.setup_words import is_ready


@dataclass(slots=True)
class Clock:
    """Session seconds at which the set-up began and at which it was ready."""

    began: float | None = None
    ready: float | None = None

    def start(self, t: float) -> None:
        """Begin to count."""
        self.began, self.ready = t, None

    def look(self, t: float, sight: Sight | None, said: Say) -> None:
        """See whether it is ready, and since when: nobody may have looked when it was said.

        A new session, whose time starts again, starts the clock again.
        """
        if self.began is None or t < self.began:
            self.start(t)
        if self.ready is None and sight is not None and is_ready(sight):
            self.ready = max(self.began or 0.0, said.t) if said.cue == "ready" else t

    def seconds(self, t: float) -> float:
        """From the beginning until ready, or now [s]."""
        if self.began is None:
            return 0.0
        return max(0.0, (t if self.ready is None else self.ready) - self.began)


@dataclass(slots=True)
class Kept:
    """One browser's set-up; ``asked`` are the measures that were pressed and are not yet in use."""

    step: int = 0
    typed: dict[str, str] = field(default_factory=dict)
    portraits: dict[str, Portrait] = field(default_factory=dict)
    found: Measures | None = None
    asked: Body | None = None
    clock: Clock = field(default_factory=Clock)


def kept_for(desk: Desk) -> Kept:
    """What this browser kept; one that is new, or was loaded again, begins with what was typed last."""
    own = f"set-up {desk.browser}"
    mine = desk.host.kept.get(own)
    if not isinstance(mine, Kept):
        others = [kept for kept in desk.host.kept.values() if isinstance(kept, Kept)]
        mine = Kept()
        if others:
            last = others[-1]
            mine = Kept(last.step, dict(last.typed), clock=replace(last.clock))
        desk.host.kept[own] = mine
    return mine
