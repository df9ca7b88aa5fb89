"""``armspan check``: what is installed, what is missing, and how to get it."""

import argparse
import importlib.metadata
import platform
import re

import msgspec
from rich.console import Console
from rich.table import Table


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "check",
        help="what is installed, which extras are missing and how to get them",
        description="Say what is installed, which optional parts are missing, and how to get them.",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print what is there; the exit code is 1 when a package of the base install is missing."""
    rows = installed()
    if args.json:
        print(msgspec.json.encode({"python": platform.python_version(), "packages": rows}).decode())
    else:
        _show(rows)
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
            row["get"] or "",
        )
    Console().print(table)
