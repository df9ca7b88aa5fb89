import math

import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.records import RobotState
from armspan.swarm.behaviours.leader import Leader
from ideal_robots import DT, least, moved, run, stage, standing, xy

THREE = np.array([(0.4, 0.4), (0.2, 0.4), (0.4, 0.25)])


@pytest.mark.parametrize(("name", "number"), [(None, 0), ("b", 1)])
def test_the_leader_goes_to_the_spot_and_the_others_keep_their_offsets(name, number):
    behaviour = Leader(stage(), states := standing(THREE), leader=name)
    trace = run(behaviour, states, 10.0, pointed=(0.6, 0.7))
    assert not behaviour.done
    assert xy(trace[-1]) == pytest.approx(THREE - THREE[number] + [0.6, 0.7], abs=1e-3)
    for now in trace:  # on the way too: all are as fast as the leader
        assert xy(now) - xy(now)[number] == pytest.approx(THREE - THREE[number], abs=0.01)


def test_a_leader_pushed_by_hand_is_followed_and_left_alone():
    behaviour, states = Leader(stage(), standing(THREE)), standing(THREE)
    for tick in range(100):
        hand = (0.4 + 0.003 * min(tick, 60), 0.4)  # 60 mm/s for 3 s
        states["a"] = RobotState(tick * DT, "a", hand, 0.0)
        wishes = behaviour.step(tick * DT, states, None)
        assert [wish.robot for wish in wishes] == ["b", "c"]
        states = moved(states, wishes)
    assert xy(states) == pytest.approx(THREE + np.array([0.18, 0.0]), abs=1e-3)


def test_at_the_edge_followers_stand_as_near_to_their_places_as_there_is_room():
    end = xy(run(Leader(stage(), standing(THREE)), standing(THREE), 10.0, pointed=(0.0, 0.0))[-1])
    assert end[0] == pytest.approx([0.045, 0.045], abs=1e-3)
    assert least(end) >= 0.12 - 1e-3
    # "b" and "c" would both be off the sheet; each goes to where the leader and the edges let it
    assert np.hypot(*(end[1:] - end[0]).T).max() < 0.3


def test_followers_that_are_pressed_against_the_edge_do_not_jump():
    here = stage()
    rows = [(0.2 + 0.2 * (i % 4), 0.25 + 0.25 * (i // 4)) for i in range(12)]
    behaviour, states, before = Leader(here, standing(rows)), standing(rows), None
    for tick in range(400):
        turn = 0.01 * tick  # two thirds round, 5 cm from the edges at the nearest, at 90 mm/s
        wishes = behaviour.step(tick * DT, states, (0.5 + 0.45 * math.cos(turn), 0.5 + 0.45 * math.sin(turn)))
        states, wanted = moved(states, wishes), np.array([wish.xy for wish in wishes])
        if before is not None:
            assert np.hypot(*(wanted - before).T).max() < 0.06  # half a pitch: two may have to change sides
        before = wanted


def test_followers_hold_while_the_leader_is_away_and_go_on_with_their_old_offsets():
    behaviour = Leader(stage(), states := standing(THREE))
    states = run(behaviour, states, 1.0, pointed=(0.6, 0.7))[-1]
    followers = {name: states[name] for name in "bc"}
    for tick in range(5):
        wishes = behaviour.step(1.0 + tick * DT, followers, (0.9, 0.1))
        assert {wish.robot: wish.xy for wish in wishes} == {name: states[name].xy for name in "bc"}
    elsewhere = {"a": states["a"]} | standing([(0.8, 0.8), (0.3, 0.9), (0.9, 0.3)]) | {"a": states["a"]}
    end = xy(run(behaviour, elsewhere, 15.0, pointed=(0.6, 0.7))[-1])
    assert end == pytest.approx(THREE - THREE[0] + [0.6, 0.7], abs=1e-3)


def test_a_robot_that_comes_later_keeps_the_offset_it_came_with():
    behaviour = Leader(stage(), standing(THREE))
    behaviour.step(0.0, standing(THREE[:2]), None)
    late = standing([*THREE[:2], (0.6, 0.6)])
    end = xy(run(behaviour, late, 10.0, pointed=(0.5, 0.5))[-1])
    assert end[2] == pytest.approx([0.7, 0.7], abs=1e-3)


def test_wishes_never_lie_on_each_other_wherever_the_spot_is():
    behaviour = Leader(stage(), standing(THREE))
    for tick, spot in enumerate(map(tuple, THREE)):  # also on a follower's own place
        wanted = [wish.xy for wish in behaviour.step(tick * DT, standing(THREE), spot)]
        assert least(wanted) >= 0.12
        assert math.dist(wanted[0], THREE[0]) <= 0.09 + 1e-9


def test_wishes_are_two_leads_ahead():
    wanted = [wish.xy for wish in Leader(stage(), standing(THREE)).step(0.0, standing(THREE), (0.9, 0.4))]
    assert np.array(wanted) == pytest.approx(THREE + np.array([0.09, 0.0]))


def test_a_leader_that_is_not_there_is_refused():
    with pytest.raises(ConfigError, match="leader 'zoe' does not exist; there are: a, b, c"):
        Leader(stage(), standing(THREE), leader="zoe")
