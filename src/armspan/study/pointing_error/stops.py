"""What more stops are worth, and more gestures at each: simulated by the thousand, and on real people."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from armspan.frames import Array
from armspan.study.pointing_error.bands import MODELS
from armspan.study.pointing_error.monte_carlo import Layout, Mapper, all_but, chunk_errors, chunks
from armspan.study.pointing_error.recordings import Gestures
from armspan.study.pointing_error.sources import NAMES
from armspan.study.pointing_error.trials import CORNERS, EDGES, MIDDLE, many_draws

COUNTS = (3, 4, 5, 8, 9, 16, 25)
GESTURES = (1, 5)
REAL_COUNTS = (4, 5, 8)


@dataclass(frozen=True, slots=True)
class StopsRow:
    """The error [m] in use after so many ``stops`` of so many ``gestures`` each: median and 90th percentile."""

    who: str
    simulated: bool
    stops: int
    gestures: int
    median: float
    p90: float

    def document(self) -> dict[str, object]:
        """For JSON, in millimetres."""
        return {
            "who": self.who,
            "simulated": self.simulated,
            "stops": self.stops,
            "gestures": self.gestures,
            "median_mm": 1000.0 * self.median,
            "p90_mm": 1000.0 * self.p90,
        }


def simulated(layouts: Sequence[Layout], count: int, seed: int, mapper: Mapper = map) -> list[StopsRow]:
    """Everything wrong at once (`sources`) but the drift of the heading, and with it; ``count`` set-ups a row.

    A stop takes 8 s, so that a calibration of many stops lasts long enough for the heading to drift in it.
    """
    cases: tuple[tuple[str, int, tuple[str, ...]], ...] = (
        ("no drift", 1, all_but("band: drift")),
        ("no drift", 5, all_but("band: drift")),
        ("drift", 1, NAMES),
    )
    rows = []
    for layout in layouts:
        for words, gestures, sources in cases:
            for stops in COUNTS:
                tasks = chunks(layout, count, seed, stops, gestures, sources)
                errors = np.concatenate(list(mapper(chunk_errors, tasks)))
                rows.append(_row(f"{layout.name}, {words}", errors, stops, gestures, simulated=True))
    return rows


def of_people(
    who: str, people: Sequence[Gestures], rng: np.random.Generator, *, simulated: bool = False, draws: int = 20
) -> list[StopsRow]:
    """People at nine places: all are tested at the four edges; with 8 stops the tested place is left out.

    Spots are the rays alone: an area that lacks the tested place would draw them away from it.
    """
    rows = []
    for name, model in MODELS:
        for gestures in GESTURES:
            for stops in REAL_COUNTS:
                found = many_draws(
                    people, chosen(stops), EDGES, model, rng, gestures=gestures, draws=draws, drawn=False
                )
                rows.append(_row(f"{who}, {name}", found.metres, stops, gestures, simulated=simulated))
    return rows


def chosen(stops: int) -> Callable[[int], tuple[int, ...]]:
    """The stops for a tested place: the corners, the corners and the middle, or all places but the tested one."""
    if stops == 8:
        return lambda test: tuple(place for place in range(9) if place != test)
    return lambda test: (*CORNERS, MIDDLE) if stops == 5 else CORNERS


def _row(who: str, errors: Array, stops: int, gestures: int, *, simulated: bool) -> StopsRow:
    median, high = np.percentile(errors, (50, 90))
    return StopsRow(who, simulated, stops, gestures, float(median), float(high))
