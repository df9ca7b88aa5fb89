"""Turned squares of a picture: what a network sees, and where in the picture its points lie.

A point of a picture is (right, down) [px] from the picture's top left corner; the first pixel's centre is (0.5, 0.5).
"""

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from armspan.errors import MissingExtra
from armspan.frames import Array

Pixels: TypeAlias = NDArray[np.uint8]
"""(height, width, 3), red green blue."""

MOST_SHRUNK = 16
"""A crop is drawn up to so many times finer and then averaged, lest a large photograph's detail turns into noise."""


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A square of side ``size`` [px] about ``centre`` (2,) [px], its own up turned clockwise by ``angle`` [rad].

    ``mirrored``: left and right are exchanged in what the network sees.
    """

    centre: Array
    size: float
    angle: float = 0.0
    mirrored: bool = False

    def axes(self) -> Array:
        """(2, 2), its columns the square's right and down in the picture [px]."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        sign = -1.0 if self.mirrored else 1.0
        return self.size * np.array([[sign * c, -s], [sign * s, c]])

    def to_picture(self, points: Array) -> Array:
        """Points (..., 2) of the square, 0 to 1 from its top left corner, in the picture [px]."""
        return self.centre + (points - 0.5) @ self.axes().T

    def moved(self, right: float = 0.0, down: float = 0.0, grown: float = 1.0, turned: float = 0.0) -> "Region":
        """The square moved by shares of its own size, grown about its centre and turned [rad]."""
        centre = self.to_picture(np.array([0.5 + right, 0.5 + down]))
        return replace(self, centre=centre, size=self.size * grown, angle=self.angle + turned)


def upright(foot: Array, head: Array, grown: float, shift: float = 0.0) -> Region:
    """The square whose up runs from ``foot`` to ``head`` (2,) [px], ``grown`` times their distance large.

    Its centre lies ``shift`` distances from the foot towards the head.
    """
    right, down = head - foot
    return Region(foot + shift * (head - foot), grown * float(np.hypot(right, down)), float(np.arctan2(right, -down)))


def crop(image: Pixels, region: Region, side: int) -> NDArray[np.float32]:
    """What lies in a square: (side, side, 3) from 0 to 1; black outside of the picture.

    Raises:
        MissingExtra: OpenCV is not installed.

    """
    try:
        import cv2
    except ImportError:
        raise MissingExtra("opencv-python-headless", "picture") from None
    finer = int(np.clip(np.ceil(region.size / side), 1, MOST_SHRUNK))
    drawn = cv2.warpAffine(
        image, picture_from_crop(region, finer * side), (finer * side, finer * side),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
    )  # fmt: skip
    small = drawn if finer == 1 else cv2.resize(drawn, (side, side), interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32) / np.float32(255)


def picture_from_crop(region: Region, side: int) -> Array:
    """(2, 3): column and row in the picture of a pixel (column, row, 1) of a crop of ``side`` pixels.

    As in OpenCV whole numbers are the pixels' centres.
    """
    axes = region.axes()
    first = region.to_picture(np.full(2, 0.5 / side)) - 0.5
    return np.column_stack([axes / side, first])
