import asyncio

import pytest

from armspan.config.fleet import Fleet
from armspan.errors import DeviceError, DeviceNotFound
from armspan.records import GoTo, Light, Stop


class Door:
    def __init__(self, failure=None):
        self.taken, self.failure = [], failure

    async def send(self, command):
        if self.failure is not None:
            raise self.failure
        self.taken.append(command)


def test_a_command_goes_to_the_door_of_its_robot_only():
    sea, land = Door(), Door()
    fleet = Fleet({"ash": land, "elm": land, "cod": sea})
    go = GoTo(1.0, "cod", (0.1, 0.1), 0.1, 2.0)
    asyncio.run(fleet.send(go))
    assert (sea.taken, land.taken) == ([go], [])


def test_a_stop_for_all_goes_once_through_every_door():
    sea, land = Door(), Door()
    asyncio.run(Fleet({"ash": land, "elm": land, "cod": sea}).send(Stop(1.0)))
    assert (sea.taken, land.taken) == ([Stop(1.0)], [Stop(1.0)])


def test_a_door_that_fails_keeps_a_stop_from_none_of_the_others():
    broken, land = Door(DeviceError("stuck")), Door()
    with pytest.raises(DeviceError, match="stuck"):
        asyncio.run(Fleet({"cod": broken, "ash": land}).send(Stop(1.0)))
    assert land.taken == [Stop(1.0)]


def test_a_name_that_nobody_has_is_answered_with_those_that_exist():
    with pytest.raises(DeviceNotFound, match=r"'as'.*there are: ash.*Did you mean 'ash'"):
        asyncio.run(Fleet({"ash": Door()}).send(Light(1.0, "as", (1, 2, 3))))
