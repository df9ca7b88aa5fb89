"""The reproduction as tables of words, for a terminal or a page."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from armspan.study.pointing_error.published import Published
from armspan.study.pointing_error.readings import Curve
from armspan.study.pointing_error.reproduction import Optimised, Reproduction
from armspan.study.pointing_error.unabsorbed import Unabsorbed

_Row = TypeVar("_Row", Curve, Optimised)


@dataclass(frozen=True, slots=True)
class Table:
    """A ``title``, the names of the ``columns``, and ``rows`` of as many texts each."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def tables(found: Reproduction) -> tuple[Table, ...]:
    """Every table of a reproduction, in the order in which it is told."""
    places = dict.fromkeys(row.workplace for row in found.unabsorbed)
    return (
        *(published_table(figure, found.published) for figure in ("1.3.3a", "1.3.3b")),
        *(curve_table(curves) for curves in _alike(found.curves)),
        *(optimiser_table(rows) for rows in _alike(found.optimised)),
        *(unabsorbed_table(place, found.unabsorbed) for place in places),
    )


def published_table(figure: str, points: Iterable[Published]) -> Table:
    """Published points beside the supposed reading's."""
    own = [point for point in points if point.figure == figure]
    rows = tuple(
        (
            f"{point.size:+g}",
            f"{point.published_mm:.1f}",
            f"{point.as_published_mm:.1f}",
            f"{point.as_published_mm - point.published_mm:+.1f}",
        )
        for point in own
    )
    columns = (own[0].unit, "published", "supposed reading", "difference")
    return Table(f"Figure {figure}, published and supposed [mm]", columns, rows)


def curve_table(curves: Sequence[Curve]) -> Table:
    """Errors of one scene and unit: calibrated on the wrong rays, and not calibrated anew."""
    first = curves[0]
    sizes = [f"{size:g} {first.unit}" for size in first.sizes]
    columns = ("error", *(f"calibrated, {size}" for size in sizes), *(f"not, {size}" for size in sizes))
    rows = tuple((c.error, *_numbers(c.refitted_mm), *_numbers(c.unfitted_mm)) for c in curves)
    return Table(f"{first.scene}: median error over its rays [mm]", columns, rows)


def optimiser_table(rows: Sequence[Optimised]) -> Table:
    """Errors of one scene and unit after the report's own optimiser, and after the same cost minimised with care."""
    first = rows[0]
    sizes = [f"{size:g} {first.unit}" for size in first.sizes]
    columns = ("error", *(f"report's, {size}" for size in sizes), *(f"careful, {size}" for size in sizes))
    told = tuple((row.error, *_numbers(row.report_mm), *_numbers(row.careful_mm)) for row in rows)
    return Table(f"{first.scene}: calibrated by Nelder-Mead on the mean angle [mm]", columns, told)


def unabsorbed_table(place: str, found: Iterable[Unabsorbed]) -> Table:
    """Errors that begin after the calibration, at one workplace."""
    columns = ("error", "per", "median", "p90", "in step up to", "usual", "costs", "if there before", "whence")
    rows = tuple(
        (
            row.kind,
            row.unit.removesuffix("s"),
            f"{row.per_unit_mm:.1f}",
            f"{row.p90_per_unit_mm:.1f}",
            f"{row.linear_to:g} {row.unit}",
            f"{row.usual:g} {row.unit}",
            f"{row.usual_mm:.0f}",
            f"{row.before_mm:.1f}",
            row.basis,
        )
        for row in found
        if row.workplace == place
    )
    return Table(f"Not absorbed, {place} [mm]", columns, rows)


def _alike(rows: Sequence[_Row]) -> list[list[_Row]]:
    groups: dict[tuple[str, str], list[_Row]] = {}
    for row in rows:
        groups.setdefault((row.scene, row.unit), []).append(row)
    return list(groups.values())


def _numbers(values: Iterable[float]) -> tuple[str, ...]:
    return tuple(f"{value:.1f}" for value in values)
