"""What the conductor must know of a room: everything that its decisions depend on, and nothing else."""

from typing import Literal

import msgspec

from armspan.errors import ConfigError, known_names
from armspan.pointing.selection import SelectionSettings
from armspan.records import MODELS, Arm, Body, Model, Quaternion, Sheet, Vec2, Zone
from armspan.swarm.director import DICTIONARY
from armspan.swarm.limits import Limits


class BandSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A band: its name, the segment and arm it sits on, and its mounting where that is known.

    ``arm`` is the pointing arm where not told; a band on the other arm's wrist serves gestures.
    ``wrist_from_sensor`` (w, x, y, z) leaves out the hanging pose of the set-up.
    """

    name: str
    segment: Literal["forearm", "upperarm"] = "forearm"
    rate_hz: float = 100.0
    wrist_from_sensor: Quaternion | None = None
    arm: Arm | None = None


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A room as the conductor sees it; kept in the header of every log, so that a log replays by itself.

    ``posture`` is how users are asked to hold the arm; a natural arm bends, and a single band cannot see it.
    ``gestures`` is the dictionary gesture -> behaviour; ``dice`` seeds behaviours that walk at random.
    For ``choice_s`` after robots were chosen by pointing, a gesture commands only these.
    """

    body: Body
    sheet: Sheet
    bands: tuple[BandSettings, ...]
    robots: tuple[str, ...]
    zones: tuple[Zone, ...] = ()
    stops: tuple[Vec2, ...] = ()
    model: Model | None = None
    posture: Literal["straight", "natural"] = "straight"
    table_height_m: float | None = None
    light_height_m: float = 0.045
    led_zero_deg: float = 0.0
    limits: Limits = Limits()
    selection: SelectionSettings = SelectionSettings()
    feedback: bool = False
    gestures: dict[str, str] = msgspec.field(default_factory=DICTIONARY.copy)
    dice: int = 0
    choice_s: float = 8.0

    def __post_init__(self) -> None:
        _check_names("band", [band.name for band in self.bands])
        _check_names("robot", list(self.robots))
        _check_names("zone", [zone.name for zone in self.zones])
        if self.model is not None and self.model not in MODELS:
            raise ConfigError(known_names("Model", self.model, MODELS))
        if not self.bands:
            return  # a room of robots only, in which nobody points
        segments = [band.segment for band in self.bands if (band.arm or self.body.arm) == self.body.arm]
        others = [band.segment for band in self.bands if (band.arm or self.body.arm) != self.body.arm]
        if others not in ([], ["forearm"]):
            raise ConfigError(
                f"bands on the other arm sit on {', '.join(others)}; gestures need one there, on the forearm"
            )
        if segments.count("forearm") != 1 or segments.count("upperarm") > 1:
            raise ConfigError(
                f"bands sit on {', '.join(segments) or 'nothing'}; pointing needs one band on the forearm and at "
                "most one on the upper arm"
            )
        if self.model == "two-band" and "upperarm" not in segments:
            raise ConfigError("model two-band needs a band on the upper arm; there is none: use head-finger")


def _check_names(what: str, names: list[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ConfigError(f"{what} {twice[0]!r} is named twice; names tell {what}s apart")
