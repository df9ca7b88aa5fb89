"""Misfits: a stop at which the person pointed at something else.

One in a hundred natural gestures goes to another place altogether (tens of degrees), and four stops cannot
outvote it by a bent loss alone. A stop is left out when the others agree so much better without it that chance
does not explain it.
"""

from dataclasses import replace

import numpy as np

from armspan.errors import CalibrationError
from armspan.frames import Array
from armspan.pointing.least_squares import Problem, solve
from armspan.pointing.pairs import check_layout

SURPRISE = 6.0
"""Drop of the robust cost, in units of the assumed noise's variance, that convicts a stop.

With one good gesture in each corner it was below 6 in 96 of 100 draws of six natural people, one band or two;
beyond it leaving the stop out cut their median error from 105 to 32 cm with two bands, from 90 to 60 with one.
"""


def leave_out_misfits(problem: Problem, place: Array, cost: float, sigma: float) -> tuple[Problem, Array]:
    """The problem with the weights of misfits set to 0, and its place (4,).

    ``place`` and ``cost`` [rad²] are those of all stops, ``sigma`` [rad] is the noise assumed per axis. At most a
    quarter of the stops is left out, and none if the rest does not agree either.
    """
    limit, quarter = SURPRISE * sigma**2, len(problem.weights) // 4
    kept, best = problem, (place, cost)
    for _ in range(quarter):
        if best[1] <= limit:
            break
        trials = [_without(kept, int(stop)) for stop in np.flatnonzero(kept.weights)]
        fewer, there, less = min(trials, key=lambda trial: trial[2])
        if best[1] - less <= limit:
            break
        kept, best = fewer, (there, less)
    agrees = best[1] <= limit * max(1, quarter)
    return (kept, best[0]) if agrees else (problem, place)


def _without(problem: Problem, stop: int) -> tuple[Problem, Array, float]:
    weights = problem.weights.copy()
    weights[stop] = 0.0
    fewer = replace(problem, weights=weights)
    try:
        check_layout(problem.points[weights > 0.0])
    except CalibrationError:
        return problem, np.zeros(4), float("inf")
    return fewer, *solve(fewer)
