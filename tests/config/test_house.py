from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from armspan.conductor import Settings
from armspan.config.house import events_of, open_house
from armspan.config.room_file import parse_room
from armspan.config.virtual_entries import SimulatedPerson
from armspan.config.virtual_world import draw_trials
from armspan.errors import ArmspanError, ConfigError, LogError
from armspan.records import Body, ImuSample, Link, Press, RobotState, Say, Tick
from small_rooms import ROOM, played, small_room

BODY = {"eye_height_m": 1.5, "shoulder_to_eye_m": [0.06, 0.15, 0.22], "shoulder_to_fingertip_m": 0.7}


def settings(robots=3, zones=2):
    corners = ((0.1, 0.1), (0.2, 0.1), (0.2, 0.2))
    room = ROOM | {
        "robots": [{"kind": "simulated", "name": f"r{k}", "start_m": [0.1, 0.1]} for k in range(robots)],
        "zones": [{"name": f"z{k}", "polygon_m": corners} for k in range(zones)],
    }
    return parse_room(room).settings(Body(1.6, (0.0, 0.1, 0.2), 0.7))


def test_a_simulated_person_is_measured_by_tape_to_the_millimetre():
    house = open_house(small_room())
    body = house.settings.body
    for measure in (body.eye_height_m, *body.shoulder_to_eye_m, body.shoulder_to_fingertip_m):
        assert round(measure, 3) == measure
    assert body.eye_height_m == pytest.approx(house.world.person.person.eye_height, abs=0.08)
    assert body != open_house(small_room(seed=6)).settings.body


def test_told_measures_are_taken_as_told():
    body = open_house(small_room(body=BODY | {"arm": "left"})).settings.body
    assert (body.eye_height_m, body.arm) == (1.5, "left")
    assert open_house(small_room(body=BODY)).world.person.person != open_house(small_room(seed=7)).world.person.person


def test_telling_measures_does_not_change_the_person():
    one, other = (open_house(small_room(**more)).world.person.person for more in ({}, {"body": BODY}))
    assert one == other


def test_the_header_holds_the_settings_and_no_wall_clock():
    house = open_house(small_room())
    assert house.header["epoch_ns"] == 0
    assert house.header["settings"]["robots"] == ("ash", "elm")
    assert set(house.header["settings"]) == set(Settings.__struct_fields__)


def test_a_stature_out_of_range():
    person = ROOM["simulation"]["person"] | {"stature_m": 180.0}
    with pytest.raises(ConfigError, match=r"stature 180 m: expected 1\.2 to 2.3 m"):
        open_house(small_room(simulation={"person": person}))


# --- trials --------------------------------------------------------------------------------------------------


def test_targets_come_in_turn_and_never_twice_running():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        trials = draw_trials(SimulatedPerson(trials=23, feedback="off"), settings(), rng)
        names = [trial.target.name for trial in trials]
        assert all(a != b for a, b in pairwise(names))
        assert Counter(names[:20]) == {f"robot:r{k}": 4 for k in range(3)} | {f"zone:z{k}": 4 for k in range(2)}
        assert len(names) == 23


@pytest.mark.parametrize(("feedback", "modes"), [("off", [False]), ("on", [True]), ("both", [False, True])])
def test_modes_and_the_same_targets_in_each(feedback, modes):
    trials = draw_trials(SimulatedPerson(trials=4, feedback=feedback), settings(), np.random.default_rng(1))
    assert [trial.feedback for trial in trials] == [mode for mode in modes for _ in range(4)]
    assert len({tuple(t.target.name for t in trials[4 * k : 4 * k + 4]) for k in range(len(modes))}) == 1


def test_a_room_with_a_single_target():
    trials = draw_trials(SimulatedPerson(trials=3, feedback="on"), settings(1, 0), np.random.default_rng(1))
    assert [trial.target.name for trial in trials] == ["robot:r0"] * 3
    assert draw_trials(SimulatedPerson(trials=0), settings(), np.random.default_rng(1)) == ()


# --- replayed devices ----------------------------------------------------------------------------------------


def replayed(log="old.mcap", band="wrist", robots=("ash", "elm")):
    return parse_room(
        ROOM
        | {
            "body": BODY,
            "bands": [{"kind": "replay", "log": log, "name": band}],
            "robots": [{"kind": "replay", "log": log, "name": name} for name in robots],
        }
    )


def test_logs_are_read_once_and_found_beside_the_room(tmp_path):
    (tmp_path / "old.mcap").write_bytes(played().data)
    house = open_house(replayed(), tmp_path)
    assert list(house.logs) == ["old.mcap"]
    assert house.world is None
    with pytest.raises(LogError, match=r"none\.mcap does not exist; most like it are: old\.mcap"):
        open_house(replayed("none.mcap"), tmp_path)


def test_a_device_that_the_log_does_not_hold(tmp_path):
    (tmp_path / "old.mcap").write_bytes(played().data)
    with pytest.raises(ConfigError, match=r"device 'oak' does not exist; there are: ash, elm, wrist\."):
        open_house(replayed(robots=("ash", "oak")), tmp_path)


def test_events_of_a_log_that_concern_a_room():
    log = played().log
    log.records.insert(0, Link(0.0, "wrist", True))
    try:
        leading = events_of({"wrist", "ash"}, log, leading=True)
        behind = events_of({"wrist", "ash"}, log, leading=False)
    finally:
        del log.records[0]
    assert {type(record) for record in leading} == {Link, ImuSample, RobotState, Tick, Press}
    assert {type(record) for record in behind} == {Link, ImuSample, RobotState}
    assert {record.robot for record in leading if isinstance(record, RobotState)} == {"ash"}
    assert "quit" not in {record.name for record in leading if isinstance(record, Press)}
    assert [r for r in leading if not isinstance(r, Tick | Press)] == behind


def test_the_world_hears_words_and_its_robots_hear_commands_once(monkeypatch):
    house, heard = open_house(small_room()), []
    monkeypatch.setattr(type(house.world), "take", lambda world, record: heard.append(record))
    session = house.session([])
    say = Say(0.0, "Stretch", "stretch")
    session._tell(say)
    assert heard == [say]
    session._tell(RobotState(0.0, "ash", (0.1, 0.1), 0.0))
    assert len(heard) == 2


def test_every_error_here_is_one_of_armspans(tmp_path):
    for room in (replayed("none.mcap"), replayed("..")):
        with pytest.raises(ArmspanError):
            open_house(room, tmp_path)


def test_a_log_stands_in_only_for_the_devices_that_name_it(tmp_path):
    """A replayed band beside a virtual robot of a name that the log also knows: the log's robot stays out."""
    (tmp_path / "old.mcap").write_bytes(played().data)
    room = parse_room(
        ROOM
        | {
            "bands": [{"kind": "replay", "name": "wrist", "log": "old.mcap"}],
            "body": {
                "eye_height_m": 1.6,
                "shoulder_to_eye_m": [0.05, 0.15, 0.22],
                "shoulder_to_fingertip_m": 0.72,
            },
        }
    )
    house = open_house(room, tmp_path)
    assert house.replayed == {"old.mcap": {"wrist"}}
    assert house.world is not None
    assert not house.world.ended
    assert "ash" in house.settings.robots
    kept = events_of(house.replayed["old.mcap"], house.logs["old.mcap"], leading=False)
    assert not any(isinstance(record, RobotState) for record in kept)
