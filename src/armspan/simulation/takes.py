"""Takes of virtual people with a band on either wrist, quickly: to train on and to be tested against."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from armspan.errors import ConfigError
from armspan.records import ImuSample
from armspan.simulation.bands import Fusion, Segment, VirtualBand, draw_band
from armspan.simulation.gesture_styles import LABELS, checked_label, draw_style
from armspan.simulation.person import draw_person
from armspan.simulation.second_arm import TwoArmedPerson

Samples: TypeAlias = dict[str, tuple[ImuSample, ...]]
"""The samples of the bands ``left`` and ``right``, in order of time."""

_SET_UP, _STEADY = 2.5, 1.0
_CHUNK = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class SetUpSamples:
    """A second of the arms stretched to the front, palms down, and a second of hanging arms, held still."""

    stretched: Samples
    hanging: Samples


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedTake:
    """One gesture from ``start`` to ``end`` [s], with 1 to 2 s before and after, or everyday motion (``null``).

    From ``reached`` to ``left`` [s] both arms did what the gesture consists of. ``number`` counts the person's
    takes of the label from 0; the bands stay as they were worn for the ``setup``.
    """

    label: str
    person: int
    number: int
    samples: Samples
    start: float
    end: float
    reached: float
    left: float
    setup: SetUpSamples


class _Session:
    """One person with two bands, from the set-up on."""

    def __init__(self, rng: np.random.Generator, fusion: Fusion, amplitude: float) -> None:
        body, arms, left, right, self._rng = rng.spawn(5)
        style = draw_style(arms, amplitude=amplitude)
        virtual = draw_person(body)
        facing = float(body.uniform(-np.pi, np.pi))
        self.person = TwoArmedPerson(virtual, (0.0, 0.0), facing, body, arms, style=style)
        own: Segment = "forearm"
        other: Segment = "other_forearm"
        worn = {"left": other, "right": own} if virtual.arm == "right" else {"left": own, "right": other}
        self._bands = {
            name: VirtualBand(name, worn[name], draw_band(draws, fusion=fusion), draws)
            for name, draws in (("left", left), ("right", right))
        }
        self.now = 0.0
        self.setup = self._set_up()

    def _set_up(self) -> SetUpSamples:
        self.person.stretch(self.now)
        self.record(_SET_UP - _STEADY)
        stretched = self.record(_STEADY)
        self.person.hang(self.now)
        self.record(_SET_UP - _STEADY)
        return SetUpSamples(stretched, self.record(_STEADY))

    def record(self, seconds: float) -> Samples:
        """Let time pass; what the bands told meanwhile."""
        heard: dict[str, list[ImuSample]] = {name: [] for name in self._bands}
        end = self.now + seconds
        while self.now < end:
            self.now = min(end, self.now + _CHUNK)
            for name, band in self._bands.items():
                heard[name].extend(sample for _, sample in band.advance(self.now, self.person))
        return {name: tuple(samples) for name, samples in heard.items()}

    def take(self, label: str, person: int, number: int) -> SimulatedTake:
        """One take of a gesture."""
        self.record(float(self._rng.uniform(0.3, 1.5)))
        before = self.record(float(self._rng.uniform(0.75, 1.5)))
        told = self.person.perform(self.now, label)
        during = self.record(told.end + float(self._rng.uniform(1.0, 2.0)) - self.now)
        samples = {name: before[name] + during[name] for name in before}
        return SimulatedTake(label, person, number, samples, told.start, told.end, told.reached, told.left, self.setup)

    def everyday(self, seconds: float, person: int) -> SimulatedTake:
        """A stretch of everyday motion, which has no gesture: all of it counts."""
        start = self.now
        self.person.everyday(start, seconds)
        samples = self.record(seconds)
        return SimulatedTake("null", person, 0, samples, start, self.now, start, self.now, self.setup)


def simulate_takes(
    rng: np.random.Generator,
    *,
    persons: int = 1,
    takes: int = 10,
    labels: Sequence[str] = LABELS[1:],
    fusion: Fusion = "onboard",
    amplitude: float = 1.0,
    everyday_s: float = 0.0,
) -> list[SimulatedTake]:
    """``takes`` of every label by each of so many people, in rounds of shuffled order.

    Each person puts both bands on once, stretches both arms and lets them hang, then performs; warm-up and
    fatigue run through. ``amplitude`` below 1 limits the shoulders' range. With ``everyday_s`` each person
    ends with so many seconds of everyday motion, labelled ``null``.

    Raises:
        ConfigError: on a label that is none, or numbers of people and takes below 1.

    """
    if persons < 1 or takes < 1:
        raise ConfigError(f"{persons} people with {takes} takes each: expected at least 1 of both")
    known = [checked_label(label) for label in labels]
    made: list[SimulatedTake] = []
    for person, draws in enumerate(rng.spawn(persons)):
        session = _Session(draws, fusion, amplitude)
        for number in range(takes):
            made.extend(session.take(known[k], person, number) for k in draws.permutation(len(known)))
        if everyday_s > 0.0:
            made.append(session.everyday(everyday_s, person))
    return made


def simulate_everyday(
    rng: np.random.Generator, seconds: float, *, persons: int = 1, fusion: Fusion = "onboard"
) -> list[SimulatedTake]:
    """``seconds`` of everyday motion, labelled ``null``, of each of so many people with both bands."""
    if persons < 1 or not 0.0 < seconds <= 3600.0:
        raise ConfigError(f"{seconds:g} s of {persons} people: expected above 0 and up to 3600 s of 1 or more")
    return [_Session(draws, fusion, 1.0).everyday(seconds, person) for person, draws in enumerate(rng.spawn(persons))]
