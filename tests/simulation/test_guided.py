from armspan.records import Press, Say, Selected
from armspan.simulation.guided import Guided
from armspan.simulation.script import Phase


def heard(*records):
    guided = Guided()
    for record in records:
        guided.hear(record)
    return guided


def test_the_set_ups_words_are_done_and_the_arm_rests_when_it_is_through():
    guided = heard(Say(1, "", "stretch"), Say(2, "", ""), Say(3, "", "point:ash"), Say(4, "", "ready"))
    assert guided.cues == ["stretch", "point:ash", "rest"]
    assert guided.phase is Phase.REST


def test_a_wish_is_pointed_at_until_something_else_is_wished():
    guided = heard(Press(1, "wish", "zone:pond"))
    assert (guided.phase, guided.cues) == (Phase.POINT, ["point:zone:pond"])
    guided.hear(Selected(2, "wrist", None, "pond", 0.9, "dwell"))
    assert (guided.phase, guided.cues[1:]) == (Phase.POINT, [])
    guided.hear(Press(3, "wish", "rest"))
    assert (guided.phase, guided.cues[1:]) == (Phase.PERFORM, ["rest"])


def test_gestures_are_wished_too_and_other_presses_are_not_heard():
    guided = heard(Press(1, "wish", "gesture:stop"), Press(2, "behaviour", "gather"))
    assert (guided.phase, guided.cues) == (Phase.PERFORM, ["gesture:stop"])


def test_it_presses_nothing_and_never_ends():
    guided = heard(Say(1, "", "ready"))
    assert guided.step(1000.0) == []
    assert guided.phase is not Phase.DONE
