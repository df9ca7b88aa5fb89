import json
import math

import msgspec
import numpy as np
import pytest

from armspan.conductor import BandSettings, Settings
from armspan.conductor.sight import Limb, Sight, StopSeen
from armspan.records import (
    Body,
    ImuSample,
    Light,
    Link,
    Pointed,
    RobotState,
    Say,
    Scores,
    Selected,
    Sheet,
    Stop,
    Zone,
)
from armspan.web.shown import STRIP_ROWS, Shown, ellipse, encode

SETTINGS = Settings(
    Body(1.6, (0.06, 0.15, 0.22), 0.72),
    Sheet(0.9, 0.6),
    (BandSettings("wrist"),),
    ("amber", "birch"),
    zones=(Zone("garden", ((0.1, 0.1), (0.3, 0.1), (0.2, 0.3))),),
    stops=((0.1, 0.1), (0.8, 0.1), (0.8, 0.5)),
    led_zero_deg=90.0,
)


class Mind:
    """Believes what it is told to."""

    def __init__(self, place=None, ray=None, waiting=None):
        self.settings = SETTINGS
        limb = Limb("right", ((0.0, -0.2, 1.4), (0.3, -0.2, 1.4), (0.7, -0.2, 1.4)))
        seen = (StopSeen(1, 0.0123456, True),)
        self.seen = Sight("point", 2, 3, seen, "", (limb,), place, ray, False, waiting or {}, (), ())

    def sight(self):
        return self.seen


def shown(**believed):
    made = Shown()
    made.clear(Mind(**believed))
    return made


def test_without_a_room_there_is_an_empty_frame_and_no_room():
    assert (Shown().frame(), Shown().room()) == ({"t": 0.0, "room": 0}, None)


def test_the_room_message_tells_what_stands_still():
    room = shown().room()
    assert (room["sheet"], room["robots"], room["number"]) == ([0.9, 0.6], ["amber", "birch"], 1)
    assert room["zones"] == [{"name": "garden", "polygon": ((0.1, 0.1), (0.3, 0.1), (0.2, 0.3))}]
    assert room["bands"] == [{"name": "wrist", "segment": "forearm", "arm": "right"}]
    assert room["led_zero"] == pytest.approx(math.pi / 2)


def test_a_room_that_changed_has_another_number():
    page = shown()
    assert (page.frame()["room"], page.frame()["room"]) == (1, 1)
    page.mind.settings = msgspec.structs.replace(SETTINGS, zones=())
    assert page.frame()["room"] == page.room()["number"] == 2
    page.clear(page.mind)
    assert page.frame()["room"] == 3


def test_a_robot_is_a_row_with_its_state_as_a_sum():
    page = shown(waiting={"birch": "too close"})
    assert [row[3] for row in page.frame()["robots"]] == [8, 8 + 2]
    page(RobotState(1.0, "amber", (0.123456, 0.2), 1.23456, held=True, battery=0.789))
    page(Light(1.0, "amber", (255, 1, 2), 3))
    page(Link(1.0, "amber", False))
    assert page.frame()["robots"][0] == [0.1235, 0.2, 1.235, 1 + 4, 0.79, 0, 0, 0, 0xFF0102, 0, 0]
    page(Link(1.1, "amber", True))
    page(RobotState(1.1, "amber", (0.2, 0.2), 0.0))
    page(Light(1.1, "amber", (0, 0, 255)))
    assert page.frame()["robots"][0] == [0.2, 0.2, 0.0, 0, -1.0, *[255] * 6]


def test_strips_are_the_last_rows_thinned_with_their_times():
    page = shown()
    for k in range(200):
        page(ImuSample(k / 100, "wrist", (k, 0.0, 9.81234), (0.0, 0.0, 1.0)))
    rows = page.frame()["strips"]["wrist"]
    assert len(rows) == STRIP_ROWS
    assert np.diff([row[0] for row in rows]) == pytest.approx(0.02)
    assert rows[-1][1:] == [pytest.approx(100 * rows[-1][0]), 0.0, 9.81, 0.0, 0.0, 1.0]
    assert page.strips["wrist"].rate == pytest.approx(100.0)


def test_what_is_pointed_at_comes_with_its_ellipse_or_why_not():
    page = shown()
    page(Pointed(1.0, "wrist", (0.4, 0.3), ((4e-4, 0.0), (0.0, 1e-4)), "amber", None, 0.93, True))
    at = page.frame()["at"]
    assert (at["robot"], at["p"], at["decided"]) == ("amber", 0.93, True)
    assert at["ellipse"] == [pytest.approx(0.0429, abs=1e-4), pytest.approx(0.0215, abs=1e-4), 0.0]
    page(Pointed(1.1, "wrist", None, None, refused="the band is not set up"))
    assert page.frame()["at"]["refused"] == "the band is not set up"


def test_an_ellipse_lies_along_its_longer_axis():
    turn = np.array([[math.cos(0.7), -math.sin(0.7)], [math.sin(0.7), math.cos(0.7)]])
    spread = turn @ np.diag([9e-4, 1e-4]) @ turn.T
    long, short, angle = ellipse(tuple(map(tuple, spread)))
    assert (long / short, angle) == (pytest.approx(3.0, abs=0.01), pytest.approx(0.7, abs=0.001))


def test_before_the_set_up_the_person_is_drawn_at_the_lower_edge():
    frame = shown().frame()
    assert not frame["placed"]
    assert frame["eye"] == pytest.approx([0.45, 0.95, 0.75 - 1.6])
    (arm,) = frame["arms"]
    assert arm["points"][2] == pytest.approx([0.65, 0.25, -0.65])  # stretched away from the person, over the table
    assert frame["setup"]["seen"] == [[1, 0.0123, True]]


def test_the_ray_ends_on_the_sheet():
    ray = ((0.0, 0.0, 1.6), (math.cos(0.9), 0.0, -math.sin(0.9)))
    frame = shown(place=(0.4, 0.8, 0.75, math.pi / 2), ray=ray).frame()
    eye, end = frame["ray"]
    assert frame["placed"]
    assert eye == pytest.approx([0.4, 0.8, -0.85])
    assert end == pytest.approx([0.4, 0.8 - 0.85 / math.tan(0.9), 0.0], abs=1e-3)


def test_words_choices_and_scores_are_carried():
    page = shown()
    page(Say(1.0, "Point at amber", "point:amber"))
    page(Selected(2.0, "wrist", None, "garden", 0.9, "dwell"))
    page(Scores(2.0, "wrist", ("fist", "none"), (0.75, 0.25)))
    frame = json.loads(encode(page.frame()))
    assert (frame["say"], frame["cue"], frame["t"]) == ("Point at amber", "point:amber", 2.0)
    assert frame["chosen"] == {"name": "garden", "t": 2.0}
    assert frame["scores"] == [["fist", 0.75], ["none", 0.25]]


def test_only_what_is_shown_makes_a_new_version():
    page = shown()
    before = page.version
    page(Stop(1.0, None, "stop"))
    assert page.version == before + 1
    page(Link(1.0, "wrist", True))
    assert page.version == before + 2
