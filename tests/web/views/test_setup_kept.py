from types import SimpleNamespace

import pytest

from armspan.conductor.sight import Sight
from armspan.records import Say
from armspan.web.host import Portrait
from armspan.web.views.setup_kept import Clock, kept_for

QUIET = Say(0.0, "")
IDLE, READY = (
    Sight("idle", 1, 4, (), "", (), place, None, False, {}, (), ()) for place in (None, (0.4, 0.8, 0.75, 1.5))
)


def desk(browser, kept):
    """As much of a browser's desk as keeps things."""
    return SimpleNamespace(browser=browser, host=SimpleNamespace(kept=kept))


def test_the_clock_counts_from_the_first_look_until_ready():
    clock = Clock()
    assert clock.seconds(3.0) == 0.0
    clock.look(10.0, IDLE, QUIET)
    assert clock.seconds(25.0) == pytest.approx(15.0)
    clock.look(60.0, READY, QUIET)
    clock.look(70.0, IDLE, QUIET)  # one stop is taken again: it was ready before
    assert clock.seconds(90.0) == pytest.approx(50.0)


def test_it_was_ready_when_it_was_said_though_nobody_looked():
    clock = Clock()
    clock.look(10.0, IDLE, QUIET)
    clock.look(200.0, READY, Say(60.0, "Your place is known", "ready"))
    assert clock.seconds(300.0) == pytest.approx(50.0)
    clock.start(400.0)  # an old word does not end the new time before it began
    clock.look(401.0, READY, Say(60.0, "Your place is known", "ready"))
    assert clock.seconds(402.0) == 0.0


def test_the_clock_starts_again_by_hand_and_with_another_session():
    clock = Clock()
    clock.look(10.0, READY, QUIET)
    clock.start(100.0)
    assert (clock.ready, clock.seconds(104.0)) == (None, pytest.approx(4.0))
    clock.look(1.0, IDLE, QUIET)
    assert clock.seconds(3.0) == pytest.approx(2.0)


def test_a_browser_finds_again_what_it_typed():
    kept = {"another view": object()}
    kept_for(desk("a", kept)).typed["height_m"] = "1.75"
    assert kept_for(desk("a", kept)).typed == {"height_m": "1.75"}


def test_a_page_that_is_loaded_again_has_what_was_typed_last_and_no_pictures():
    kept = {}
    first = kept_for(desk("a", kept))
    first.typed["height_m"], first.step, first.clock.began = "1.75", 2, 5.0
    first.portraits["front"] = Portrait("front", "me.jpg", b"...")
    second = kept_for(desk("b", kept))
    assert (second.typed, second.step, second.clock.began, second.portraits) == ({"height_m": "1.75"}, 2, 5.0, {})
    second.typed["height_m"], second.clock.began = "1.60", 9.0
    assert (first.typed["height_m"], first.clock.began) == ("1.75", 5.0)
