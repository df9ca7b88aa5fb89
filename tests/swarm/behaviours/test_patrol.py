import math
from itertools import pairwise

import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.records import RobotState
from armspan.swarm.behaviours.patrol import Patrol
from ideal_robots import DT, least, run, square, stage, standing, xy

TRIANGLE = [square("pond", 0.2, 0.2), square("hill", 0.8, 0.2), square("lake", 0.8, 0.8)]
MIDDLES = {"pond": (0.2, 0.2), "hill": (0.8, 0.2), "lake": (0.8, 0.8)}


def visits(trace, robot, middles, near=0.02):
    """The zones that a robot came to, in turn."""
    found = []
    for now in trace:
        found += [name for name, at in middles.items() if math.dist(now[robot].xy, at) < near and found[-1:] != [name]]
    return found


def test_a_lone_robot_visits_the_zones_in_turn_at_six_tenths_of_the_speed():
    trace = run(Patrol(stage(zones=TRIANGLE), standing([(0.3, 0.2)])), standing([(0.3, 0.2)]), 50.0)
    assert visits(trace, "a", MIDDLES)[:6] == ["hill", "lake", "pond", "hill", "lake", "pond"]
    # the tour is 0.6 + 0.6 + 0.849 m long: 22.8 s at 0.09 m/s
    at_hill = [tick for tick, now in enumerate(trace) if math.dist(now["a"].xy, (0.8, 0.2)) < 0.01]
    laps = [b for a, b in pairwise(at_hill) if b - a > 100]
    assert laps[0] * DT - at_hill[0] * DT == pytest.approx(22.8, abs=0.3)


def test_several_are_spread_evenly_and_all_visit_all():
    states = standing([(0.3, 0.2), (0.8, 0.5), (0.5, 0.5)])
    trace = run(Patrol(stage(zones=TRIANGLE), states), states, 40.0)
    for robot in "abc":
        assert set(visits(trace, robot, MIDDLES)) == set(MIDDLES)
    # a third of the tour, 0.683 m, goes round the 45 degree corner at worst: 0.683 sin(22.5°) = 0.261 m
    assert min(least(xy(now)) for now in trace[100:]) > 0.261 - 0.02


def test_between_two_zones_they_drive_along_both_sides():
    zones = {"pond": (0.2, 0.5), "hill": (0.8, 0.5)}
    states = standing([(0.2, 0.4), (0.5, 0.5), (0.8, 0.6), (0.3, 0.6)])
    trace = run(Patrol(stage(zones=[square(name, *at) for name, at in zones.items()]), states), states, 60.0)
    for robot in "abcd":
        assert set(visits(trace, robot, zones)) == set(zones)
    assert min(least(xy(now)) for now in trace[100:]) > 0.11
    assert max(abs(xy(now)[:, 1] - 0.5).max() for now in trace[150:]) < 0.0615 + 0.005


def test_round_one_zone_they_drive_in_a_circle():
    states = standing([(0.4, 0.4), (0.6, 0.4), (0.5, 0.6)])
    trace = run(Patrol(stage(zones=[square("pond", 0.5, 0.5)]), states), states, 20.0)
    # 1.6 times 3 pitches: a circle of 0.094 m
    radii = np.array([np.hypot(*(xy(now) - 0.5).T) for now in trace[100:]])
    assert radii == pytest.approx(np.full(radii.shape, 0.094), abs=0.004)
    angle = np.unwrap([math.atan2(*np.subtract(now["a"].xy, 0.5)[::-1]) for now in trace[100:]])
    assert abs(angle[-1] - angle[0]) > 2 * math.pi


def test_the_convoy_waits_for_the_one_behind():
    states = standing([(0.3, 0.2), (0.8, 0.5), (0.5, 0.5)])
    behaviour = Patrol(stage(zones=TRIANGLE), states)
    states = run(behaviour, states, 10.0)[-1]
    away = states | {"c": RobotState(0.0, "c", (0.1, 0.9), 0.0)}
    behaviour.step(10.0, away, None)
    first, later = ([wish.xy for wish in behaviour.step(10.0 + tick * DT, away, None)] for tick in (1, 40))
    assert first == later


def test_a_crowded_convoy_goes_round_the_zones_in_their_order():
    tiny = [square("a", 0.45, 0.45), square("b", 0.55, 0.45), square("c", 0.5, 0.55)]  # clockwise from above
    for zones, sign in ((tiny, 1), (tiny[::-1], -1)):
        states = standing([(0.1 + 0.2 * (i % 3), 0.1 + 0.2 * (i // 3)) for i in range(6)])
        trace = run(Patrol(stage(zones=zones), states), states, 20.0)
        angle = np.unwrap([math.atan2(*np.subtract(now["a"].xy, 0.5)[::-1]) for now in trace[200:]])
        assert sign * (angle[-1] - angle[0]) > 1.0  # y runs down: the angle grows clockwise


def test_at_the_edge_the_loop_between_two_zones_keeps_its_width():
    zones = [square("shore", 0.2, 0.0), square("pier", 0.8, 0.0)]
    states = standing([(0.2, 0.1), (0.5, 0.3), (0.8, 0.1)])
    trace = run(Patrol(stage(zones=zones), states), states, 30.0)
    sides = np.concatenate([xy(now)[:, 1] for now in trace[150:]])
    assert (sides.min(), sides.max()) == pytest.approx((0.045, 0.045 + 0.123), abs=0.004)


def test_a_lone_robot_waits_in_a_lone_zone():
    end = run(Patrol(stage(zones=[square("pond", 0.5, 0.5)]), standing([(0.1, 0.1)])), standing([(0.1, 0.1)]), 6.0)[-1]
    assert end["a"].xy == pytest.approx((0.5, 0.5))


def test_a_zone_at_the_edge_is_visited_as_near_as_robots_can():
    zones = [square("shore", 0.0, 0.5), square("hill", 0.8, 0.5)]
    trace = run(Patrol(stage(zones=zones), standing([(0.3, 0.5)])), standing([(0.3, 0.5)]), 20.0)
    assert min(now["a"].xy[0] for now in trace) == pytest.approx(0.045, abs=0.005)


def test_a_tour_that_crosses_itself_or_is_too_short_keeps_robots_apart():
    bow = [square("a", 0.2, 0.2), square("b", 0.8, 0.8), square("c", 0.8, 0.2), square("d", 0.2, 0.8)]
    tiny = [square("a", 0.45, 0.5), square("b", 0.55, 0.5), square("c", 0.5, 0.58)]
    line = [square("a", 0.2, 0.5), square("b", 0.5, 0.5), square("c", 0.8, 0.5)]
    for zones in (bow, tiny, line):
        states = standing([(0.1 + 0.16 * (i % 5), 0.2 + 0.2 * (i // 5)) for i in range(10)])
        behaviour = Patrol(stage(zones=zones), states)
        for now in run(behaviour, states, 10.0)[::5]:
            wanted = [wish.xy for wish in behaviour.step(11.0, now, None)]
            assert least(wanted) >= 0.12


def test_the_convoy_goes_on_for_ever_through_a_crossing():
    bow = [square("a", 0.2, 0.2), square("b", 0.8, 0.8), square("c", 0.8, 0.2), square("d", 0.2, 0.8)]
    states = standing([(0.2, 0.2), (0.5, 0.2), (0.8, 0.5), (0.2, 0.6), (0.5, 0.8)])
    trace = run(Patrol(stage(zones=bow), states), states, 120.0)
    middles = {zone.name: np.mean(zone.polygon, axis=0) for zone in bow}
    for robot in "abcde":
        assert set(visits(trace, robot, middles)) == set(middles)


def test_a_room_without_zones_is_told():
    with pytest.raises(ConfigError, match="the room has no zones"):
        Patrol(stage(), standing([(0.5, 0.5)]))
