from functools import partial

import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.records import Drive, GoTo, RobotState, Sheet, Zone
from armspan.swarm.director import BEHAVIOURS, DICTIONARY, MAKERS, STOP, Director, behaviour_name, order_name
from armspan.swarm.limits import Limits

SHEET, LIMITS = Sheet(1.2, 0.9), Limits()
ZONES = (
    Zone("garden", ((0.1, 0.1), (0.4, 0.1), (0.4, 0.4), (0.1, 0.4))),
    Zone("harbour", ((0.7, 0.5), (1.0, 0.5), (1.0, 0.8))),
)
PLACES = {"a": (0.2, 0.2), "b": (0.6, 0.2), "c": (0.6, 0.6), "d": (0.9, 0.7)}
STATES = {name: RobotState(0.0, name, xy, 0.0) for name, xy in PLACES.items()}


def director(seed=0):
    return Director(LIMITS, SHEET, ZONES, np.random.default_rng(seed))


@pytest.mark.parametrize("name", sorted(MAKERS))
def test_every_behaviour_begins_by_its_name_and_wishes_for_its_own_robots_only(name):
    one = director()
    some = {robot: STATES[robot] for robot in ("a", "b", "d")}
    one.begin(name, some, user=(0.5, 1.2))
    for k in range(40):
        wishes = one.step(0.05 * k, STATES, (0.5, 0.5))
        assert all(isinstance(wish, GoTo | Drive) for wish in wishes)
        assert len({wish.robot for wish in wishes}) == len(wishes)
        assert {wish.robot for wish in wishes} <= set(some)


def test_the_dictionary_names_behaviours_that_exist_and_one_way_to_stop():
    assert set(DICTIONARY.values()) <= set(BEHAVIOURS)
    assert DICTIONARY["stop"] == STOP
    assert len(set(DICTIONARY.values())) == len(DICTIONARY) == 7


@pytest.mark.parametrize("text", ["random walk", "random-walk", "Random_Walk", " random walk "])
def test_a_name_is_known_however_its_words_are_joined(text):
    assert behaviour_name(text) == "random-walk"


def test_an_order_is_a_behaviour_and_perhaps_a_zone():
    assert order_name("Stop") == "stop"
    assert order_name("sweep@ garden") == "sweep@garden"
    with pytest.raises(ConfigError, match="stop knows no zones"):
        order_name("stop@garden")


def test_an_unknown_name_is_answered_with_those_that_exist():
    with pytest.raises(ConfigError, match=r"dance.*come, deploy.*sweep"):
        behaviour_name("dance")


def test_robots_leave_what_they_did_for_what_they_are_asked_now():
    one = director()
    one.begin("random-walk", STATES)
    one.begin("gather", {robot: STATES[robot] for robot in ("a", "b")})
    assert [(running.name, sorted(running.robots)) for running in one.running] == [
        ("random-walk", ["c", "d"]),
        ("gather", ["a", "b"]),
    ]
    one.begin(STOP, {"c": STATES["c"]})
    assert one.busy == {"a", "b", "d"}
    one.leave(["a", "b", "d"])
    assert one.running == []


def test_a_behaviour_that_cannot_be_done_leaves_the_others_as_they_were():
    one = director()
    one.begin("random-walk", STATES)
    with pytest.raises(ConfigError, match="set up first"):
        one.begin("come", STATES)  # nobody knows where the user is
    assert one.busy == set(STATES)


def test_a_zone_is_covered_where_one_is_named():
    one = director()
    one.begin("sweep@garden", {"a": STATES["a"]})
    wish = one.step(0.0, STATES, None)[0]
    assert 0.1 <= wish.xy[0] <= 0.4
    assert 0.1 <= wish.xy[1] <= 0.4
    with pytest.raises(ConfigError, match=r"zone 'moon'.*garden, harbour"):
        one.begin("sweep@moon", STATES)
    with pytest.raises(ConfigError, match="gather knows no zones"):
        one.begin("gather@garden", STATES)


def test_robots_hold_their_places_until_all_are_done():
    one, states = director(), dict(STATES)
    one.begin("gather", {robot: STATES[robot] for robot in ("a", "b")})
    one.begin("random-walk", {robot: STATES[robot] for robot in ("c", "d")})
    step = partial(one.step, pointed=None)
    for k in range(200):  # robots that are where they wish to be at once
        for wish in step(0.05 * k, states):
            if isinstance(wish, GoTo) and wish.robot in "ab":
                states[wish.robot] = RobotState(0.05 * k, wish.robot, wish.xy, 0.0)
    assert {wish.robot for wish in step(10.0, states)} == {"a", "b", "c", "d"}
    one.leave(["c", "d"])
    step(10.05, states)
    assert one.running == []
