import math

import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.swarm.behaviours.rotate import Rotate
from ideal_robots import DT, least, moved, run, stage, standing, xy

PAIR = [(0.4, 0.5), (0.6, 0.5)]


@pytest.mark.parametrize(("turn", "y"), [(1, 0.4), (-1, 0.6)])
def test_left_is_counter_clockwise_from_above(turn, y):
    # y runs down the print: the right robot of a pair goes up the print when the pair turns left
    behaviour = Rotate(stage(), standing(PAIR), turn=turn)
    end = xy(run(behaviour, standing(PAIR))[-1])
    assert behaviour.done
    assert end == pytest.approx(np.array([[0.5, 1.0 - y], [0.5, y]]), abs=0.008)


def test_the_rim_moves_at_six_tenths_of_the_speed():
    # a quarter of a circle of 0.1 m is 0.157 m: 1.745 s at 0.09 m/s
    seconds = (len(run(Rotate(stage(), standing(PAIR)), standing(PAIR))) - 1) * DT
    assert 1.745 - 0.1 <= seconds <= 1.745 + 0.15


def test_the_angle_can_be_told():
    end = xy(run(Rotate(stage(), standing(PAIR), angle=math.pi), standing(PAIR))[-1])
    assert end == pytest.approx(np.array(PAIR[::-1]), abs=0.008)


def test_a_robot_in_the_middle_stays_and_the_shape_with_it():
    cross = [(0.5, 0.5), (0.7, 0.5), (0.3, 0.5), (0.5, 0.35), (0.5, 0.65)]
    trace = run(Rotate(stage(), standing(cross)), standing(cross))
    assert all(now["a"].xy == (0.5, 0.5) for now in trace)
    assert xy(trace[-1])[1:] == pytest.approx(np.array([(0.5, 0.3), (0.5, 0.7), (0.35, 0.5), (0.65, 0.5)]), abs=0.008)
    assert min(least(xy(now)) for now in trace) > 0.14  # 0.15 while they stand


def test_nobody_is_left_behind():
    start = standing(PAIR)
    trace = run(Rotate(stage(), start), start, speeds={"b": 0.02})
    arms = [np.subtract(now["b"].xy, 0.5) for now in trace]
    others = [np.subtract(0.5, now["a"].xy) for now in trace]
    bends = [
        math.acos(np.clip(a @ b / math.hypot(*a) / math.hypot(*b), -1, 1)) for a, b in zip(arms, others, strict=True)
    ]
    # 45 mm behind on a circle of 100 mm, and a tick
    assert max(bends) < 2 * math.asin(0.225) + 0.05
    assert len(trace) * DT > 0.1 / 0.02  # the slow one has 0.14 m to go as the crow flies, 0.157 m along the circle
    assert xy(trace[-1]) == pytest.approx(np.array([[0.5, 0.6], [0.5, 0.4]]), abs=0.008)


def test_a_robot_that_stands_still_stops_the_turn():
    behaviour = Rotate(stage(), states := standing(PAIR))
    for tick in range(200):
        wishes = behaviour.step(tick * DT, states, None)
        states = moved(states, [wish for wish in wishes if wish.robot == "a"])
    assert not behaviour.done
    assert math.dist(wishes[1].xy, states["b"].xy) < 0.045 + 0.005


def test_a_formation_at_the_edge_is_shifted_first():
    edge = standing([(0.1, 0.045), (0.4, 0.045)])  # a circle of 0.15 m fits 0.195 m from the edge
    end = xy(run(Rotate(stage(), edge), edge)[-1])
    assert end == pytest.approx(np.array([[0.25, 0.345], [0.25, 0.045]]), abs=0.008)


def test_a_formation_wider_than_the_sheet_is_drawn_together():
    wide = standing([(0.1, 0.25), (0.5, 0.25), (0.9, 0.25)])  # 0.41 m of the 0.5 m are there for centres
    end = xy(run(Rotate(stage(1.0, 0.5), wide), wide)[-1])
    assert end == pytest.approx(np.array([[0.5, 0.455], [0.5, 0.25], [0.5, 0.045]]), abs=0.008)


def test_a_row_that_cannot_turn_closes_up():
    row = standing(
        [(0.2 + 0.125 * i, 0.25) for i in range(6)]
    )  # half of 0.625 m on 0.205 m: 82 mm from each to the next
    behaviour = Rotate(stage(1.0, 0.5), row)
    end = xy(run(behaviour, row)[-1])
    assert behaviour.done
    assert least(end) >= 0.12 - 0.016
    assert np.hypot(*(end - end.mean(axis=0)).T).max() < 0.14


def test_it_goes_on_without_the_one_that_leaves_and_turns_no_more_than_told():
    three = [(0.3, 0.5), (0.7, 0.5), (0.5, 0.5)]
    behaviour = Rotate(stage(), standing(three))
    states = run(behaviour, standing(three), seconds=1.5)[-1]
    pair = {name: states[name] for name in "ab"}
    end = xy(run(behaviour, pair)[-1])
    assert behaviour.done
    assert end == pytest.approx(np.array([[0.5, 0.7], [0.5, 0.3]]), abs=0.06)  # what lay behind then is kept


def test_a_lone_robot_is_done_where_it_is():
    behaviour = Rotate(stage(), standing([(0.3, 0.3)]))
    end = run(behaviour, standing([(0.3, 0.3)]))[-1]
    assert behaviour.done
    assert end["a"].xy == (0.3, 0.3)


def test_robots_without_room_to_turn_are_refused():
    # 0.21 m for centres: a ring of five is 0.2093 m wide, six need 0.246 m
    with pytest.raises(ConfigError, match=r"6 robots have no room to turn .* at most 5 have"):
        Rotate(stage(0.3, 0.3), standing([(0.1, 0.1)] * 6))
    Rotate(stage(0.3, 0.3), standing([(0.1, 0.1)] * 5))


@pytest.mark.parametrize("wrong", [{"turn": 0}, {"turn": 2}, {"angle": 0.0}, {"angle": math.nan}])
def test_a_turn_that_is_none_is_refused(wrong):
    with pytest.raises(ConfigError, match="expected"):
        Rotate(stage(), standing(PAIR), **wrong)
