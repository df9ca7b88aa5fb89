"""The study's results as pictures: PNG files, simulated filled, real hatched or starred."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from armspan.frames import Array
from armspan.study.pointing_error.bands import BandRow
from armspan.study.pointing_error.feedback import FeedbackRow, Quoted
from armspan.study.pointing_error.monte_carlo import Budget, MonteCarlo
from armspan.study.pointing_error.moving import RealRow, SimulatedRow
from armspan.study.pointing_error.stops import StopsRow
from armspan.study.pointing_error.value import Values

_INK, _GREY = "#222222", "#999999"
_BLUE, _ORANGE, _GREEN, _RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
"""Okabe and Ito's, apart for every kind of colour vision."""

_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.edgecolor": _GREY,
    "axes.titlesize": 9.5,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
}
_SERIES = (_BLUE, _ORANGE, _GREEN, _RED)


def draw_values(folder: Path, values: Values) -> list[Path]:
    """Write all pictures into a folder that exists; their paths."""
    with mpl.rc_context(_STYLE):
        figures = {
            "monte-carlo": monte_carlo(values.monte_carlo),
            "budget": budget(values.monte_carlo),
            "stops": stops(values.stops),
            "bands": bands(values.bands),
            "feedback": feedback(values.feedback, values.quoted),
            "moving": moving(values.moving, values.followed),
        }
    paths = []
    for name, figure in figures.items():
        path = folder / f"{name}.png"
        figure.savefig(path, dpi=110, format="png", metadata={"Software": "armspan"})
        paths.append(path)
    return paths


def _figure(columns: int, size: tuple[float, float], title: str, *, sharey: bool = False) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, columns, squeeze=False, sharey=sharey)[0]
    figure.suptitle(title, fontsize=11)
    for one in axes:
        one.spines[["top", "right"]].set_visible(False)
        one.tick_params(color=_GREY)
    return figure, list(axes)


def monte_carlo(parts: Sequence[MonteCarlo]) -> Figure:
    """How often which error comes up, with median, 90th and 99th percentile."""
    figure, axes = _figure(len(parts), (4.4 * len(parts), 3.4), "Where a gesture is taken to point (simulated)")
    for one, part in zip(axes, parts, strict=True):
        far = 1000.0 * part.percentile(99.7)
        one.hist(1000.0 * part.errors, bins=np.linspace(0.0, far, 80).tolist(), color=_BLUE, alpha=0.55, density=True)
        for share, style in ((50, "-"), (90, "--"), (99, ":")):
            at = 1000.0 * part.percentile(share)
            name = "median" if share == 50 else f"{share} %"
            one.axvline(at, color=_INK, ls=style, lw=1.2, label=f"{name}: {at:.0f} mm")
        one.set(xlim=(0, far), yticks=[], xlabel="from the target [mm]")
        one.set_title(f"{part.layout.name}, {part.layout.side:g} m square\n{part.count:,} calibrations of 4 stops")
        one.spines["left"].set_visible(False)
        one.legend(frameon=True, framealpha=1.0, edgecolor="none", loc="upper right")
    return figure


def budget(parts: Sequence[MonteCarlo]) -> Figure:
    """What each source makes alone, and what is left without it; the largest on top."""
    title = "What makes the error: each source alone, and all but it (simulated)"
    figure, axes = _figure(len(parts), (4.9 * len(parts), 4.6), title, sharey=True)
    order = sorted(range(len(parts[0].budget)), key=lambda k: parts[0].budget[k].share)
    for one, part in zip(axes, parts, strict=True):
        rows = [part.budget[k] for k in order]
        _budget_bars(one, rows, 1000.0 * part.percentile(90))
        one.set_title(part.layout.name)
    axes[0].set_yticks(range(len(order)), [parts[0].budget[k].source for k in order])
    for one in axes:
        one.legend(frameon=True, framealpha=1.0, edgecolor="none", loc="lower right", bbox_to_anchor=(0.9, 0.02))
    return figure


def _budget_bars(axes: Axes, rows: Sequence[Budget], whole: float) -> None:
    places = np.arange(len(rows))
    alone = [1000.0 * row.alone[1] for row in rows]
    axes.barh(places, alone, 0.62, color=_BLUE, alpha=0.8, label="alone")
    axes.plot([1000.0 * row.without[1] for row in rows], places, "D", ms=4.5, color=_ORANGE, label="all but this one")
    axes.axvline(whole, color=_INK, lw=1, ls="--", label=f"all together: {whole:.0f} mm")
    for place, row, length in zip(places, rows, alone, strict=True):
        axes.annotate(
            f"{100 * row.share:.0f} %", (length, place), xytext=(4, 0), textcoords="offset points", va="center"
        )
    axes.set(xlim=(0, 1.12 * whole), xlabel="90th percentile [mm], and share of the mean square")


def stops(rows: Sequence[StopsRow]) -> Figure:
    """Median errors by the number of stops: the two layouts, and people at nine places."""
    figure, (left, right) = _figure(2, (9.6, 4.2), "What more stops are worth (median error in use)")
    names = list(dict.fromkeys(row.who for row in rows))
    for who in names:
        people = "band" in who
        first = "one band" in who if people else who.startswith(names[0].partition(",")[0])
        _stop_lines(right if people else left, rows, who, (_ORANGE if people else _BLUE) if first else _GREEN)
    left.set(xscale="log", ylim=(0, None), ylabel="from the target [mm]")
    left.set_xticks([3, 4, 5, 8, 9, 16, 25], ["3", "4", "5", "8", " 9", "16", "25"], minor=False)
    left.minorticks_off()
    left.set_title("simulated: straight arm, one band")
    right.set(ylim=(0, None), xlim=(3.7, 8.3))
    right.set_xticks([4, 5, 8])
    right.set_title("natural arms, nine places 1.5 to 3.5 m away")
    _legend(left, [(names[0].partition(",")[0], _BLUE, "-", ""), (_second(names), _GREEN, "-", ""), *_GESTURE_KEYS])
    people_keys = [("simulated", _INK, "", "o"), ("REAL people", _INK, "", "*")]
    _legend(right, [("one band", _ORANGE, "-", ""), ("two bands", _GREEN, "-", ""), *_GESTURE_KEYS[:2], *people_keys])
    for one in (left, right):
        one.set_xlabel("stops")
    return figure


_GESTURE_KEYS = (
    ("1 gesture a stop", _GREY, "-", ""),
    ("5 gestures a stop", _GREY, ":", ""),
    ("1 gesture, heading drifts", _GREY, "--", ""),
)


def _second(names: Sequence[str]) -> str:
    """The second layout's name."""
    layouts = list(dict.fromkeys(name.partition(",")[0] for name in names))
    return layouts[1] if len(layouts) > 1 else layouts[0]


def _legend(axes: Axes, keys: Sequence[tuple[str, str, str, str]]) -> None:
    """A legend below the axes of (label, colour, line, marker)."""
    handles = [
        Line2D([], [], color=colour, ls=line, marker=marker, ms=9 if marker == "*" else 5, label=label)
        for label, colour, line, marker in keys
    ]
    axes.legend(handles=handles, frameon=False, fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.15))


def _stop_lines(axes: Axes, rows: Sequence[StopsRow], who: str, colour: str) -> None:
    own = [row for row in rows if row.who == who]
    for gestures, simulated in sorted({(row.gestures, row.simulated) for row in own}):
        line = [row for row in own if (row.gestures, row.simulated) == (gestures, simulated)]
        axes.plot(
            [row.stops for row in line],
            [1000.0 * row.median for row in line],
            marker="o" if simulated else "*",
            ms=4 if simulated else 10,
            color=colour,
            ls=":" if gestures > 1 else "--" if who.endswith(", drift") else "-",
            lw=1.1 if simulated else 1.8,
        )


def bands(rows: Sequence[BandRow]) -> Figure:
    """One band beside two: median bars with the 90th percentile as a whisker."""
    figure, (axes,) = _figure(1, (8.2, 3.9), "What a second band on the upper arm is worth (4 stops)")
    for shift, colour, label in ((-0.2, _ORANGE, "one band"), (0.2, _GREEN, "two bands")):
        misses = [row.one if shift < 0 else row.two for row in rows]
        found = [miss.document() for miss in misses]
        hatch = ["" if row.simulated else "//" for row in rows]
        places = np.arange(len(rows)) + shift
        middle = np.array([one["median_mm"] for one in found])
        high = np.array([one["p90_mm"] for one in found])
        axes.bar(places, middle, 0.36, color=colour, alpha=0.8, label=label, hatch=hatch, edgecolor="white")
        axes.errorbar(places, middle, [0 * high, high - middle], fmt="none", ecolor=_GREY, capsize=3, lw=1)
        for place, value in zip(places, middle, strict=True):
            patch = {"facecolor": colour, "edgecolor": "none", "pad": 1.0}
            axes.annotate(f"{value:.0f}", (place, 0), (0, 5), textcoords="offset points", ha="center", bbox=patch)
    words = [f"{'simulated' if row.simulated else 'REAL'}\n{row.who.replace(', ', chr(10))}" for row in rows]
    axes.set_xticks(range(len(rows)), words)
    axes.set(ylabel="from the target [mm]")
    axes.legend(frameon=False, title="median, whisker to 90 %")
    return figure


def feedback(rows: Sequence[FeedbackRow], quoted: Sequence[Quoted]) -> Figure:
    """What happens over time in the simulation, and what is left beside what others measured."""
    figure, (left, right) = _figure(2, (10.4, 4.2), "What live feedback is worth")
    for row, colour in zip(rows, _SERIES, strict=False):
        left.plot(row.seconds, 1000.0 * row.metres[0], color=colour, ls="--", lw=1.1)
        left.plot(row.seconds, 1000.0 * row.metres[1], color=colour, lw=1.9, label=row.who)
    top = 1300.0 * max((float(row.metres.max()) for row in rows), default=0.1)
    left.set(xlabel="seconds after the word", ylabel="from the target [mm], median", ylim=(0, top))
    left.set_title("simulated, one band: with (solid) and without a cursor")
    left.legend(
        frameon=True, framealpha=0.9, edgecolor="none", fontsize=8, loc="upper right", bbox_to_anchor=(1.0, 1.0)
    )
    ends = [(row.who, True, 1000.0 * row.metres[:, -1]) for row in rows]
    ends += [(one.who, one.simulated, 1000.0 * np.array(one.metres)) for one in quoted]
    for place, (_, simulated, (without, shown)) in enumerate(reversed(ends)):
        colour = _BLUE if simulated else _RED
        right.plot([without, shown], [place, place], color=colour, lw=1.2, alpha=0.6)
        right.plot(without, place, "o", mfc="white", color=colour)
        right.plot(shown, place, "o" if simulated else "*", ms=6 if simulated else 11, color=colour)
    right.set_yticks(range(len(ends)), [_folded(who, simulated) for who, simulated, _ in reversed(ends)])
    right.set(xscale="log", xlabel="median [mm], without (open) and with (filled)", ylim=(-0.6, len(ends) - 0.4))
    ticks = [10, 20, 50, 100, 200, 500]
    right.set_xticks(ticks, [str(tick) for tick in ticks])
    right.minorticks_off()
    right.set_title("at the end: simulated, and quoted")
    return figure


def _folded(who: str, simulated: bool) -> str:
    head, _, tail = who.partition(", ")
    return f"{head},\n{tail}" + ("" if simulated else " (REAL)")


def moving(simulated: Sequence[SimulatedRow], real: Sequence[RealRow]) -> Figure:
    """Stops beside a driving robot, simulated; and the real sessions by what was used of them."""
    figure, axes = _figure(3 if real else 1, (13.2 if real else 5.5, 4.2), "Pairs from stops and from a moving robot")
    kinds = list(dict.fromkeys(row.pairs for row in simulated))[::-1]
    for shift, colour, who in zip((0.19, -0.19), _SERIES, dict.fromkeys(row.who for row in simulated), strict=False):
        rows = {row.pairs: row for row in simulated if row.who == who}
        lengths = 1000.0 * np.array([rows[kind].median for kind in kinds])
        axes[0].barh(np.arange(len(kinds)) + shift, lengths, 0.36, color=colour, alpha=0.8, label=who)
        for place, length in enumerate(lengths):
            axes[0].annotate(
                f"{length:.0f}", (length, place + shift), xytext=(3, 0), textcoords="offset points", va="center"
            )
    seconds = {row.pairs: row.seconds for row in simulated}
    axes[0].set_yticks(range(len(kinds)), [f"{kind.replace(', ', chr(10))} ({seconds[kind]:.0f} s)" for kind in kinds])
    axes[0].set(xlabel="error in use, median [mm]")
    axes[0].set_title("simulated, one band")
    axes[0].margins(x=0.1)
    axes[0].legend(frameon=False, fontsize=7.5, loc="upper center", bbox_to_anchor=(0.4, -0.14))
    if real:
        _sessions(axes[1], real, [1000.0 * row.head for row in real], "eye from the tracked head [mm]")
        _sessions(
            axes[2], real, [float(np.degrees(row.angle)) for row in real], "miss in the rest of the session [deg]"
        )
        axes[1].set_title("REAL sessions: the place found")
        axes[2].set_title("REAL sessions: how well rays then meet the robot")
        axes[2].set_yticklabels([])
        axes[2].legend(frameon=False, fontsize=7.5, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.14))
    return figure


def _sessions(axes: Axes, rows: Sequence[RealRow], values: Sequence[float], label: str) -> None:
    kinds = list(dict.fromkeys(row.pairs for row in rows))[::-1]
    for shift, colour, seconds in zip(
        (0.26, 0.0, -0.26), _SERIES, dict.fromkeys(row.seconds for row in rows), strict=False
    ):
        found = {row.pairs: value for row, value in zip(rows, values, strict=True) if row.seconds == seconds}
        lengths: Array = np.array([found[kind] for kind in kinds])
        places = np.arange(len(kinds)) + shift
        axes.barh(
            places, lengths, 0.25, color=colour, alpha=0.75, hatch="//", edgecolor="white", label=f"{seconds:g} s"
        )
    axes.set_yticks(range(len(kinds)), [kind.replace(", ", ",\n") for kind in kinds])
    axes.set(xlabel=label)
