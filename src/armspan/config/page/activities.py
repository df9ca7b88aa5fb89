"""The game master's list, led: what is asked of the robots is pressed in the session, and so is in its log."""

from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path

import msgspec

from armspan.conductor import Settings
from armspan.config.page.zones import rezoned
from armspan.errors import ConfigError, known_names
from armspan.records import Stop, Zone
from armspan.swarm.director import STOP, order_name
from armspan.web.activities import Act, Agenda, Turn, in_words
from armspan.web.host import Seen

PAUSED = "told to rest"
"""Why a robot waits after a pause."""


class ActivityList:
    """The list of one room, kept in ``file``.

    ``mind`` is what decides in the session that runs, None where none does; ``press`` reaches it; ``keep`` is told the
    zones that a room opened next time has.
    """

    def __init__(
        self,
        file: Path,
        mind: Callable[[], Seen | None],
        press: Callable[[str, str], Awaitable[None]],
        keep: Callable[[Sequence[Zone]], None],
    ) -> None:
        self._file, self._mind, self._press, self._keep = file, mind, press, keep
        self._agenda: Agenda | None = None

    @property
    def agenda(self) -> Agenda:
        """The list now: as kept, or else what the room's gestures can ask for."""
        if self._agenda is None:
            settings = self._settings
            if settings is None:
                return Agenda()
            self._agenda = self._read() or Agenda(usual(settings))
        return self._agenda

    async def arrange(self, acts: Sequence[Act]) -> None:
        """Put another list in its place; the activity whose turn it was keeps its turn, wherever it is now."""
        settings, old = self._room(), self.agenda
        acts = tuple(checked(act, settings) for act in acts)
        turn = old.acts[old.place] if old.acts else None
        place = acts.index(turn) if turn in acts else min(old.place, max(0, len(acts) - 1))
        state = old.state if turn in acts else "ready"
        self._agenda = msgspec.structs.replace(old, acts=acts, place=place, state=state, note="")
        self._write()

    async def lead(self, turn: Turn) -> None:
        """Begin the activity whose turn it is, let its robots rest, or go to another one and begin it."""
        place = self.agenda.place
        match turn:
            case "pause":
                await self._rest(self._room().robots)
                self._agenda = msgspec.structs.replace(self.agenda, state="paused")
            case "start":
                await self.choose(place)
            case "next":
                await self.choose(place + 1)
            case "previous":
                await self.choose(place - 1)

    async def choose(self, place: int) -> None:
        """Begin the activity at a place."""
        self._room()
        acts = self.agenda.acts
        if not 0 <= place < len(acts):
            raise ConfigError("There is no such activity in the list: add one" if acts else "The list has no activity")
        await self._begin(acts[place].order, acts[place].robots)
        self._agenda = msgspec.structs.replace(self.agenda, place=place, state="begun")

    async def behave(self, order: str) -> None:
        """Let the robots that take part do something that is not in the list."""
        await self._begin(order, ())
        self._agenda = msgspec.structs.replace(self.agenda, state="ready")

    async def leave_out(self, robot: str, out: bool) -> None:
        """Let a robot take part no more (it comes to rest), or again."""
        left = set(self.agenda.out) - {robot} | ({robot} if out else set())
        self._agenda = msgspec.structs.replace(self.agenda, out=tuple(sorted(left)))
        if out:
            await self._rest([robot])

    async def rezone(self, zones: Sequence[Zone], renamed: tuple[str, str] | None = None) -> None:
        """Change the room's zones, and the activities that are for one that was renamed."""
        settings = self._room()
        acts = [_renamed(act, renamed) for act in self.agenda.acts]
        value = rezoned(settings, zones, acts)
        await self._press("zones", value)
        self._keep(zones)
        if acts != list(self.agenda.acts):
            self._agenda = msgspec.structs.replace(self.agenda, acts=tuple(acts))
            self._write()

    @property
    def _settings(self) -> Settings | None:
        mind = self._mind()
        return mind.settings if mind is not None else None

    def _room(self) -> Settings:
        settings = self._settings
        if settings is None:
            raise ConfigError("No room is open, so there is nobody to do it: open the room first")
        return settings

    async def _begin(self, order: str, robots: Sequence[str]) -> None:
        settings, mind = self._room(), self._mind()
        sight = mind.sight() if mind is not None else None
        if sight is not None and sight.stopped:
            raise ConfigError("The robots are stopped: press Resume all, then begin again")
        order = checked(Act("", order, tuple(robots)), settings).order
        taking = [robot for robot in robots or settings.robots if robot not in self.agenda.out]
        if not taking:
            raise ConfigError("None of these robots takes part: tick one")
        only = "" if len(taking) == len(settings.robots) else ":" + ",".join(taking)
        await self._press("behaviour", order + only)

    async def _rest(self, robots: Sequence[str]) -> None:
        """Robots come to rest; nothing is latched, the next thing asked of them begins."""
        for robot in robots:
            await self._press("command", msgspec.json.encode(Stop(0.0, robot, PAUSED)).decode())

    def _read(self) -> Agenda | None:
        try:
            acts = msgspec.json.decode(self._file.read_bytes(), type=tuple[Act, ...])
        except FileNotFoundError:
            return None
        except (OSError, msgspec.DecodeError) as error:
            settings = self._settings
            note = f"The list kept in {self._file} cannot be read ({error}), so this is the usual one"
            return Agenda(usual(settings) if settings else (), note=note)
        return Agenda(acts)

    def _write(self) -> None:
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            self._file.write_bytes(msgspec.json.format(msgspec.json.encode(self.agenda.acts)))
        except OSError as error:
            raise ConfigError(f"The list holds for now, but cannot be kept: {self._file}: {error.strerror}") from None


def usual(settings: Settings) -> tuple[Act, ...]:
    """The activities of a room where nobody made a list: what its gestures can ask for."""
    orders = dict.fromkeys(order for order in settings.gestures.values() if order != STOP)
    return tuple(Act(in_words(order), order) for order in orders)


def checked(act: Act, settings: Settings) -> Act:
    """An activity that can be done in a room; without a name it gets one (ConfigError)."""
    order = order_name(act.order)
    zone = order.partition("@")[2]
    names = [known.name for known in settings.zones]
    if zone and zone not in names:
        raise ConfigError(f"{act.name or in_words(order)}: {known_names('zone', zone, names)}")
    for robot in act.robots:
        if robot not in settings.robots:
            raise ConfigError(f"{act.name or in_words(order)}: {known_names('robot', robot, settings.robots)}")
    return Act(act.name.strip() or in_words(order), order, act.robots)


def _renamed(act: Act, renamed: tuple[str, str] | None) -> Act:
    name, at, zone = act.order.partition("@")
    if renamed is None or not at or zone != renamed[0]:
        return act
    words = in_words(f"{name}@{renamed[1]}") if act.name == in_words(act.order) else act.name
    return Act(words, f"{name}@{renamed[1]}", act.robots)
