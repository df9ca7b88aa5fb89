import asyncio
import contextlib
import math
from pathlib import Path

import numpy as np
import pytest

import fast_time
from armspan.conductor.robots_only import RobotsOnly
from armspan.config import house
from armspan.config.doors import make_doors
from armspan.config.room_file import ZoneEntry, parse_room
from armspan.config.swarm_act import Act, behind_relay, drive, plant_of, simulate
from armspan.config.swarm_run import Wanted, places, run_in_room, swarm_run
from armspan.devices.cellulo.emulator import Emulator, addresses
from armspan.devices.cellulo.emulator import places as emulated_places
from armspan.devices.cellulo.firmware import Firmware
from armspan.errors import ConfigError, DeviceNotFound
from armspan.records import GoTo, Press, RobotState, Sheet, Stop, Tick
from armspan.session import Stopwatch
from armspan.simulation.discs import IdealDiscs
from armspan.simulation.robots import VirtualRobots
from armspan.swarm.limits import Limits
from small_rooms import ROOM

SHEET, LIMITS = Sheet(1.0, 0.8), Limits(latency_s=0.03)
SPACING = 2 * (0.045 + 0.15 * 0.03) + 0.01 + 0.005
TRIANGLE = ZoneEntry("pond", ((0.1, 0.1), (0.5, 0.1), (0.5, 0.5)))


def placed(how, n, sheet=SHEET, seed=0):
    return places(how, n, sheet, LIMITS, np.random.default_rng(seed))


def nearest(xy):
    return min(math.dist(a, b) for k, a in enumerate(xy) for b in xy[:k])


def played(run):
    records, act = [], Act(run)
    asyncio.run(simulate(act, [records.append]))
    return act, records


@pytest.mark.parametrize(("how", "most"), [("random", 30), ("line", 8), ("ring", 19), ("grid", 56)])
def test_robots_begin_apart_and_on_the_sheet(how, most):
    # (1.0 - 0.09) / 0.114 = 7.98 and (0.8 - 0.09) / 0.114 = 6.2: 8 x 7 on a grid; asin(0.114 / 0.71) = pi / 19.5
    xy = placed(how, most)
    assert xy.shape == (most, 2)
    assert nearest(xy) >= SPACING - 1e-9
    assert (xy >= 0.045 - 1e-9).all()
    assert (xy <= np.array([1.0, 0.8]) - 0.045 + 1e-9).all()


@pytest.mark.parametrize(("how", "n"), [("random", 70), ("line", 9), ("ring", 20), ("grid", 57)])
def test_more_robots_than_fit_are_refused(how, n):
    with pytest.raises(ConfigError, match=rf"{n} robots do not fit on a sheet of 1 x 0.8 m 114 mm apart \({how}\)"):
        placed(how, n)


@pytest.mark.parametrize("how", ["line", "ring", "grid", "random"])
def test_one_robot_always_fits_if_the_sheet_is_larger_than_it(how):
    assert placed(how, 1, Sheet(0.091, 0.091)).shape == (1, 2)
    with pytest.raises(ConfigError, match=r"no robot fits on a sheet of 0\.08 x 0\.2 m"):
        placed(how, 1, Sheet(0.08, 0.2))


def test_a_line_runs_along_the_longer_side():
    np.testing.assert_allclose(placed("line", 3, Sheet(0.4, 0.69)), [[0.2, 0.045], [0.2, 0.345], [0.2, 0.645]])


def test_a_seed_is_a_start():
    np.testing.assert_array_equal(placed("random", 5, seed=3), placed("random", 5, seed=3))
    assert not np.array_equal(placed("random", 5, seed=3), placed("random", 5, seed=4))


def test_limits_follow_the_plant_and_its_latency():
    discs = swarm_run(Wanted(behaviour="sweep", plant="disc", latency=0.1))
    assert discs.settings.limits == Limits(body_radius_m=0.0375, accel_m_s2=10.0, latency_s=0.1)
    assert discs.account().gaps.body == 0.0375
    assert isinstance(plant_of(discs), IdealDiscs)
    robots = swarm_run(Wanted(behaviour="sweep", latency=0.1))
    assert robots.settings.limits == Limits(latency_s=0.13)
    plant = plant_of(robots)
    assert isinstance(plant, VirtualRobots)
    assert plant.plant.latency == pytest.approx((0.105, 0.13))


@pytest.mark.parametrize("name", ["random walk", "random_walk", "Random-Walk"])
def test_a_behaviours_words_are_joined_in_any_way(name):
    assert swarm_run(Wanted(behaviour=name)).behaviour == "random-walk"


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ({"behaviour": "dance"}, "behaviour 'dance' does not exist; there are: come, deploy,"),
        ({"robots": 0}, "0 robots; expected 1 to 1000"),
        ({"robots": 60}, "60 robots do not fit"),
        ({"zones": (ZoneEntry("z", ((0.1, 0.1), (1.2, 0.1), (0.5, 0.5))),)}, "zone 'z' reaches outside the sheet"),
        (
            {"zones": (ZoneEntry("z", ((0.1, 0.1), (0.5, 0.5), (0.5, 0.1), (0.1, 0.5))),)},
            "zone 'z' crosses itself",
        ),
        ({"behaviour": "sweep@lake", "zones": (TRIANGLE,)}, "zone 'lake' does not exist; there are: pond"),
        ({"behaviour": "gather@pond", "zones": (TRIANGLE,)}, "gather knows no zones"),
        ({"behaviour": "follow"}, "follow goes where somebody points: tell a spot with --point"),
        ({"behaviour": "come"}, "come goes to the user: tell where they stand with --user"),
        ({"behaviour": "patrol"}, "patrol goes from zone to zone: give one at least with --zone"),
        ({"points": ((2.0, 0.5),)}, r"the pointed spot \(2.0, 0.5\) lies off the sheet"),
        ({"user": (0.5, 99.0)}, r"the user stands at \(0.5, 99.0\)"),
        ({"user": (0.5, math.nan)}, "the user stands at"),
        ({"user": (math.nan, 0.5)}, "the user stands at"),
        ({"latency": 0.6}, "limits.latency_s is 0.63"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_runs(wanted, words):
    with pytest.raises(ConfigError, match=words):
        swarm_run(Wanted(**{"behaviour": "gather"} | wanted))


def test_a_single_zone_is_what_is_covered():
    run = swarm_run(Wanted(behaviour="sweep", zones=(TRIANGLE,)))
    assert run.behaviour == "sweep@pond"
    assert run.account().coverage.area.area == pytest.approx(0.08)
    whole = swarm_run(Wanted(behaviour="random-walk", zones=(TRIANGLE,)))
    assert (whole.behaviour, whole.account().coverage.area.area) == ("random-walk", pytest.approx(1.0))


def test_a_room_tells_sheet_zones_limits_and_robots():
    room = parse_room(ROOM | {"limits": {"speed_m_s": 0.08}})
    run = run_in_room(Wanted(behaviour="patrol", latency=0.1), room)
    assert run.settings.sheet == room.sheet
    assert run.settings.robots == ("ash", "elm")
    assert run.settings.limits == Limits(speed_m_s=0.08, latency_s=0.13)
    np.testing.assert_allclose(run.starts, [[0.2, 0.1], [0.4, 0.24]])
    np.testing.assert_allclose(run.headings, [0.0, math.pi / 2])
    act, _ = played(run_in_room(Wanted(behaviour="patrol", seconds=3.0), room))
    np.testing.assert_allclose(act.account.places[0], [[0.2, 0.1], [0.4, 0.24]], atol=1e-6)


def room_with(*robots):
    return parse_room(
        ROOM
        | {
            "body": {"eye_height_m": 1.6, "shoulder_to_eye_m": [0.06, 0.15, 0.22], "shoulder_to_fingertip_m": 0.72},
            "bands": [{"kind": "replay", "log": "a.mcap", "name": "wrist"}],
            "robots": list(robots),
        }
    )


def real(name, mac, port=2556):
    return {"kind": "cellulo", "name": name, "address": mac, "door": "relay", "relay": f"127.0.0.1:{port}"}


def test_a_rooms_robots_are_of_one_kind_and_can_be_driven():
    replayed = {"kind": "replay", "log": "a.mcap", "name": "ash"}
    with pytest.raises(ConfigError, match="robot 'ash' is replayed, and nobody can drive it"):
        run_in_room(Wanted(behaviour="gather"), room_with(replayed))
    virtual = {"kind": "simulated", "name": "elm", "start_m": [0.2, 0.2]}
    with pytest.raises(ConfigError, match="robot 'oak' is not simulated like 'elm'"):
        run_in_room(Wanted(behaviour="gather"), room_with(virtual, real("oak", addresses(1)[0])))


@contextlib.asynccontextmanager
async def emulated(names, sheet):
    n = len(names)
    firmware = Firmware(emulated_places(n, sheet), np.zeros(n), sheet, np.random.default_rng(0))
    emulator = Emulator(firmware, dict(zip(addresses(n), names, strict=True)))
    async with emulator.listening() as port:
        living = asyncio.create_task(emulator.live())
        try:
            yield port
        finally:
            living.cancel()
            await asyncio.gather(living, return_exceptions=True)


def test_a_rooms_real_robots_are_driven_from_where_they_stand(monkeypatch):
    fast_time.hasten(monkeypatch)

    async def scene():
        async with emulated(("ash", "elm"), Sheet(**ROOM["sheet"])) as port:
            room = room_with(*(real(name, mac, port) for name, mac in zip(("ash", "elm"), addresses(2), strict=True)))
            act, now = (
                Act(run_in_room(Wanted(behaviour="gather", seconds=20.0, points=((0.4, 0.3),)), room)),
                Stopwatch(),
            )
            assert act.run.room is not None
            await drive(act, make_doors(act.run.room, now, Path()), now, "there")
            return act

    act = fast_time.run(scene, 60.0)
    assert act.began is not None
    assert math.dist(act.states["ash"].xy, act.states["elm"].xy) < 0.16
    assert act.account.document()["violations"] == {}


def test_the_behaviour_begins_once_all_robots_were_heard():
    act, records = played(swarm_run(Wanted(behaviour="gather", robots=3, seconds=1.0, points=((0.5, 0.4),))))
    presses = [record for record in records if isinstance(record, Press)]
    assert [(press.name, press.value) for press in presses] == [
        ("point", "0.500000 0.400000"),
        ("behaviour", "gather"),
        ("quit", ""),
    ]
    heard = {record.robot for record in records[: records.index(presses[1])] if isinstance(record, RobotState)}
    assert heard == {"r1", "r2", "r3"}
    assert act.began == presses[1].t
    assert not any(isinstance(record, GoTo) for record in records[: records.index(presses[1])])


def test_a_gathering_comes_to_the_pointed_spot_and_ends():
    act, records = played(swarm_run(Wanted(behaviour="gather", robots=3, seconds=12.0, seed=2, points=((0.3, 0.7),))))
    assert np.linalg.norm(act.account.places[-1].mean(axis=0) - [0.3, 0.7]) < 0.02
    assert 1.0 < act.finished < 12.0
    assert not any(isinstance(record, GoTo) for record in records if record.t > act.finished)
    assert any(isinstance(record, Stop) for record in records)  # the way out


def test_the_spot_moves_from_one_place_to_the_next_in_equal_times():
    run = swarm_run(
        Wanted(behaviour="follow", robots=1, seconds=8.0, points=((0.2, 0.2), (0.6, 0.2), (0.6, 0.3)), seed=1)
    )
    act, records = played(run)
    spots = [(r.t, *map(float, r.value.split())) for r in records if isinstance(r, Press) and r.name == "point"]
    for t, x, y in spots:
        along = (t - act.began) / 4.0
        assert (x, y) == pytest.approx((0.2 + 0.4 * min(max(along, 0), 1), 0.2 + 0.1 * max(along - 1, 0)), abs=1e-5)
    assert len(spots) > 150
    assert np.linalg.norm(act.account.places[-1][0] - [0.6, 0.3]) < 0.03


def test_true_places_are_taken_every_ten_milliseconds_and_wishes_at_every_tick():
    act, records = played(swarm_run(Wanted(behaviour="disperse", robots=2, seconds=2.0)))
    np.testing.assert_allclose(act.account.times, np.arange(201) / 100, atol=1e-9)
    assert sum(isinstance(record, Tick) for record in records) == 40


def robots_alone(*presses):
    """A mind for robots alone that was told things; what it says to each, and then to two ticks."""
    mind = RobotsOnly(swarm_run(Wanted(behaviour="gather", robots=2, start="line")).settings)
    for robot, x in (("r1", 0.2), ("r2", 0.8)):
        mind.step(RobotState(0.1, robot, (x, 0.5), 0.0))
    said = [mind.step(Press(0.1, name, value)) for name, value in presses]
    return said, mind.step(Tick(0.1)) + mind.step(Tick(0.15))


def test_a_pressed_spot_is_where_robots_go_until_it_is_taken_back():
    said, goals = robots_alone(("point", "0.5 0.8"), ("behaviour", "follow"))
    assert said[0] == []
    assert any(isinstance(goal, GoTo) and goal.xy[1] > 0.5 for goal in goals)
    said, goals = robots_alone(("point", "0.5 0.8"), ("behaviour", "follow"), ("point", ""))
    assert {stop.robot for stop in said[2]} == {"r1", "r2"}
    assert goals == []


@pytest.mark.parametrize("value", ["here", "1", "1 2 3", "nan 1", "1 inf", "30 0", "0 -30"])
def test_a_pressed_place_that_is_none_is_told_and_changes_nothing(value):
    for name in ("point", "user"):
        said, _ = robots_alone((name, value))
        assert [say.cue for say in said[0]] == ["trouble"]
        assert repr(value) in said[0][0].text


def test_robots_come_to_a_user_that_was_pressed():
    said, goals = robots_alone(("user", "0.5 -0.4"), ("behaviour", "come"))
    assert said[0] == []
    assert goals
    assert all(goal.xy[1] < 0.5 for goal in goals if isinstance(goal, GoTo))


@pytest.mark.parametrize("plant", ["cellulo", "disc"])
def test_the_same_seed_is_the_same_run(plant):
    wanted = Wanted(behaviour="random-walk", robots=3, seconds=3.0, seed=5, plant=plant)
    first, again = (played(swarm_run(wanted))[0].account.document() for _ in range(2))
    assert first == again
    other = Wanted(behaviour="random-walk", robots=3, seconds=3.0, seed=6, plant=plant)
    assert played(swarm_run(other))[0].account.document() != first


def test_a_relay_where_nobody_is_heard_is_told(monkeypatch):
    monkeypatch.setattr("armspan.config.swarm_act.HEARD", 0.3)
    act, now = Act(swarm_run(Wanted(behaviour="gather", robots=2))), Stopwatch()
    strangers = ["00:06:66:E7:0A:01", "00:06:66:E7:0A:02"]

    async def scene():
        async with emulated(("r1", "r2"), SHEET) as port:
            await drive(act, behind_relay(act, "127.0.0.1", port, strangers, now), now, "behind the relay")

    with pytest.raises(DeviceNotFound, match=r"r1, r2 not heard within 0\.3 s behind the relay; see that they are on"):
        asyncio.run(scene())
    monkeypatch.setattr("armspan.config.swarm_act.HEARD", 5.0)
    with pytest.raises(DeviceNotFound, match=r"127\.0\.0\.1:9"):
        asyncio.run(drive(act, behind_relay(act, "127.0.0.1", 9, strangers, now), now, "behind the relay"))


def test_a_dictionary_and_a_model_speak_of_the_same_gestures():
    labels = ("wave", "halt")
    house._check_labels({"wave": "gather", "halt": "stop"}, labels)
    with pytest.raises(ConfigError, match="gesture 'flibber' does not exist; there are: halt, wave"):
        house._check_labels({"flibber": "stop"}, labels)
    with pytest.raises(ConfigError, match=r"no gesture that the model knows \(wave, halt\) is mapped to 'stop'"):
        house._check_labels({"wave": "gather", "stop": "stop"}, labels)
