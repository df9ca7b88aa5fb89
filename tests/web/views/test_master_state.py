import pytest

from armspan.web.activities import Act, Agenda
from armspan.web.shown import HELD, LOST, UNHEARD, WAITING
from armspan.web.views.master_state import battery_sign, done_words, robot_rows, turn_words

ROOM = {"robots": ["ash", "elm"]}
LIST = (Act("Tidy", "sweep@pond"), Act("Meet", "gather", ("ash",)))


def told(state=0, battery=-1.0):
    return [0.1, 0.2, 0.0, state, battery, *[0] * 6]


def rows(one, two=None, **frame):
    return robot_rows(ROOM, {"robots": [one, two or told()], **frame})


def test_a_robot_that_is_well_says_so_in_words():
    row = rows(told(battery=0.5), running=[["gather", ["ash"]]])[0]
    assert (row.robot, row.doing.words, row.battery.words, row.held.words, row.link.words, row.waits) == (
        "ash",
        "come together",
        "50 %",
        "on the sheet",
        "connected",
        "",
    )
    assert not any(sign.bad for sign in (row.doing, row.battery, row.held, row.link))


def test_what_needs_care_is_told_apart_by_words_and_icon_not_by_colour_alone():
    lifted, lost = rows(told(HELD | WAITING, 0.1), told(LOST), waiting={"ash": "lifted off the sheet"})
    assert (lifted.held.words, lifted.held.bad, lifted.doing.words, lifted.waits) == (
        "lifted",
        True,
        "waits",
        "lifted off the sheet",
    )
    assert (lifted.battery.words, lifted.battery.bad) == ("low, 10 %", True)
    assert (lost.link.words, lost.link.bad) == ("out of reach", True)
    assert lifted.link.icon != lost.link.icon


def test_a_robot_not_heard_yet_is_not_said_to_be_on_the_sheet():
    row = rows(told(UNHEARD))[0]
    assert (row.held.words, row.link.words, row.battery.words) == ("not known", "not heard yet", "not known")


def test_a_stop_of_all_is_said_for_every_robot():
    assert [row.doing.words for row in rows(told(), stopped=True)] == ["stopped", "stopped"]


def test_without_a_room_there_is_no_row():
    assert robot_rows(None, {"t": 0.0, "room": 0}) == []
    assert robot_rows(ROOM, {"t": 0.0, "room": 0}) == []


@pytest.mark.parametrize(("share", "words"), [(None, "not known"), (1.0, "100 %"), (0.19, "low, 19 %")])
def test_a_battery_in_words(share, words):
    assert battery_sign(share).words == words


@pytest.mark.parametrize(
    ("agenda", "frame", "words"),
    [
        (Agenda(LIST), {}, "1. Tidy: is next. Press Start."),
        (Agenda(LIST, 0, "begun"), {"running": [["sweep@pond", ["ash"]]]}, "1. Tidy: goes on."),
        (Agenda(LIST, 1, "begun"), {"running": [["sweep@pond", ["ash"]]]}, "2. Meet: goes on no more. Press Next,"),
        (Agenda(LIST, 1, "paused"), {}, "2. Meet: paused."),
        (Agenda(LIST, 1, "begun"), {"stopped": True}, "2. Meet: all robots are stopped. Press Resume all"),
        (Agenda(), {}, "The list has no activity"),
    ],
)
def test_whose_turn_it_is(agenda, frame, words):
    assert turn_words(agenda, frame, True).startswith(words)
    assert turn_words(agenda, frame, False) == "No room is open."


def test_what_the_robots_do_whoever_asked():
    assert done_words({"running": [["split", ["ash", "elm"]]]}) == "Now: Split in two groups (ash, elm)"
    assert done_words({}) == "Now: the robots do nothing"
