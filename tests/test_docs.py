"""Every block of code in the README and the docs does what it says: Python runs, commands and files can be read."""

import re
import shlex
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

from armspan.cli import parser
from armspan.config.body_file import body_from_table
from armspan.config.room_file import parse_room
from command_line import code_of
from small_rooms import played

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
PLAIN, SHELL = ("", "text"), ("sh", "console")
"""Languages of blocks that are drawings and may hold commands, and that are commands."""

FENCE = re.compile(
    r"^(?P<indent> *)```(?P<language>\w*)[^\n]*\n(?P<text>.*?)^(?P=indent)```$", re.MULTILINE | re.DOTALL
)


class Block(NamedTuple):
    page: str
    line: int
    language: str
    text: str


def blocks_in(page: str, text: str) -> list[Block]:
    return [
        Block(
            page,
            text[: found.start()].count("\n") + 1,
            found["language"],
            re.sub(rf"^{found['indent']}", "", found["text"], flags=re.MULTILINE),
        )
        for found in FENCE.finditer(text)
    ]


def blocks(*languages):
    found = [block for page in PAGES for block in blocks_in(str(page.relative_to(ROOT)), page.read_text("utf-8"))]
    return [block for block in found if not languages or block.language in languages]


def commands(block: Block) -> list[list[str]]:
    """The words of each command line; comments are left out, continued lines joined, pipes and lists taken apart."""
    lines = [line.removeprefix("$ ") for line in block.text.replace("\\\n", " ").splitlines()]
    if block.language in PLAIN:
        lines = [line for line in lines if line.startswith(("armspan ", "make "))]
    words = [shlex.split(line, comments=True) for line in lines]
    split = [part for line in words for part in _parts(line)]
    return [line for line in split if line]


def _parts(words):
    part = []
    for word in words:
        if word in ("|", "&&", ";", ">"):
            yield part
            part = []
        else:
            part.append(word)
    yield part


def test_every_block_is_of_a_kind_that_is_tried_here():
    known = {*SHELL, *PLAIN, "python", "toml"}
    assert [block for block in blocks() if block.language not in known] == []
    fences = sum(len(re.findall(r"^ *```", page.read_text("utf-8"), re.MULTILINE)) for page in PAGES)
    assert fences == 2 * len(blocks())


def test_python_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sessions").mkdir()
    (tmp_path / "sessions" / "first.mcap").write_bytes(played().data)
    for page in PAGES:
        names = {"__name__": "__main__"}  # a page is read from top to bottom
        for block in (b for b in blocks("python") if b.page == str(page.relative_to(ROOT))):
            code = "\n" * block.line + block.text  # so that a traceback names the page's own lines
            exec(compile(code, block.page, "exec"), names)


def test_commands_can_be_parsed():
    for block in blocks(*SHELL, *PLAIN):
        for words in commands(block):
            program = Path(words[0]).name
            if program == "armspan":
                parsed(block, words[1:])
            elif program == "make":
                assert re.search(rf"^{words[1]}:", (ROOT / "Makefile").read_text(), re.MULTILINE), (block, words)
            elif program == "python" and words[1].endswith(".py"):
                assert (ROOT / words[1]).is_file(), (block, words)


def parsed(block, words):
    try:
        parser().parse_args(words)
    except SystemExit as end:
        if end.code != 0:  # --help and --version end with 0
            pytest.fail(f"{block.page}, line {block.line}: armspan {' '.join(words)} is not understood")


def test_calibrating_the_examples_works_as_shown(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    shown = [
        words[1:] for block in blocks(*SHELL) for words in commands(block) if words[:2] == ["armspan", "calibrate"]
    ]
    for words in shown:
        assert code_of(*words) == 0, (words, capsys.readouterr().err)


def test_settings_files_can_be_read():
    for block in blocks("toml"):
        document = tomllib.loads(block.text)
        if "robots" in document and "bands" in document:
            parse_room(document)
        elif "body" in document:
            body_from_table(document["body"], block.page)


def test_links_between_pages_lead_somewhere():
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text("utf-8")):
            if "://" not in link:
                assert (page.parent / link).exists(), (page, link)


def test_the_readme_shows_the_two_commands_of_a_fresh_machine():
    lines = [words for block in blocks(*SHELL) if block.page == "README.md" for words in commands(block)]
    assert ["make", "demo"] in lines
    assert ["make", "test"] in lines


# --- the reader of blocks itself ---------------------------------------------------------------------------

PAGE = """\
Text
```sh
$ armspan demo --seed 3 \\
    --json  # a comment
armspan replay a.mcap | head
```
1. a list
   ```python
   x = 1
   ```
"""


def test_blocks_are_found_with_their_lines():
    shell, python = blocks_in("p.md", PAGE)
    assert (shell.line, shell.language) == (2, "sh")
    assert (python.line, python.language, python.text) == (8, "python", "x = 1\n")


def test_commands_are_joined_and_taken_apart():
    shell, _ = blocks_in("p.md", PAGE)
    assert commands(shell) == [
        ["armspan", "demo", "--seed", "3", "--json"],
        ["armspan", "replay", "a.mcap"],
        ["head"],
    ]
    assert commands(Block("p.md", 1, "", "| it's a drawing\nmake demo\n")) == [["make", "demo"]]


def test_a_wrong_command_fails():
    with pytest.raises(pytest.fail.Exception, match="armspan fly is not understood"):
        parsed(Block("p.md", 2, "sh", ""), ["fly"])
