"""What is simulated or replayed, as a room file names it."""

from typing import Literal

import msgspec

from armspan.records import Arm, Quaternion, Vec2


class SimulatedBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="simulated"):
    """A virtual band, on the pointing ``arm`` where not told.

    ``fusion`` tells whether it sends its own quaternion or raw samples only.
    """

    name: str
    segment: Literal["forearm", "upperarm"] = "forearm"
    fusion: Literal["onboard", "raw"] = "onboard"
    wrist_from_sensor: Quaternion | None = None
    arm: Arm | None = None


class ReplayedBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="replay"):
    """A band whose samples come from a log."""

    name: str
    log: str
    segment: Literal["forearm", "upperarm"] = "forearm"
    rate_hz: float = 100.0
    wrist_from_sensor: Quaternion | None = None
    arm: Arm | None = None


class SimulatedRobot(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="simulated"):
    """A virtual robot and where it starts; with a ``receptor`` it notices the laser of a room that has one."""

    name: str
    start_m: Vec2
    heading_deg: float = 0.0
    receptor: bool = False


class ReplayedRobot(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="replay"):
    """A robot whose states come from a log; commands to it go nowhere."""

    name: str
    log: str


class SimulatedPerson(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The virtual person: where they stand in sheet coordinates, what they are asked.

    After the trials they make ``gestures``, labels and ``everyday:SECONDS`` in turn.
    """

    at_m: Vec2 = (0.4, 0.8)
    facing_deg: float = 0.0
    seated: bool = False
    stature_m: float | None = None
    trials: int = 8
    feedback: Literal["off", "on", "both"] = "both"
    gestures: tuple[str, ...] = ()


class Simulation(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The virtual part of a room."""

    seed: int = 0
    table_height_m: float = 0.75
    person: SimulatedPerson = SimulatedPerson()
