import asyncio
from types import SimpleNamespace

import msgspec
import pytest

from armspan.config.page.activities import PAUSED, ActivityList, usual
from armspan.config.page.host import PageHost
from armspan.errors import ConfigError
from armspan.log import read
from armspan.records import Body, Press, Stop, Zone
from armspan.web.activities import Act, in_words
from small_rooms import small_room

HILL = Zone("hill", ((0.3, 0.3), (0.4, 0.3), (0.35, 0.4)))


class Mind:
    """What decides, as far as the list asks it."""

    def __init__(self):
        self.settings = small_room().settings(Body(1.6, (0.06, 0.15, 0.22), 0.72))
        self.stopped = False

    def sight(self):
        return SimpleNamespace(stopped=self.stopped)


class Stage:
    """A list, the presses that it made and the zones that it kept."""

    def __init__(self, file):
        self.mind, self.pressed, self.kept = Mind(), [], []
        self.list = ActivityList(file, lambda: self.mind, self.press, self.kept.append)

    async def press(self, name, value):
        self.pressed.append((name, value))
        if name == "command":
            self.pressed[-1] = ("rest", msgspec.json.decode(value, type=Stop).robot)

    def do(self, work):
        return asyncio.run(work)

    def values(self):
        found = [value for _, value in self.pressed]
        self.pressed.clear()
        return found


@pytest.fixture
def stage(tmp_path):
    return Stage(tmp_path / "sessions" / "list.json")


def test_without_a_list_of_ones_own_it_is_what_the_rooms_gestures_ask_for(stage):
    acts = stage.list.agenda.acts
    assert acts == usual(stage.mind.settings)
    assert [act.order for act in acts][:2] == ["random-walk", "sweep"]
    assert [act.name for act in acts] == [in_words(act.order) for act in acts]
    assert "stop" not in [act.order for act in acts]


def test_start_pause_and_next_go_through_the_list_and_keep_its_place(stage):
    stage.do(stage.list.arrange([Act("", "gather"), Act("Tidy", "sweep@pond", ("elm",))]))
    for turn in ("start", "pause", "start", "next"):
        stage.do(stage.list.lead(turn))
    assert stage.values() == ["gather", "ash", "elm", "gather", "sweep@pond:elm"]
    agenda = stage.list.agenda
    assert (agenda.place, agenda.state, agenda.acts[0].name) == (1, "begun", "Come together")
    with pytest.raises(ConfigError, match="no such activity"):
        stage.do(stage.list.lead("next"))
    assert (stage.list.agenda.place, stage.values()) == (1, [])
    stage.do(stage.list.lead("previous"))
    assert (stage.list.agenda.place, stage.values()) == (0, ["gather"])


def test_a_robot_left_out_rests_and_nothing_is_asked_of_it(stage):
    stage.do(stage.list.leave_out("ash", True))
    stage.do(stage.list.behave("disperse"))
    assert stage.values() == ["ash", "disperse:elm"]
    stage.do(stage.list.leave_out("elm", True))
    stage.values()
    with pytest.raises(ConfigError, match="takes part"):
        stage.do(stage.list.behave("disperse"))
    stage.do(stage.list.leave_out("ash", False))
    stage.do(stage.list.leave_out("elm", False))
    stage.do(stage.list.behave("disperse"))
    assert stage.values() == ["disperse"]


def test_after_a_stop_nothing_begins_before_a_resume(stage):
    stage.mind.stopped = True
    with pytest.raises(ConfigError, match="press Resume all"):
        stage.do(stage.list.lead("start"))
    assert (stage.list.agenda.state, stage.pressed) == ("ready", [])


def test_where_no_room_is_open_that_is_said(stage):
    stage.mind = None
    assert stage.list.agenda.acts == ()
    for work in (stage.list.lead("start"), stage.list.behave("gather"), stage.list.arrange([]), stage.list.rezone([])):
        with pytest.raises(ConfigError, match="No room is open"):
            stage.do(work)


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (Act("Dance", "dance"), "dance"),
        (Act("Tidy", "sweep@lake"), "Tidy: .*pond"),
        (Act("Meet", "gather", ("oak",)), "Meet: .*ash"),
        (Act("Meet", "gather@pond"), "knows no zones"),
    ],
)
def test_an_activity_that_cannot_be_changes_nothing(stage, act, words):
    before = stage.list.agenda
    with pytest.raises(ConfigError, match=words):
        stage.do(stage.list.arrange([*before.acts, act]))
    assert stage.list.agenda == before


def test_the_one_whose_turn_it_is_keeps_it_when_the_list_is_put_in_another_order(stage):
    first, second, *rest = stage.list.agenda.acts
    stage.do(stage.list.choose(1))
    stage.do(stage.list.arrange([second, first, *rest]))
    assert (stage.list.agenda.place, stage.list.agenda.state) == (0, "begun")
    stage.do(stage.list.arrange([first]))
    assert (stage.list.agenda.place, stage.list.agenda.state) == (0, "ready")


def test_the_list_is_kept_for_the_next_time(stage, tmp_path):
    acts = (Act("Tidy", "sweep@pond", ("elm",)), Act("Meet", "gather"))
    stage.do(stage.list.arrange(acts))
    assert Stage(tmp_path / "sessions" / "list.json").list.agenda.acts == acts


def test_a_list_that_cannot_be_read_is_said_and_not_written_over(tmp_path):
    file = tmp_path / "list.json"
    file.write_text("[{")
    agenda = Stage(file).list.agenda
    assert len(agenda.acts) > 2
    assert "cannot be read" in agenda.note
    assert file.read_text() == "[{"


def test_zones_are_pressed_and_kept_and_a_renamed_one_takes_its_activities_along(stage):
    stage.do(stage.list.arrange([Act("", "sweep@pond"), Act("Tidy", "sweep@pond"), Act("Meet", "gather")]))
    (pond,) = stage.mind.settings.zones
    zones = [msgspec.structs.replace(pond, name="lake"), HILL]
    stage.do(stage.list.rezone(zones, ("pond", "lake")))
    assert stage.pressed == [("zones", msgspec.json.encode(zones).decode())]
    assert stage.kept == [zones]
    assert stage.list.agenda.acts == (
        Act("Cover lake in lanes", "sweep@lake"),
        Act("Tidy", "sweep@lake"),
        Act("Meet", "gather"),
    )
    with pytest.raises(ConfigError, match="needed by the activity"):
        stage.do(stage.list.rezone([HILL]))
    assert len(stage.pressed) == 1


def test_in_a_real_session_zones_change_robots_rest_and_all_of_it_is_in_the_log(tmp_path):
    host = PageHost(small_room(), "small", folder=tmp_path, sessions=tmp_path / "sessions")

    async def until(what):
        async with asyncio.timeout(10):
            while not what():
                await asyncio.sleep(0.01)

    async def scene():
        try:
            await host.steer()
            await until(lambda: host.status.activity == "steering" and len(host.shown.robots) == 2)
            await host.activities.rezone([*host.settings.zones, HILL])
            await until(lambda: HILL in host.settings.zones)
            await host.activities.behave("sweep@hill")
            await until(lambda: host.shown.mind.sight().running)
            await host.activities.lead("pause")
            await until(lambda: not host.shown.mind.sight().running)
            assert not host.shown.mind.sight().stopped
            return host.status.log
        finally:
            await host.close()

    records = read(asyncio.run(scene())).records
    assert [r.name for r in records if isinstance(r, Press)] == ["zones", "behaviour", "command", "command", "quit"]
    assert {r.robot for r in records if isinstance(r, Stop) and r.why == PAUSED} == {"ash", "elm"}
    assert [zone.name for zone in host.room.zones] == ["pond", "hill"]
