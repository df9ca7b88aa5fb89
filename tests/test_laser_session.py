"""A whole session with a laser on the wrist: choices by hits, and a log that replays."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from armspan.cli.play import play
from armspan.cli.replay import first_difference
from armspan.config.house import open_house
from armspan.config.recalled import settings_of
from armspan.config.room_file import parse_room
from armspan.log import read
from armspan.records import Calibrated, Hit, Selected
from small_rooms import ROOM

ROBOTS = [robot | {"receptor": True} for robot in ROOM["robots"]]
PERSON = ROOM["simulation"]["person"] | {"trials": 3, "feedback": "off"}


@cache
def played(number=0):
    """The session's bytes and its log; another ``number`` plays it anew."""
    room = parse_room(ROOM | {"robots": ROBOTS, "simulation": ROOM["simulation"] | {"person": PERSON}})
    with TemporaryDirectory() as folder:
        path = Path(folder) / "laser.mcap"
        play(open_house(room, seconds=90), path, live=False)
        return path.read_bytes(), read(path)


def of(kind):
    return [record for record in played()[1].records if isinstance(record, kind)]


def test_the_robots_notice_the_spot_and_one_is_chosen_by_it():
    assert len(of(Calibrated)) >= 1
    assert {hit.robot for hit in of(Hit)} == {"ash", "elm"}
    by_hit = [chosen for chosen in of(Selected) if chosen.how == "hit"]
    assert by_hit
    assert all(chosen.probability >= 0.8 for chosen in by_hit)


def test_a_choice_by_hit_is_made_while_the_robot_is_hit_and_teaches_the_place():
    lit, since = set(), {}
    taught = {found.t for found in of(Calibrated)}
    for record in played()[1].records:
        if isinstance(record, Hit):
            (lit.add if record.on else lit.discard)(record.robot)
            since[record.robot] = record.t
        elif isinstance(record, Selected) and record.how == "hit":
            assert record.robot in lit
            assert record.t - since[record.robot] >= 0.3 - 1e-6
            assert record.t in taught


def test_it_replays_as_it_was_decided():
    _, log = played()
    assert first_difference(log, settings_of(log)) is None


@pytest.mark.parametrize("number", [1])
def test_it_is_the_same_again(number):
    assert played(number)[0] == played()[0]
