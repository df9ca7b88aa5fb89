"""What a MetaWear board can say: the structs that `wire.decode` makes of its notifications.

Quantities are in the units in which the vendor's library reports them: g, deg/s, microtesla, deg C; numbers are
single precision (MbientLab MetaWear-API, docs/protocol-reference.md; tests of MetaWear-SDK-Cpp 0.30.0).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias

TICK_S: Final = 48 / 32768
"""A tick of the board's clock [s]."""
Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Ranges:
    """What a notification does not tell: the chips' ranges, and what each data processor was made for.

    A processor that is not named gives `Fused` samples where they fit, else `Output`; acc, gyro and mag are
    accounters of that chip. The defaults are the boards'.
    """

    acc_g: float = 2
    gyro_dps: float = 2000
    processors: Mapping[int, Literal["fused", "quaternion", "acc", "gyro", "mag", "raw"]] = field(default_factory=dict)


DEFAULTS: Final = Ranges()
"""As a board wakes."""


@dataclass(frozen=True, slots=True)
class Samples:
    """One sample of a chip, or the three of a packed notification, oldest first: g, deg/s, or microtesla."""

    sensor: Literal["acc", "gyro", "mag"]
    samples: tuple[Vector, ...]


@dataclass(frozen=True, slots=True)
class Fused:
    """Acceleration [g] and angular velocity [deg/s] of one instant, with the board's clock (or its counter)."""

    processor: int
    tick: int
    acc: Vector
    gyro: Vector


@dataclass(frozen=True, slots=True)
class Timed:
    """One chip's sample [g, deg/s, microtesla] with the board's clock (or its counter)."""

    processor: int
    tick: int
    sensor: Literal["acc", "gyro", "mag"]
    vector: Vector


@dataclass(frozen=True, slots=True)
class Quaternion:
    """The fusion's orientation, earth_from_sensor."""

    w: float
    x: float
    y: float
    z: float


@dataclass(frozen=True, slots=True)
class Euler:
    """The fusion's angles [deg]."""

    heading: float
    pitch: float
    roll: float
    yaw: float


@dataclass(frozen=True, slots=True)
class Corrected:
    """A fusion's corrected sample [g, deg/s, microtesla] and its accuracy from 0 to 3."""

    output: Literal["corrected_acc", "corrected_gyro", "corrected_mag"]
    vector: Vector
    accuracy: int


@dataclass(frozen=True, slots=True)
class Acceleration:
    """The fusion's gravity or linear acceleration [g]."""

    output: Literal["gravity", "linear_acc"]
    vector: Vector


@dataclass(frozen=True, slots=True)
class CalibrationState:
    """How well each chip is calibrated, 0 to 3."""

    acc: int
    gyro: int
    mag: int


@dataclass(frozen=True, slots=True)
class CalibrationData:
    """Ten bytes that the firmware keeps of a chip, to be given back later."""

    sensor: Literal["acc", "gyro", "mag"]
    data: bytes


@dataclass(frozen=True, slots=True)
class Switch:
    """The button: 1 pressed, 0 released."""

    state: int


@dataclass(frozen=True, slots=True)
class Tap:
    """A tap on the board and the sign of its direction."""

    kind: Literal["single", "double"]
    sign: int


@dataclass(frozen=True, slots=True)
class Gesture:
    """A BMI270's wrist gesture: 1 arm down, 2 pivot up, 3 shake, 4 flick in, 5 flick out."""

    kind: int
    code: int


@dataclass(frozen=True, slots=True)
class Activity:
    """A BMI270's activity."""

    code: int


@dataclass(frozen=True, slots=True)
class Battery:
    """Charge [%] and voltage [mV]."""

    percent: int
    millivolts: int


@dataclass(frozen=True, slots=True)
class Mac:
    """The board's address."""

    address: str


@dataclass(frozen=True, slots=True)
class Status:
    """Power (1: plugged in) or charge (1: charging) status."""

    what: Literal["power_status", "charge_status"]
    value: int


@dataclass(frozen=True, slots=True)
class LogTime:
    """The board's clock now [ticks] and the number of its last reset."""

    tick: int
    reset_uid: int


@dataclass(frozen=True, slots=True)
class LogLength:
    """How many entries are logged."""

    entries: int


@dataclass(frozen=True, slots=True)
class LogEntry:
    """A logger's four bytes with their tick."""

    logger: int
    reset_uid: int
    tick: int
    data: int


@dataclass(frozen=True, slots=True)
class LogEntries:
    """The one or two entries of a notification."""

    entries: tuple[LogEntry, ...]


@dataclass(frozen=True, slots=True)
class LogProgress:
    """Entries still to come; None: a page is done and waits to be confirmed."""

    left: int | None


@dataclass(frozen=True, slots=True)
class ModuleInfo:
    """How a module is made; None where the board lacks it."""

    module: int
    implementation: int | None
    revision: int | None
    extra: bytes


@dataclass(frozen=True, slots=True)
class Created:
    """The number of what the board was asked to create."""

    what: Literal["processor", "event", "logger", "timer", "macro"]
    number: int


@dataclass(frozen=True, slots=True)
class ChipConfig:
    """How the accelerometer (Hz, g) or the gyro (Hz, deg/s) is set."""

    sensor: Literal["acc", "gyro"]
    rate_hz: float
    range: float


@dataclass(frozen=True, slots=True)
class FusionConfig:
    """How the fusion is set; a range is None where its code is unknown."""

    mode: str
    range_g: float | None
    range_dps: float | None


@dataclass(frozen=True, slots=True)
class Temperature:
    """A channel's temperature [deg C]."""

    channel: int
    celsius: float


@dataclass(frozen=True, slots=True)
class TimerFired:
    """A timer's moment."""

    number: int


@dataclass(frozen=True, slots=True)
class Output:
    """What a data processor gives, whatever it is."""

    processor: int
    data: bytes


Notification: TypeAlias = (
    Samples
    | Fused
    | Timed
    | Quaternion
    | Euler
    | Corrected
    | Acceleration
    | CalibrationState
    | CalibrationData
    | Switch
    | Tap
    | Gesture
    | Activity
    | Battery
    | Mac
    | Status
    | LogTime
    | LogLength
    | LogEntries
    | LogProgress
    | ModuleInfo
    | Created
    | ChipConfig
    | FusionConfig
    | Temperature
    | TimerFired
    | Output
)
