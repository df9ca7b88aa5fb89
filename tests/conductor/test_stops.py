"""What stops robots, as the conductor decides it: the arm, its bands, its calibration."""

import numpy as np
import pytest

from armspan.conductor import pointer
from armspan.conductor.choice import Choice
from armspan.records import GoTo, Link, Pointed, Say, Selected, Stop, Tap
from puppet import Puppet


def moving(outputs):
    return {output.robot for output in outputs if isinstance(output, GoTo)}


@pytest.fixture
def walking():
    """Set up, and both robots walking at random."""
    puppet = Puppet().set_up()
    puppet.press("behaviour", "random-walk")
    assert moving(puppet.run(0.5)) == {"ash", "elm"}
    return puppet


def stops(outputs):
    return [output for output in outputs if isinstance(output, Stop)]


def test_a_silent_band_stops_all_robots_within_a_third_of_a_second_and_nothing_resumes(walking):
    since, walking.silent = walking.t, True
    told = stops(walking.run(1))
    for why, most in (("a band is late", 0.18), ("nothing heard of wrist", 0.26)):
        assert {stop.robot for stop in told if stop.why == why} == {"ash", "elm"}
        assert max(stop.t for stop in told if stop.why == why) - since <= most
    walking.silent = False
    assert moving(walking.run(3)) == set()
    walking.press("behaviour", "gather")
    assert moving(walking.run(0.5)) == {"ash", "elm"}


def test_robots_pause_while_a_band_is_late_and_go_on_by_themselves(walking):
    walking.silent = True
    told = walking.run(0.16)
    assert {stop.why for stop in stops(told)} == {"a band is late"}
    walking.silent = False
    assert moving(walking.run(0.3)) == {"ash", "elm"}


def test_a_band_out_of_reach_stops_all_robots(walking):
    told = walking.tell(Link(walking.t, "wrist", False))
    assert {stop.robot for stop in stops(told)} == {"ash", "elm"}
    assert told[-1] == Say(walking.t, "wrist is out of reach", "")
    assert moving(walking.run(1)) == set()


def test_a_band_that_began_anew_stops_all_robots_and_wants_the_set_up_again(walking):
    assert walking.tell(Link(walking.t, "wrist", True)) == []  # it comes back, and its heading holds
    assert isinstance(walking.run(0.2)[-1], Pointed | GoTo)
    told = walking.tell(Link(walking.t, "wrist", True, fresh=True))
    assert {stop.robot for stop in stops(told)} == {"ash", "elm"}
    assert told[-1].cue == "trouble"
    later = walking.run(1)
    assert moving(later) == set()
    assert not [output for output in later if isinstance(output, Pointed)]
    walking.set_up()
    assert [output for output in walking.run(0.3) if isinstance(output, Pointed)]


def test_a_band_that_is_heard_for_the_first_time_is_no_news():
    assert Puppet().tell(Link(0.0, "wrist", True, fresh=True)) == []


def test_three_taps_stop_all_robots_one_does_not(walking):
    assert stops(walking.tell(Tap(walking.t, "wrist", 1))) == []
    (stop,) = stops(walking.tell(Tap(walking.t, "wrist", 3)))
    assert stop.robot is None
    assert moving(walking.run(1)) == set()


def test_the_set_up_is_broken_off_when_its_robot_is_lifted():
    puppet = Puppet()
    puppet.press("setup")
    puppet.run(30, until=GoTo)
    puppet.held.add("ash")
    said = [output for output in puppet.run(1) if isinstance(output, Say)]
    assert [say.text for say in said] == ["The set-up was broken off (ash: lifted or off the sheet); begin it again"]
    puppet.held.clear()
    assert moving(puppet.run(2)) == set()
    puppet.set_up()  # begins again


def test_robots_that_follow_the_arm_stop_when_its_calibration_expires(monkeypatch):
    puppet = Puppet().set_up()
    puppet.point_at("elm")
    puppet.press("behaviour", "follow:ash")
    assert "ash" in moving(puppet.run(1.5))
    monkeypatch.setattr(pointer, "EXPIRED", 0.0)
    told = puppet.run(0.5)
    refused = [output.refused for output in told if isinstance(output, Pointed)]
    assert all("expired: the heading may be off by 15 degrees; set up again" in why for why in refused)
    (stop,) = stops(told)
    assert stop.robot == "ash"
    assert "expired" in stop.why
    monkeypatch.undo()
    assert moving(puppet.run(1)) == set()


def test_a_calibration_expires_by_itself_where_nothing_is_chosen():
    puppet = Puppet().set_up()
    deviation = []
    for _ in range(9):
        puppet.run(60)
        deviation.append(np.degrees(np.sqrt(puppet.conductor._pointer.place.covariance[3, 3])))
    assert deviation[3] < 15 < deviation[-1]
    assert "expired" in puppet.of(Pointed)[-1].refused


def test_the_swarm_follows_where_the_arm_points():
    puppet = Puppet().set_up()
    puppet.robots["elm"] = (0.7, 0.45)
    puppet.point_at("elm")
    puppet.press("behaviour", "follow:ash")
    before = np.hypot(*np.subtract(puppet.robots["ash"], (0.7, 0.45)))
    puppet.run(4)
    after = np.hypot(*np.subtract(puppet.robots["ash"], (0.7, 0.45)))
    assert after < before - 0.05
    assert after >= 0.1 - 1e-6  # elm stands there


def test_a_chosen_robot_is_the_only_one_that_the_next_gesture_is_for():
    puppet = Puppet().set_up()
    puppet.point_at("elm")
    puppet.run(4, until=Selected)
    said = puppet.conductor._behave(puppet.t, "random-walk", "gesture mixing")
    assert said[-1].text == "gesture mixing: wander about (elm)"
    assert moving(puppet.run(0.5)) == {"elm"}
    said = puppet.conductor._behave(puppet.t, "gather", "gesture raise_both")
    assert said[-1].text == "gesture raise_both: come together"  # a choice counts once


def test_a_choice_is_forgotten_after_a_while():
    choice = Choice(8.0)
    choice.add(0.0, "ash")
    choice.add(5.0, "elm")
    assert choice.take(9.0) == (["elm"], "")
    assert choice.take(9.1) == ([], "")
    choice.add_zone(10.0, "pond")
    assert choice.take(18.0) == ([], "pond")
    choice.add_zone(20.0, "pond")
    assert choice.take(28.1) == ([], "")


def test_a_chosen_zone_is_the_one_that_is_swept():
    puppet = Puppet().set_up()
    puppet.point_at((0.15, 0.3))
    chosen = [output for output in puppet.run(4, until=Selected) if isinstance(output, Selected)]
    assert [choice.zone for choice in chosen] == ["pond"]
    said = puppet.conductor._behave(puppet.t, "sweep", "gesture breaststroke")
    assert said[-1].text == "gesture breaststroke: cover pond in lanes"
    said = puppet.conductor._behave(puppet.t, "sweep", "gesture breaststroke")
    assert said[-1].text == "gesture breaststroke: cover the sheet in lanes"
