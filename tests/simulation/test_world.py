from itertools import pairwise

import numpy as np
import pytest

from armspan.records import (
    Calibrated,
    GoTo,
    ImuSample,
    Light,
    Press,
    RobotState,
    Say,
    Selected,
    Sheet,
    Tick,
    Zone,
)
from armspan.simulation.bands import VirtualBand, draw_band
from armspan.simulation.person import VirtualPerson, draw_person
from armspan.simulation.robots import VirtualRobots
from armspan.simulation.script import Phase, Script, Target, Trial
from armspan.simulation.world import World, zone_middles

PLACE = Calibrated(0.0, "wrist", (0.0,) * 3, 0.0, (0.0,) * 16, 0.0, 0.0, 4)


def world(seed=3, trials=(), person=True):
    rng = np.random.default_rng(seed)
    someone = VirtualPerson(draw_person(rng), (0.45, -0.85), np.pi / 2, rng) if person else None
    bands = [VirtualBand("wrist", "forearm", draw_band(rng), rng)] if person else []
    places = np.array([[0.3, 0.3], [0.6, 0.3]])
    robots = VirtualRobots(("ash", "elm"), places, np.zeros(2), Sheet(0.9, 0.6), rng)
    return World(someone, bands, robots, {"pond": (0.15, 0.2)}, Script(trials), rng, table_height=0.7)


def say(t, cue):
    return Say(t, "words", cue)


def of(kind, events):
    return [event for event in events if isinstance(event, kind)]


def elevation(pose):
    """How far the forearm points up, in degrees."""
    return float(np.degrees(np.arcsin(pose.room_from_forearm[0][2, 0])))


def test_ticks_are_twenty_a_second_and_states_and_samples_come_at_their_rates():
    events = world().advance(10.0)
    assert [tick.t for tick in of(Tick, events)] == pytest.approx([0.05 * k for k in range(1, 201)])
    assert len(of(ImuSample, events)) == pytest.approx(1000, abs=60)
    assert {state.robot for state in of(RobotState, events)} == {"ash", "elm"}
    assert of(Press, events) == [Press(0.5, "setup")]


def test_each_source_is_in_order_and_nothing_comes_before_it_was_measured():
    shown = world()
    for k in range(1, 100):
        for event in shown.advance(0.05 * k):
            assert event.t <= 0.05 * k + 1e-9
    events = world().advance(5.0)
    for source in ("wrist", "ash", "elm"):
        mine = [e.t for e in events if source in (getattr(e, "source", None), getattr(e, "robot", None))]
        assert all(a < b for a, b in pairwise(mine))


class Radio:
    """Robots whose states of the first step arrive in disorder, one of them a step later."""

    def advance(self, t):
        if t > 0.051:
            return []
        arrivals = {"a": 0.04, "b": 0.02, "c": 0.07}
        return [(arrived, RobotState(0.01, name, (0.1, 0.1), 0.0)) for name, arrived in arrivals.items()]

    def lights(self):
        return np.zeros((3, 6, 3))


def test_events_come_in_the_order_in_which_they_arrive():
    here = World(None, [], Radio(), {}, Script(()), np.random.default_rng(0))
    first, second = here.advance(0.05), here.advance(0.10)
    assert [event.robot for event in of(RobotState, first)] == ["b", "a"]
    assert first[-1] == Tick(0.05)
    assert [type(event) for event in second] == [RobotState, Tick]
    assert second[0].robot == "c"


def test_what_happens_does_not_depend_on_the_steps_it_is_asked_in():
    one, other = world(), world()
    whole = one.advance(3.0)
    pieces = [event for k in range(1, 61) for event in other.advance(0.05 * k)]
    assert whole == pieces


def test_one_seed_is_one_world():
    assert world().advance(2.0) == world().advance(2.0)
    assert world(seed=4).advance(2.0) != world().advance(2.0)


def test_the_person_does_what_is_said():
    here = world()
    here.advance(1.0)
    here.take(say(1.0, "stretch"))
    here.advance(4.0)
    assert abs(elevation(here.person.pose([4.0]))) < 15
    here.take(say(4.0, "hang"))
    here.advance(7.0)
    assert elevation(here.person.pose([7.0])) < -70


def test_pointing_at_a_robot_brings_the_finger_before_it_as_the_eye_sees_it():
    here = world()
    here.take(say(0.0, "point:elm"))
    here.advance(4.0)
    pose = here.person.pose([4.0])
    light = np.array([0.6, -0.3, 0.7 + 0.045])  # the room's y is up the sheet
    sight, finger = light - pose.eye[0], pose.fingertip[0] - pose.eye[0]
    angle = np.arccos(sight @ finger / np.linalg.norm(sight) / np.linalg.norm(finger))
    assert np.degrees(angle) < 9


def test_a_target_that_moves_is_followed():
    here = world()
    here.take(say(0.0, "point:elm"))
    here.advance(3.0)
    before = here.person.pose([3.0]).fingertip[0]
    for k in range(60):
        t = 3.0 + 0.05 * k
        here.take(GoTo(t, "elm", (0.80, 0.3), 0.15, t + 0.3))
        here.advance(t + 0.05)
    after = here.person.pose([6.0]).fingertip[0]
    assert after[0] - before[0] > 0.02  # to the right, as the robot


def test_robots_obey_commands_and_words_do_not_move_them():
    here = world(person=False)
    here.take(GoTo(0.0, "ash", (0.34, 0.3), 0.1, 0.3))
    here.take(say(0.0, "stretch"))
    here.advance(2.0)
    xy, _, _ = here.robots.truth()
    assert xy[0] == pytest.approx((0.34, 0.3), abs=0.006)
    assert xy[1] == pytest.approx((0.6, 0.3), abs=1e-6)
    here.take(Light(2.0, "elm", (0, 255, 0)))
    here.advance(2.5)
    assert here.robots.lights()[1, :, 1].max() > 0.9


def test_the_truth_is_told_only_after_the_set_up_and_stays():
    here = world()
    here.advance(1.0)
    here.take(PLACE)
    assert here.truth is None  # nobody has said where ahead is
    here.take(say(1.0, "stretch"))
    here.advance(4.0)
    here.take(say(4.0, "hang"))
    here.advance(5.0)
    here.take(PLACE)
    eye = here.person.pose([5.0]).eye[0]
    assert here.truth.xyz == pytest.approx((eye[0], -eye[1], 0.7))
    assert here.truth.eye_height == pytest.approx(eye[2])
    forearm = here.person.pose([4.0]).room_from_forearm[0][:, 0]
    assert here.truth.yaw == pytest.approx(np.arctan2(forearm[1], forearm[0]))
    first = here.truth
    here.advance(6.0)
    here.take(PLACE)
    assert here.truth == first


def test_it_ends_with_its_script():
    trial = Trial(Target("zone:pond"), False)
    here = world(trials=(trial,))
    here.advance(1.0)
    here.take(say(1.0, "ready"))
    events = here.advance(4.0)
    assert [press.value for press in of(Press, events) if press.name == "trial"] == ["zone:pond"]
    assert not here.ended
    here.take(Selected(4.0, "wrist", None, "pond", 0.9, "dwell"))
    here.advance(6.0)
    assert here.ended
    assert here.script.phase is Phase.DONE


def test_without_a_person_there_are_robots_and_ticks():
    here = world(person=False)
    here.take(say(0.0, "point:elm"))
    here.take(PLACE)
    events = here.advance(2.0)
    assert {type(event) for event in events} == {RobotState, Tick, Press}
    assert here.truth is None


def test_the_middle_of_a_zone():
    bent = Zone("L", ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)))  # three unit squares
    [(name, middle)] = zone_middles([bent]).items()
    assert name == "L"
    assert middle == pytest.approx((2.5 / 3, 2.5 / 3))
