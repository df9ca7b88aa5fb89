import re

import pytest
from numpy.testing import assert_allclose

from armspan.config.room_file import default_stops, parse_room, read_room
from armspan.config.virtual_entries import ReplayedBand, ReplayedRobot, SimulatedBand, SimulatedRobot
from armspan.errors import ConfigError
from armspan.records import Body, Sheet, Zone
from command_line import written_room
from small_rooms import ROOM

BODY = {"eye_height_m": 1.6, "shoulder_to_eye_m": [0.06, 0.15, 0.22], "shoulder_to_fingertip_m": 0.72}
BAND, ROBOT = ROOM["bands"][0], ROOM["robots"][0]


def refusal(**changes):
    with pytest.raises(ConfigError) as caught:
        parse_room(ROOM | changes)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_room_from_its_file(tmp_path):
    room = read_room(written_room(tmp_path / "room.toml", ROOM))
    assert room.sheet == Sheet(0.6, 0.45)
    assert room.bands == (SimulatedBand("wrist"),)
    assert room.robots[1] == SimulatedRobot("elm", (0.4, 0.24), 90.0)
    assert room.simulation.person.at_m == (0.3, 0.65)
    assert room == parse_room(ROOM)


def test_what_the_conductor_gets_of_it():
    body = Body(1.6, (0.06, 0.15, 0.22), 0.72)
    settings = parse_room(ROOM | {"posture": "natural", "led_zero_deg": 30.0, "feedback": True}).settings(body)
    assert settings.body == body
    assert (settings.robots, settings.bands[0].name) == (("ash", "elm"), "wrist")
    assert settings.zones == (Zone("pond", ((0.08, 0.2), (0.18, 0.2), (0.18, 0.3), (0.08, 0.3))),)
    assert settings.stops == ((0.12, 0.1), (0.5, 0.1), (0.48, 0.36))
    assert (settings.posture, settings.led_zero_deg, settings.feedback) == ("natural", 30.0, True)


def test_stops_are_drawn_up_where_none_are_told():
    stops = {key: value for key, value in ROOM.items() if key != "stops_m"}
    found = parse_room(stops).settings(Body(1.6, (0.0, 0.1, 0.2), 0.7)).stops
    assert_allclose(found, [[0.08, 0.08], [0.52, 0.08], [0.52, 0.37], [0.08, 0.37]])
    assert default_stops(Sheet(1.0, 1.0), inset=0.1)[2] == (0.9, 0.9)


def test_replayed_devices():
    bands = [{"kind": "replay", "name": "wrist", "log": "a.mcap", "rate_hz": 52.0}]
    robots = [{"kind": "replay", "name": "ash", "log": "b.mcap"}]
    room = parse_room(ROOM | {"bands": bands, "robots": robots, "body": BODY})
    assert room.bands == (ReplayedBand("wrist", "a.mcap", rate_hz=52.0),)
    assert room.robots == (ReplayedRobot("ash", "b.mcap"),)
    assert room.settings(Body(1.6, (0.0, 0.1, 0.2), 0.7)).bands[0].rate_hz == 52.0
    assert "[body] is missing: a real person's measures are needed" in refusal(bands=bands, robots=robots)
    wrong = BODY | {"eye_height_m": 160.0}
    assert "did you mean 1.6?" in refusal(bands=bands, robots=robots, body=wrong)
    assert "rate_hz = 0.0; expected 1 to 2000" in refusal(bands=[bands[0] | {"rate_hz": 0.0}], robots=robots, body=BODY)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"colour": "red"}, "at the top of the file: object contains unknown field `colour`"),
        ({"sheet": {"width_m": 0.6}}, "at sheet: object missing required field `height_m`"),
        ({"sheet": {"width_m": 60.0, "height_m": 45.0}}, "sheet.width_m is 60.0; expected metres between 0.05 and 20"),
        ({"bands": [BAND | {"fusion": "magic"}]}, "at bands[0].fusion: invalid enum value 'magic'"),
        (
            {"bands": [BAND | {"kind": "metawaer"}]},
            "at bands[0].kind: kind 'metawaer' does not exist; there are",
        ),
        ({"robots": [ROBOT, {"kind": "simulated"}]}, "at robots[1]: object missing required field `name`"),
        ({"robots": [ROBOT | {"start_m": "here"}]}, "at robots[0].start_m: expected `array`, got `str`"),
        ({"model": "elbow"}, "at model: invalid enum value 'elbow'"),
        ({"bands": []}, "at least one entry in [[bands]] and one in [[robots]]"),
        ({"robots": []}, "at least one entry in [[bands]] and one in [[robots]]"),
        ({"limits": {"speed_m_s": 1.0}}, "limits.speed_m_s is 1.0; expected more than 0 and at most 0.3"),
        ({"selection": {"dwell_s": 9.0}}, "dwell_s is 9.0; a dwell lasts 0.3 to 2 s"),
        ({"table_height_m": 75.0}, "table_height_m is 75.0; expected metres between 0 and 2"),
        ({"light_height_m": 45.0}, "light_height_m is 45.0; expected metres between 0 and 0.5"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(changes, told):
    assert told in refusal(**changes)


@pytest.mark.parametrize(
    ("corners", "told"),
    [
        ([[0.1, 0.1], [0.3, 0.3]], "zone 'z' has 2 corners; a polygon has three at least"),
        ([[0.1, 0.1], [0.3, 0.3], [0.3, 0.1], [0.1, 0.3]], "zone 'z' crosses itself or has no area"),
        ([[0.1, 0.1], [0.2, 0.2], [0.3, 0.3]], "zone 'z' crosses itself or has no area"),
        ([[0.1, 0.1], [0.1, 0.1], [0.1, 0.1]], "zone 'z' crosses itself or has no area"),
        ([[-0.1, 0.1], [0.3, 0.1], [0.3, 0.3]], "zone 'z' reaches outside the sheet of 0.6 x 0.45 m"),
        ([[0.1, 0.1], [0.3, 0.1], [0.3, 0.46]], "zone 'z' reaches outside the sheet"),
        ([[float("nan"), 0.1], [0.3, 0.1], [0.3, 0.4]], "at zones[0].polygon_m[0][0]: nan is not a finite number"),
    ],
)
def test_zones(corners, told):
    assert told in refusal(zones=[{"name": "z", "polygon_m": corners}])


def test_a_zone_may_reach_the_rim_in_either_order():
    whole = [[0.0, 0.0], [0.6, 0.0], [0.6, 0.45], [0.0, 0.45]]
    for corners in (whole, whole[::-1]):
        assert len(parse_room(ROOM | {"zones": [{"name": "all", "polygon_m": corners}]}).zones[0].polygon_m) == 4


def test_names_tell_things_apart():
    assert "robot 'ash' is named twice" in refusal(robots=[ROBOT, ROBOT])
    assert "band 'wrist' is named twice" in refusal(bands=[BAND, BAND | {"segment": "upperarm"}])
    assert "zone 'pond' is named twice" in refusal(zones=ROOM["zones"] * 2)


def test_bands_sit_where_pointing_needs_them():
    upper = {"kind": "simulated", "name": "elbow", "segment": "upperarm"}
    assert "bands sit on upperarm; pointing needs one band on the forearm" in refusal(bands=[upper])
    assert "bands sit on forearm, forearm;" in refusal(bands=[BAND, upper | {"segment": "forearm"}])
    assert "model two-band needs a band on the upper arm" in refusal(model="two-band")
    assert parse_room(ROOM | {"model": "two-band", "bands": [BAND, upper]}).model == "two-band"


def test_places_on_the_sheet():
    assert "the stop (0.7, 0.1) lies off the sheet of 0.6 x 0.45 m" in refusal(stops_m=[[0.1, 0.1], [0.7, 0.1]])
    assert "stops_m has 2 stops; the set-up needs three" in refusal(stops_m=[[0.1, 0.1], [0.2, 0.1]])
    assert "the start of robot 'ash', (0.1, -0.1) lies off" in refusal(robots=[ROBOT | {"start_m": [0.1, -0.1]}])


def test_a_known_mounting_is_a_unit_quaternion():
    assert "of length 2.000; a unit quaternion" in refusal(bands=[BAND | {"wrist_from_sensor": [1, 1, 1, 1]}])
    turned = parse_room(ROOM | {"bands": [BAND | {"wrist_from_sensor": [0.0, 0.6, 0.8, 0.0]}]})
    assert turned.bands[0].wrist_from_sensor == (0.0, 0.6, 0.8, 0.0)


@pytest.mark.parametrize("simulation", [{"seed": -1}, {"person": {"trials": -3}}])
def test_what_is_counted_is_not_negative(simulation):
    assert "expected whole numbers from 0" in refusal(simulation=simulation)


def test_whole_numbers_are_lengths_too():
    assert parse_room(ROOM | {"sheet": {"width_m": 1, "height_m": 1}}).sheet == Sheet(1.0, 1.0)


def test_the_file_is_named(tmp_path):
    path = written_room(tmp_path / "lab.toml", ROOM | {"bands": []})
    with pytest.raises(ConfigError, match=f"^{re.escape(str(path))}: the room needs"):
        read_room(path)
    with pytest.raises(ConfigError, match=r"No such file or directory\. `armspan init"):
        read_room(tmp_path / "none.toml")
    path.write_text("= 3")
    with pytest.raises(ConfigError, match=r"lab\.toml is not TOML: "):
        read_room(path)
