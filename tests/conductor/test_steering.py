import msgspec
import pytest

from armspan.conductor.robots_only import RobotsOnly, press_robots
from armspan.conductor.steering import Steering
from armspan.records import Drive, GoTo, Light, Link, Press, RobotState, Say, Stop, Tick, Touch
from puppet import settings

PLACES = {"ash": (0.3, 0.3), "elm": (0.6, 0.3)}


class Herd:
    """Robots that follow at once, and a mind without an arm."""

    def __init__(self, **changes):
        self.mind = RobotsOnly(settings(**changes))
        self.at, self.t, self.held, self.silent, self.battery = dict(PLACES), 0.0, set(), set(), {}
        self.outputs = []
        self.run(0.1)

    def tell(self, event):
        found = self.mind.step(event)
        self.outputs += found
        for command in found:
            if isinstance(command, GoTo):
                assert command.robot not in self.held
                self.at[command.robot] = command.xy
        return found

    def run(self, seconds):
        before, end = len(self.outputs), self.t + seconds
        while self.t < end - 1e-9:
            self.t = round(self.t + 0.05, 9)
            for name, xy in self.at.items():
                if name not in self.silent:
                    self.tell(RobotState(self.t, name, xy, 0.0, name in self.held, self.battery.get(name)))
            self.tell(Tick(self.t))
        return self.outputs[before:]

    def press(self, name, value=""):
        return self.tell(Press(self.t, name, value))


def motions(outputs):
    return {output.robot for output in outputs if isinstance(output, GoTo)}


def walking(**changes):
    herd = Herd(**changes)
    herd.press("behaviour", "random-walk")
    assert motions(herd.run(0.5)) == {"ash", "elm"}
    return herd


STOPS = [
    Press(9.0, "stop"),
    Press(9.0, "quit"),
    Press(9.0, "behaviour", "stop"),
    Touch(9.0, "ash", 2, "long"),
    Press(9.0, "command", '{"type": "Stop", "t": 0}'),
]


@pytest.mark.parametrize("event", STOPS, ids=lambda event: f"{type(event).__name__} {getattr(event, 'name', '')}")
def test_after_a_stop_nothing_moves_until_a_resume_and_a_new_command(event):
    herd = walking()
    stops = [output for output in herd.tell(event) if isinstance(output, Stop)]
    assert [stop.robot for stop in stops] == [None]
    assert motions(herd.run(1)) == set()
    assert [output.text for output in herd.press("behaviour", "gather")] == [
        "gather: the robots are stopped; resume first"
    ]
    herd.press("command", msgspec.json.encode(GoTo(0.0, "ash", (0.5, 0.5), 0.1, herd.t + 9)).decode())
    assert motions(herd.run(1)) == set()
    herd.press("resume")
    assert motions(herd.run(1)) == set()
    herd.press("behaviour", "gather")
    assert motions(herd.run(1)) == {"ash", "elm"}


def unfit_held(herd):
    herd.held.add("ash")


def unfit_silent(herd):
    herd.silent.add("ash")


def unfit_battery(herd):
    herd.battery["ash"] = 0.02


def unfit_off(herd):
    herd.at["ash"] = (-0.1, 0.3)


@pytest.mark.parametrize("befall", [unfit_held, unfit_silent, unfit_battery, unfit_off])
def test_a_robot_that_must_not_be_driven_waits_for_a_new_command_the_others_go_on(befall):
    herd = walking()
    befall(herd)
    later = herd.run(1.5)
    assert [output.robot for output in later if isinstance(output, Stop)] == ["ash"]
    herd.held.clear(), herd.silent.clear(), herd.battery.clear()
    herd.at["ash"] = (0.3, 0.3)
    assert motions(herd.run(2)) == {"elm"}
    herd.press("behaviour", "random-walk:ash")
    assert "ash" in motions(herd.run(1))


def test_a_robot_whose_link_is_down_is_stopped_once_and_waits():
    herd = walking()
    told = herd.tell(Link(herd.t, "ash", False))
    assert [type(output) for output in told] == [Stop, Say]
    assert motions(herd.run(1)) == {"elm"}


def test_a_behaviour_for_some_robots_leaves_the_others_alone():
    herd = Herd()
    herd.press("behaviour", "random-walk: elm")
    assert motions(herd.run(1)) == {"elm"}
    said = herd.press("behaviour", "random-walk:oak")
    assert [output.text for output in said] == ["random-walk: robot 'oak' does not exist; there are: ash, elm."]
    herd.press("behaviour", "stop:elm")
    assert motions(herd.run(1)) == set()
    assert not herd.mind.steering.filter.stopped


def test_what_cannot_be_done_is_said_and_what_goes_on_goes_on():
    herd = walking()
    assert "set up first" in herd.press("behaviour", "come")[0].text
    assert "dance" in herd.press("behaviour", "dance")[0].text
    assert motions(herd.run(0.5)) == {"ash", "elm"}


def test_commands_from_a_script_are_filtered_like_any_other():
    herd = Herd()
    herd.press("command", msgspec.json.encode(Drive(0.0, "ash", (9.0, 0.0), 0.0, herd.t + 60)).decode())
    (go,) = [output for output in herd.run(0.05) if isinstance(output, GoTo)]
    assert go.robot == "ash"
    assert go.speed <= 0.15
    assert go.until <= herd.t + 0.3 + 1e-9
    lights = Light(0.0, "elm", (1, 2, 3))
    herd.press("command", msgspec.json.encode(lights).decode())
    assert [type(output) for output in herd.run(0.05)] == [Light]


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("go", "That is no command"),
        ('{"type": "Tick", "t": 0}', "expected JSON with a type of GoTo, Drive, Light, Haptic, Stop"),
        ('{"type": "Light", "t": 0, "robot": "oak", "colour": [1, 2, 3]}', "robot 'oak' does not exist"),
        ('{"type": "Stop", "t": 0, "robot": "oak"}', "robot 'oak' does not exist"),
        ('{"type": "Light", "t": 0, "robot": "ash", "colour": [999, 2, 3]}', "colours go from 0 to 255"),
        ('{"type": "Light", "t": 0, "robot": "ash", "colour": [1, 2, 3], "led": 77}', "lights from 0 to 5"),
        ('{"type": "Haptic", "t": 0, "robot": "ash", "strength": -1, "duration": 1}', "strength goes to 1"),
        ('{"type": "\ud800"}', "That is no command"),
        ('{"type": "Light", "x": ' + "[" * 200_000, "That is no command"),
    ],
)
def test_what_is_no_command_is_told(value, said):
    (told,) = Herd().press("command", value)
    assert said in told.text


def test_colouring_a_robot_leaves_it_in_its_behaviour():
    herd = walking()
    herd.press("command", msgspec.json.encode(Light(0.0, "ash", (1, 2, 3))).decode())
    assert motions(herd.run(1)) == {"ash", "elm"}


def test_a_behaviour_that_cannot_begin_releases_nobody():
    herd = walking()
    herd.held.add("ash")
    herd.run(0.2)
    herd.held.clear()
    herd.run(0.2)
    assert "does not exist" in herd.press("behaviour", "sweep@nowhere")[0].text
    herd.press("command", msgspec.json.encode(GoTo(0.0, "ash", (0.6, 0.5), 0.1, herd.t + 9)).decode())
    assert motions(herd.run(0.2)) == {"elm"}


def test_a_robot_that_the_room_does_not_name_takes_part_in_nothing():
    herd = Herd()
    herd.at["ghost"] = (0.45, 0.5)
    herd.run(0.1)
    herd.press("behaviour", "random-walk")
    assert motions(herd.run(1)) == {"ash", "elm"}
    assert "ghost" in herd.press("resume", "ghost")[0].text


def test_a_lease_that_is_not_renewed_ends_in_a_stop():
    herd = Herd()
    herd.press("command", msgspec.json.encode(GoTo(0.0, "ash", (0.6, 0.5), 0.1, herd.t + 9)).decode())
    out = herd.run(1)
    assert [type(output) for output in out] == [GoTo, Stop]
    assert out[1].t - out[0].t == pytest.approx(0.3)


def test_halting_latches_nothing():
    herd = walking()
    stops = herd.mind.steering.halt(herd.t, "nothing heard of wrist")
    assert sorted((stop.robot, stop.why) for stop in stops) == [(n, "nothing heard of wrist") for n in ("ash", "elm")]
    assert motions(herd.run(1)) == set()
    herd.press("behaviour", "gather")
    assert motions(herd.run(1)) == {"ash", "elm"}


def test_only_those_that_follow_the_arm_stop_when_it_points_nowhere():
    steering = Steering(settings())
    for name, xy in PLACES.items():
        steering.robot(RobotState(0.0, name, xy, 0.0))
    steering.behave(0.0, "follow", "asked for", None, ["ash"])
    steering.behave(0.0, "random-walk", "asked for", None, ["elm"])
    assert [stop.robot for stop in steering.unsteer(0.1, "expired")] == ["ash"]
    assert steering.director.busy == {"elm"}


def test_robots_whose_names_have_spaces_are_named_alone_or_apart_by_commas():
    steering = Steering(settings(robots=("ash", "old oak")))
    for robot, xy in (("ash", (0.45, 0.3)), ("old oak", (0.6, 0.25))):
        steering.robot(RobotState(0.0, robot, xy, 0.0))
    for asked, named in (("old oak", "old oak"), ("ash, old oak", "ash, old oak"), ("ash", "ash")):
        [said] = press_robots(steering, Press(0.1, "behaviour", f"gather:{asked}"), None)
        assert said.text.endswith(f"({named})")
