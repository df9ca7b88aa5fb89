import json
import math
import time

import numpy as np
import pytest

from armspan.errors import DataError, DeviceNotFound
from armspan.records import Drive, GoTo, RobotState, Sheet, Stop
from armspan.simulation.discs import IdealDiscs
from armspan.study.safety import BODY, SafetyWatch
from armspan.study.swarm import SwarmAccount, deadlocks, path_lengths
from armspan.swarm.limits import Limits

SHEET, LIMITS = Sheet(1.0, 1.0), Limits()
GONE = (math.nan, math.nan)


def names(n):
    return [f"disc{i}" for i in range(n)]


def account(*ways, every=1.0, body=0.0375, begin=0.0, **more):
    """One robot for each way, a place every so often."""
    found = SwarmAccount(names(len(ways)), SHEET, LIMITS, body=body, **more)
    for k, places in enumerate(zip(*ways, strict=True)):
        found.take(begin + every * k, places)
    return found


def goto(x, y, robot="disc0", t=0.0, speed=0.1):
    return GoTo(t, robot, (x, y), speed, t + 0.3)


# --- gaps and collisions ----------------------------------------------------------------------------------


def test_the_least_gap_is_between_bodies_and_between_two_takes():
    # Two lanes 100 mm apart; they pass each other half way between the second take and the third, 30 s after the first.
    found = account(
        [(0.1, 0.4), (0.3, 0.4), (0.5, 0.4), (0.7, 0.4)],
        [(0.7, 0.5), (0.5, 0.5), (0.3, 0.5), (0.1, 0.5)],
        every=20.0,
        begin=7.0,
    )
    least = found.gaps.least
    assert least.gap == pytest.approx(0.1 - 0.075)
    assert least.t == pytest.approx(40.0)  # the take that it came before
    assert found.document()["min_gap_mm"] == 25.0
    assert found.document()["min_gap_t"] == 40.0
    assert found.gaps.series[0].gap == pytest.approx(math.hypot(0.6, 0.1) - 0.075)
    assert found.gaps.collisions == 0


def test_a_pair_collides_once_for_every_time_that_it_comes_to_overlap():
    far, near, nearer = (0.5, 0.5), (0.44, 0.5), (0.43, 0.5)
    found = account([far, near, nearer, far, far, near, far], [(0.4, 0.5)] * 7)
    assert found.gaps.collisions == 2
    assert found.document()["min_gap_mm"] == -45.0


def test_passing_through_between_two_takes_is_a_collision():
    found = account([(0.2, 0.5), (0.8, 0.5)], [(0.8, 0.52), (0.2, 0.52)])
    assert found.gaps.collisions == 1
    assert found.gaps.least.gap == pytest.approx(0.02 - 0.075, abs=1e-3)


def test_those_that_overlap_from_the_start_collide_too():
    assert account([(0.5, 0.5)] * 3, [(0.55, 0.5)] * 3, [(0.2, 0.2)] * 3).gaps.collisions == 1


def test_three_that_meet_are_three_pairs():
    found = account([(0.2, 0.2), (0.5, 0.5)], [(0.8, 0.2), (0.55, 0.5)], [(0.5, 0.9), (0.52, 0.53)])
    assert found.gaps.collisions == 3


def test_a_lifted_robot_is_in_nobodys_way():
    found = account([(0.2, 0.5), GONE, (0.8, 0.2)], [(0.4, 0.5), (0.2, 0.5), (0.2, 0.5)])
    assert found.gaps.collisions == 0
    assert [each.t for each in found.gaps.series] == [0.0, 2.0]


def test_one_robot_has_no_gap():
    document = account([(0.2, 0.5), (0.4, 0.5)]).document()
    assert (document["min_gap_mm"], document["min_gap_t"], document["collisions"]) == (None, None, 0)


@pytest.mark.parametrize("seed", range(4))
def test_gaps_are_those_of_all_pairs(seed):
    dice = np.random.default_rng(seed)
    at, way = dice.uniform(0.0, 1.0, (12, 2)), dice.uniform(-0.3, 0.3, (12, 2))
    found = account(*np.stack([at, at + way], axis=1))
    shares = np.linspace(0.0, 1.0, 2001)[:, None, None]
    places = at + shares * way
    gaps = np.linalg.norm(places[:, :, None] - places[:, None], axis=3)[:, *np.triu_indices(12, 1)]
    assert found.gaps.least.gap == pytest.approx(gaps.min() - 0.075, abs=1e-4)
    assert found.gaps.series[0].gap == pytest.approx(gaps[0].min() - 0.075)
    assert found.gaps.collisions == np.count_nonzero(gaps.min(axis=0) < 0.075)


def test_the_count_agrees_with_the_ideal_discs_own():
    dice = np.random.default_rng(2)
    plant = IdealDiscs(names(15), dice.uniform(0.1, 0.9, (15, 2)), SHEET)
    found = SwarmAccount(plant.names, SHEET, LIMITS, body=0.0375)
    for step in range(600):
        if step % 100 == 0:
            for i, (x, y) in enumerate(dice.uniform(0.1, 0.9, (15, 2)).tolist()):
                plant.command(0.01 * step, goto(x, y, f"disc{i}", 0.01 * step))
        plant.advance(0.01 * step)
        found.take(0.01 * step, plant.truth()[0])
    assert plant.contacts > 25
    # The account also sees what touches for less than the 10 ms between the plant's own looks.
    assert plant.contacts <= found.gaps.collisions <= plant.contacts + 2


# --- paths ------------------------------------------------------------------------------------------------


def test_paths_are_summed_and_carrying_is_none():
    found = account([(0.2, 0.2), (0.5, 0.6), (0.5, 0.7)], [(0.1, 0.1), GONE, (0.9, 0.9)], [(0.8, 0.2)] * 3)
    assert path_lengths(found.places) == pytest.approx([0.6, 0.0, 0.0])
    assert found.document()["path_m"] == {"total": 0.6, "robots": {"disc0": 0.6, "disc1": 0.0, "disc2": 0.0}}


# --- deadlocks --------------------------------------------------------------------------------------------


def history(*ways, seconds=20.0):
    """Places (k, n, 2) of robots that each go a straight way in the time."""
    times = np.arange(0.0, seconds + 0.01, 0.05)
    shares = (times / seconds)[:, None, None]
    starts, ends = (np.array([way[k] for way in ways]) for k in (0, 1))
    return times, starts + shares * (ends - starts)


def test_a_deadlock_is_an_open_goal_and_no_progress():
    still = ((0.5, 0.5), (0.5, 0.5))
    creeping = ((0.2, 0.2), (0.2, 0.238))  # 19 mm nearer within 10 s
    slow = ((0.2, 0.2), (0.2, 0.242))  # 21 mm
    times, places = history(still, still, still, creeping, slow)
    goals = [(0.5, 0.505), (0.5, 0.52), GONE, (0.2, 0.8), (0.2, 0.8)]
    assert deadlocks(goals, times, places) == 2  # the second, and the fourth
    assert deadlocks(goals, times, places, near=0.03) == 1
    assert deadlocks(goals, times, places, progress=0.03) == 3


def test_driving_to_and_fro_is_no_progress():
    times = np.arange(0.0, 30.0, 0.05)
    places = np.stack([0.5 + 0.1 * np.sin(2 * np.pi * times / 5.0), np.full(len(times), 0.5)], axis=1)[:, None]
    assert deadlocks([(0.9, 0.5)], times, places) == 1


def test_all_arrived_is_no_deadlock_however_short_the_run():
    times, places = history(((0.2, 0.2), (0.5, 0.5)), seconds=2.0)
    assert deadlocks([(0.5, 0.5)], times, places) == 0
    assert deadlocks([(0.6, 0.5)], times, places) is None  # who can tell so soon


def played(wish, seconds=20.0, every=0.1, start=(0.3, 0.5)):
    """A robot that does not move, and a behaviour that wishes ``wish(t)``."""
    found = SwarmAccount(names(1), SHEET, LIMITS)
    for k in range(round(seconds / every) + 1):
        found.want(k * every, wish(k * every))
        found.take(k * every, [start])
    return found


def test_the_account_knows_deadlocks_by_the_wishes():
    assert played(lambda t: [goto(0.8, 0.5)]).document()["deadlocks"] == 1
    assert played(lambda t: [goto(0.305, 0.5)]).document()["deadlocks"] == 0
    assert played(lambda t: []).document()["deadlocks"] == 0
    assert played(lambda t: [Drive(t, "disc0", (0.1, 0.0), 0.0, t + 0.3)]).document()["deadlocks"] == 0
    assert account([(0.2, 0.2)] * 30).document()["deadlocks"] is None  # nobody told
    assert played(lambda t: [goto(0.8, 0.5)], seconds=5.0).document()["deadlocks"] is None


def test_a_goal_that_is_new_is_no_deadlock_yet():
    assert played(lambda t: [goto(0.8, 0.5 if t < 12.0 else 0.6)]).document()["deadlocks"] == 0
    assert played(lambda t: [goto(0.8, 0.5 if t < 8.0 else 0.6)]).document()["deadlocks"] == 1


def test_a_goal_may_creep_without_being_a_new_one():
    assert played(lambda t: [goto(0.8 + 0.0005 * t, 0.5)]).document()["deadlocks"] == 1
    # One that crept towards the robot until it was there is fulfilled.
    assert played(lambda t: [goto(0.315 - 0.00075 * t, 0.5)]).document()["deadlocks"] == 0


def test_wishes_are_for_those_who_take_part():
    with pytest.raises(DeviceNotFound, match="there are: disc0"):
        account([(0.2, 0.2)]).want(0.0, [goto(0.5, 0.5, "disk0")])


# --- the document -----------------------------------------------------------------------------------------


def test_a_whole_run_worked_out_by_hand():
    # Four discs as wide as a quarter of the sheet sweep it side by side, from above it to below it, in 10 s.
    lanes = [[(0.125 + 0.25 * i, y) for y in np.linspace(-0.125, 1.125, 201)] for i in range(4)]
    found = account(*lanes, every=0.05, body=0.1, cover_radius=0.125)
    document = json.loads(json.dumps(found.document()))
    assert document["seconds"] == 10.0
    assert document["robots"] == 4
    assert document["path_m"]["total"] == pytest.approx(5.0)
    assert document["min_gap_mm"] == 50.0
    assert (document["collisions"], document["deadlocks"], document["violations"]) == (0, None, {})
    assert document["coverage"]["share_end"] == pytest.approx(1.0, abs=0.001)
    assert document["coverage"]["overlap"] == 0.0
    # The fronts are half discs: on average they are pi/4 of the radius ahead of the middles.
    for name, share in (("t50", 0.5), ("t90", 0.9)):
        middle = share - math.pi / 4 * 0.125
        assert document["coverage"][name] == pytest.approx((middle + 0.125) / 0.125, abs=0.03)
    assert document["cs"] == 1.0
    assert document["z_m"] == pytest.approx(-(3 * 0.25 + 2 * 0.5 + 0.75))
    # Four middles in a row 0.125 m below the sheet: strips of 0.25 m by 1 m, 0.625 m from their middles.
    assert document["locational_cost"] == pytest.approx((0.25**2 + 1) / 12 + 0.625**2, abs=1e-5)


def test_what_can_be_covered_depends_on_the_limits():
    coverage = account([(0.045, 0.5), (0.955, 0.5)]).document()["coverage"]
    side = 1 - 2 * LIMITS.body_radius_m
    reach = side**2 + 4 * side * 0.0375 + math.pi * 0.0375**2
    assert coverage["coverable"] == pytest.approx(reach, abs=1e-3)
    assert coverage["of_coverable"]["share_end"] == pytest.approx(coverage["share_end"] / reach, abs=1e-3)
    assert coverage["of_coverable"]["t50"] is None


def test_an_area_may_be_a_part_of_the_sheet():
    found = account([(0.0, 0.25), (1.0, 0.25)], area=((0.2, 0.2), (0.4, 0.2), (0.4, 0.3), (0.2, 0.3)))
    assert found.coverage.share() == pytest.approx(0.75, abs=0.01)


def test_numbers_that_cannot_be_had_are_none():
    nobody = SwarmAccount(names(2), SHEET, LIMITS).document()
    assert nobody["seconds"] == 0.0
    assert nobody["coverage"]["t50"] is None
    lost = ("locational_cost", "cs", "z_m", "min_gap_mm", "min_gap_t", "deadlocks")
    assert [nobody[name] for name in lost] == [None] * 6
    lifted = account([(0.2, 0.2), GONE]).document()
    assert [lifted[name] for name in lost] == [None] * 6
    assert account([(0.5, 0.5)]).document()["locational_cost"] == pytest.approx(1 / 6, abs=1e-6)


def test_places_must_fit_the_robots():
    with pytest.raises(DataError, match=r"2 robots need places \(2, 2\)"):
        SwarmAccount(names(2), SHEET, LIMITS).take(0.0, [(0.1, 0.1)])


# --- violations -------------------------------------------------------------------------------------------


def test_violations_are_counted_from_what_was_heard():
    found = account([(0.5, 0.5)], [(0.58, 0.5)])
    for record in (
        RobotState(0.0, "disc0", (0.5, 0.5), 0.0),
        RobotState(0.0, "disc1", (0.58, 0.5), 0.0),  # 80 mm apart: ideal discs of 75 mm, not Cellulos
        goto(0.53, 0.5, speed=0.2),
        Stop(0.1, "disc1"),
        goto(0.6, 0.5, "disc1", t=0.2),  # its own stop is over
        Stop(0.3),
        goto(0.53, 0.5, t=0.4),
    ):
        found.hear(record)
    assert found.document()["violations"] == {"speed above the cap": 1, "motion after stop": 1}


@pytest.mark.parametrize("seed", range(3))
def test_the_watch_sees_what_looking_at_all_pairs_sees(seed):
    dice = np.random.default_rng(seed)
    safety, places, touches, least = SafetyWatch(LIMITS, SHEET), {}, 0, np.inf
    for step in range(600):
        robot, held = f"disc{dice.integers(30)}", bool(dice.random() < 0.1)
        xy = dice.uniform(0.0, 1.0, 2).tolist()
        safety.take(RobotState(step * 0.001, robot, tuple(xy), 0.0, held=held))
        places.pop(robot, None)
        gaps = [math.dist(xy, other) - 2 * BODY for other in places.values()]
        if not held:
            touches, least = touches + any(gap < 0 for gap in gaps), min([least, *gaps])
            places[robot] = xy
    assert safety.violations["robots touch"] == touches > 50
    assert safety.least_gap == pytest.approx(least)


def test_watching_200_robots_is_cheap():
    safety = SafetyWatch(LIMITS, Sheet(5.0, 4.0))
    states = [
        RobotState(k * 0.02, f"disc{i}", (0.1 + 0.2 * (i % 20), 0.1 + 0.2 * (i // 20)), 0.0)
        for k in range(50)
        for i in range(200)
    ]
    began = time.process_time()
    for state in states:
        safety.take(state)
    assert time.process_time() - began < 0.5  # a second's states; it takes about 0.05 s
    assert safety.violations == {}
    assert safety.least_gap == pytest.approx(0.2 - 2 * BODY)
