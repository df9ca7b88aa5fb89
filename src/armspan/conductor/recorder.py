"""The mind of a recording: leads a person through takes, hands-free, and cuts them out of what the bands tell."""

from collections import deque
from collections.abc import Callable
from enum import Enum

import msgspec
import numpy as np

from armspan.conductor.arm import Arm, Band
from armspan.conductor.recorder_cut import AROUND, STANDING, Moment, RecordedTake, cut
from armspan.conductor.recorder_motion import MOVED
from armspan.conductor.recorder_plan import Recording, asks_of
from armspan.conductor.recorder_setup import WristSetUp
from armspan.conductor.recorder_trace import Trace
from armspan.conductor.recorder_words import announced, now
from armspan.conductor.settings import Settings
from armspan.conductor.sight import Sight, limbs
from armspan.conductor.wrist import wrist_row
from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.gesture.takes import INITIAL, NULL
from armspan.orientation import MOVING
from armspan.records import Event, ImuSample, Link, Output, Press, Say, TakeEnded, Tap, Tick
from armspan.swarm.errands import Errands

BEAT = 0.8
"""Seconds between the words of the countdown."""

LONGEST, LONGEST_BY_TAPS = 8.0, 30.0
"""Seconds from the cue after which a take ends by itself."""

MOST_TRIES = 3
"""After so many spoilt takes of one gesture in a row the next one is asked for."""

_QUIET, _HELD_ELSEWHERE = 0.8, 3.0
_BACK = float(np.cos(np.radians(30.0)))
_MORE = 1.0
_LATE = 0.3  # how long a sample may be on its way
_PATIENCE = 12.0
_MEMORY = 5.0


class Stage(Enum):
    """Where a recording stands."""

    WAITING = "waiting"
    SET_UP = "set-up"
    CALM = "calm"
    COUNT = "count"
    READY = "ready"
    MOVE = "move"
    AFTER = "after"
    DONE = "done"


class Recorder:
    """The one mind of a recording; it knows the press ``setup`` that begins it, and ``stop`` and ``quit`` that end it.

    With each `TakeEnded` the take itself is appended to ``finished``, from where whoever writes it down takes it.

    Raises:
        ConfigError: on wrists that wear no band.

    """

    def __init__(self, settings: Settings, recording: Recording) -> None:
        self.settings, self.recording = settings, recording
        self.stage = Stage.WAITING
        self.finished: deque[RecordedTake] = deque()
        self._arm = Arm.from_settings(settings.bands, settings.body.arm)
        self._setup = WristSetUp(settings, self._arm, Errands(settings.limits, settings.sheet))
        self._wrists: dict[str, Band] = _worn(self._arm, recording)
        self._traces = {band.settings.name: Trace() for band in self._wrists.values()}
        self._asks = deque(asks_of(recording))
        self._numbers = dict(recording.first)
        self._told: set[str] = set()
        self._now = self._since = self._cue = 0.0
        self._moment = Moment(0.0, 0.0)
        self._beat = 0
        self._calm: float | None = None
        self._rest: dict[str, Array] = {}
        self._moved = False

    def step(self, event: Event) -> list[Output]:
        """Everything that follows from one event."""
        match event:
            case ImuSample():
                self._feel(event)
            case Tick():
                return self._tick(event.t)
            case Tap(count=2) if self.recording.taps:
                return self._double_click(event.t)
            case Press(name="setup") if self.stage is Stage.WAITING:
                self.stage = Stage.SET_UP
                return self._setup.begin(event.t)
            case Press(name="stop") if self.stage is not Stage.DONE:
                return self._finish(event.t, "The recording ends")
            case Press(name="quit"):
                self.stage = Stage.DONE
            case Link(up=False):
                return [Say(event.t, f"{event.source} is out of reach", "")]
        return []

    def sight(self) -> Sight:
        """The arms as the bands feel them, for those who show them; ``step`` is the stage."""
        return Sight(
            step=self.stage.value,
            stop=0,
            stops=0,
            seen=(),
            quality="",
            limbs=limbs(self._arm, self.settings.body),
            place=None,
            ray=None,
            stopped=False,
            waiting={},
            running=(),
            silent=tuple(self._arm.any_silent(self._now)),
        )

    def _feel(self, sample: ImuSample) -> None:
        band = self._arm.by_name.get(sample.source)
        if band is None or sample.t <= band.attitude.t:
            return
        band.feel(sample)
        trace = self._traces.get(sample.source)
        row = wrist_row(band, sample) if trace is not None else None
        if trace is not None and row is not None:
            trace.push(sample.t, row)

    def _tick(self, t: float) -> list[Output]:
        self._now = t
        for band in self._arm.bands:
            band.tick()
        stages: dict[Stage, Callable[[float], list[Output]]] = {
            Stage.SET_UP: self._set_up,
            Stage.CALM: self._calm_down,
            Stage.COUNT: self._count,
            Stage.READY: self._ready,
            Stage.MOVE: self._move,
            Stage.AFTER: self._after,
        }
        follow = stages.get(self.stage)
        return follow(t) if follow else []

    def _set_up(self, t: float) -> list[Output]:
        outputs = self._setup.tick(t, {})
        return [*outputs, *self._next(t)] if self._setup.ready else outputs

    def _next(self, t: float) -> list[Output]:
        """Announce the next take, if there is one."""
        if not self._asks:
            return self._finish(t, "That is all: thank you")
        ask = self._asks[0]
        text = announced(ask, ask.label not in self._told)
        self._told.add(ask.label)
        self.stage, self._since, self._calm = Stage.CALM, t, None
        return [Say(t, text, "")]

    def _finish(self, t: float, text: str) -> list[Output]:
        self.stage = Stage.DONE
        return [Say(t, text, "done")]

    def _calm_down(self, t: float) -> list[Output]:
        """Wait until all bands are heard and the arms hang still."""
        for trace in self._traces.values():
            trace.forget(t - _MEMORY)
        silent = [band.settings.name for band in self._wrists.values() if band.stale(t)]
        if not self._still_for(t, _QUIET, not silent):
            if t - self._since < _PATIENCE:
                return []
            self._since = t
            if silent:
                return [Say(t, f"Nothing is heard of {' and '.join(silent)}: is the band on and near?", "")]
            return [Say(t, "Let your arms hang, and hold still for a moment", "relax")]
        if self.recording.taps and self._asks[0].label != NULL:
            self.stage = Stage.READY
            return [Say(t, "Double click on a band, make the gesture, let your arms hang and double click again", "")]
        self.stage, self._since, self._beat = Stage.COUNT, t, 3
        return self._count(t)

    def _count(self, t: float) -> list[Output]:
        if t < self._since + (3 - self._beat) * BEAT - 1e-6:
            return []
        self._beat -= 1
        return [Say(t, str(self._beat + 1), "")] if self._beat >= 0 else self._begin(t)

    def _begin(self, t: float) -> list[Output]:
        ask = self._asks[0]
        self._rest = {side: _along(band) for side, band in self._wrists.items()}
        self.stage, self._cue, self._calm, self._moved = Stage.MOVE, t, None, False
        text, cue = now(ask)
        return [Say(t, text, cue)]

    def _ready(self, t: float) -> list[Output]:
        """Wait for a double click."""
        for trace in self._traces.values():
            trace.forget(t - _MEMORY)
        return []

    def _double_click(self, t: float) -> list[Output]:
        if self.stage is Stage.READY:
            return self._begin(t)
        if self.stage is Stage.MOVE and self._asks[0].label != NULL:
            return self._over(t, _MORE, clicked=t)
        return []

    def _move(self, t: float) -> list[Output]:
        """Wait for the end of the gesture."""
        ask, since = self._asks[0], t - self._cue
        if ask.label == NULL:
            return self._over(t, 0.0) if since >= ask.seconds - 1e-6 else []
        if ask.label == INITIAL:
            return self._over(t, _MORE) if since >= STANDING - 1e-6 else []
        if self.recording.taps:
            return self._over(t, _MORE) if since >= LONGEST_BY_TAPS else []
        self._moved = self._moved or max(band.rate for band in self._wrists.values()) > MOVED
        back = all(float(_along(band) @ self._rest[side]) > _BACK for side, band in self._wrists.items())
        ended = self._still_for(t, _QUIET if back else _HELD_ELSEWHERE, self._moved)
        return self._over(t, AROUND - _QUIET + 0.2) if ended or since >= LONGEST else []

    def _over(self, t: float, more: float, clicked: float | None = None) -> list[Output]:
        """The gesture is over; the arms' rest after it is still recorded, for ``more`` seconds."""
        self.stage, self._moment = Stage.AFTER, Moment(self._cue, t + more, clicked)
        return [Say(t, "Good: let your arms hang", "relax")]

    def _after(self, t: float) -> list[Output]:
        """Wait for the samples on their way, then cut the take."""
        if t < self._moment.end + _LATE - 1e-6:
            return []
        ask = self._asks.popleft()
        number = self._numbers.get(ask.label, 1)
        self._numbers[ask.label] = number + 1
        traces = {side: self._traces[band.settings.name] for side, band in self._wrists.items()}
        done = cut(traces, ask, self._moment, self.recording.person, number)
        if done.note and ask.tries + 1 < MOST_TRIES:
            self._asks.appendleft(msgspec.structs.replace(ask, tries=ask.tries + 1))
        self.finished.append(done)
        return [*_told(t, done), *self._next(t)]

    def _still_for(self, t: float, seconds: float, allowed: bool) -> bool:
        """Whether all arms have been still for some time, as far as that counts."""
        if not allowed or max(band.rate for band in self._wrists.values()) > MOVING:
            self._calm = None
            return False
        if self._calm is None:
            self._calm = t
        return t - self._calm >= seconds - 1e-6


def _worn(arm: Arm, recording: Recording) -> dict[str, Band]:
    """The bands to record, by wrist: the right one first, as in a take's columns (ConfigError)."""
    for wrist in recording.wrists:
        if wrist not in arm.wrists:
            raise ConfigError(
                f"no band is worn on the {wrist} wrist, only on: {', '.join(sorted(arm.wrists)) or 'none'}; name those "
                "that are with --bands"
            )
    return {wrist: arm.wrists[wrist] for wrist in ("right", "left") if wrist in recording.wrists}


def _along(band: Band) -> Array:
    """Where the forearm points (3,) in ``user``."""
    attitude = band.in_user()
    return np.zeros(3) if attitude is None else attitude[:, 0]


def _told(t: float, done: RecordedTake) -> list[Output]:
    take = done.take
    started = done.start + (take.gesture[0] if take.gesture else 0.0)
    ended = TakeEnded(t, started, take.label, take.person, take.number, take.practice)
    return [ended, Say(t, f"That take does not count: {done.note}", "")] if done.note else [ended]
