"""What the view of gestures needs of the rest of the house."""

from typing import Protocol

import msgspec

from armspan.gesture.model import Facts, GestureModel


class Asked(msgspec.Struct, frozen=True):
    """A recording as it is asked for: gestures, ``takes`` of each, seconds of everyday motion.

    With ``taps`` a double click of a band begins and ends a take. ``hurried``: a virtual person may be quick.
    """

    gestures: tuple[str, ...]
    takes: int
    person: str
    null_s: float = 0.0
    taps: bool = False
    hurried: bool = False


class TakeRow(msgspec.Struct, frozen=True):
    """A take in the list: ``key`` is its place in the folder; without ``seconds`` it could not be read."""

    key: str
    label: str
    person: str
    number: int
    recorded: str
    seconds: float | None
    practice: bool
    simulated: bool
    note: str

    @property
    def counts(self) -> bool:
        """Whether a training learns from it."""
        return self.seconds is not None and not self.practice and not self.note


class Curves(msgspec.Struct, frozen=True):
    """A take's signals, thinned: ``times`` [s], a list of numbers per column (None: missing), the gesture's span."""

    times: list[float]
    columns: dict[str, list[float | None]]
    gesture: tuple[float, float] | None


class Job(msgspec.Struct, frozen=True):
    """A training: does it run, what it is at, which share of that is done, and what went wrong."""

    runs: bool = False
    what: str = ""
    share: float = 0.0
    trouble: str = ""


class Trained(msgspec.Struct, frozen=True):
    """A model that was trained: its file, and what it says of itself."""

    path: str
    facts: Facts


class GestureHost(Protocol):
    """Records, lists, trains; what cannot be is an `ArmspanError` in one sentence."""

    @property
    def simulated(self) -> bool:
        """Whether a virtual person wears the bands."""

    @property
    def wrists(self) -> tuple[str, ...]:
        """The wrists that wear a band."""

    @property
    def progress(self) -> tuple[int, int] | None:
        """Takes finished and asked for in the recording that runs, None where none does."""

    async def record(self, asked: Asked) -> None:
        """End what runs and record; afterwards the room is opened again."""

    @property
    def stamp(self) -> int:
        """Another number whenever the folder of takes has changed."""

    async def takes(self) -> list[TakeRow]:
        """All takes, by gesture, person and number."""

    async def curves(self, key: str) -> Curves:
        """One take's signals."""

    async def delete(self, key: str) -> str:
        """Put a take aside; returns where it is kept."""

    @property
    def job(self) -> Job:
        """The training that runs, or the last one."""

    async def train(self) -> None:
        """Begin to train on all takes, in a process of its own."""

    def cancel(self) -> None:
        """End the training that runs."""

    @property
    def trained(self) -> Trained | None:
        """The model trained last."""

    @property
    def used(self) -> bool:
        """Whether the room has the model trained last already."""

    async def use(self) -> None:
        """Open the room anew with the model trained last."""

    @property
    def model(self) -> GestureModel | None:
        """The model that spots gestures now, with its threshold as it was set last."""

    async def keep(self) -> None:
        """Keep dictionary and threshold for the sessions to come, as long as the page is served."""
