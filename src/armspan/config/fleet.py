"""All robots and bands of a room behind one door for commands, whatever each of them is."""

import asyncio
from collections.abc import Mapping

from armspan.errors import DeviceNotFound, known_names
from armspan.ports import Swarm
from armspan.records import Command


class Fleet:
    """Sends each command to the door of whom it concerns; ``doors`` are by the names of what is behind them."""

    def __init__(self, doors: Mapping[str, Swarm]) -> None:
        self._doors: dict[str, Swarm] = {}
        self._all: list[Swarm] = []
        self.add(doors)

    def add(self, doors: Mapping[str, Swarm]) -> None:
        """Take more doors in, by the names of what is behind them."""
        self._doors |= doors
        self._all = list({id(door): door for door in self._doors.values()}.values())

    async def send(self, command: Command) -> None:
        """Take a command; one for all robots goes through every door, though one of them fails.

        Raises:
            DeviceNotFound: for a name that nothing here has.

        """
        if command.robot is not None:
            door = self._doors.get(command.robot)
            if door is None:
                raise DeviceNotFound(known_names("robot", command.robot, self._doors))
            await door.send(command)
            return
        told = await asyncio.gather(*(door.send(command) for door in self._all), return_exceptions=True)
        for failure in told:
            if isinstance(failure, BaseException):
                raise failure
