"""A take as a picture: for each band where the forearm points, its acceleration and its rate, the gesture shaded."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from armspan.frames import Array, rotation_from_quaternion
from armspan.gesture.channels import Band, Channels, sensor_of
from armspan.gesture.takes import Take

_WIDTH, _HEIGHT = 5.6, 2.0
"""A panel's size [inch]."""

_USER = ("x front", "y left", "z up")
_KINDS = {"a": "acceleration without gravity [m/s²]", "g": "rate [rad/s]"}
_SHADE = "#f2d98b"


def draw_take(path: Path, take: Take, title: str) -> None:
    """Write a PNG: a column of panels for each band, time along; gaps are left open."""
    bands = [(band, _panels(band, take)) for band in Channels(take.columns).bands]
    rows = max(len(panels) for _, panels in bands)
    with mpl.rc_context({"font.size": 9, "text.parse_math": False}):  # a name may hold dollars
        figure = Figure(figsize=(_WIDTH * len(bands), _HEIGHT * rows + 0.6), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(rows, len(bands), sharex=True, squeeze=False)
        for column, (band, panels) in enumerate(bands):
            for row, (what, names, values) in enumerate(panels):
                _panel(grid[row][column], take, names, values)
                grid[row][column].set_title(f"{band.prefix}: {what}", fontsize=9)
            for row in range(len(panels), rows):
                grid[row][column].set_visible(False)
            grid[len(panels) - 1][column].set_xlabel("time [s]")
        figure.suptitle(title)
        figure.savefig(path, dpi=110, format="png", metadata={"Software": "armspan"})


def _panels(band: Band, take: Take) -> list[tuple[str, tuple[str, ...], Array]]:
    """What is drawn of a band: a title, the lines' names, their values (n, lines)."""
    values, attitude = take.values[:, list(band.places)], band.attitude
    panels: list[tuple[str, tuple[str, ...], Array]] = []
    if attitude is not None:
        panels.append(("where the forearm points", _USER, forearm_directions(values[:, attitude])))
    groups: dict[str, list[int]] = {}
    for place, name in enumerate(band.columns):
        if attitude is None or place not in attitude:
            groups.setdefault(sensor_of(name), []).append(place)
    for sensor, places in groups.items():
        kind = sensor.removeprefix(f"{band.prefix}_")
        known = attitude is not None and len(places) == len(_USER)
        names = _USER if known else tuple(band.columns[place] for place in places)
        panels.append((_KINDS.get(kind, kind) if known else kind, names, values[:, places]))
    return panels


def forearm_directions(wxyz: Array) -> Array:
    """Where the forearm points, unit vectors (n, 3) in ``user``, of attitudes ``user_from_wrist`` (n, 4)."""
    return np.asarray(rotation_from_quaternion(wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True))[:, :, 0])


def _panel(axes: Axes, take: Take, names: tuple[str, ...], values: Array) -> None:
    if take.gesture is not None:
        axes.axvspan(*take.gesture, color=_SHADE, alpha=0.5, lw=0)
    for number, (name, line) in enumerate(zip(names, values.T, strict=True)):
        axes.plot(take.times, line, color=f"C{number}", lw=1.1, label=name)
    axes.axhline(0.0, color="#999999", lw=0.5, zorder=0)
    axes.margins(x=0.0)
    axes.legend(loc="upper right", fontsize=7, ncols=3, framealpha=0.7)
