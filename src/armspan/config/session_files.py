"""Where the logs of sessions go."""

import datetime
from pathlib import Path

from armspan.errors import LogError

SESSIONS = Path("sessions")
"""The folder of logs, where no other is named."""


def fresh_log(what: str, folder: Path = SESSIONS) -> Path:
    """A name for a log that does not exist yet."""
    stem = f"{datetime.datetime.now():%Y-%m-%d_%H%M%S}_{what}"
    names = [folder / f"{stem}{more}.mcap" for more in ("", *(f"_{k}" for k in range(2, 100)))]
    return next(name for name in names if not name.exists())


def make_folder(folder: Path) -> None:
    """A folder for what is written, made where there is none (LogError)."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LogError(f"{folder} cannot be a folder ({error.strerror}): choose another place") from None
