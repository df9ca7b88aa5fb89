from itertools import combinations

import msgspec
import numpy as np
import pytest
import shapely

from armspan.config.demo_room import ROBOTS, SHEET, ZONES, demo_room
from armspan.config.room_file import parse_room


def as_a_file(room):
    """What a room file with this room says: TOML has no null."""
    return {key: value for key, value in msgspec.to_builtins(room).items() if value is not None}


@pytest.mark.parametrize("seed", range(12))
def test_a_demo_room_keeps_its_word(seed):
    room = demo_room(seed)
    assert parse_room(as_a_file(room)) == room
    robots = [shapely.Point(robot.start_m) for robot in room.robots]
    zones = [shapely.Polygon(zone.polygon_m) for zone in room.zones]
    assert (len(robots), len(zones)) == (4, 4)
    assert min(a.distance(b) for a, b in combinations([*robots, *zones], 2)) >= 0.10 - 1e-4
    sheet = shapely.box(0, 0, SHEET.width_m, SHEET.height_m)
    for thing in [*robots, *zones]:
        assert sheet.exterior.distance(thing) > 0.0449
        assert sheet.contains(thing)
    x, y = room.simulation.person.at_m
    assert 0.3 <= x <= 0.6
    assert 0.15 <= y - SHEET.height_m <= 0.35
    assert abs(room.simulation.person.facing_deg) <= 15


def test_names_and_options():
    room = demo_room(3, posture="natural", bands=2, trials=5, feedback="on")
    assert tuple(robot.name for robot in room.robots) == ROBOTS
    assert tuple(zone.name for zone in room.zones) == ZONES
    assert [(band.name, band.segment) for band in room.bands] == [("wrist", "forearm"), ("upperarm", "upperarm")]
    assert (room.posture, room.simulation.person.trials, room.simulation.person.feedback) == ("natural", 5, "on")
    assert len(demo_room(3).bands) == 1


def test_one_seed_is_one_room_whoever_stands_in_it():
    assert demo_room(3) == demo_room(3)
    assert demo_room(3).zones == demo_room(3, bands=2, posture="natural").zones
    assert demo_room(3).robots != demo_room(4).robots
    assert demo_room(3).simulation.seed == 3


def test_the_tape_reads_the_table_within_two_centimetres():
    told = np.array([demo_room(seed).table_height_m for seed in range(20)])
    assert np.abs(told - 0.75).max() < 0.02
    assert told.std() > 0.002
