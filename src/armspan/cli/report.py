"""The closing table of a session in the terminal."""

from typing import Any

from rich.table import Table

from armspan.cli.results import Results


def print_account(document: dict[str, Any], title: str = "What the session showed") -> None:
    """Print an account's document, as `Account.document` gives it, on stdout."""
    table = Table(title=title, show_header=False, title_justify="left")
    table.add_column(style="bold")
    table.add_column()
    for row in _rows(document):
        table.add_row(*row)
    Results().print(table)


def _rows(document: dict[str, Any]) -> list[tuple[str, str]]:
    pointing = document["pointing"]
    rows = [("Calibration", _calibration(document["calibration"]))]
    for name, part in (
        ("Pointing, no cursor", "without_feedback"),
        ("Pointing, cursor shown", "with_feedback"),
    ):
        if pointing[part]["trials"]:
            rows.append((name, _pointing(pointing[part])))
    selection = document["selection"]
    if selection["shown"]:
        rows.append(
            (
                "Selection",
                f"{selection['decided']} of {selection['shown']} decided, {selection['right']} of these right, "
                f"{selection['unasked']} unasked",
            )
        )
    if "gestures" in document:
        rows.append(("Gestures", _gestures(document["gestures"])))
    rows.append(("Safety", _safety(document["safety"])))
    step = document.get("step_us", {})
    if step.get("p50") is not None:
        rows.append(("Conductor's step", f"median {step['p50']:.0f} µs, 99 % below {step['p99']:.0f} µs"))
    rows += [(name.capitalize(), str(document[name])) for name in ("log", "picture") if document.get(name)]
    return rows


def _calibration(found: dict[str, Any]) -> str:
    if not found["found"]:
        return "none"
    text = f"residual {found['rms_deg']:.1f}° over {found['pairs']} stops"
    if found.get("sheet_rms_mm") is not None:
        text += f" (taken as the eye's true line: {found['sheet_rms_mm']:.0f} mm; it absorbs this person's habits)"
    return text


def _pointing(part: dict[str, Any]) -> str:
    if part["median_mm"] is None:
        return f"no spot in {part['trials']} trials"
    return (
        f"median {part['median_mm']:.0f} mm ({part['median_deg']:.1f}°), 90 % within {part['p90_mm']:.0f} mm; "
        f"{part['right']} of {part['trials']} right, {part['median_s']:.1f} s each"
    )


def _gestures(found: dict[str, Any]) -> str:
    score = found["score"]
    if score is None:
        return f"{found['recognised']} recognised"
    text = f"{score['hits']} of {score['gestures']} recognised, {score['substitutions']} taken for another"
    text += f", {score['insertions'] + score['duplicates']} that were not made"
    return text + (f"; {score['latency_s'][0]:.1f} s after the onset (median)" if score["latency_s"] else "")


def _safety(safety: dict[str, Any]) -> str:
    kinds = ", ".join(f"{count} x {kind}" for kind, count in safety["kinds"].items())
    gap = f"; nearest two robots {safety['least_gap_mm']:.0f} mm apart" if safety["least_gap_mm"] is not None else ""
    return f"{safety['violations']} violations{': ' + kinds if kinds else ''}{gap}"
