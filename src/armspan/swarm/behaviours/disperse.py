"""Disperse: everybody goes as far from the others as the sheet allows."""

from collections.abc import Mapping

import numpy as np

from armspan.frames import Array
from armspan.records import RobotState
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.slots import Slots, check_room, lattices, least_distance, matched, pitch

_HALVINGS = 16  # of the sheet's diagonal: to a twentieth of a millimetre on a large one


def disperse(stage: Stage, states: Mapping[str, RobotState]) -> Slots:
    """The lattice on the sheet whose sites lie farthest apart, or where the robots are if they are as far apart.

    Raises:
        ConfigError: where not so many robots fit.

    """
    check_room(len(states), stage)
    low, high = stage.bounds

    def plan(here: Array) -> Array:
        inside = np.clip(here, low, high)
        sites = low + spread(len(here), pitch(stage), high - low)
        return inside if least_distance(inside) >= least_distance(sites) else matched(here, np.clip(sites, low, high))

    return Slots(stage, plan, swap=True)


def spread(n: int, gap: float, size: Array) -> Array:
    """``n`` sites (n, 2) in [0, size] (2,) of the lattice with the longest distance between neighbours.

    At least ``gap``, which must fit. In the square as far apart as the best packings known (Specht, packomania.com)
    for 2, 4, 5, 6, 9, 12, 16 and 18 sites, at worst 7 % nearer for the others up to 20.
    """
    if n == 1:
        return np.asarray(size[None] / 2)
    best, least, most = _thinned(_fullest(gap, size), n), gap, float(np.hypot(*size))
    for _ in range(_HALVINGS):
        sites = _fullest(middle := (least + most) / 2, size)
        if len(sites) < n:
            most = middle
        else:
            best, least = _thinned(sites, n), middle
    return best


def _fullest(gap: float, size: Array) -> Array:
    return max(lattices(gap, size), key=len)


def _thinned(sites: Array, n: int) -> Array:
    """``n`` of the sites, each next one the farthest from those before it."""
    chosen, away = [0], np.hypot(*(sites - sites[0]).T)
    while len(chosen) < n:
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.hypot(*(sites - sites[chosen[-1]]).T))
    return sites[chosen]
