"""The records that cross walls: small, frozen, compared with ``==``; floats, strings and tuples, never arrays.

What happened is an *event* (`Event`); what is decided is an *output* (`Output`); what makes a robot do
something is a *command* (`Command`, a subset of the outputs). ``t`` is always session seconds at which the
thing was measured or decided; units are SI and radians; a vector's frame is told by its record.
"""

import math
from typing import Literal, TypeAlias

import msgspec

Vec2: TypeAlias = tuple[float, float]
Vec3: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]
Covariance2: TypeAlias = tuple[Vec2, Vec2]
Colour: TypeAlias = tuple[int, int, int]
Arm: TypeAlias = Literal["left", "right"]
Model: TypeAlias = Literal["head-finger", "shoulder-finger", "forearm", "two-band"]

MODELS: tuple[Model, ...] = ("head-finger", "shoulder-finger", "forearm", "two-band")


class Record(msgspec.Struct, frozen=True, gc=False, tag_field="type", tag=True):
    """Anything that crosses a wall, at session time ``t`` [s]."""

    t: float


# --- events: what happened -------------------------------------------------------------------------------


class ImuSample(Record, frozen=True, gc=False):
    """One sample of a band: specific force [m/s²], rate [rad/s], field [µT], in ``sensor``.

    ``quat`` is the band's own fusion, ``earth_from_sensor`` as (w, x, y, z), where it has one.
    """

    source: str
    acc: Vec3
    gyr: Vec3
    mag: Vec3 | None = None
    quat: Quaternion | None = None


class Tap(Record, frozen=True, gc=False):
    """A band's button, pressed ``count`` times in a row."""

    source: str
    count: int = 1


class RobotState(Record, frozen=True, gc=False):
    """Where a robot is: ``xy`` [m] and ``heading`` [rad, clockwise from above] in ``sheet``.

    ``held`` means lifted off the sheet (kidnapped); ``battery`` is a share from 0 to 1, None if unknown.
    """

    robot: str
    xy: Vec2
    heading: float
    held: bool = False
    battery: float | None = None


class Touch(Record, frozen=True, gc=False):
    """A robot's key."""

    robot: str
    key: int
    kind: Literal["began", "long", "released"]


class Hit(Record, frozen=True, gc=False):
    """A receptor on a robot sees the laser, or sees it no more."""

    robot: str
    on: bool


class Link(Record, frozen=True, gc=False):
    """A device came or went.

    One that comes back ``fresh`` began anew: what was known of its heading is void.
    """

    source: str
    up: bool
    fresh: bool = False


class Press(Record, frozen=True, gc=False):
    """A button on the page, a key, a ROS service, a script: ``name`` and what it carries."""

    name: str
    value: str = ""


class Tick(Record, frozen=True, gc=False):
    """Twenty a second, so that time-outs are data."""


# --- outputs: what is decided ----------------------------------------------------------------------------


class Pointed(Record, frozen=True, gc=False):
    """Where the user points now: ``xy`` [m] with its covariance [m²] in ``sheet``, and at what.

    ``robot`` or ``zone`` name the most probable candidate and ``probability`` is its posterior, whatever it
    is: below the gate the user has not been understood yet ("undecided"). ``xy`` is None where there is no
    answer, and ``refused`` says why.
    """

    source: str
    xy: Vec2 | None
    covariance: Covariance2 | None
    robot: str | None = None
    zone: str | None = None
    probability: float = 0.0
    decided: bool = False
    refused: str | None = None


class Selected(Record, frozen=True, gc=False):
    """The user chose a robot or a zone, with the posterior it had, by dwell, tap or hit."""

    source: str
    robot: str | None
    zone: str | None
    probability: float
    how: Literal["dwell", "tap", "hit"]


class Gesture(Record, frozen=True, gc=False):
    """An arm gesture was recognised; it began at ``started`` [s]."""

    started: float
    source: str
    label: str
    score: float


class Scores(Record, frozen=True, gc=False):
    """The posterior over gesture labels, ten a second, for confidence bars."""

    source: str
    labels: tuple[str, ...]
    probabilities: tuple[float, ...]


class Calibrated(Record, frozen=True, gc=False):
    """``sheet_from_user`` was found or refined: p_sheet = diag(1, -1, -1) Rz(yaw) p_user + xyz.

    ``covariance`` is 4×4 over (x, y, z, yaw), row by row [m², m·rad, rad²]; ``rms`` [rad] is the residual
    angle and ``sigma`` [rad] the pointing noise per axis that the pairs showed.
    """

    source: str
    xyz: Vec3
    yaw: float
    covariance: tuple[float, ...]
    rms: float
    sigma: float
    pairs: int


class GoTo(Record, frozen=True, gc=False):
    """Drive a robot to ``xy`` [m] in ``sheet`` at most at ``speed`` [m/s]; void after ``until`` [s]."""

    robot: str
    xy: Vec2
    speed: float
    until: float
    heading: float | None = None


class Drive(Record, frozen=True, gc=False):
    """Move a robot at a velocity [m/s] in ``sheet`` and a turn rate [rad/s]; void after ``until`` [s]."""

    robot: str
    velocity: Vec2
    turn: float
    until: float


class Light(Record, frozen=True, gc=False):
    """Colour (0 to 255 each) of a robot's lights, of one of them where ``led`` is told."""

    robot: str
    colour: Colour
    led: int | None = None


class Haptic(Record, frozen=True, gc=False):
    """A robot or a band vibrates at ``strength`` (0 to 1) for ``duration`` [s]."""

    robot: str
    strength: float
    duration: float


class Stop(Record, frozen=True, gc=False):
    """A robot stops, all robots where ``robot`` is None."""

    robot: str | None = None
    why: str = ""


class Say(Record, frozen=True, gc=False):
    """What the person should do now, in words; ``cue`` is the same for machines, as ``verb:object``."""

    text: str
    cue: str = ""


class TakeEnded(Record, frozen=True, gc=False):
    """A take was recorded; its gesture began at ``started`` [s]. One for ``practice`` is not learnt from."""

    started: float
    label: str
    person: str
    number: int
    practice: bool = False


Event: TypeAlias = ImuSample | Tap | RobotState | Touch | Hit | Link | Press | Tick
Command: TypeAlias = GoTo | Drive | Light | Haptic | Stop
Output: TypeAlias = Pointed | Selected | Gesture | Scores | Calibrated | Say | TakeEnded | Command
EVENTS: tuple[type[Record], ...] = (ImuSample, Tap, RobotState, Touch, Hit, Link, Press, Tick)
COMMANDS: tuple[type[Record], ...] = (GoTo, Drive, Light, Haptic, Stop)
OUTPUTS: tuple[type[Record], ...] = (Pointed, Selected, Gesture, Scores, Calibrated, Say, TakeEnded, *COMMANDS)


# --- what several crafts share ---------------------------------------------------------------------------


class Body(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A person's measures [m], with the report's five first.

    ``shoulder_to_eye_m`` runs from the pointing shoulder's pivot to the dominant eye as (forward, left, up);
    the fingertip is that of the straight arm. ``covariance`` is over (eye height, forward, left, up, arm
    length) row by row [m²], where it is known.
    """

    eye_height_m: float
    shoulder_to_eye_m: Vec3
    shoulder_to_fingertip_m: float
    arm: Arm = "right"
    upper_arm_m: float | None = None
    elbow_to_fingertip_m: float | None = None
    covariance: tuple[float, ...] | None = None


class Zone(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A named polygon [m] on the sheet that can be pointed at."""

    name: str
    polygon: tuple[Vec2, ...]


class Sheet(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The printed sheet: its size [m] and where its corner lies in the robots' own coordinates [m]."""

    width_m: float
    height_m: float
    origin_m: Vec2 = (0.0, 0.0)


def is_finite(record: Record) -> bool:
    """Whether every number in a record is finite."""
    return _finite(msgspec.structs.astuple(record))


def _finite(values: tuple[object, ...]) -> bool:
    for value in values:  # asked of every record: a plain loop is twice as fast as all()
        if isinstance(value, float):
            if not math.isfinite(value):
                return False
        elif isinstance(value, tuple) and not _finite(value):
            return False
    return True
