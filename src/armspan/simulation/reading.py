"""How the virtual person reads the robots' lights: colours in, a belief about the cursor out.

The person was told: green all round means the cursor is on this robot; a single light shows the cursor's
side, yellow within about 6 cm, orange within 12, red within 25, none beyond. Nothing else is known to the
person, who takes the lights to say "you are there" as long as they would look like this with the cursor on
the target, and else believes in the nearest place at which they would.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LIT = 0.35
_RINGS = {"green": (0.0, 0.025), "yellow": (0.025, 0.06), "orange": (0.06, 0.12), "red": (0.12, 0.25)}
_BEYOND = 0.25
_HALF_SECTOR = np.pi / 6
_MISJUDGED_DISTANCE = 0.15
_MISJUDGED_SIDE = np.radians(10)
_UNSTEADY = 0.006
_SPAN, _STEP = 0.26, 0.02
_OFFSETS: Array = np.stack(np.meshgrid(*[np.arange(-_SPAN, _SPAN + 1e-9, _STEP)] * 2), axis=-1).reshape(-1, 2)
_NEAREST_FIRST: Array = _OFFSETS[np.argsort(np.hypot(*_OFFSETS.T), kind="stable")]


@dataclass(frozen=True, slots=True)
class Sign:
    """What one robot's lights say: the cursor's distance [m] between two bounds, its side [rad] if one is told."""

    near: float
    far: float
    side: float | None


def read_cursor(lights: Array, xy: Array, heading: Array, target: Array, rng: np.random.Generator) -> Array | None:
    """Where the cursor seems to be, (2,) [m] in the frame of ``xy``, or None when no light tells.

    ``lights`` (n, 6, 3) are 0 to 1, ``xy`` (n, 2) [m] and ``heading`` (n,) [rad, clockwise from above] the
    robots, light 0 at the front, counted clockwise; ``target`` (2,) is where the cursor should be. Each robot's
    distance is misjudged by 15 %, its side by 10 degrees, and the whole by 6 mm.
    """
    signs = [_sign(ring) for ring in lights]
    if all(sign is None for sign in signs):
        return None
    places = target + _NEAREST_FIRST
    doubts = sum(
        (_doubt(places, here, front, sign, rng) for here, front, sign in zip(xy, heading, signs, strict=True)),
        start=np.zeros(len(places)),
    )
    place = places[int(np.argmin(np.round(doubts, 3)))]  # of equals the first is the nearest to the target
    return np.asarray(place + rng.normal(0.0, _UNSTEADY, 2))


def _doubt(places: Array, here: Array, front: float, sign: Sign | None, rng: np.random.Generator) -> Array:
    """How badly each place (k, 2) goes with what one robot shows: 0 where it fits."""
    scale, turn = np.exp(rng.normal(0.0, _MISJUDGED_DISTANCE)), rng.normal(0.0, _MISJUDGED_SIDE)
    away = places - here
    distance = scale * np.hypot(*away.T)
    if sign is None:
        return np.asarray(np.maximum(0.0, _BEYOND - distance) / _BEYOND)
    doubt = (np.maximum(0.0, sign.near - distance) + np.maximum(0.0, distance - sign.far)) / (sign.far + 0.02)
    if sign.side is not None:
        bearing = np.arctan2(away[:, 1], away[:, 0]) - front - sign.side + turn
        off = np.abs((bearing + np.pi) % (2 * np.pi) - np.pi)
        doubt += np.maximum(0.0, off - _HALF_SECTOR)
    return np.asarray(doubt)


def _sign(ring: Array) -> Sign | None:
    """What one robot's six lights (6, 3) say; None when they are dark, or tell of a choice (blue)."""
    bright = ring.max(axis=1)
    lit = np.flatnonzero(bright > _LIT)
    if len(lit) == 0:
        return None
    strongest = int(lit[np.argmax(bright[lit])])
    colour = _colour(ring[strongest])
    if colour == "blue":
        return None
    side = None if colour == "green" else strongest * np.pi / 3
    return Sign(*_RINGS[colour], side)


def _colour(rgb: Array) -> str:
    r, g, b = (float(v) for v in rgb)
    if b > max(r, g):
        return "blue"
    if r < 0.3 * g:
        return "green"
    share = g / r
    return "yellow" if share > 0.7 else "orange" if share > 0.2 else "red"
