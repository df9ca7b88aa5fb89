from armspan.records import Press, Say, Selected
from armspan.simulation.script import Phase, Script, Target, Trial

TRIALS = (Trial(Target("robot:ash"), False), Trial(Target("zone:pond"), False), Trial(Target("robot:elm"), True))


def chosen(t):
    return Selected(t, "wrist", "ash", None, 0.9, "dwell")


def stepped(script, start, end):
    """The presses of a stretch of time, and the cues given in it; steps are a tenth of a second."""
    presses = [press for k in range(round(10 * start), round(10 * end)) for press in script.step(k / 10)]
    cues = list(script.cues)
    script.cues.clear()
    return presses, cues


def ready(trials=TRIALS, **more):
    """A script whose set-up has just ended at 5 s."""
    script = Script(trials, **({"rest": 0.65, "patience": 5.95} | more))
    stepped(script, 0, 5)
    script.hear(Say(5.0, "Your place is known", "ready"))
    return script


def test_a_target_has_a_kind_and_a_label():
    target = Target("zone:the:pond")
    assert (target.kind, target.label) == ("zone", "the:pond")


def test_it_begins_the_set_up_once():
    script = Script(TRIALS, start=0.5)
    assert stepped(script, 0, 5) == ([Press(0.5, "setup")], [])
    assert script.phase is Phase.SET_UP


def test_the_person_hears_cues_and_nothing_else():
    script = Script(TRIALS)
    script.hear(Say(1.0, "Stretch your arm", "stretch"))
    script.hear(Say(1.0, "Robots may move again", ""))
    script.hear(Press(1.0, "stop"))
    assert script.cues == ["stretch"]


def test_a_trial_begins_after_a_rest_and_ends_with_a_choice():
    script = ready()
    presses, cues = stepped(script, 5.0, 6.5)
    assert presses == [Press(5.7, "feedback", "off"), Press(5.7, "trial", "robot:ash")]
    assert cues == ["rest", "point:robot:ash"]
    script.hear(chosen(6.4))
    presses, cues = stepped(script, 6.5, 7.5)
    assert presses == [Press(6.5, "trial", ""), Press(7.2, "trial", "zone:pond")]
    assert cues == ["rest", "point:zone:pond"]


def test_a_trial_without_a_choice_ends_when_patience_does():
    script = ready()
    presses, _ = stepped(script, 5.0, 12.5)
    assert presses[1:3] == [Press(5.7, "trial", "robot:ash"), Press(11.7, "trial", "")]


def test_a_choice_before_the_trial_is_not_the_trials():
    script = ready()
    script.hear(chosen(5.0))
    stepped(script, 5.0, 6.0)
    script.hear(chosen(5.7))  # just when it began: meant before
    assert stepped(script, 6.0, 8.0)[0] == []


def test_feedback_is_pressed_where_it_changes_and_the_script_ends():
    script = ready(patience=1.0)
    presses, _ = stepped(script, 5.0, 20.0)
    assert [press.value for press in presses if press.name == "feedback"] == ["off", "on"]
    assert [press.value for press in presses if press.name == "trial"] == [
        "robot:ash",
        "",
        "zone:pond",
        "",
        "robot:elm",
        "",
    ]
    assert script.phase is Phase.DONE
    assert stepped(script, 20.0, 30.0) == ([], [])


def test_without_trials_it_ends_after_the_set_up():
    script = ready(trials=())
    assert stepped(script, 5.0, 8.0)[0] == []
    assert script.phase is Phase.DONE
