"""Behind the view of gestures: record, list, train, use."""

import asyncio
import datetime
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from armspan.conductor import Conductor
from armspan.config.model_files import write_model
from armspan.config.page.recording import Recorded, ready
from armspan.config.page.takes import TakeFolder
from armspan.config.page.training import Training
from armspan.config.record_room import is_simulated, wrists_of
from armspan.config.session_files import fresh_log
from armspan.errors import ConfigError
from armspan.gesture.model import GestureModel
from armspan.gesture.takes import NULL
from armspan.swarm.director import DICTIONARY, STOP
from armspan.web.views.gestures_host import Asked, Curves, Job, TakeRow, Trained

if TYPE_CHECKING:
    from armspan.config.page.host import PageHost


class Gestures:
    """Takes lie in ``takes``, models are written to ``models`` beside it."""

    def __init__(self, page: "PageHost", takes: Path) -> None:
        self._page, self._models = page, takes.parent / "models"
        self._folder = TakeFolder(takes)
        self._training = Training()
        self._recorded: Recorded | None = None
        self._used = ""

    @property
    def simulated(self) -> bool:
        """Whether a virtual person wears the bands."""
        return is_simulated(self._page.room)

    @property
    def wrists(self) -> tuple[str, ...]:
        """The wrists that wear a band."""
        return wrists_of(self._page.room)

    # --- takes -------------------------------------------------------------------------------------------

    @property
    def progress(self) -> tuple[int, int] | None:
        """Takes finished and asked for in the recording that runs."""
        return self._recorded.progress if self._recorded is not None else None

    async def record(self, asked: Asked) -> None:
        """End what runs and record; afterwards the room is opened again."""
        if self._recorded is not None:
            raise ConfigError("a recording goes on: end it before the next one")
        self._check_no_training()
        page = self._page
        recorded = await asyncio.to_thread(ready, page.room, page.folder, self._folder.folder, asked)
        await page.begin("recording", lambda: self._record(recorded))

    async def _record(self, recorded: Recorded) -> None:
        self._recorded = recorded
        page = self._page
        try:
            await page.play(
                recorded.house, "recording", fresh_log("record", page.sessions), sinks=[recorded], run=recorded.run
            )
        finally:
            self._recorded = None
        await page.open_room()

    @property
    def stamp(self) -> int:
        """Another number whenever the folder of takes has changed."""
        return self._folder.stamp

    async def takes(self) -> list[TakeRow]:
        """All takes."""
        return await asyncio.to_thread(self._folder.rows)

    async def curves(self, key: str) -> Curves:
        """One take's signals."""
        return await asyncio.to_thread(self._folder.curves, key)

    async def delete(self, key: str) -> str:
        """Put a take aside."""
        self._check_no_training()
        return str(await asyncio.to_thread(self._folder.delete, key))

    # --- training ----------------------------------------------------------------------------------------

    @property
    def job(self) -> Job:
        """The training that runs, or the last one."""
        return self._training.job

    @property
    def trained(self) -> Trained | None:
        """The model trained last."""
        return self._training.trained

    async def train(self) -> None:
        """Begin to train on all takes."""
        self._check_no_training()
        if self._recorded is not None:
            raise ConfigError("a recording goes on: train when it is over, so that all its takes count")
        check_enough(await self.takes())
        self._training.start(self._folder.folder, self._fresh_model())

    def cancel(self) -> None:
        """End the training that runs."""
        self._training.cancel()

    async def close(self) -> None:
        """End the training that runs, and wait for its end."""
        await self._training.close()

    def _check_no_training(self) -> None:
        if self._training.job.runs:
            raise ConfigError("a training goes on: wait for it, or cancel it")

    def _fresh_model(self) -> Path:
        stem = f"{datetime.datetime.now():%Y-%m-%d_%H%M%S}"
        names = [self._models / f"{stem}{more}.model" for more in ("", *(f"_{k}" for k in range(2, 100)))]
        return next(name for name in names if not name.exists()).resolve()

    # --- use ---------------------------------------------------------------------------------------------

    @property
    def model(self) -> GestureModel | None:
        """The model that spots gestures now."""
        mind = self._page.shown.mind
        return mind.model if isinstance(mind, Conductor) else None

    @property
    def used(self) -> bool:
        """Whether the room has the model trained last already."""
        return self.trained is not None and self._used == self.trained.path

    async def use(self) -> None:
        """Open the room anew with the model trained last."""
        trained = self._training.trained
        if trained is None:
            raise ConfigError("no model was trained yet: record takes and train first")
        if self._recorded is not None:
            raise ConfigError("a recording goes on: end it first")
        before = self.model.facts.labels if self.model is not None else ()
        orders = known_orders(self._page.room.gestures.behaviours, before, trained.facts.labels)
        self._choose(trained.path, orders)
        self._used = trained.path
        await self._page.steer()

    async def keep(self) -> None:
        """Keep dictionary and threshold for the sessions to come; a model with another threshold is a new file."""
        if self._page.session is not None:
            await self._page.session.caught_up()
        settings, model = self._page.settings, self.model
        if settings is None or self._recorded is not None:
            raise ConfigError("no room is open: open it, then keep what it does")
        house, path = self._page.house, self._page.room.gestures.model
        if model is not None and house is not None and house.model is not model:
            target = self._fresh_model()
            target.parent.mkdir(parents=True, exist_ok=True)
            await asyncio.to_thread(write_model, target, model)
            path, house.model = str(target), model
        self._choose(path, settings.gestures)

    def _choose(self, model: str | None, orders: Mapping[str, str]) -> None:
        room = self._page.room
        entry = msgspec.structs.replace(room.gestures, model=model, behaviours=dict(orders))
        self._page.room = msgspec.structs.replace(room, gestures=entry)


def known_orders(orders: Mapping[str, str], before: tuple[str, ...], labels: tuple[str, ...]) -> dict[str, str]:
    """What of a dictionary holds for a model's gestures, and the usual orders for those that are new to the room.

    ``before`` are the gestures that the room knew. Where none would stop the robots, it is the usual dictionary.
    """
    fresh = {label: order for label, order in DICTIONARY.items() if label not in before}
    known = {label: order for label, order in (fresh | dict(orders)).items() if label in labels}
    return known if STOP in known.values() else DICTIONARY.copy()


def check_enough(rows: list[TakeRow]) -> None:
    """Refuse to train on what cannot be learnt from (ConfigError)."""
    counts: dict[str, int] = {}
    for row in rows:
        if row.counts and row.label != NULL:
            counts[row.label] = counts.get(row.label, 0) + 1
    if not counts:
        why = "those that are there are for practice, spoilt, or everyday motion" if rows else "none was recorded yet"
        raise ConfigError(f"there is no take of a gesture to learn from ({why}): record two gestures, five takes each")
    if len(counts) == 1:
        raise ConfigError(f"all takes are of one gesture, {next(iter(counts))}: record a second one to tell it from")
    few = [label for label, count in counts.items() if count < 2]
    if few:
        raise ConfigError(f"there is one take only of {', '.join(few)}: record one more at least, better five")
