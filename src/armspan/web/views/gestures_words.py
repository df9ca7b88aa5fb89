"""What the view of gestures says and draws: words, counts, the table of confusions, a take's curves."""

from collections.abc import Collection, Mapping, Sequence
from html import escape
from typing import Any

from armspan.gesture.model import Facts
from armspan.gesture.scoring import rate_bound
from armspan.gesture.takes import NULL
from armspan.swarm.director import IN_ZONES, MAKERS, STOP
from armspan.swarm.words import order_words
from armspan.web.views.gestures_host import Curves, TakeRow

EVERYDAY = "everyday motion"

NAMES = {
    "x_left_high": "big X, left arm high",
    "x_right_high": "big X, right arm high",
    "raise_both": "raise both arms",
    "mixing": "mixing",
    "stop": "stop",
    "arms_to_ground": "arms to ground",
    "breaststroke": "breaststroke",
    NULL: EVERYDAY,
}
"""Gestures' labels as they are read."""


def name_of(label: str) -> str:
    """A gesture's name as it is read."""
    return NAMES.get(label, label.replace("_", " "))


def orders_of(zones: Sequence[str]) -> dict[str, str]:
    """Everything that a gesture can begin in a room with these zones, with its words."""
    plain = {"": "nothing"} | {order: order_words(order) for order in (STOP, *MAKERS)}
    in_zones = [f"{order}@{zone}" for order in IN_ZONES for zone in zones]
    return plain | {order: order_words(order) for order in in_zones}


def own_labels(text: str) -> list[str]:
    """Labels that were typed, separated by commas."""
    return [label.strip() for label in text.split(",") if label.strip()]


def counted(rows: Sequence[TakeRow]) -> list[tuple[str, str]]:
    """Every label with what there is of it in words."""
    return [
        (label, _count([row for row in rows if row.label == label])) for label in dict.fromkeys(r.label for r in rows)
    ]


def _count(rows: Sequence[TakeRow]) -> str:
    good = [row for row in rows if row.counts]
    spoilt = sum(bool(row.note) for row in rows)
    practice = len(rows) - len(good) - spoilt
    if rows[0].label == NULL:
        parts = [f"{sum(row.seconds or 0.0 for row in good) / 60:.1f} min"]
    else:
        parts = [f"{len(good)} {'take' if len(good) == 1 else 'takes'}"]
    parts += [f"{practice} for practice"] if practice else []
    return ", ".join(parts + ([f"{spoilt} spoilt"] if spoilt else []))


def state_of(row: TakeRow) -> str:
    """What a take is good for, in words."""
    if row.note:
        return f"spoilt: {row.note}"
    words = "for practice, not learnt from" if row.practice else "counts"
    return f"{words}, simulated" if row.simulated else words


def account(facts: Facts) -> list[str]:
    """How good a model is, with no more claimed than was seen."""
    takes = sum(facts.takes.values())
    persons = f"{len(facts.persons)} {'person' if len(facts.persons) == 1 else 'persons'}"
    lines = [
        f"{takes} takes of {len(facts.labels)} gestures by {persons}, {facts.null_s / 60:.1f} min of everyday motion."
    ]
    for key, words in (("by_take", "takes"), ("by_person", "persons")):
        entry = facts.scores.get(key)
        if entry:
            right = sum(row[k] for k, row in enumerate(entry["confusion"]))
            total = sum(map(sum, entry["confusion"]))
            lines.append(f"Held-out {words}: {right} of {total} recognised ({100 * entry['accuracy']:.0f} %).")
    spotting = facts.scores["spotting"]
    text = f"While you move freely: {spotting['recognised']} of {spotting['takes']} held-out takes noticed"
    if spotting["latency_s"] is not None:
        text += f", {spotting['latency_s']:.1f} s after they began"
    return [*lines, f"{text}. {predicted(facts, facts.rule.threshold)}"]


def predicted(facts: Facts, threshold: float) -> str:
    """How often everyday motion would be taken for a gesture with a threshold, as far as that is known."""
    spotting = facts.scores.get("spotting", {})
    tried = spotting.get("thresholds")
    if not spotting.get("null_hours"):
        return "False triggers: not known. Record everyday motion, best ten minutes, and train again."
    if not tried:
        return "False triggers at other thresholds: not known for this model. Train it again."
    hours, false = spotting["null_hours"], _nearest(tried, threshold)["false_triggers"]
    bound = rate_bound(false, hours)
    seen = f"{false or 'none'} in {60 * hours:.1f} min of held-out everyday motion"
    about = f"about {false / hours:.0f} an hour ({seen})" if false else f"{seen}"
    return f"False triggers: {about}; fewer than {bound:.0f} an hour (95 % sure)."


def noticed(facts: Facts, threshold: float) -> str:
    """How many held-out takes a threshold would notice, where that is known."""
    spotting = facts.scores.get("spotting", {})
    if not spotting.get("thresholds"):
        return ""
    entry = _nearest(spotting["thresholds"], threshold)
    wrong = entry["wrong_or_twice"]
    more = f", {wrong} wrongly or twice" if wrong else ""
    return f"Gestures noticed: {entry['recognised']} of {spotting['takes']} held-out takes{more}."


def _nearest(tried: Sequence[dict[str, Any]], threshold: float) -> dict[str, Any]:
    return min(tried, key=lambda entry: abs(entry["threshold"] - threshold))


def missing_stop(orders: Mapping[str, str], labels: Collection[str]) -> bool:
    """Whether no gesture that the model knows stops the robots."""
    return STOP not in {orders.get(label) for label in labels}


def confusion_table(labels: Sequence[str], table: Sequence[Sequence[int]]) -> str:
    """The confusions as an HTML table: a row per gesture made, a column per gesture recognised."""
    names = [escape(name_of(label)) for label in labels]
    head = "".join(f'<th scope="col">{name}</th>' for name in names)
    rows = []
    for k, (name, counts) in enumerate(zip(names, table, strict=True)):
        cells = "".join(_cell(count, right=k == column) for column, count in enumerate(counts))
        rows.append(f'<tr><th scope="row">{name}</th>{cells}</tr>')
    return (
        '<table class="confusion" aria-label="Held-out takes: gestures made by gestures recognised">'
        f"<tr><td></td>{head}</tr>{''.join(rows)}</table>"
    )


def _cell(count: int, *, right: bool) -> str:
    kind = "right" if right else "wrong" if count else "none"
    return f'<td class="{kind}">{count}</td>'


WIDTH, HEIGHT, LEFT = 640, 110, 54
_KINDS = (("a", "acceleration", "m/s²"), ("g", "rotation", "rad/s"))
_DASHES = {"x": "", "y": "6 3", "z": "2 3"}


def drawing(curves: Curves) -> str:
    """A take's signals as SVG: acceleration and rotation of each band, the gesture shaded, dashes tell the axes."""
    bands = list(dict.fromkeys(name.rpartition("_")[0] for name in curves.columns if name[-2:-1] in ("a", "g")))
    panels = [(band, *kind) for band in bands for kind in _KINDS if f"{band}_{kind[0]}x" in curves.columns]
    drawn = [_panel(curves, number, *panel) for number, panel in enumerate(panels)]
    height = HEIGHT * len(panels) + 24
    end = curves.times[-1] if curves.times else 0.0
    return (
        f'<svg class="take" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="Signals of the take">'
        f"{''.join(drawn)}"
        f'<text x="{LEFT}" y="{height - 6}">0 s</text><text x="{WIDTH - 60}" y="{height - 6}">{end:.1f} s</text></svg>'
    )


def _panel(curves: Curves, number: int, band: str, kind: str, what: str, unit: str) -> str:
    axes = {axis: curves.columns.get(f"{band}_{kind}{axis}", []) for axis in _DASHES}
    most = max((abs(v) for column in axes.values() for v in column if v is not None), default=0.0) or 1.0
    first, span = curves.times[0], max(curves.times[-1] - curves.times[0], 1e-9)
    top, half = number * HEIGHT, HEIGHT / 2 - 12

    def x(t: float) -> float:
        return LEFT + (t - first) / span * (WIDTH - LEFT - 4)

    parts = [f'<text x="0" y="{top + 11}">{escape(band)} band: {what} up to {most:.1f} {unit}</text>']
    if curves.gesture:
        start, end = map(x, curves.gesture)
        parts.append(
            f'<rect class="made" x="{start:.1f}" y="{top + 15}" width="{end - start:.1f}" height="{2 * half:.0f}"/>'
        )
    for axis, column in axes.items():
        points = [
            f"{x(t):.1f},{top + 15 + half - v / most * half:.1f}"
            for t, v in zip(curves.times, column, strict=False)
            if v is not None
        ]
        parts.append(f'<polyline class="{axis}" stroke-dasharray="{_DASHES[axis]}" points="{" ".join(points)}"/>')
    return "".join(parts)
