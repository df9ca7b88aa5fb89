"""Rooms with a laser: what the file says reaches the conductor and the virtual world."""

import pytest

from armspan.config.demo_room import demo_room
from armspan.config.house import open_house
from armspan.config.room_file import parse_room
from armspan.errors import ConfigError
from armspan.pointing.laser import LaserSettings
from small_rooms import ROOM


def room(laser=None, receptors=(), **more):
    robots = [robot | ({"receptor": True} if robot["name"] in receptors else {}) for robot in ROOM["robots"]]
    table = ROOM | {"robots": robots} | more
    return parse_room(table if laser is None else table | {"laser": laser})


def settings(made):
    return open_house(made).settings


def test_a_room_without_a_laser_has_none():
    house = open_house(room())
    assert house.settings.laser is None
    assert house.world._beam is None


def test_a_laser_is_worn_and_receptors_are_those_of_the_robots_that_have_one():
    house = open_house(room({"direction_deg": [2.0, -10.0], "dwell_s": 0.4}, ["elm"]))
    assert house.settings.laser == LaserSettings(direction_deg=(2.0, -10.0), dwell_s=0.4, receptors=("elm",))
    assert house.world._beam.receptors.robots == ("elm",)


def test_receptors_alone_mean_a_laser_where_it_usually_sits():
    assert settings(room(receptors=["ash", "elm"])).laser == LaserSettings(receptors=("ash", "elm"))


def test_a_laser_without_receptors_is_seen_by_the_person_alone():
    house = open_house(room({}))
    assert house.settings.laser == LaserSettings()
    assert house.world._beam.receptors is None


def test_the_true_laser_is_not_quite_where_it_should_be():
    house = open_house(room({}))
    traits = house.world._beam.laser.traits
    assert traits.position != house.settings.laser.position_m
    again = open_house(room({})).world._beam.laser.traits
    assert again == traits


def test_the_demo_wears_one_where_it_is_asked_to():
    assert open_house(demo_room(3)).settings.laser is None
    house = open_house(demo_room(3, laser=LaserSettings()))
    assert house.settings.laser.receptors == house.settings.robots
    assert demo_room(3, laser=LaserSettings()).robots[0].start_m == demo_room(3).robots[0].start_m


def test_what_cannot_be_is_refused_in_words():
    with pytest.raises(ConfigError, match=r"laser\.dwell_s is 9.0; expected 0\.1 to 2 s"):
        room({"dwell_s": 9.0})
    with pytest.raises(ConfigError, match=r"laser\.receptors: robot 'oak' does not exist; there are: ash, elm"):
        room({"receptors": ["oak"]})
    with pytest.raises(ConfigError, match="at laser: object contains unknown field `colour`"):
        room({"colour": "green"})
