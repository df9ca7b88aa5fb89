import copy
from itertools import pairwise

import pytest

from armspan.conductor import Conductor
from armspan.errors import ConfigError
from armspan.records import (
    GoTo,
    Hit,
    ImuSample,
    Light,
    Link,
    Pointed,
    Press,
    RobotState,
    Say,
    Selected,
    Stop,
    Tap,
    Tick,
    Touch,
)
from puppet import Puppet, settings

QUIET = [
    Tick(0.0),
    Link(0.0, "wrist", True),
    Touch(0.0, "ash", 1, "began"),
    Touch(0.0, "ash", 1, "released"),
    Hit(0.0, "ash", True),
    Tap(0.0, "wrist"),
    RobotState(0.0, "ash", (0.4, 0.3), 0.0),
    ImuSample(0.0, "wrist", (0.0, 0.0, 9.8), (0.0, 0.0, 0.0)),
    ImuSample(0.0, "stranger", (0.0, 0.0, 9.8), (0.0, 0.0, 0.0)),
    Press(0.0, "trial", "robot:ash"),
    Press(0.0, "nobody knows"),
    Press(0.0, "feedback", "off"),
]


@pytest.mark.parametrize("event", QUIET, ids=lambda event: f"{type(event).__name__}-{getattr(event, 'name', '')}")
def test_before_the_set_up_most_events_decide_nothing(event):
    assert Conductor(settings()).step(event) == []


@pytest.mark.parametrize(
    ("event", "why"),
    [
        (Press(1.0, "stop"), "stop"),
        (Press(1.0, "quit"), "quit"),
        (Touch(1.0, "elm", 2, "long"), "long touch on elm"),
    ],
)
def test_every_way_to_stop_stops_all_robots(event, why):
    assert Conductor(settings()).step(event) == [Stop(1.0, None, why)]


def driving():
    """In the set-up, the robot ash on its way to a stop."""
    puppet = Puppet()
    puppet.press("setup")
    puppet.run(30, until=GoTo)
    puppet.run(0.3)
    assert puppet.of(GoTo)
    return puppet


def test_after_a_stop_nothing_moves_until_resume_and_a_new_command():
    puppet = driving()
    puppet.press("stop")
    assert not [record for record in puppet.run(3) if isinstance(record, GoTo)]
    assert puppet.press("resume") == [Say(puppet.t, "Robots may move again", "")]
    assert not [record for record in puppet.run(3) if isinstance(record, GoTo)]
    puppet.press("setup")
    puppet.run(30, until=GoTo)
    assert isinstance(puppet.outputs[-1], GoTo)


def test_a_lifted_robot_is_stopped_once():
    puppet = driving()
    puppet.held.add("ash")
    stops = [record for record in puppet.run(2) if isinstance(record, Stop)]
    assert stops == [Stop(stops[0].t, "ash", "lifted or off the sheet")]
    assert [record for record in puppet.run(1) if isinstance(record, GoTo)] == []


def test_every_motion_leaves_with_a_lease_and_within_the_lead():
    puppet = driving()
    goes = puppet.of(GoTo)
    assert all(go.until - go.t == pytest.approx(0.3) for go in goes)
    assert all(go.speed <= 0.15 for go in goes)
    assert [b.t - a.t for a, b in pairwise(goes)] == pytest.approx([0.1] * (len(goes) - 1))


def test_a_lost_link_is_told():
    assert Conductor(settings()).step(Link(1.0, "wrist", False)) == [Say(1.0, "wrist is out of reach", "")]


def test_feedback_off_darkens_the_lights():
    puppet = Puppet().set_up()
    puppet.press("feedback", "on")
    puppet.point_at("elm")
    puppet.run(0.8)
    assert puppet.of(Light)
    puppet.press("feedback", "off")
    puppet.run(4)
    shown = {}
    for light in puppet.of(Light):
        leds = range(6) if light.led is None else [light.led]
        shown |= {(light.robot, led): light.colour for led in leds}
    assert {key: colour for key, colour in shown.items() if colour != (0, 0, 0)} == {}


def test_feedback_may_be_on_from_the_start():
    puppet = Puppet(feedback=True).set_up()
    puppet.point_at("elm")
    puppet.run(0.5)
    assert puppet.of(Light)


def test_samples_of_a_band_decide_nothing_by_themselves():
    puppet = Puppet().set_up()
    puppet.point_at("elm")
    decided = {type(record) for record in puppet.run(2)}
    assert decided >= {Pointed, Selected}
    sample = ImuSample(puppet.t, "wrist", (0.0, 0.0, 9.8), (0.0, 0.0, 0.0), None, (1.0, 0.0, 0.0, 0.0))
    assert puppet.tell(sample) == []


def test_two_conductors_fed_alike_decide_alike():
    one = Puppet().set_up()
    one.point_at("elm")
    one.run(2)
    other = Puppet().set_up()
    other.point_at("elm")
    other.run(2)
    assert one.outputs == other.outputs


def test_settings_are_not_changed_by_a_session():
    puppet = Puppet()
    before = copy.deepcopy(puppet.conductor.settings)
    puppet.set_up()
    assert puppet.conductor.settings == before


def test_a_sample_that_comes_late_is_passed_over():
    puppet = Puppet().set_up()
    puppet.point_at("elm")
    puppet.run(0.5)
    upside_down = ImuSample(1.0, "wrist", (0.0, 0.0, 9.8), (0.0, 0.0, 0.0), None, (0.0, 1.0, 0.0, 0.0))
    puppet.tell(upside_down)
    assert puppet.run(0.05)[0].robot == "elm"


def test_a_conductor_without_an_arm_is_refused():
    with pytest.raises(ConfigError, match="needs a band on the forearm"):
        Conductor(settings(bands=()))
