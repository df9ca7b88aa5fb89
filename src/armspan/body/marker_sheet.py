"""The sheet that lies on the floor and tells a picture's scale: an A4 page with one ArUco marker to print."""

import io
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAGE_WIDTH, PAGE_HEIGHT = 0.210, 0.297
"""A4 [m]."""
MARKER_SIDE = 0.170
"""Side of the marker over its black border [m]."""
MARKER_DICTIONARY = "DICT_5X5_50"
MARKER_ID = 7
MARKER_BITS = (
    "0000000",
    "0011100",
    "0001000",
    "0001010",
    "0000110",
    "0010110",
    "0000000",
)
"""The marker's cells row by row, its border included; 0 is black."""
RULER = 0.100
"""Length of the line that shows whether the printer kept the scale [m]."""

_MM_PER_INCH = 25.4
_MARKER_LEFT_MM, _MARKER_BOTTOM_MM = 20.0, 107.0
_RULER_MM = 90.0
_WORDS = (
    "Print at 100 % (no fit to page); the line above must then be 100 mm long.",
    "Lay this sheet flat on the floor, half a metre before the feet.",
    "Camera at chest height, 3 m away or more: the whole person and the sheet are in the picture.",
)


def marker_figure() -> "Figure":
    """The page as a figure of 210 x 297 mm whose data coordinates are millimetres from its lower left corner."""
    from matplotlib.figure import Figure  # here, as it takes a second and whoever finds the marker needs no page

    width, height = 1e3 * PAGE_WIDTH, 1e3 * PAGE_HEIGHT
    figure = Figure(figsize=(width / _MM_PER_INCH, height / _MM_PER_INCH), facecolor="white")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    _draw_marker(axes)
    _draw_ruler(axes, width / 2)
    for line, words in enumerate(_WORDS):
        axes.text(width / 2, 62.0 - 9.0 * line, words, ha="center", fontsize=11, family="DejaVu Sans")
    return figure


def marker_pdf() -> bytes:
    """The sheet to print, an A4 page without any scaling; the same bytes every time."""
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    file = io.BytesIO()
    canvas: Any = FigureCanvasPdf(marker_figure())
    canvas.print_pdf(file, metadata={"CreationDate": None})
    return file.getvalue()


def marker_png(dpi: float = 200.0) -> bytes:
    """The same sheet as a picture of ``dpi`` pixels per inch, for a screen."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    file, figure = io.BytesIO(), marker_figure()
    figure.set_dpi(dpi)
    canvas: Any = FigureCanvasAgg(figure)
    canvas.print_png(file)
    return file.getvalue()


def _draw_marker(axes: "Axes") -> None:
    """Black cells as one square with white cells upon it: no hairlines show between black neighbours."""
    side, cell = 1e3 * MARKER_SIDE, 1e3 * MARKER_SIDE / len(MARKER_BITS)
    top = _MARKER_BOTTOM_MM + side
    _draw_square(axes, _MARKER_LEFT_MM, _MARKER_BOTTOM_MM, side, "black")
    for row, bits in enumerate(MARKER_BITS):
        for column, bit in enumerate(bits):
            if bit == "1":
                _draw_square(axes, _MARKER_LEFT_MM + column * cell, top - (row + 1) * cell, cell, "white")


def _draw_square(axes: "Axes", left: float, bottom: float, side: float, colour: str) -> None:
    from matplotlib.patches import Rectangle

    axes.add_patch(Rectangle((left, bottom), side, side, facecolor=colour, edgecolor="none", linewidth=0.0))


def _draw_ruler(axes: "Axes", middle: float) -> None:
    left, length = middle - 5e2 * RULER, 1e3 * RULER
    axes.plot([left, left + length], [_RULER_MM, _RULER_MM], color="black", linewidth=0.8, solid_capstyle="butt")
    for tick in range(0, int(length) + 1, 10):
        tall = 4.0 if tick % 50 == 0 else 2.0
        axes.plot([left + tick] * 2, [_RULER_MM, _RULER_MM + tall], color="black", linewidth=0.5, solid_capstyle="butt")
    for tick in (0, 50, 100):
        axes.text(left + tick, _RULER_MM + 6.0, f"{tick} mm", ha="center", fontsize=9, family="DejaVu Sans")
