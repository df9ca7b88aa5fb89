"""``armspan check``: what is installed, what is missing, and how to get it."""

import argparse
import asyncio
import importlib.metadata
import platform
import re

import msgspec
from rich.markup import escape
from rich.table import Column, Table

from armspan.cli.results import Results
from armspan.cli.run import positive
from armspan.config.survey import Survey, survey
from armspan.links.hci import radio_named


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "check",
        help="what is installed and in reach, what is missing and how to get it",
        description="Say what is installed, which optional parts are missing and how to get them; with --scan, which "
        "bands and robots are in reach, or why there are none.",
    )
    parser.add_argument(
        "--scan",
        type=positive,
        nargs="?",
        const=5.0,
        metavar="S",
        help="also look for bands and robots for S seconds (5): addresses, batteries, firmware; or why there are none",
    )
    parser.add_argument(
        "--radio", metavar="R", help="scan with this one: hci1, or bumble:TRANSPORT, as in a room file's radio"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print what is there; the exit code is 1 when a package of the base install is missing."""
    rows = installed()
    seen = asyncio.run(survey(args.scan, radio_named(args.radio))) if args.scan else None
    if args.json:
        document = {"python": platform.python_version(), "packages": rows}
        print(msgspec.json.encode(document | ({"scan": seen} if seen else {})).decode())
    else:
        _show_reach(seen) if seen else _show(rows)
    return 1 if any(row["version"] is None and row["extra"] is None for row in rows) else 0


def installed() -> list[dict[str, str | None]]:
    """Every package Armspan can use: name, extra (None: base install), version (None: missing), how to get it."""
    rows: list[dict[str, str | None]] = []
    for requirement in importlib.metadata.requires("armspan") or []:
        match = re.match(r"([A-Za-z0-9_.-]+)[^;]*(?:;.*extra == [\"'](\w+)[\"'])?", requirement)
        if match is None:
            continue
        name, extra = match.group(1), match.group(2)
        get = f"pip install 'armspan[{extra}]'" if extra else "pip install armspan"
        version = _version(name)
        rows.append({"package": name, "extra": extra, "version": version, "get": None if version else get})
    return rows


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _show(rows: list[dict[str, str | None]]) -> None:
    table = Table("package", "part of", "version", "to get it", title=f"Python {platform.python_version()}")
    for row in rows:
        table.add_row(
            row["package"],
            f"extra {row['extra']}" if row["extra"] else "base install",
            row["version"] or "missing",
            escape(row["get"] or ""),
        )
    Results().print(table)


def _show_reach(seen: Survey) -> None:
    """A table of what was found, and a line for each door behind which nothing can be heard."""
    table = Table("kind", Column("address", no_wrap=True), title="In reach")
    for name in ("name", "signal", "battery", "firmware", "note"):
        table.add_column(name)
    for found in seen.found:
        table.add_row(
            found.kind,
            found.address,
            found.name or "",
            "" if found.signal is None else f"{found.signal} dBm",
            "" if found.battery is None else f"{100 * found.battery:.0f} %",
            found.firmware or "",
            found.note,
        )
    console = Results()
    console.print(table if seen.found else "Nothing is in reach.")
    for missing in seen.missing:
        console.print(f"{missing.door}: {missing.why}", markup=False, highlight=False)
