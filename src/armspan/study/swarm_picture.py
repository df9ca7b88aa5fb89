"""A swarm's run as a picture: what was covered and when, the robots' paths, coverage and the least gap over time."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from armspan.errors import DataError
from armspan.frames import Array
from armspan.records import Sheet, Zone
from armspan.study.coverage import Coverage
from armspan.study.swarm import Gaps, SwarmAccount
from armspan.study.trials import zone_middle

_INK, _PAPER, _RULE = "#222222", "#fbfaf5", "#8a8a8a"
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's, apart for every kind of colour vision; the yellow is too pale for a line."""

_DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1)))  # with them three times as many robots are told apart
_SHADES = LinearSegmentedColormap.from_list("first covered", ["#8f9aa6", "#dfe4e8"])
_MARKS = (("t50", "o"), ("t90", "s"), ("t95", "^"), ("t99", "D"))
_PANEL, _SIDE, _MARGIN = 6.4, 4.2, 0.04
"""Widths of the sheet's panel and of the one beside it [inch], and what stays free round the sheet, as a share."""

_LEAST, _MOST = 5.0, 9.0  # [pt] the smallest letters that are read, and the largest that are needed


def draw_swarm(path: Path, account: SwarmAccount, zones: Sequence[Zone] = (), title: str = "") -> None:
    """Write a PNG: the sheet from above with paths and covered area, and beside it coverage and least gap over time.

    Raises:
        DataError: where the account has taken no places.

    """
    if not len(account.times):
        raise DataError(f"nothing to draw in {path}: no robot's place was taken; run for longer")
    with mpl.rc_context({"font.size": 9, "text.parse_math": False}):  # a name may hold dollars
        figure = Figure(figsize=(_PANEL + _SIDE, _height(account.sheet)), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(2, 2, width_ratios=(_PANEL, _SIDE))
        sheet = figure.add_subplot(grid[:, 0])
        _sheet(sheet, account.sheet, zones)
        _shade(figure, sheet, account.coverage)
        _robots(sheet, account)
        above = figure.add_subplot(grid[0, 1])
        _covered(above, account.coverage)
        _gaps(figure.add_subplot(grid[1, 1], sharex=above), account.gaps, float(account.times[-1]))
        figure.suptitle(title)
        figure.savefig(path, dpi=110, format="png", metadata={"Software": "armspan"})


def _height(sheet: Sheet) -> float:
    """The figure's height [inch] for a sheet of this shape, with room for what is written round it."""
    return float(np.clip(round((_PANEL - 1.4) * sheet.height_m / sheet.width_m + 1.3, 1), 4.4, 10.0))


def _sheet(axes: Axes, sheet: Sheet, zones: Sequence[Zone]) -> None:
    width, height = 1000 * sheet.width_m, 1000 * sheet.height_m
    corners = [(0, 0), (width, 0), (width, height), (0, height)]
    axes.add_patch(Polygon(corners, closed=True, facecolor=_PAPER, edgecolor=_INK, zorder=0))
    for zone in zones:
        axes.add_patch(Polygon(1000 * np.array(zone.polygon), closed=True, fill=False, edgecolor=_RULE, ls="--"))
        x, y = zone_middle(zone)
        text = axes.annotate(zone.name, (1000 * x, 1000 * y), ha="center", va="center", color="#555555", zorder=6)
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
    rim = _MARGIN * max(width, height)
    axes.set_xlim(-rim, width + rim)
    axes.set_ylim(height + rim, -rim)  # y grows downwards, as printed
    axes.set_aspect("equal")
    axes.set_autoscale_on(False)
    axes.set_xlabel("sheet coordinates [mm] · broken circle: start, full one: end")


def _shade(figure: Figure, axes: Axes, coverage: Coverage) -> None:
    """The covered cells, the darker the earlier; without a scale where all happened at once."""
    first = np.ma.masked_where(~(coverage.inside & np.isfinite(coverage.first)), coverage.first)
    left, right, top, bottom = (1000 * edge for edge in coverage.extent)
    last = max(1e-3, float(coverage.taken[-1]))
    image = axes.imshow(
        first, cmap=_SHADES, vmin=0, vmax=last, extent=(left, right, bottom, top), interpolation="nearest", zorder=0.5
    )
    figure.colorbar(image, ax=axes, location="left", shrink=0.5, aspect=30, label="covered first at [s]", pad=0.02)


def _robots(axes: Axes, account: SwarmAccount) -> None:
    places, radius, count = 1000 * account.places, 1000 * account.gaps.body, len(account.names)
    for i, name in enumerate(account.names):
        xy = places[:, i]
        seen = xy[np.isfinite(xy).all(axis=1)]
        if not len(seen):
            continue
        colour, dash = _COLOURS[i % len(_COLOURS)], _DASHES[i // len(_COLOURS) % len(_DASHES)]
        width = 1.3 if count <= 12 else 1.0 if count <= 40 else 0.6
        axes.plot(*xy.T, color=colour, ls=dash, lw=width, zorder=3)
        start = Circle(_point(seen[0]), radius, fill=False, edgecolor=colour, ls=(0, (2.5, 1.5)), lw=width, zorder=3.5)
        start.set_path_effects([withStroke(linewidth=width + 1.5, foreground="white")])
        axes.add_patch(start)
        axes.add_patch(Circle(_point(seen[-1]), radius, facecolor=colour, edgecolor=_INK, lw=0.6, alpha=0.75, zorder=4))
        _name(axes, name, seen[-1], account)


def _name(axes: Axes, name: str, xy: Array, account: SwarmAccount) -> None:
    """A robot's name, in its disc where it fits, beside it (towards the sheet's middle) where few are to be told."""
    letters = _letters(account)
    inside = letters >= _LEAST
    if not inside and len(account.names) > 12:
        return
    below = xy[1] < 500 * account.sheet.height_m
    off = 0.0 if inside else (1000 * account.gaps.body + 3) * (1 if below else -1)
    text = axes.text(
        xy[0],
        xy[1] + off,
        name,
        ha="center",
        va="center" if inside else "top" if below else "bottom",
        fontsize=letters if inside else 8,
        color=_INK,
        clip_on=True,
        zorder=6,
    )
    text.set_path_effects([withStroke(linewidth=2, foreground="white")])


def _point(xy: Array) -> tuple[float, float]:
    return float(xy[0]), float(xy[1])


def _letters(account: SwarmAccount) -> float:
    """The size [pt] at which the longest name fits into a robot's disc as it is drawn."""
    size = max(account.sheet.width_m, account.sheet.height_m * (_PANEL - 1.4) / (_height(account.sheet) - 1.3))
    across = 72 * (_PANEL - 1.4) * 2 * account.gaps.body / (size * (1 + 2 * _MARGIN))
    return min(_MOST, 1.5 * across / max(1, *map(len, account.names)))


def _covered(axes: Axes, coverage: Coverage) -> None:
    taken, share = coverage.taken, 100 * coverage.shares()
    axes.plot(taken, share, color=_INK, lw=1.5)
    times = coverage.times()
    for (name, mark), colour in zip(_MARKS, _COLOURS, strict=False):
        t, told = times[name], f"{name}  never"
        if t is not None:
            told = f"{name}  {t:.1f} s"
            axes.plot([t, t], [0, float(name[1:])], color=colour, lw=0.8, ls=":")
        axes.plot([] if t is None else [t], [] if t is None else [float(name[1:])], mark, color=colour, label=told)
    axes.set_ylim(0, 105)
    axes.set_ylabel("covered [%]")
    axes.set_title(f"{100 * coverage.share():.1f} % of the area covered in the end", fontsize=9)
    axes.legend(loc="lower right" if share[-1] > 50 else "upper left", fontsize=8, framealpha=0.9)
    axes.tick_params(labelbottom=False)


def _gaps(axes: Axes, gaps: Gaps, seconds: float) -> None:
    least = gaps.least
    axes.set_xlabel("time [s]")
    axes.set_xlim(0, max(seconds, 1e-3))
    axes.xaxis.set_major_locator(MaxNLocator(7))
    if least is None:
        axes.text(0.5, 0.5, "one robot: no gap", ha="center", va="center", transform=axes.transAxes, color=_RULE)
        axes.set_yticks([])
        return
    axes.plot([each.t for each in gaps.series], [1000 * each.gap for each in gaps.series], color=_INK, lw=1.2)
    axes.axhline(0, color="#D55E00", lw=1, ls="--", label="bodies touch")
    axes.plot(least.t, 1000 * least.gap, "v", color="#D55E00", ms=7, zorder=4)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -0.08 * high), high)
    axes.set_ylabel("least gap of bodies [mm]")
    axes.set_title(f"least {1000 * least.gap:.1f} mm at {least.t:.1f} s, collisions: {gaps.collisions}", fontsize=9)
    axes.legend(loc="best", fontsize=8, framealpha=0.9)
