"""The closing table of a swarm's run in the terminal."""

from typing import Any

from rich.table import Table

from armspan.cli.results import Results


def title(document: dict[str, Any]) -> str:
    """What was run, in one line."""
    width, height = document["sheet_m"]
    plant = {"cellulo": "virtual Cellulo", "disc": "ideal disc", "relay": "Cellulo", "real": "real"}[document["plant"]]
    robots = f"{document['robots']} {plant}{'' if document['robots'] == 1 else 's'}"
    late = f", {document['latency_ms']:g} ms late" if document["latency_ms"] else ""
    how = f"seed {document['seed']}, simulated" if document["simulated"] else "in real time"
    return f"{document['behaviour']}: {robots} on {width:g} x {height:g} m for {document['seconds']:.0f} s{late}, {how}"


def print_run(document: dict[str, Any]) -> None:
    """Print a run's document as a table on stdout, and a verdict."""
    table = Table(title=title(document), show_header=False, title_justify="left")
    table.add_column(style="bold")
    table.add_column()
    for row in _rows(document):
        table.add_row(*row)
    console = Results()
    console.print(table)
    console.print(_verdict(document))


def _rows(document: dict[str, Any]) -> list[tuple[str, str]]:
    covered, paths = document["coverage"], list(document["path_m"]["robots"].values())
    rows = [
        (
            "Covered",
            f"{_percent(covered['share_end'])}; a robot's middle can be where {_percent(covered['coverable'])} "
            f"can be covered; {_percent(covered['overlap'])} more than once",
        ),
        ("Covered, of all", _times(covered)),
        ("Covered, of what can be", _times(covered["of_coverable"])),
    ]
    if document["locational_cost"] is not None:
        rows.append(("Locational cost", f"{document['locational_cost']:.4f} (of the area squared)"))
    rows.append(("Paths", f"{document['path_m']['total']:.2f} m in all, {min(paths):.2f} to {max(paths):.2f} m each"))
    if document["min_gap_mm"] is not None:
        rows.append(("Least gap", f"{document['min_gap_mm']:.1f} mm at {document['min_gap_t']:.1f} s"))
    stuck = document["deadlocks"]
    rows.append(("Stuck robots", "not known: the run is too short" if stuck is None else str(stuck)))
    rows.append(("Collisions", str(document["collisions"])))
    rows.append(("Violations", _violations(document["violations"])))
    if document["stopped"]:
        rows.append(("Stopped robots", "; ".join(f"{robot}: {why}" for robot, why in document["stopped"].items())))
    if document["finished_s"] is not None:
        rows.append(("Finished after", f"{document['finished_s']:.1f} s"))
    return rows + [(name.capitalize(), document[name]) for name in ("log", "picture") if name in document]


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _times(covered: dict[str, Any]) -> str:
    def when(t: float | None) -> str:
        return "never" if t is None else f"{t:.1f} s"

    return ", ".join(f"{share} % {when(covered[f't{share}'])}" for share in (50, 90, 95, 99))


def _violations(kinds: dict[str, int]) -> str:
    return ", ".join(f"{number} x {kind}" for kind, number in kinds.items()) or "0"


def _verdict(document: dict[str, Any]) -> str:
    wrong = [
        f"{number} {what}"
        for what, number in (
            ("collisions", document["collisions"]),
            ("robots stuck", document["deadlocks"]),
            ("robots stopped", len(document["stopped"])),
            ("violations", sum(document["violations"].values())),
        )
        if number
    ]
    done = document["finished_s"]
    went = "went on to the end" if done is None else f"was done after {done:.1f} s"
    return f"{document['behaviour']} {went}, " + (
        f"with {', '.join(wrong)}." if wrong else "without a collision, a violation or a stuck robot."
    )
