"""The report's four figures drawn afresh in three readings each, and the errors no calibration absorbs as bars."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from numpy.typing import ArrayLike

from armspan.frames import Array
from armspan.study.pointing_error.published import Map, Places, Published
from armspan.study.pointing_error.readings import ALL_MEASURES, Curve
from armspan.study.pointing_error.reproduction import Reproduction
from armspan.study.pointing_error.unabsorbed import Unabsorbed

INK, RULE = "#222222", "#8a8a8a"
REFITTED, UNFITTED, PUBLISHED = "#0072B2", "#D55E00", "#CC79A7"
"""Okabe and Ito's, apart for every kind of colour vision; each reading has a mark of its own too."""

_OTHERS = ("#009E73", "#E69F00", "#56B4E9", "#000000", "#D55E00", "#0072B2")
_DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1)), (0, (5, 1.5, 1.5, 1.5)), "-", (0, (5, 1.5)))
_DPI, _WIDTH = 110, 9.2

_WHAT = {
    "refitted": "calibrated on the wrong rays (this study)",
    "unfitted": "not calibrated anew (this study)",
    "published": "published (read from the report's figure)",
    "as_published": "supposed: only the fit's yaw used, and the wrong way round",
}


def draw_all(found: Reproduction, folder: Path) -> list[str]:
    """Write every picture of the reproduction into a ``folder`` that exists; the files' names."""
    body, angle = found.maps
    pictures: dict[str, Callable[[Path], None]] = {
        "figure-1.3.2a.png": lambda path: draw_map(path, body),
        "figure-1.3.2b.png": lambda path: draw_map(path, angle),
        "figure-1.3.3a.png": lambda path: draw_body_curves(path, found),
        "figure-1.3.3b.png": lambda path: draw_angle_curves(path, found),
        "unabsorbed.png": lambda path: draw_unabsorbed(path, found.unabsorbed),
    }
    for name, draw in pictures.items():
        draw(folder / name)
    return list(pictures)


def draw_map(path: Path, found: Map) -> None:
    """Write a PNG: the circle on the floor from above, true, published, and in the study's readings."""
    with _style():
        figure = _figure(7.6)
        axes = figure.add_subplot()
        _missed(axes, found.true, found.unfitted, UNFITTED)
        _missed(axes, found.true, found.published, PUBLISHED)
        axes.plot(*_seen(found.true), color=INK, lw=5, alpha=0.25, label="what is truly pointed at")
        axes.plot(*_seen(found.refitted), "x", color=REFITTED, ms=8, mew=2, label=_WHAT["refitted"])
        axes.plot(*_seen(found.unfitted), "s", color=UNFITTED, ms=5, label=_WHAT["unfitted"])
        axes.plot(*_seen(found.as_published), "--", color=INK, lw=1, label=_WHAT["as_published"])
        axes.plot(*_seen(found.published), "o", color=PUBLISHED, ms=9, mfc="none", mew=1.8, label=_WHAT["published"])
        axes.plot(0, 0, marker="^", ms=13, color=INK, ls="none")
        axes.annotate("user, looking up", (0, 0), (0, 12), textcoords="offset points", ha="center")
        axes.set_aspect("equal")
        axes.set_xlabel("to the right of the user [mm]")
        axes.set_ylabel("ahead of the user [mm]")
        axes.grid(color=RULE, alpha=0.25)
        axes.set_title(f"Figure {found.figure} drawn afresh: {found.error}")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
        _save(figure, path)


def draw_body_curves(path: Path, found: Reproduction) -> None:
    """Write a PNG: figure 1.3.3a, wrong measures, all together and each alone."""
    measures = [curve for curve in found.figures if curve.unit == "%"]
    with _style():
        figure = _figure(4.9)
        left, right = figure.subplots(1, 2)
        together = next(curve for curve in measures if curve.error == ALL_MEASURES)
        _readings(left, together, _of(found.published, "1.3.3a"))
        _titled(left, "all measures wrong together", "error of the measures [%]")
        for number, curve in enumerate(each for each in measures if each is not together):
            _line(right, curve.sizes, curve.unfitted_mm, number, curve.error)
        worst = max(max(curve.worst_mm) for curve in measures)
        _nothing(right, (-10, 10), f"calibrated with any of them: at most {worst:.0e} mm")
        right.legend(title="not calibrated anew", loc="upper center", fontsize=8.5)
        _titled(right, "each measure wrong alone", "error of the measure [%]")
        _alike(left, right)
        figure.suptitle("Figure 1.3.3a drawn afresh: median error over the circle")
        _legend(figure, left)
        _save(figure, path)


def draw_angle_curves(path: Path, found: Reproduction) -> None:
    """Write a PNG: figure 1.3.3b, an error by an angle, and what of its other meanings a calibration leaves."""
    angles = [curve for curve in found.figures if curve.unit == "deg"]
    with _style():
        figure = _figure(4.9)
        left, right = figure.subplots(1, 2)
        _readings(left, angles[0], _of(found.published, "1.3.3b"))
        _titled(left, "yaw of the arm's band wrong", "error of the angle [deg]")
        shown = [curve for curve in angles if max(curve.refitted_mm) > 1e-6]
        for number, curve in enumerate(shown):
            upwards = np.array(curve.sizes) >= 0
            _line(right, np.array(curve.sizes)[upwards], np.array(curve.refitted_mm)[upwards], number, curve.error)
        gone = [curve.error for curve in angles if curve not in shown]
        _nothing(right, (0, 10), f"{', '.join(gone)}: 0")
        right.legend(title="calibrated on the wrong rays", loc="upper left", fontsize=8.5)
        _titled(right, "other meanings of an angle", "error of the angle [deg]")
        _alike(left, right)
        figure.suptitle("Figure 1.3.3b drawn afresh: median error over the circle")
        _legend(figure, left)
        _save(figure, path)


def draw_unabsorbed(path: Path, rows: tuple[Unabsorbed, ...]) -> None:
    """Write a PNG: what a usual size of each error costs that begins after the calibration, and before it."""
    places = list(dict.fromkeys(row.workplace for row in rows))
    with _style():
        figure = _figure(6.6)
        panels = figure.subplots(1, len(places), sharey=True, squeeze=False)[0]
        kinds = sorted((r for r in rows if r.workplace == places[0]), key=lambda row: row.usual_mm)
        for axes, place in zip(panels, places, strict=True):
            by_kind = {row.kind: row for row in rows if row.workplace == place}
            _bars(axes, [by_kind[row.kind] for row in kinds])
            axes.set_title(place)
        panels[0].set_yticks(range(len(kinds)), [f"{row.kind}, {_size(row)}" for row in kinds])
        figure.suptitle("What calibration does not absorb: median error of the place pointed at")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        _save(figure, path)


def _bars(axes: Axes, rows: list[Unabsorbed]) -> None:
    high = np.arange(len(rows))
    axes.barh(high, [row.usual_mm for row in rows], height=0.62, color=UNFITTED, label="began after the calibration")
    before = [row.before_mm for row in rows]
    axes.plot(before, high, "D", color=REFITTED, ms=6, label="was there already, unchanged, while calibrating")
    for y, row in zip(high, rows, strict=True):
        text = f"{row.per_unit_mm:.1f} mm/{row.unit.removesuffix('s')}"
        axes.annotate(text, (max(row.usual_mm, row.before_mm), y), (7, 0), textcoords="offset points", va="center")
    axes.set_axisbelow(True)
    axes.set_xlim(0, 1.5 * max(row.usual_mm for row in rows))
    axes.set_xlabel("error [mm]")
    axes.grid(axis="x", color=RULE, alpha=0.25)


def _size(row: Unabsorbed) -> str:
    return "62 mm beside" if row.unit == "eyes" else f"{row.usual:g} {row.unit}"


def _readings(axes: Axes, curve: Curve, published: list[Published]) -> None:
    """The study's readings of one error, and the published points beside them."""
    axes.plot(curve.sizes, curve.unfitted_mm, "s-", color=UNFITTED, ms=4, label=_WHAT["unfitted"])
    axes.plot(curve.sizes, curve.refitted_mm, "x-", color=REFITTED, ms=6, mew=1.8, label=_WHAT["refitted"])
    sizes = [each.size for each in published]
    supposed = [each.as_published_mm for each in published]
    middle = len(sizes) // 2  # nothing was published at 0, where the line would have its corner
    sizes_shown, supposed = [*sizes[:middle], 0.0, *sizes[middle:]], [*supposed[:middle], 0.0, *supposed[middle:]]
    axes.plot(sizes_shown, supposed, "--", color=INK, lw=1, label=_WHAT["as_published"])
    told = [p.published_mm for p in published]
    axes.plot(sizes, told, "o", color=PUBLISHED, ms=8, mfc="none", mew=1.8, label=_WHAT["published"])


def _nothing(axes: Axes, ends: tuple[float, float], text: str) -> None:
    """The line of what a calibration absorbs, with its ``text`` below."""
    axes.plot(ends, [0, 0], color=REFITTED, lw=2.5)
    where = (sum(ends) / 2, 0)
    axes.annotate(text, where, (0, -5), textcoords="offset points", ha="center", va="top", color=REFITTED, fontsize=8.5)


def _alike(left: Axes, right: Axes) -> None:
    """One scale of errors for both panels, with room for a line of text below zero."""
    top = left.get_ylim()[1]
    for axes in (left, right):
        axes.set_ylim(-0.09 * top, top)


def _line(axes: Axes, sizes: ArrayLike, errors: ArrayLike, number: int, name: str) -> None:
    axes.plot(np.asarray(sizes), np.asarray(errors), color=_OTHERS[number], ls=_DASHES[number], lw=1.8, label=name)


def _seen(places: Places) -> Array:
    """Places as the user sees the floor, (2, n) [mm]: to the right, ahead."""
    ahead, left = np.array(places).T
    return np.stack([-left, ahead])


def _missed(
    axes: Axes, true: tuple[tuple[float, float], ...], found: tuple[tuple[float, float], ...], ink: str
) -> None:
    """A thin line from every true place to where the rays seem to go."""
    for wanted, got in zip(_seen(true).T, _seen(found).T, strict=True):
        axes.plot(*np.stack([wanted, got], axis=1), color=ink, lw=0.9, alpha=0.8)


def _of(published: tuple[Published, ...], figure: str) -> list[Published]:
    return [each for each in published if each.figure == figure]


def _titled(axes: Axes, title: str, size: str) -> None:
    axes.set_title(title)
    axes.set_xlabel(size)
    axes.set_ylabel("error of the place pointed at [mm]")
    axes.xaxis.set_major_locator(MultipleLocator(2))
    axes.grid(color=RULE, alpha=0.25)


def _legend(figure: Figure, axes: Axes) -> None:
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)


def _style() -> AbstractContextManager[None]:
    return mpl.rc_context({"font.size": 9.5, "text.parse_math": False})


def _figure(height: float) -> Figure:
    figure = Figure(figsize=(_WIDTH, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _save(figure: Figure, path: Path) -> None:
    figure.savefig(path, dpi=_DPI, format="png", metadata={"Software": "armspan"})
