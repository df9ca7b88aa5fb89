"""What logs are told by."""

from collections.abc import Mapping

_TOLD = (
    ("Selected", "selection", "selections"),
    ("Gesture", "gesture", "gestures"),
    ("TakeEnded", "take", "takes"),
    ("Calibrated", "calibration", "calibrations"),
    ("Stop", "stop", "stops"),
)


def happened_words(counts: Mapping[str, int]) -> str:
    """What happened in a session, from its records by type."""
    parts = [f"{n} {one if n == 1 else many}" for kind, one, many in _TOLD if (n := counts.get(kind, 0))]
    return ", ".join(parts) or "nothing was chosen, made or stopped"


def length_words(seconds: float | None) -> str:
    """A length of time: minutes and seconds."""
    if seconds is None:
        return "not known"
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d} min"


def size_words(size: int) -> str:
    """A file's size."""
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.0f} kB"
