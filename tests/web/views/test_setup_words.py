import math
from types import SimpleNamespace

import numpy as np
import pytest

from armspan.body.measured import measure
from armspan.conductor import BandSettings
from armspan.conductor.sight import Sight, StopSeen
from armspan.records import Body
from armspan.web.host import Device
from armspan.web.views import setup_words as words

PLACE = (0.4, 0.8, 0.75, 1.5)


def sight(step="idle", stop=1, stops=4, seen=(), quality="", place=None, stopped=False):
    """What a conductor believes, as far as the set-up is concerned."""
    found = tuple(StopSeen(number, math.radians(degrees), used) for number, degrees, used in seen)
    return Sight(step, stop, stops, found, quality, (), place, None, stopped, {}, (), ())


SEEN = ((1, 0.5, True), (2, 2.5, True), (3, 6.0, True), (4, 30.0, False))


# --- devices ------------------------------------------------------------------------------------------------


def test_what_is_not_known_of_a_device_is_said_so():
    row = words.device_row(Device("left", "band", "left wrist", False, None, None, None, "nothing heard"))
    assert (row["link"], row["battery"], row["rate"], row["lost"]) == ("Not connected", *["not known"] * 3)
    assert (row["kind"], row["note"]) == ("Band", "nothing heard")


def test_what_is_known_of_a_device_has_its_unit_and_what_to_do():
    row = words.device_row(Device("left", "band", "left wrist", True, 0.1, 99.7, 0.08))
    assert (row["link"], row["battery"]) == ("Connected", "10 %: charge it")
    assert (row["rate"], row["lost"]) == ("100 a second", "8.0 %: bring it nearer")


@pytest.mark.parametrize(("share", "told"), [(0.0, "none"), (0.0004, "under 0.1 %"), (0.012, "1.2 %")])
def test_a_share_of_lost_samples(share, told):
    assert words.lost_words(share) == told


def test_those_who_are_away_are_named():
    here, away = Device("a", "robot", "", True, None, None, None), Device("b", "robot", "", False, None, None, None)
    assert words.devices_verdict([here, here]) == "All 2 devices are connected"
    assert words.devices_verdict([here, away]) == "Waiting for b"
    assert words.devices_verdict([]) == "The room names no devices"


# --- measures -----------------------------------------------------------------------------------------------


def test_what_is_typed_is_in_metres_with_a_comma_or_a_point():
    told = words.told_of({"height_m": " 1,75 m", "sole_m": "0.03", "sex": "woman", "arm": "left", "eye": "both"})
    assert (told.height_m, told.sole_m, told.sex, told.arm, told.eye) == (1.75, 0.03, "woman", "left", "both")
    assert told.span_m is None


def test_nothing_typed_is_the_right_arm_barefoot():
    told = words.told_of({})
    assert (told.height_m, told.sole_m, told.sex, told.arm, told.eye) == (None, 0.0, None, "right", "right")


@pytest.mark.parametrize(
    ("typed", "field", "says"),
    [
        ({"height_m": "17.5"}, "height_m", "Height = 17.5, but it is in metres"),
        ({"height_m": "175"}, "height_m", "centimetres, did you mean 1.75"),
        ({"height_m": "tall"}, "height_m", "'tall' is not a number"),
        ({"height_m": "nan"}, "height_m", "not a number"),
        ({"height_m": "1.75", "span_m": "0.9"}, "span_m", "Arm span = 0.9 does not fit Height = 1.75"),
        ({"height_m": "1.75", "sole_m": "3"}, "sole_m", "Thickness of the soles = 3"),
    ],
)
def test_what_cannot_be_is_told_at_its_field_in_the_words_of_the_page(typed, field, says):
    with pytest.raises(words.FieldError) as told:
        words.told_of(typed)
    assert told.value.field == field
    assert says in str(told.value)


def test_people_are_counted_from_one():
    assert (words.whole_number(" 2 "), words.whole_number("")) == (2, None)
    for wrong in ("0", "-1", "two"):
        with pytest.raises(words.FieldError, match="count the people"):
            words.whole_number(wrong)


@pytest.mark.parametrize(
    ("bands", "arms"),
    [
        ([("forearm", "right")], ("right",)),
        ([("forearm", None)], ("left", "right")),
        ([("forearm", "left"), ("forearm", "right")], ("left", "right")),
        ([("forearm", "left"), ("upperarm", "right")], ("left",)),
    ],
)
def test_an_arm_points_where_a_band_is_worn_on_its_forearm(bands, arms):
    worn = [BandSettings(str(number), segment, arm=arm) for number, (segment, arm) in enumerate(bands)]
    assert sorted(words.arms_with_band(SimpleNamespace(bands=worn))) == sorted(arms)


def test_measures_in_millimetres_with_their_standard_deviations():
    body = measure(words.told_of({"height_m": "1.75"})).fused.body
    sds = 1000 * np.sqrt(np.reshape(body.covariance, (5, 5)).diagonal())
    rows = words.body_rows(body)
    assert rows[0]["value"] == f"{1000 * body.eye_height_m:.0f} mm"
    assert [row["sd"] for row in rows] == [f"± {sd:.0f} mm" for sd in sds]
    assert [row["sd"] for row in words.body_rows(Body(1.6, (0.1, 0.15, 0.2), 0.7))] == ["not known"] * 5


# --- calibration --------------------------------------------------------------------------------------------


def test_ready_is_who_has_a_place_and_is_asked_nothing():
    assert words.is_ready(sight(place=PLACE))
    assert not words.is_ready(sight())
    assert not words.is_ready(sight("point", place=PLACE))


def test_progress_never_goes_back_from_the_first_pose_to_the_last_stop():
    steps = [sight(step) for step in ("idle", "rest", "stretch", "hang")]
    steps += [sight(step, stop) for stop in (1, 2, 3, 4) for step in ("drive", "point")]
    shares = [words.progress_share(one) for one in [*steps, sight(place=PLACE)]]
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)


def test_what_is_asked_is_told_with_its_stop():
    assert words.progress_words(sight("drive", 2)) == "Stop 2 of 4: The robot drives to its stop"
    assert words.progress_words(sight("stretch")).startswith("Arm stretched forward")
    assert words.progress_words(sight(place=PLACE)) == "The set-up is done"
    assert words.progress_words(sight(stopped=True)).startswith("All robots are stopped")


def test_stops_of_a_first_round():
    told = [words.stop_words(sight("point", 2), number) for number in (1, 2, 3)]
    assert told == ["taken", "now", "to come"]
    told = [words.stop_words(sight("point", 4, seen=SEEN[:3]), number) for number in (1, 3, 4)]
    assert told == ["0.5 degrees off: fits well", "6.0 degrees off: fits badly", "now"]


def test_stops_of_a_round_that_is_done_or_taken_again_in_part():
    done = sight(seen=SEEN, place=PLACE)
    assert [words.stop_words(done, number) for number in (1, 2, 3, 4)] == [
        "0.5 degrees off: fits well",
        "2.5 degrees off: fits fairly",
        "6.0 degrees off: fits badly",
        "30.0 degrees off: fits none of the others and was left out",
    ]
    again = sight("drive", 2, seen=SEEN, place=PLACE)
    assert [words.stop_words(again, number) for number in (1, 2)] == ["0.5 degrees off: fits well", "now"]


def test_the_verdict_says_what_to_do():
    assert words.verdict(sight(seen=SEEN, quality="good", place=PLACE)).startswith("Good")
    assert "stop 4 again" in words.verdict(sight(seen=SEEN, quality="fair", place=PLACE))
    assert "stop 3 again" in words.verdict(sight(seen=SEEN[:3], quality="poor", place=PLACE))
    assert words.verdict(sight("point", seen=SEEN, quality="good", place=PLACE)) == ""


def test_the_time_in_words():
    assert words.clock_words(65.9, ready=False).startswith("1 min 05 s since you began")
    assert words.clock_words(53, ready=True) == "Ready after 0 min 53 s: under 2 minutes, as aimed at"
    assert words.clock_words(130, ready=True) == "Ready after 2 min 10 s: the aim is 2 minutes"
