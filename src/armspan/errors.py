"""What can go wrong, in words a person can act on.

    ArmspanError
    ├── ConfigError        a setting or a room file            (also ValueError)
    ├── FrameError         frames that do not fit together     (also ValueError)
    ├── CalibrationError   pairs that cannot place the user    (also ValueError)
    ├── LogError           a session file                      (also ValueError)
    ├── ModelError         a gesture model                     (also ValueError)
    ├── DataError          a recording                         (also ValueError)
    └── DeviceError
        ├── DeviceNotFound
        ├── DeviceLost
        └── MissingExtra                                       (also ImportError)

A message says what is wrong, with its value; what was expected; what to try.
"""

from collections.abc import Iterable
from difflib import get_close_matches


class ArmspanError(Exception):
    """Everything Armspan raises on purpose."""


class ConfigError(ArmspanError, ValueError):
    """A setting or a room file cannot be used as it stands."""


class FrameError(ArmspanError, ValueError):
    """Two frames do not fit together."""


class CalibrationError(ArmspanError, ValueError):
    """The pairs cannot place the user."""


class LogError(ArmspanError, ValueError):
    """A session file cannot be read, or does not replay as it was recorded."""


class ModelError(ArmspanError, ValueError):
    """A gesture model cannot be used."""


class DataError(ArmspanError, ValueError):
    """A recording cannot be used."""


class DeviceError(ArmspanError):
    """A device cannot do its work."""


class DeviceNotFound(DeviceError):
    """A device that the room names does not answer."""


class DeviceLost(DeviceError):
    """A device that a person must mend went away."""


class MissingExtra(DeviceError, ImportError):
    """An optional package is not installed."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(f"{package} is not installed: pip install 'armspan[{extra}]'")


def known_names(what: str, name: str, known: Iterable[str]) -> str:
    """The sentence for a name that does not exist: those that do, the nearest first."""
    names = sorted(known)
    near = get_close_matches(name, names, n=1)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    return f"{what} {name!r} does not exist; there are: {', '.join(names) or 'none'}.{hint}"
