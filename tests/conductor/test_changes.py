import json

import pytest
from numpy.testing import assert_allclose

from armspan.conductor.changes import changed
from armspan.errors import ConfigError
from armspan.records import Calibrated, Pointed, Say, Selected, Stop
from puppet import PLACE, Puppet, settings

HARBOUR = {"name": "harbour", "polygon": [[0.6, 0.4], [0.7, 0.4], [0.7, 0.5], [0.6, 0.5]]}
TALLER = {"eye_height_m": 1.7, "shoulder_to_eye_m": [0.06, 0.15, 0.22], "shoulder_to_fingertip_m": 0.72}


def test_zones_are_replaced_and_a_pointed_one_is_found():
    puppet = Puppet().set_up()
    assert puppet.press("zones", json.dumps([HARBOUR])) == []
    assert [zone.name for zone in puppet.conductor.settings.zones] == ["harbour"]
    puppet.point_at((0.65, 0.45))
    pointed = [record for record in puppet.run(2) if isinstance(record, Pointed)][-1]
    assert (pointed.zone, pointed.decided) == ("harbour", True)
    began = puppet.press("behaviour", "sweep@harbour")
    assert [record.text for record in began if isinstance(record, Say)] == ["asked for: cover harbour in lanes"]


@pytest.mark.parametrize(
    ("zones", "why"),
    [
        ([HARBOUR, HARBOUR], "named twice"),
        ([HARBOUR | {"polygon": [[0.6, 0.4], [0.7, 0.5], [0.7, 0.4], [0.6, 0.5]]}], "crosses itself"),
        ([HARBOUR | {"polygon": [[0.6, 0.4], [0.7, 0.5]]}], "a polygon has three at least"),
        ([HARBOUR | {"polygon": [[0.6, 0.4], [1.7, 0.4], [0.7, 0.5]]}], "reaches outside the sheet"),
        ([HARBOUR | {"name": " "}], "needs a name"),
        ({"a": 1}, "zones: Expected"),
    ],
)
def test_zones_that_cannot_be_change_nothing(zones, why):
    puppet = Puppet()
    [said] = puppet.press("zones", json.dumps(zones))
    assert isinstance(said, Say)
    assert said.cue == "trouble"
    assert why in said.text
    assert [zone.name for zone in puppet.conductor.settings.zones] == ["pond"]


def test_a_zone_that_a_gesture_needs_stays():
    old = settings(gestures={"stop": "stop", "mixing": "sweep@pond"})
    with pytest.raises(ConfigError, match="'pond' is needed by the gesture 'mixing'"):
        changed(old, "zones", "[]")


def test_a_dictionary_must_stop_and_know_its_behaviours():
    assert changed(settings(), "gestures", '{"wave": "stop"}').gestures == {"wave": "stop"}
    for wrong, why in (
        ('{"wave": "gather"}', "one must always stop"),
        ('{"wave": "fly"}', "fly"),
        ('{"a": "stop", "b": "sweep@moon"}', "moon"),
    ):
        with pytest.raises(ConfigError, match=why):
            changed(settings(), "gestures", wrong)


def test_new_measures_want_a_new_set_up_and_stop_the_robots():
    puppet = Puppet().set_up()
    puppet.press("behaviour", "random-walk")
    puppet.run(0.5)
    told = puppet.press("body", json.dumps(TALLER))
    assert {stop.robot for stop in told if isinstance(stop, Stop)} == {"ash", "elm"}
    assert puppet.conductor.sight().place is None
    assert not any(isinstance(record, Pointed) for record in puppet.run(1))
    puppet.set_up()
    assert_allclose(puppet.of(Calibrated)[-1].xyz[:2], PLACE[0][:2], atol=0.2)


def test_measures_that_cannot_be_are_refused():
    puppet = Puppet().set_up()
    for wrong, why in (
        (TALLER | {"eye_height_m": 17.5}, "17.5 m: expected"),
        (TALLER | {"shoulder_to_fingertip_m": 0.1}, "0.1 m: expected"),
        ({"eye_height_m": 1.7}, "missing required field"),
    ):
        [said] = puppet.press("body", json.dumps(wrong))
        assert why in said.text
    assert puppet.conductor.sight().place is not None


def test_one_stop_is_taken_again_and_the_others_are_kept():
    puppet = Puppet().set_up()
    before = len(puppet.of(Calibrated))
    [asked] = [record for record in puppet.press("stop_again", "3") if isinstance(record, Say)]
    assert asked.text.endswith("(3 of 4)")
    puppet.run(60, until=Calibrated)
    assert len(puppet.of(Calibrated)) == before + 1
    assert_allclose(puppet.of(Calibrated)[-1].xyz, PLACE[0], atol=1e-4)
    assert [stop.number for stop in puppet.conductor.sight().seen] == [1, 2, 3, 4]


@pytest.mark.parametrize("number", ["0", "5", "x", ""])
def test_a_stop_that_is_none_is_not_taken_again(number):
    [said] = Puppet().set_up().press("stop_again", number)
    assert said.cue == "trouble"
    assert "there are stops 1 to 4" in said.text


def test_without_a_set_up_no_stop_is_taken_again():
    [said] = Puppet().press("stop_again", "1")
    assert "no finished set-up" in said.text


def test_what_was_chosen_after_a_change_is_logged_as_before():
    puppet = Puppet().set_up()
    puppet.press("zones", json.dumps([HARBOUR]))
    puppet.point_at("elm")
    puppet.run(4, until=Selected)
    assert [chosen.robot for chosen in puppet.of(Selected)][-1] == "elm"
