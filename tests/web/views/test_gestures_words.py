import re

import msgspec
import pytest

from armspan.gesture.model import Facts
from armspan.gesture.takes import SEVEN
from armspan.swarm.director import BEHAVIOURS
from armspan.web.views.gestures_host import Curves, TakeRow
from armspan.web.views.gestures_words import (
    account,
    confusion_table,
    counted,
    drawing,
    missing_stop,
    name_of,
    noticed,
    orders_of,
    own_labels,
    predicted,
    state_of,
)

SPOTTING = {
    "takes": 10,
    "recognised": 9,
    "latency_s": 1.24,
    "null_hours": 0.25,
    "thresholds": [
        {"threshold": 0.3, "recognised": 10, "wrong_or_twice": 2, "false_triggers": 7},
        {"threshold": 0.6, "recognised": 9, "wrong_or_twice": 0, "false_triggers": 0},
    ],
}
FACTS = Facts(
    kind="kernels",
    recipe="standard",
    columns=("right_ax",),
    labels=("stop", "wave"),
    rate_hz=100.0,
    take_length=100,
    window_s=1.0,
    grid_hz=50.0,
    hop=5,
    persons=("p01",),
    takes={"stop": 5, "wave": 5},
    null_s=900.0,
    scores={"by_take": {"accuracy": 0.9, "confusion": [[5, 0], [1, 4]]}, "by_person": None, "spotting": SPOTTING},
)


def facts(**changes):
    return msgspec.structs.replace(FACTS, scores=FACTS.scores | {"spotting": SPOTTING | changes})


def row(label, number=1, *, seconds=4.0, practice=False, note="", simulated=False):
    return TakeRow(f"{label}/p_{number:02d}.csv", label, "p", number, "2026-01-01", seconds, practice, simulated, note)


def test_the_account_claims_what_was_seen():
    assert account(FACTS) == [
        "10 takes of 2 gestures by 1 person, 15.0 min of everyday motion.",
        "Held-out takes: 9 of 10 recognised (90 %).",
        "While you move freely: 9 of 10 held-out takes noticed, 1.2 s after they began. False triggers: none in "
        "15.0 min of held-out everyday motion; fewer than 12 an hour (95 % sure).",
    ]


def test_a_lower_threshold_notices_more_and_costs_more():
    assert noticed(FACTS, 0.35) == "Gestures noticed: 10 of 10 held-out takes, 2 wrongly or twice."
    assert noticed(FACTS, 0.7) == "Gestures noticed: 9 of 10 held-out takes."
    assert "about 28 an hour (7 in 15.0 min of held-out everyday motion)" in predicted(FACTS, 0.25)


@pytest.mark.parametrize("hours", [0, 0.0, None])
def test_without_everyday_motion_nothing_is_predicted(hours):
    assert predicted(facts(null_hours=hours), 0.6).startswith("False triggers: not known. Record everyday motion")


def test_an_older_model_knows_no_other_thresholds():
    older = facts(thresholds=None)
    assert "not known for this model" in predicted(older, 0.6)
    assert noticed(older, 0.6) == ""


def test_every_gesture_and_behaviour_has_words():
    assert all("_" not in name_of(label) for label in (*SEVEN, "my_own", "null"))
    options = orders_of(["garden"])
    assert set(BEHAVIOURS) <= set(options)
    assert options["sweep@garden"] == "cover garden in lanes"
    assert options["stop"] == "stop all robots"
    assert "gather@garden" not in options


def test_labels_are_typed_with_commas():
    assert own_labels(" wave, ,clap,") == ["wave", "clap"]


def test_counts_tell_what_counts():
    rows = [row("null", seconds=90.0), row("stop"), row("stop", 2, practice=True), row("stop", 3, note="nothing moved")]
    assert counted(rows) == [("null", "1.5 min"), ("stop", "1 take, 1 for practice, 1 spoilt")]
    assert [state_of(entry) for entry in rows[1:]] == [
        "counts",
        "for practice, not learnt from",
        "spoilt: nothing moved",
    ]
    assert state_of(row("stop", simulated=True)) == "counts, simulated"


def test_one_gesture_that_the_model_knows_must_stop():
    assert missing_stop({"stop": "stop"}, ["wave"])
    assert not missing_stop({"wave": "stop"}, ["wave"])


def test_confusions_are_a_table_and_labels_no_markup():
    table = confusion_table(["<b>", "stop"], [[3, 1], [0, 4]])
    assert "<b>" not in table
    assert re.findall(r'class="(\w+)">(\d)', table) == [("right", "3"), ("wrong", "1"), ("none", "0"), ("right", "4")]


def test_a_take_is_drawn_with_its_gesture_and_gaps():
    columns = {f"right_{kind}{axis}": [0.0, None, 2.0] for kind in "ag" for axis in "xyz"}
    svg = drawing(Curves([0.0, 1.0, 2.0], columns, (0.5, 1.5)))
    assert svg.count("<polyline") == 6
    assert svg.count('class="made"') == 2
    assert "right band: acceleration up to 2.0 m/s²" in svg
    assert all(len(points.split()) == 2 for points in re.findall(r'points="([^"]*)"', svg))
