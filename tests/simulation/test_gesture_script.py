"""Agendas for gestures, by themselves and in a world."""

import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.records import ImuSample, Press, Say, Sheet
from armspan.simulation.bands import VirtualBand, draw_band
from armspan.simulation.gesture_script import GestureScript, Programme
from armspan.simulation.robots import VirtualRobots
from armspan.simulation.script import Phase, Script
from armspan.simulation.world import World
from two_arms import both, climbs, drawn


def world(script, seed=3):
    rng = np.random.default_rng(seed)
    bands = [
        VirtualBand(name, segment, draw_band(rng), rng)
        for name, segment in (("right", "forearm"), ("left", "other_forearm"))
    ]
    robots = VirtualRobots(("ash",), np.array([[0.3, 0.3]]), np.zeros(1), Sheet(0.9, 0.6), rng)
    return World(drawn(seed), bands, robots, {}, script, rng)


def truths(events):
    return [event for event in events if isinstance(event, Press) and event.name == "truth"]


def test_a_recorder_is_obeyed_until_it_is_done():
    script = GestureScript(button="record", start=0.3)
    presses = [press for k in range(10) for press in script.step(0.1 * k)]
    assert presses == [Press(pytest.approx(0.3), "record")]
    script.hear(Say(1.0, "words", "gesture:mixing"))
    script.hear(Say(1.0, "words"))
    script.hear(Press(1.0, "record"))
    assert script.cues == ["gesture:mixing"]
    assert script.phase is Phase.PERFORM
    script.hear(Say(2.0, "words", "done"))
    script.hear(Say(2.0, "words", "gesture:stop"))
    assert script.phase is Phase.DONE
    assert script.cues == ["gesture:mixing"]


def test_the_person_performs_what_is_said_and_the_truth_is_noted():
    here = world(GestureScript())
    events = here.advance(1.0)
    here.take(Say(1.0, "Stop!", "gesture:stop"))
    for k in range(21, 140):
        events += here.advance(0.05 * k)
    here.take(Say(6.95, "Do what you like", "everyday:20"))
    events += here.advance(15.0)
    here.take(Say(15.0, "Relax", "relax"))
    events += here.advance(18.0)
    [told] = here.person.performed
    assert truths(events) == [Press(told.start, "truth", "stop"), Press(told.end, "truth", "")]
    assert 1.2 < told.start < 1.7
    assert {event.source for event in events if isinstance(event, ImuSample)} == {"left", "right"}
    assert max(climbs(pose)[0] for pose in both(here.person, [18.0])) < -60
    assert not here.ended
    here.take(Say(18.0, "Thank you", "done"))
    assert here.ended


def test_a_programme_follows_the_pointing_by_itself():
    here = world(Programme(Script(()), ("mixing", "everyday:5", "stop"), pause=1.0))
    events = here.advance(2.0)
    here.take(Say(2.0, "Your place is known", "ready"))
    assert here.script.phase is Phase.SET_UP
    while not here.ended:
        events += here.advance(events[-1].t + 0.05)
        assert events[-1].t < 60
    labels = [press.value for press in truths(events)]
    assert labels == ["mixing", "", "stop", ""]
    _, over, stop, last = (press.t for press in truths(events))
    assert over + 1.0 + 5.0 + 1.0 < stop < over + 9.0
    assert last + 1.0 <= events[-1].t < last + 1.3
    assert here.script.phase is Phase.DONE


def test_a_programme_hears_the_set_up_and_then_no_more():
    programme = Programme(Script((), phase=Phase.DONE), ("stop",))
    programme.hear(Say(1.0, "words", "stretch"))
    assert programme.cues == []
    assert programme.phase is Phase.PERFORM
    other = Programme(Script(()), ())
    other.hear(Say(1.0, "words", "stretch"))
    assert other.cues == ["stretch"]


@pytest.mark.parametrize("item", ["everyday", "everyday:soon", "everyday:-3", "everyday:nan", "mixin", "walking:3"])
def test_an_item_that_is_none_is_refused(item):
    with pytest.raises(ConfigError):
        Programme(Script(()), (item,))
