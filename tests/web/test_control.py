from armspan.web.control import Control


def test_the_first_browser_steers_and_taking_over_is_seen_by_all():
    control = Control()
    assert [control.enter("a", "Computer"), control.enter("b", "Tablet")] == ["Computer 1", "Tablet 1"]
    assert (control.words("a"), control.words("b")) == ("You have control", "Computer 1 has control")
    control.take("b")
    assert (control.words("a"), control.words("b")) == ("Tablet 1 has control", "You have control")


def test_only_the_going_of_who_steers_matters():
    control = Control()
    control.enter("a", "Computer")
    control.enter("b", "Tablet")
    assert not control.leave("b")
    assert control.leave("a")
    assert not control.leave("a")
    assert control.holder is None


def test_when_nobody_steers_that_is_said():
    control = Control()
    control.enter("a", "Computer")
    control.leave("a")
    control.enter("b", "Phone")
    assert control.has("b")
    control.leave("b")
    assert control.words("c") == "Nobody has control"


def test_a_browser_that_is_gone_cannot_take_control():
    control = Control()
    control.enter("a", "Computer")
    control.take("gone")
    assert control.has("a")


def test_a_page_that_is_loaded_anew_keeps_control():
    control = Control()
    control.enter("a", "Computer")
    control.away("a")
    control.enter("again", "Computer")
    assert control.has("again")
    assert not control.leave("a")


def test_a_line_that_comes_back_keeps_control():
    control = Control()
    control.enter("a", "Computer")
    control.away("a")
    control.enter("a", "Computer")
    control.enter("b", "Tablet")
    assert control.has("a")
    assert control.words("b") == "Computer 1 has control"
