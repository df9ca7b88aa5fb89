"""What the conductor must know of a room: everything that its decisions depend on, and nothing else."""

from typing import Literal

import msgspec

from armspan.errors import ConfigError, known_names
from armspan.pointing.laser import LaserSettings
from armspan.pointing.selection import SelectionSettings
from armspan.records import MODELS, Arm, Body, Model, Quaternion, Sheet, Vec2, Zone
from armspan.swarm.director import DICTIONARY
from armspan.swarm.limits import Limits


class BandSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A band: its name, the segment and arm it sits on, and its mounting where that is known.

    ``arm`` is the pointing arm where not told; a band on the other arm's wrist serves gestures.
    ``wrist_from_sensor`` (w, x, y, z) leaves out the hanging pose of the set-up. After ``stale_s`` [s] of silence a
    band is taken to be lost, and the robots stop: four of a bad radio's intervals between packets, and no more, since
    an arm that is not felt cannot stop them.
    """

    name: str
    segment: Literal["forearm", "upperarm"] = "forearm"
    rate_hz: float = 100.0
    wrist_from_sensor: Quaternion | None = None
    arm: Arm | None = None
    stale_s: float = 0.2

    def __post_init__(self) -> None:
        if not 0.1 <= self.stale_s <= 2.0:
            raise ConfigError(f"band {self.name!r} has stale_s = {self.stale_s}; expected 0.1 to 2 s, 0.2 for most")


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A room as the conductor sees it; kept in the header of every log, so that a log replays by itself.

    ``posture`` is how users are asked to hold the arm; a natural arm bends, and a single band cannot see it.
    ``gestures`` is the dictionary gesture -> behaviour; ``dice`` seeds behaviours that walk at random.
    For ``choice_s`` after robots were chosen by pointing, a gesture commands only these. With a ``laser`` on the wrist
    its beam is the ray, unless another ``model`` is told.
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
    laser: LaserSettings | None = None

    @property
    def beam(self) -> LaserSettings | None:
        """The laser, where its beam is the ray."""
        return self.laser if self.model in (None, "forearm") else None

    def __post_init__(self) -> None:
        _check_names("band", [band.name for band in self.bands])
        _check_names("robot", list(self.robots))
        _check_names("zone", [zone.name for zone in self.zones])
        for robot in self.laser.receptors if self.laser else ():
            if robot not in self.robots:
                raise ConfigError(f"laser.receptors: {known_names('robot', robot, self.robots)}")
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
                "most one on the upper arm; a band on the other wrist says so, as arm = 'left'"
            )
        if self.model == "two-band" and "upperarm" not in segments:
            raise ConfigError("model two-band needs a band on the upper arm; there is none: use head-finger")


def _check_names(what: str, names: list[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ConfigError(f"{what} {twice[0]!r} is named twice; names tell {what}s apart")
