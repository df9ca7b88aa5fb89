"""How tests call the command line."""

import os
import subprocess
import sys
from pathlib import Path

from armspan.cli import main


def code_of(*words) -> int:
    """The exit code of a command line, also where argparse ends it."""
    try:
        return main([str(word) for word in words])
    except SystemExit as end:
        return end.code


def contents(folder: Path) -> dict[Path, bytes | None]:
    """Everything under a folder: a file's bytes, None for a folder."""
    return {path: path.read_bytes() if path.is_file() else None for path in sorted(folder.rglob("*"))}


def refused(capsys, folder, *words) -> str:
    """The sentence with which bad input is refused: one line on stderr, nothing on stdout, no file touched."""
    capsys.readouterr()
    before = contents(folder)
    code = code_of(*words)
    out, err = capsys.readouterr()
    assert code == 2, err
    assert out == ""
    assert len(err.splitlines()) == 1, err
    assert err.startswith(f"armspan {words[0]}: "), err
    assert contents(folder) == before
    return err


def fresh(*words, cwd=None, **environment):
    """Start ``python WORDS`` in a new interpreter; stdout and stderr are kept as text."""
    return subprocess.Popen(
        [sys.executable, *map(str, words)],
        cwd=cwd,
        env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"} | environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def toml(value) -> str:
    """A value as TOML writes it in line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(value)


def written_room(path: Path, room: dict) -> Path:
    """A room file with these entries."""
    path.write_text("".join(f"{key} = {toml(value)}\n" for key, value in room.items()), encoding="utf-8")
    return path
