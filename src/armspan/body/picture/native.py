"""What libraries write on stderr by themselves, past Python: LiteRT's greeting, a codec's complaint."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO

_STDERR = 2


@contextmanager
def stderr_kept() -> Iterator[IO[bytes]]:
    """Keep what this process writes on stderr meanwhile in a file, and yield it; afterwards stderr is as it was.

    Errors are raised as ever. Where no stderr is open nothing is kept.
    """
    with tempfile.TemporaryFile() as said:
        try:
            before = os.dup(_STDERR)
        except OSError:
            yield said
            return
        os.dup2(said.fileno(), _STDERR)
        try:
            yield said
        finally:
            os.dup2(before, _STDERR)
            os.close(before)
