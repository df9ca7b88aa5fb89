"""What ``armspan study pointing-error`` found beyond the report, as tables of words."""

import math
from collections.abc import Iterable, Sequence

from armspan.study.pointing_error.bands import BandRow
from armspan.study.pointing_error.feedback import FeedbackRow, Quoted
from armspan.study.pointing_error.monte_carlo import MonteCarlo
from armspan.study.pointing_error.moving import RealRow, SimulatedRow
from armspan.study.pointing_error.stops import StopsRow
from armspan.study.pointing_error.tables import Table
from armspan.study.pointing_error.value import Values


def value_tables(values: Values) -> tuple[Table, ...]:
    """Every table, in the order in which it is told; those of real recordings only where there are any."""
    told = [
        _drawn(values.monte_carlo),
        *(_budget(part) for part in values.monte_carlo),
        _stops(values.stops),
        _bands(values.bands),
        _feedback([*values.feedback, *values.quoted]),
        _moving(values.moving),
    ]
    return (*told, _followed(values.followed)) if values.followed else tuple(told)


def _drawn(parts: Iterable[MonteCarlo]) -> Table:
    rows = tuple(
        (part.layout.name, f"{part.count}", *(_mm(part.percentile(p)) for p in (50, 90, 99))) for part in parts
    )
    return Table(
        "Simulated calibrations of four stops", ("where", "calibrations", "median mm", "p90 mm", "p99 mm"), rows
    )


def _budget(part: MonteCarlo) -> Table:
    columns = ("source", "share of mean square", "alone, median mm", "alone, p90 mm", "without it, p90 mm")
    rows = tuple(
        (row.source, f"{100 * row.share:.0f} %", _mm(row.alone[0]), _mm(row.alone[1]), _mm(row.without[1]))
        for row in part.budget
    )
    return Table(f"What makes the error, {part.layout.name}", columns, rows)


def _stops(rows: Iterable[StopsRow]) -> Table:
    told = tuple(
        (row.who, _made(row.simulated), f"{row.stops}", f"{row.gestures}", _mm(row.median), _mm(row.p90))
        for row in rows
    )
    return Table("The value of more stops", ("who", "", "stops", "gestures a stop", "median mm", "p90 mm"), told)


def _bands(rows: Iterable[BandRow]) -> Table:
    told = tuple(
        (
            row.who,
            _made(row.simulated),
            *(f"{found.document()[key]:.0f}" for found in (row.one, row.two) for key in ("median_mm", "p90_mm")),
        )
        for row in rows
    )
    columns = ("who", "", "one band, median mm", "p90 mm", "two bands, median mm", "p90 mm")
    return Table("The value of a second band on the upper arm", columns, told)


def _feedback(rows: Sequence[FeedbackRow | Quoted]) -> Table:
    documents = [row.document() for row in rows]
    told = tuple(
        (
            str(d["who"]),
            _made(bool(d["simulated"])),
            f"{d['without_mm']:.0f}",
            f"{d['with_mm']:.0f}",
            f"{d['without_deg']:.1f}",
            f"{d['with_deg']:.1f}",
        )
        for d in documents
    )
    columns = ("who", "", "without, mm", "with, mm", "without, deg", "with, deg")
    return Table("The value of seeing where one is taken to point", columns, told)


def _moving(rows: Iterable[SimulatedRow]) -> Table:
    told = tuple((row.who, row.pairs, f"{row.seconds:.0f}", _mm(row.median), _mm(row.p90)) for row in rows)
    return Table("Static and moving pairs, simulated", ("who", "pairs", "seconds", "median mm", "p90 mm"), told)


def _followed(rows: Iterable[RealRow]) -> Table:
    cells = tuple(
        (row.pairs, f"{row.seconds:.0f}", f"{row.fits}", f"{row.refused}", *_fitted(row.head, row.angle, row.fits))
        for row in rows
    )
    columns = ("pairs", "seconds", "fits", "refused", "head off by mm", "rest of session, deg")
    return Table("Static and moving pairs, real sessions", columns, cells)


def _fitted(head: float, angle: float, fits: int) -> tuple[str, str]:
    """Millimetres and degrees; dashes where nothing was fitted."""
    return (_mm(head), f"{math.degrees(angle):.1f}") if fits else ("-", "-")


def _mm(metres: float) -> str:
    return f"{1000 * metres:.0f}"


def _made(simulated: bool) -> str:
    return "simulated" if simulated else "real"
