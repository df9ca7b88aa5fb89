"""What was found, drawn over the picture, so that a person can check it at a glance."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from armspan.body.picture.image import Pixels, opencv, png
from armspan.body.picture.marker import Marker
from armspan.body.skeleton import Keypoint, Skeleton
from armspan.records import Arm, Colour

DRAWN_SIDE = 1600
"""Longer side of what is drawn at most [px]: it is to look at, not to measure."""
LEFT, RIGHT, MIDDLE = (86, 180, 233), (230, 159, 0), (255, 255, 255)
MEASURED, SHEET = (240, 228, 66), (0, 158, 115)
"""Colours that colour-blind people can tell (Okabe and Ito 2008): the person's left, right and middle; what is
measured; the sheet."""

_LIMBS = ("sh-el", "el-wr", "hip-kn", "kn-an", "an-heel", "an-toe", "wr-idxtip", "sh-hip")
_ACROSS = (("lsh", "rsh"), ("lhip", "rhip"), ("leye", "reye"))
_DARK = (0, 0, 0)
_FONT = 0  # cv2.FONT_HERSHEY_SIMPLEX

_Line: TypeAlias = tuple[tuple[float, float], tuple[float, float]]
_Points: TypeAlias = Mapping[str, Keypoint]
_Box: TypeAlias = tuple[int, int, int, int]


def overlay(
    pixels: Pixels,
    skeleton: Skeleton,
    *,
    marker: Marker | None = None,
    notes: Sequence[str] = (),
    arm: Arm | None = None,
) -> bytes:
    """PNG of an RGB picture with the points and their names, limbs, measured lines, marker and ``notes`` upon it.

    The measured lines are those of ``arm``, of both arms where it is not told; points that are not sure are rings
    without lines. The picture given is left as it is.
    """
    canvas = _Canvas(pixels)
    sure = skeleton.trusted()
    for limb, colour in _limbs(sure):
        canvas.line(limb, colour, 2)
    for line in _measured(sure, ("left", "right") if arm is None else (arm,)):
        canvas.line(line, MEASURED, 3)
    if marker is not None:
        corners = [(float(x), float(y)) for x, y in marker.corners]
        for line in zip(corners, [*corners[1:], corners[0]], strict=True):
            canvas.line(line, SHEET, 2)
        canvas.words(max(corners), "sheet", SHEET)
    surest_last = sorted(skeleton.points, key=lambda name: name in sure)
    for name in surest_last:
        canvas.point(skeleton.points[name][:2], _side_colour(name), hollow=name not in sure)
    for name in reversed(surest_last):
        canvas.words(skeleton.points[name][:2], _short(name), _side_colour(name))
    return canvas.png(notes)


def _limbs(points: _Points) -> list[tuple[_Line, Colour]]:
    named = [(side + a, side + b) for side in "lr" for a, b in (limb.split("-") for limb in _LIMBS)]
    lines = [(_line(points, a, b), _side_colour(a)) for a, b in named]
    lines += [(_line(points, a, b), MIDDLE) for a, b in _ACROSS]
    return [(line, colour) for line, colour in lines if line is not None]


def _measured(points: _Points, arms: Sequence[Arm]) -> list[_Line]:
    """Shoulder to the eye of its side, and shoulder to fingertip (to the wrist where no tip is known)."""
    lines = []
    for side in (arm[0] for arm in arms):
        tip = side + "idxtip" if side + "idxtip" in points else side + "wr"
        lines += [_line(points, side + "sh", side + "eye"), _line(points, side + "sh", tip)]
    return [line for line in lines if line is not None]


def _line(points: _Points, start: str, end: str) -> _Line | None:
    if start not in points or end not in points:
        return None
    return points[start][:2], points[end][:2]


def _short(name: str) -> str:
    return name.replace("idxtip", "tip").replace("idxknuckle", "knuckle").replace("midtip", "mid")


def _side_colour(name: str) -> Colour:
    if name in ("nose", "neck", "crown"):
        return MIDDLE
    return LEFT if name.startswith("l") else RIGHT


class _Canvas:
    """A copy of a picture, of at most `DRAWN_SIDE`, to draw on in the picture's own coordinates [px]."""

    def __init__(self, pixels: Pixels) -> None:
        height, width = pixels.shape[:2]
        self._share = min(1.0, DRAWN_SIDE / max(height, width))
        size = max(1, round(width * self._share)), max(1, round(height * self._share))
        self._cv2 = opencv()
        self._pixels = self._cv2.resize(np.ascontiguousarray(pixels), size, interpolation=self._cv2.INTER_AREA)
        self._unit = max(size) / DRAWN_SIDE
        self._taken: list[_Box] = []

    def line(self, line: _Line, colour: Colour, width: int) -> None:
        start, end = (self._at(point) for point in line)
        thick = max(1, round(width * self._unit))
        self._cv2.line(self._pixels, start, end, _DARK, thick + 2, self._cv2.LINE_AA)
        self._cv2.line(self._pixels, start, end, colour, thick, self._cv2.LINE_AA)

    def point(self, at: tuple[float, float], colour: Colour, *, hollow: bool) -> None:
        """A dot; a ring where it is not sure."""
        middle, radius = self._at(at), max(2, round(5 * self._unit))
        self._cv2.circle(self._pixels, middle, radius + 1, _DARK, -1, self._cv2.LINE_AA)
        self._cv2.circle(self._pixels, middle, radius, colour, -1, self._cv2.LINE_AA)
        if hollow:
            self._cv2.circle(self._pixels, middle, radius - 1, _DARK, -1, self._cv2.LINE_AA)
        self._taken.append((middle[0] - radius, middle[1] - radius, middle[0] + radius, middle[1] + radius))

    def words(self, at: tuple[float, float], text: str, colour: Colour) -> None:
        """A word beside a point, at the first of four places where nothing else stands; left out where none is."""
        size, gap = max(0.35, 0.5 * self._unit), max(4, round(9 * self._unit))
        (width, height), drop = self._cv2.getTextSize(text, _FONT, size, 1)
        x, y = self._at(at)
        for left in (x + gap, x - gap - width):
            for foot in (y - gap, y + gap + height):
                box = left - 1, foot - height - 1, left + width + 1, foot + drop
                if not any(_overlap(box, taken) for taken in self._taken):
                    self._taken.append(box)
                    self._cv2.rectangle(self._pixels, box[:2], box[2:], _DARK, -1)
                    self._cv2.putText(self._pixels, text, (left, foot), _FONT, size, colour, 1, self._cv2.LINE_AA)
                    return

    def png(self, notes: Sequence[str]) -> bytes:
        """The picture, with a line of explanation and the notes below it."""
        legend = "blue: the person's left   orange: right   yellow: measured   green: sheet   ring: not sure"
        size = max(0.4, 0.6 * self._unit)
        width = self._pixels.shape[1]
        letters = max(1, int((width - 16) / self._cv2.getTextSize("n", _FONT, size, 1)[0][0]))
        lines = [line for note in (legend, *notes) for line in textwrap.wrap(_plain(note), letters)]
        step = round(36 * size) + 6
        below = np.zeros((step * len(lines) + step // 2, width, 3), np.uint8)
        for number, line in enumerate(lines, start=1):
            foot = number * step - step // 4
            self._cv2.putText(below, line, (8, foot), _FONT, size, MIDDLE, 1, self._cv2.LINE_AA)
        return png(np.vstack([self._pixels, below]))

    def _at(self, point: tuple[float, float]) -> tuple[int, int]:
        x, y = (round((value + 0.5) * self._share - 0.5) for value in point)
        return int(np.clip(x, -(2**14), 2**14)), int(np.clip(y, -(2**14), 2**14))


def _plain(text: str) -> str:
    """What the font can write: it has no letters beyond ASCII."""
    return text.replace("±", "+-").encode("ascii", "replace").decode()


def _overlap(one: _Box, other: _Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
