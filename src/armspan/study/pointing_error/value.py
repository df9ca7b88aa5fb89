"""All that the study of pointing errors has beyond the report: what each thing that helps is worth."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from armspan.study.pointing_error import bands, feedback, moving, stops
from armspan.study.pointing_error.bands import BandRow
from armspan.study.pointing_error.feedback import FeedbackRow, Quoted
from armspan.study.pointing_error.monte_carlo import FEWEST, FLOOR, TABLE, Layout, Mapper, MonteCarlo, run
from armspan.study.pointing_error.moving import RealRow, SimulatedRow
from armspan.study.pointing_error.recordings import Recordings
from armspan.study.pointing_error.sources import SOURCES
from armspan.study.pointing_error.stops import StopsRow

COUNT = 100_000
PEOPLE, DRAWS = 30, 12

_STOPPED = 15
"""So many of the virtual people try numbers of stops too."""

_PARTS = ("stops", "feedback", "moving", "virtual people", "recordings")

Progress: TypeAlias = Callable[[str, int, int], None]
"""Told what is under way and how much of how much of it is done."""


@dataclass(frozen=True, slots=True)
class Values:
    """Simulated and, where there were recordings, real results; `document` makes them JSON."""

    monte_carlo: tuple[MonteCarlo, ...]
    stops: tuple[StopsRow, ...]
    bands: tuple[BandRow, ...]
    feedback: tuple[FeedbackRow, ...]
    quoted: tuple[Quoted, ...]
    moving: tuple[SimulatedRow, ...]
    followed: tuple[RealRow, ...] = ()
    by_speed: tuple[tuple[float, float], ...] = ()

    def document(self) -> dict[str, object]:
        """For JSON: lengths in mm, angles in degrees."""
        return {
            "sources": [{"name": s.name, "size": s.size, "basis": s.basis} for s in SOURCES],
            "monte_carlo": [part.document() for part in self.monte_carlo],
            "stops": [row.document() for row in self.stops],
            "bands": [row.document() for row in self.bands],
            "feedback": [row.document() for row in self.feedback] + [row.document() for row in self.quoted],
            "moving": [row.document() for row in self.moving] + [row.document() for row in self.followed],
            "miss_by_speed": [
                {"deg_per_s": float(np.degrees(pace)), "miss_deg": float(np.degrees(angle))}
                for pace, angle in self.by_speed
            ],
        }


def study(
    recordings: Recordings | None = None,
    *,
    count: int = COUNT,
    people: int = PEOPLE,
    seed: int = 0,
    progress: Progress = lambda what, done, total: None,
    mapper: Mapper = map,
) -> Values:
    """Measure everything, on ``recordings`` too where they are at hand.

    ``count`` calibrations are drawn for each layout and a fiftieth of them for each number of stops; so many virtual
    ``people`` do the rest. ``mapper`` is ``map`` or a process pool's: it changes the time, not the result.
    """

    def drawn(layout: Layout) -> MonteCarlo:
        return run(layout, count, seed, lambda done, total: progress(layout.name, done, total), mapper)

    def begin(part: str) -> np.random.Generator:
        progress(part, _PARTS.index(part), len(_PARTS))
        return np.random.default_rng([seed, 0, _PARTS.index(part)])

    carlo = (drawn(TABLE), drawn(FLOOR))
    begin("stops")
    found = Values(
        monte_carlo=carlo,
        stops=tuple(stops.simulated((TABLE, FLOOR), max(FEWEST, count // 50), seed, mapper)),
        bands=(),
        feedback=tuple(feedback.simulated(begin("feedback"), people)),
        quoted=feedback.QUOTED,
        moving=tuple(moving.simulated(TABLE, begin("moving"), people)),
    )
    found = _with_virtual_people(found, begin("virtual people"), people)
    if recordings is not None:
        found = _with_recordings(found, recordings, begin("recordings"))
    progress(_PARTS[-1], len(_PARTS), len(_PARTS))
    return found


def _with_virtual_people(found: Values, rng: np.random.Generator, people: int) -> Values:
    """What virtual people at nine places add: one and two bands, and numbers of stops as the real ones'."""
    crowds = bands.virtual_crowds(rng, people)
    rows = [bands.compare(who, crowd, simulated=True, rng=rng, draws=4) for who, crowd in crowds.items()]
    who = next(iter(crowds))
    more = stops.of_people(who, crowds[who][:_STOPPED], rng, simulated=True, draws=3)
    return replace(found, bands=(*found.bands, *rows), stops=(*found.stops, *more))


def _with_recordings(found: Values, recordings: Recordings, rng: np.random.Generator) -> Values:
    """What the real people add."""
    who = f"{len(recordings.pointed)} people, 1.5 to 3.5 m"
    row = bands.compare(who, recordings.pointed, simulated=False, rng=rng)
    return replace(
        found,
        bands=(*found.bands, row),
        stops=(*found.stops, *stops.of_people(who, recordings.pointed, rng, draws=DRAWS)),
        followed=tuple(moving.real(recordings.followed, rng)),
        by_speed=tuple(moving.miss_by_speed(recordings.followed)),
    )
