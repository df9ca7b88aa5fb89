"""The conductor in a room with a laser and receptors."""

import copy

import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.conductor import Conductor
from armspan.conductor.pointer import EXPIRED
from armspan.errors import ConfigError
from armspan.pointing.laser import LaserSettings
from armspan.records import Calibrated, Hit, Pointed, RobotState, Say, Selected, Tick
from laser_arms import LaserPuppet
from puppet import FORWARD, PLACE, RAISED, settings

RECEPTORS = LaserSettings(receptors=("ash", "elm"))


@pytest.fixture(scope="module")
def set_up():
    return ready()


@pytest.fixture
def puppet(set_up):
    """After the set-up, its spot on the robot elm from now on."""
    return copy.deepcopy(set_up)


def ready(**changes):
    made = LaserPuppet(**changes).set_up()
    made.pose(FORWARD)
    made.run(5)  # ash drives home
    made.outputs.clear()
    made.point_at("elm")
    return made


def test_the_set_up_finds_the_place_by_the_beam():
    puppet = LaserPuppet().set_up()
    [found] = puppet.of(Calibrated)
    assert_allclose(found.xyz, PLACE[0], atol=2e-3)
    assert found.yaw == pytest.approx(PLACE[1], abs=2e-3)
    assert "Bring the spot onto the light of ash and follow it (1 of 4)" in [
        say.text for say in puppet.outputs if isinstance(say, Say)
    ]


def test_a_stop_counts_only_while_the_robot_is_hit():
    puppet = LaserPuppet(working=("ash",))
    puppet.working.clear()
    puppet.lit = {"ash"}  # it was heard once, and sees nothing now
    puppet.tell(Hit(0.0, "ash", True))
    puppet.tell(Hit(0.0, "ash", False))
    puppet.lit = set()
    puppet.press("setup")
    puppet.run(15)
    assert not any("2 of 4" in say.text for say in puppet.of(Say))
    puppet.working.add("ash")
    puppet.run(4)
    assert any("2 of 4" in say.text for say in puppet.of(Say))


def test_a_receptor_that_never_saw_anything_does_not_hold_up_the_set_up():
    puppet = LaserPuppet(working=()).set_up()
    assert len(puppet.of(Calibrated)) == 1
    assert "The receptor of ash sees nothing: this goes on without it" in [say.text for say in puppet.of(Say)]


def test_pointed_is_where_the_spot_is(puppet):
    puppet.working.clear()
    puppet.point_at((0.7, 0.5))
    puppet.run(2)
    assert_allclose(puppet.of(Pointed)[-1].xy, (0.7, 0.5), atol=3e-3)


def test_a_robot_that_is_hit_is_chosen_soon(puppet):
    before = puppet.t
    puppet.run(3, until=Selected)
    [chosen] = puppet.of(Selected)
    assert (chosen.robot, chosen.zone, chosen.how) == ("elm", None, "hit")
    assert chosen.probability > 0.99
    assert 0.3 <= chosen.t - before <= 0.5
    puppet.run(5)
    assert len(puppet.of(Selected)) == 1


def test_a_hit_teaches_the_place_with_the_cursor_and_without(puppet):
    puppet.press("feedback", "on")
    puppet.robots["elm"] = (0.615, 0.25)
    puppet.shine((0.606, 0.25))
    puppet.run(3, until=Selected)
    [chosen], [refined] = puppet.of(Selected), puppet.of(Calibrated)
    assert chosen.how == "hit"
    assert refined.t == chosen.t


def test_what_is_hit_teaches_nothing_of_another_ray():
    puppet = LaserPuppet(model="head-finger", working=()).set_up()
    puppet.outputs.clear()
    puppet.press("feedback", "on")
    puppet.run(1.0)
    pointed = puppet.of(Pointed)[-1]
    puppet.robots["elm"] = pointed.xy
    puppet.step()
    puppet.tell(Hit(puppet.t, "elm", True))
    puppet.run(2, until=Selected)
    assert [chosen.how for chosen in puppet.of(Selected)] == ["hit"]
    assert puppet.of(Calibrated) == []


def test_it_can_be_chosen_again_once_it_was_dark(puppet):
    puppet.run(1)
    puppet.working.clear()
    puppet.run(0.3)
    puppet.working = {"ash", "elm"}
    puppet.run(1)
    assert len(puppet.of(Selected)) == 1  # a flicker
    puppet.working.clear()
    puppet.run(0.8)
    puppet.working = {"ash", "elm"}
    puppet.run(1)
    assert [chosen.how for chosen in puppet.of(Selected)] == ["hit", "hit"]


def test_between_two_robots_a_hit_decides(puppet):
    puppet.robots["ash"], puppet.robots["elm"] = (0.525, 0.25), (0.55, 0.25)  # the beam is nearer to elm
    puppet.working = {"ash"}
    puppet.shine((0.54, 0.25))
    puppet.run(2, until=Selected)
    assert (puppet.of(Selected)[0].robot, puppet.of(Selected)[0].how) == ("ash", "hit")


def test_a_stray_light_far_from_the_beam_chooses_nothing(puppet):
    puppet.working.clear()
    puppet.robots["ash"] = (0.1, 0.55)
    puppet.point_at((0.80, 0.08))
    puppet.run(1)
    puppet.tell(Hit(puppet.t, "ash", True))
    puppet.run(3)
    assert puppet.of(Selected) == []
    assert puppet.of(Pointed)[-1].decided is False


def test_a_stray_light_while_the_arm_points_nowhere_chooses_nothing(puppet):
    puppet.working.clear()
    puppet.pose(RAISED)
    puppet.run(1)
    puppet.tell(Hit(puppet.t, "ash", True))
    puppet.run(3)
    assert puppet.of(Selected) == []


def test_without_receptors_the_beam_alone_chooses_by_dwell():
    puppet = ready(laser=LaserSettings())
    puppet.run(3, until=Selected)
    [chosen] = puppet.of(Selected)
    assert (chosen.robot, chosen.how) == ("elm", "dwell")


def test_before_any_set_up_a_hit_chooses_by_itself():
    conductor = Conductor(settings(laser=RECEPTORS))
    for name, xy in (("ash", (0.45, 0.3)), ("elm", (0.6, 0.25))):
        conductor.step(RobotState(0.0, name, xy, 0.0))
    conductor.step(Hit(0.1, "elm", True))
    outputs = [output for k in range(20) for output in conductor.step(Tick(0.05 * k))]
    [chosen] = [output for output in outputs if isinstance(output, Selected)]
    assert (chosen.robot, chosen.how, chosen.source) == ("elm", "hit", "wrist")
    assert chosen.t == pytest.approx(0.4)
    conductor.step(Hit(1.0, "ash", True))  # two lights at once say nothing
    assert not any(isinstance(o, Selected) for k in range(20, 60) for o in conductor.step(Tick(0.05 * k)))


def test_in_the_set_up_the_spot_goes_where_it_is_led_and_chooses_nothing():
    puppet = LaserPuppet().set_up()
    puppet.run(0.8)
    assert "ash" in puppet.lit
    assert puppet.of(Selected) == []


def test_a_hit_revives_a_place_whose_heading_has_expired(puppet):
    puppet.working.clear()
    puppet.pose(FORWARD)
    puppet.run(1)
    place = puppet.conductor._pointer.place
    place.covariance[3, 3] = (1.2 * EXPIRED) ** 2
    puppet.point_at("elm")
    puppet.run(1)
    assert puppet.of(Pointed)[-1].refused.startswith("expired")
    puppet.working.add("elm")
    puppet.run(2, until=Selected)
    assert puppet.of(Selected)[0].how == "hit"
    puppet.run(0.2)
    last = puppet.of(Pointed)[-1]
    assert last.refused is None
    assert (last.robot, last.decided) == ("elm", True)
    assert np.sqrt(place.covariance[3, 3]) < np.radians(5)


def test_silence_of_the_band_is_no_choice(puppet):
    puppet.silent = True
    puppet.run(3)
    assert puppet.of(Selected) == []


def test_hits_of_a_room_without_a_laser_decide_nothing():
    conductor = Conductor(settings())
    assert conductor.step(Hit(0.0, "ash", True)) == []
    assert conductor.step(Tick(1.0)) == []


def test_a_receptor_on_a_robot_that_does_not_exist_is_refused():
    with pytest.raises(ConfigError, match=r"laser\.receptors: robot 'elf' does not exist; there are: ash, elm"):
        settings(laser=LaserSettings(receptors=("elf",)))
