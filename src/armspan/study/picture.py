"""A session as a picture: the sheet from above, targets, pointed spots with their ellipses, the robots' paths."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Polygon

from armspan.frames import Array
from armspan.records import Covariance2, Record, RobotState, Sheet, Zone
from armspan.study.account import Account
from armspan.study.trials import CHI2_90, TrialResult, zone_middle

_INK = "#222222"
_LEGEND = (
    "sheet coordinates [mm]; the user stands below · ellipse: 90 % of where the target should be",
    "+ right, x wrong, o undecided",
)
_PANEL, _MARGIN = 6.4, 0.14
"""A panel's width [inch], and what stays free round the sheet as a share of its height."""

_RIGHT, _WRONG, _OPEN = "#1b7837", "#b2182b", "#4575b4"


def draw(path: Path, records: Iterable[Record], found: Account, sheet: Sheet, zones: Sequence[Zone]) -> None:
    """Write a PNG: one panel without the cursor and one with it, where there are both."""
    groups = [(False, "no cursor"), (True, "cursor shown by the robots' lights")]
    panels = [(flag, title) for flag, title in groups if any(t.feedback == flag for t in found.trials)]
    panels = panels or [(False, "no trials")]
    paths = _paths(records)
    with mpl.rc_context({"font.size": 9, "text.parse_math": False}):  # a name may hold dollars
        figure = Figure(figsize=(_PANEL * len(panels), _height(sheet)), layout="constrained")
        FigureCanvasAgg(figure)
        for number, (flag, title) in enumerate(panels, 1):
            axes = figure.add_subplot(1, len(panels), number)
            _sheet(axes, sheet, zones, paths)
            for trial in found.trials:
                if trial.feedback == flag:
                    _trial(axes, trial)
            axes.set_title(f"{title}\n{_words(found, flag)}")
        figure.supxlabel(("\n" if len(panels) == 1 else " · ").join(_LEGEND), fontsize=8)
        figure.savefig(path, dpi=110, format="png", metadata={"Software": "armspan"})


def _height(sheet: Sheet) -> float:
    """The figure's height [inch] at which a panel of the sheet's own shape leaves room for what is written round it."""
    margin = 2 * _MARGIN * sheet.height_m
    shape = (sheet.height_m + margin) / (sheet.width_m + margin)
    return min(10.0, round((_PANEL - 0.7) * shape + 1.3, 1))


def _words(found: Account, flag: bool) -> str:
    trials = [trial for trial in found.trials if trial.feedback == flag]
    misses = [1000 * trial.miss for trial in trials if trial.miss is not None]
    if not misses:
        return "nothing was pointed at"
    right = sum(trial.right for trial in trials)
    return f"median {np.median(misses):.0f} mm from the target, {right} of {len(trials)} chosen right"


def _paths(records: Iterable[Record]) -> dict[str, Array]:
    """Where each robot went, (n, 2) [mm]."""
    points: dict[str, list[tuple[float, float]]] = {}
    for record in records:
        if isinstance(record, RobotState):
            points.setdefault(record.robot, []).append(record.xy)
    return {name: 1000 * np.array(xy) for name, xy in points.items()}


def _sheet(axes: Axes, sheet: Sheet, zones: Sequence[Zone], paths: dict[str, Array]) -> None:
    width, height = 1000 * sheet.width_m, 1000 * sheet.height_m
    corners = [(0, 0), (width, 0), (width, height), (0, height)]
    axes.add_patch(Polygon(corners, closed=True, facecolor="#fbfaf5", edgecolor=_INK))
    for zone in zones:
        axes.add_patch(Polygon(1000 * np.array(zone.polygon), closed=True, facecolor="#e8e4d2", edgecolor="none"))
        x, y = zone_middle(zone)
        axes.annotate(zone.name, (1000 * x, 1000 * y), ha="center", va="center", color="#7a7350")
    for number, (name, xy) in enumerate(paths.items()):
        axes.plot(*xy.T, color=f"C{number}", lw=1, alpha=0.6, zorder=2)
        axes.plot(*xy[-1], marker="h", ms=13, color=f"C{number}", zorder=3)
        axes.annotate(name, xy[-1], xytext=(0, 11), textcoords="offset points", ha="center", color=f"C{number}")
    margin = _MARGIN * height
    axes.set_xlim(-margin, width + margin)
    axes.set_ylim(height + margin, -margin)  # y grows downwards, as printed
    axes.set_aspect("equal")


def _trial(axes: Axes, trial: TrialResult) -> None:
    if trial.spot is None:
        return
    colour = _OPEN if not trial.decided else _RIGHT if trial.right else _WRONG
    mark = "o" if not trial.decided else "+" if trial.right else "x"
    (x, y), (a, b) = trial.spot, trial.xy
    axes.plot([1000 * x, 1000 * a], [1000 * y, 1000 * b], color=colour, lw=0.6, alpha=0.7, zorder=4)
    axes.plot(1000 * x, 1000 * y, marker=mark, color=colour, ms=6, mfc="none", zorder=5)
    if trial.covariance is not None:
        axes.add_patch(_ellipse(trial.spot, trial.covariance, colour))


def _ellipse(spot: tuple[float, float], covariance: Covariance2, colour: str) -> Ellipse:
    values, vectors = np.linalg.eigh(np.array(covariance))
    long, short = 2000 * np.sqrt(CHI2_90 * values[::-1])
    turn = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    centre = (1000 * spot[0], 1000 * spot[1])
    return Ellipse(centre, long, short, angle=turn, facecolor="none", edgecolor=colour, lw=0.5, alpha=0.35)
