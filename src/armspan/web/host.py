"""What the page needs of the rest of the house, which comes to it through this door."""

from typing import Literal, Protocol, TypeAlias

import msgspec

from armspan.body import told
from armspan.conductor import Settings
from armspan.conductor.sight import Sight
from armspan.records import Body
from armspan.web.activities import Activities
from armspan.web.sessions import Sessions
from armspan.web.views.gestures_host import GestureHost

Activity: TypeAlias = Literal["idle", "opening", "steering", "recording", "training", "replaying"]


class Seen(Protocol):
    """What decides in a session, as far as it is shown."""

    settings: Settings

    def sight(self) -> Sight | None:
        """What it believes now, None where there is nothing to show."""


class Status(msgspec.Struct, frozen=True):
    """What is going on: the activity in a word, since when [s, of the process], its log, and what went wrong last."""

    activity: Activity = "idle"
    room: str = ""
    log: str = ""
    trouble: str = ""
    simulated: bool = False


class Device(msgspec.Struct, frozen=True):
    """A band or a robot: is its link up, its battery (share), samples a second, share of them lost; None: not known."""

    name: str
    kind: Literal["band", "robot"]
    where: str
    up: bool
    battery: float | None
    rate_hz: float | None
    lost: float | None
    note: str = ""


class Portrait(msgspec.Struct, frozen=True):
    """A picture of a person or a skeleton file, as it was uploaded: seen from where, its name, what is in it."""

    side: Literal["front", "side"]
    name: str
    data: bytes


class Portraits(msgspec.Struct, frozen=True):
    """What a person is measured by beside typed sizes; ``person`` counts from 1 on the left where there are several.

    With ``marker`` the marker sheet lies on the floor and gives the scale.
    """

    files: tuple[Portrait, ...] = ()
    person: int | None = None
    marker: bool = False


class Measures(msgspec.Struct, frozen=True):
    """A person's measures, what is to be known of how they were found, and PNG pictures with the points drawn in."""

    body: Body
    notes: tuple[str, ...] = ()
    drawn: tuple[tuple[str, bytes], ...] = ()


class Host(Protocol):
    """Runs the activities that the page asks for, one at a time."""

    @property
    def status(self) -> Status:
        """What is going on now."""

    @property
    def settings(self) -> Settings | None:
        """The room as it is now, None where none is open."""

    def devices(self) -> list[Device]:
        """Every band and robot of the room."""

    async def press(self, name: str, value: str = "") -> None:
        """Press a button of the session that runs; a stop is sent at once. Nothing where none runs."""

    async def steer(self) -> None:
        """End what runs and open the room (its trouble is told in ``status``)."""

    @property
    def gestures(self) -> GestureHost:
        """Takes, training and what gestures do."""

    async def close(self) -> None:
        """End what runs: the robots are stopped, the log is whole."""

    @property
    def activities(self) -> Activities:
        """The game master's list, and the room's zones."""

    @property
    def logs(self) -> Sessions:
        """The folder of sessions."""

    @property
    def kept(self) -> dict[str, object]:
        """What views keep for their browsers while those look elsewhere, by a key of the view and the browser."""

    async def measure(self, typed: told.Told, portraits: Portraits) -> Measures:
        """Measure a person; the pictures are deleted at once.

        Raises:
            ConfigError: for sizes that cannot be.
            DataError: for a picture or skeleton file in which the person cannot be measured.
            MissingExtra: where pictures need what is not installed.

        """

    async def lacks_for_pictures(self) -> str:
        """What must be installed to measure pictures, in a sentence; nothing where all is there."""

    def keep_body(self, body: Body) -> None:
        """The room has these measures when it is opened again."""

    def invitation(self) -> str:
        """What to do on phones so that they join as bands, with QR codes of blocks; nothing where there are none."""

    def advice(self) -> list[str]:
        """What a person should mend at the devices, in sentences."""
