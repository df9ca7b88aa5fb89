"""Where results are printed: a terminal, a file or a pipe."""

import sys

from rich.console import Console

WIDE = 160
"""Columns where nobody's window sets a limit."""


class Results(Console):
    """A console on stdout; a reader that has seen enough is no error, and a file is as wide as its tables are."""

    def __init__(self, *, soft_wrap: bool = False, highlight: bool = True) -> None:
        width = None if sys.stdout.isatty() else WIDE
        super().__init__(file=sys.stdout, width=width, soft_wrap=soft_wrap, highlight=highlight)

    def on_broken_pipe(self) -> None:
        """Let the command line end as it does for any reader that is gone."""
        raise BrokenPipeError
