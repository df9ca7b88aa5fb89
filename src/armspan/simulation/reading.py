"""How the virtual person reads the robots' lights: colours in, a rough idea of where the cursor is out.

The person was told: green all round means the cursor is on this robot; a single light shows the cursor's
side, yellow within about 6 cm, orange within 12, red within 25. Nothing else is known to the person.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LIT = 0.35
_MIDDLES = {"green": 0.0, "yellow": 0.042, "orange": 0.09, "red": 0.18}
_FLOOR = 0.006
_SHARE = 0.15


def read_cursor(lights: Array, xy: Array, heading: Array, rng: np.random.Generator) -> Array | None:
    """Where the cursor seems to be, (2,) [m] in the frame of ``xy``, or None when no light tells.

    ``lights`` (n, 6, 3) are 0 to 1, ``xy`` (n, 2) [m] and ``heading`` (n,) [rad, clockwise from above] the
    robots, light 0 at the front, counted clockwise. A perceived distance is off by 15 % and 6 mm.
    """
    places, weights = [], []
    for ring, here, front in zip(lights, xy, heading, strict=True):
        seen = _seen(ring)
        if seen is None:
            continue
        distance, side = seen
        bearing = front + side
        guess = here + distance * np.array([np.cos(bearing), np.sin(bearing)])
        error = _FLOOR + _SHARE * distance
        places.append(guess + rng.normal(0.0, error, 2))
        weights.append(1.0 / (0.02 + distance) ** 2)
    if not places:
        return None
    return np.asarray(np.average(places, axis=0, weights=weights))


def _seen(ring: Array) -> tuple[float, float] | None:
    """Distance [m] and side [rad from the front] that one robot's six lights (6, 3) tell."""
    bright = ring.max(axis=1)
    lit = np.flatnonzero(bright > _LIT)
    if len(lit) == 0:
        return None
    colours = [_colour(ring[k]) for k in lit]
    if len(lit) >= 5 and colours.count("green") >= 5:
        return 0.0, 0.0
    strongest = int(lit[np.argmax(bright[lit])])
    colour = _colour(ring[strongest])
    return (_MIDDLES[colour], strongest * np.pi / 3) if colour in _MIDDLES and colour != "green" else None


def _colour(rgb: Array) -> str:
    r, g, b = (float(v) for v in rgb)
    if b > max(r, g):
        return "blue"
    if r < 0.3 * g:
        return "green"
    share = g / r
    return "yellow" if share > 0.7 else "orange" if share > 0.2 else "red"
