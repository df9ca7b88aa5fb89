"""Runs what the page asks for, one activity at a time, in the page's own loop."""

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import TypeAlias

import msgspec

from armspan.body.told import Told
from armspan.conductor import Settings
from armspan.config.house import House, open_house
from armspan.config.page import measures
from armspan.config.page.activities import ActivityList
from armspan.config.page.devices import advice_of, devices_of, invitation_of
from armspan.config.page.gestures import Gestures
from armspan.config.page.logs import LogShelf
from armspan.config.page.zones import entries
from armspan.config.room_file import RoomFile
from armspan.config.session_files import fresh_log, make_folder
from armspan.errors import ArmspanError
from armspan.log import LogWriter
from armspan.ports import Sink
from armspan.records import Body, Zone
from armspan.session import Session
from armspan.web.host import Activity, Device, Measures, Portraits, Seen, Status
from armspan.web.shown import Shown

Run: TypeAlias = Callable[[Session], Awaitable[None]]


class PageHost:
    """The activities of one room: ``sessions`` is the folder of its logs, ``folder`` that of its room file.

    Takes lie in ``takes``, beside the sessions unless told otherwise. A virtual room goes ``speed`` times as
    fast as the clock.

    What goes wrong in an activity is told in ``status.trouble``; the robots were stopped then, and the log is whole.
    """

    def __init__(
        self,
        room: RoomFile,
        name: str,
        *,
        folder: Path = Path(),
        sessions: Path = Path("sessions"),
        takes: Path | None = None,
        speed: float = 1.0,
    ) -> None:
        self.room, self.name, self.folder, self.sessions, self.speed = room, name, folder, sessions, speed
        self.shown = Shown()
        self.house: House | None = None
        self.session: Session | None = None
        self.kept: dict[str, object] = {}
        self._status = Status(room=name)
        self._task: asyncio.Task[None] | None = None
        self._turn = asyncio.Lock()
        self.begun = 0
        self.gestures = Gestures(self, takes or sessions.parent / "takes")
        self.activities = ActivityList(sessions / f"{name}.activities.json", self._steering, self.press, self._keep)
        self.logs = LogShelf(self)

    @property
    def status(self) -> Status:
        """What is going on now."""
        return self._status

    @property
    def settings(self) -> Settings | None:
        """The room as it is now."""
        return self.shown.mind.settings if self.shown.mind is not None else None

    def devices(self) -> list[Device]:
        """Every band and robot of the room."""
        return devices_of(self.house, self.shown)

    async def measure(self, typed: Told, portraits: Portraits) -> Measures:
        """Measure a person."""
        return await asyncio.to_thread(measures.measured, typed, portraits)

    async def lacks_for_pictures(self) -> str:
        """What must be installed to measure pictures."""
        return await asyncio.to_thread(measures.lacks)

    def keep_body(self, body: Body) -> None:
        """The room has these measures when it is opened again."""
        self.room = msgspec.structs.replace(self.room, body=measures.entry(body))

    def invitation(self) -> str:
        """What to do on phones."""
        return invitation_of(self.house.doors) if self.house is not None else ""

    def advice(self) -> list[str]:
        """What a person should mend at the devices."""
        return advice_of(self.house.doors) if self.house is not None else []

    async def press(self, name: str, value: str = "") -> None:
        """Press a button of the session that runs."""
        if self.session is not None:
            await self.session.press(name, value)

    async def steer(self) -> None:
        """End what runs and open the room."""
        await self.begin("steering", self.open_room)

    async def begin(self, activity: Activity, work: Callable[[], Awaitable[None]]) -> None:
        """End what runs, then let ``work`` run as ``activity`` until it ends or the next one begins."""
        async with self._turn:
            self.begun += 1
            await self._end()
            self.tell(activity=activity, trouble="")
            self._task = asyncio.create_task(self._run(work))

    async def close(self) -> None:
        """End what runs: the robots are stopped, the log is whole."""
        await self.gestures.close()
        self.logs.close()
        async with self._turn:
            await self._end()

    def tell(self, **changes: object) -> None:
        """Change the status."""
        self._status = msgspec.structs.replace(self._status, **changes)

    async def _end(self) -> None:
        if self._task is not None:
            self._task.cancel()
            await asyncio.wait([self._task])
            self._task = None

    async def _run(self, work: Callable[[], Awaitable[None]]) -> None:
        trouble = ""
        try:
            await work()
        except ArmspanError as error:
            trouble = str(error)
        except Exception as error:  # a mistake of ours: the page goes on, and says so
            trouble = (
                f"Armspan itself failed ({type(error).__name__}: {error}); the robots were stopped. Please report this"
            )
        finally:
            self.house = self.session = None
            self.shown.clear(None)
            self.tell(activity="idle", trouble=trouble)

    async def open_room(self) -> None:
        """Open the room until its session ends; for activities that have ended."""
        self.tell(activity="opening")
        house = await asyncio.to_thread(open_house, self.room, self.folder, guided=True)
        house.lead.waits = True
        await self.play(house, "steering", fresh_log(self.name, self.sessions))

    async def play(
        self, house: House, activity: Activity, path: Path, sinks: Sequence[Sink] = (), run: Run | None = None
    ) -> None:
        """Run a house's session, or let ``run`` do so, into a log and ``sinks``, shown on the page."""
        make_folder(path.parent)
        with LogWriter(path, house.header) as log:
            session = house.session([log, *sinks, self.shown])
            mind = session.conductor
            self.house, self.session = house, session
            self.shown.clear(mind, simulated=house.world is not None and house.world.person is not None)  # type: ignore[arg-type]
            self.tell(activity=activity, log=str(path), simulated=self.shown.simulated)
            await (house.run(session, live=True, times=self.speed) if run is None else run(session))

    def _steering(self) -> Seen | None:
        """What decides, where robots are steered."""
        return self.shown.mind if self._status.activity == "steering" else None

    def _keep(self, zones: Sequence[Zone]) -> None:
        """The room has these zones when it is opened again."""
        self.room = msgspec.structs.replace(self.room, zones=entries(zones))
