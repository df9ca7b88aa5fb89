"""What a Cellulo's camera sees of the dotted paper: 120 lines of 188 grey bytes, in the packets that carry it.

The pattern's dots sit beside the corners of a 0.508 mm grid; which side each takes is drawn from its place, so that it
looks like the real one and decodes to nothing. The size of a picture on the paper is a guess.
"""

import numpy as np
from numpy.typing import NDArray

from armspan.devices.cellulo.wire import EVENTS
from armspan.records import Vec2

WIDTH, HEIGHT = 188, 120
GRID_MM, DOT_MM, ASIDE_MM = 0.508, 0.1, 0.085
MM_PER_PIXEL = 0.04
PAPER, DOT, AIR = 190, 40, 12


def picture(xy_mm: Vec2, theta: float, lifted: bool) -> NDArray[np.uint8]:
    """The grey picture (120, 188) at a place [mm] and heading [rad]; nearly black off the paper."""
    if lifted:
        return np.full((HEIGHT, WIDTH), AIR, dtype=np.uint8)
    v, u = (np.indices((HEIGHT, WIDTH)) - np.array([[[HEIGHT]], [[WIDTH]]]) / 2) * MM_PER_PIXEL
    x = xy_mm[0] + np.cos(theta) * u - np.sin(theta) * v
    y = xy_mm[1] + np.sin(theta) * u + np.cos(theta) * v
    column, row = np.rint(x / GRID_MM), np.rint(y / GRID_MM)
    side = (3 * column + 7 * row + np.floor(column * row / 5)) % 4 * (np.pi / 2)
    dx = x - GRID_MM * column - ASIDE_MM * np.cos(side)
    dy = y - GRID_MM * row - ASIDE_MM * np.sin(side)
    grey: NDArray[np.uint8] = np.where(np.hypot(dx, dy) < DOT_MM, DOT, PAPER).astype(np.uint8)
    return grey


def packets(grey: NDArray[np.uint8]) -> list[bytes]:
    """The packets of a picture, a line each."""
    return [EVENTS.encode("frameLine", line=line, pixels=row.tobytes()) for line, row in enumerate(grey)]
