import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.conductor.pointer import CORRECTING, CURSOR, CURSOR_SHARE, SURE, steered_by_cursor
from armspan.pointing.selection import SelectionSettings
from armspan.pointing.spots import Spot
from armspan.records import Calibrated, Light, Pointed, RobotState, Selected, Tap
from puppet import FORWARD, RAISED, Puppet


@pytest.fixture
def puppet():
    """After the set-up, pointing at the robot elm from now on."""
    ready = Puppet().set_up()
    ready.pose(FORWARD)
    ready.run(5)  # ash drives home
    ready.outputs.clear()
    ready.point_at("elm")
    return ready


def test_a_robot_is_found_and_chosen_after_a_dwell(puppet):
    puppet.run(3, until=Selected)
    [chosen] = puppet.of(Selected)
    assert (chosen.robot, chosen.zone, chosen.how) == ("elm", None, "dwell")
    assert chosen.probability > 0.95
    assert 1.0 <= chosen.t - puppet.of(Pointed)[0].t <= 1.5
    last = puppet.of(Pointed)[-1]
    assert_allclose(last.xy, puppet.robots["elm"], atol=2e-3)
    assert (last.robot, last.decided) == ("elm", True)


def test_it_is_chosen_once(puppet):
    puppet.run(8)
    assert len(puppet.of(Selected)) == 1


def test_a_zone_is_found_on_the_sheet(puppet):
    puppet.point_at((0.15, 0.3))
    puppet.run(3, until=Selected)
    [chosen] = puppet.of(Selected)
    assert (chosen.robot, chosen.zone) == (None, "pond")
    assert_allclose(puppet.of(Pointed)[-1].xy, (0.15, 0.3), atol=2e-3)


def test_between_two_robots_nothing_is_decided(puppet):
    puppet.robots["ash"] = (0.50, 0.25)
    puppet.point_at((0.55, 0.25))
    puppet.run(4)
    assert puppet.of(Selected) == []
    assert puppet.of(Pointed)[-1].probability < 0.8
    assert puppet.of(Pointed)[-1].decided is False


def test_far_from_everything_nothing_is_decided(puppet):
    puppet.point_at((0.80, 0.55))
    puppet.run(4)
    last = puppet.of(Pointed)[-1]
    assert (last.robot, last.zone, last.decided) == (None, None, False)


def test_a_tap_chooses_without_waiting(puppet):
    puppet.run(0.6)
    assert puppet.of(Selected) == []
    [chosen, *_] = puppet.tell(Tap(puppet.t, "wrist"))
    assert (chosen.robot, chosen.how) == ("elm", "tap")
    assert puppet.tell(Tap(puppet.t, "wrist")) == []


def test_a_tap_at_nothing_chooses_nothing(puppet):
    puppet.point_at((0.80, 0.55))
    puppet.run(1)
    assert puppet.tell(Tap(puppet.t, "wrist")) == []


def test_an_arm_that_points_over_everything_is_refused_with_a_sentence(puppet):
    puppet.pose(RAISED)
    puppet.run(2)
    last = puppet.of(Pointed)[-1]
    assert (last.xy, last.covariance, last.decided) == (None, None, False)
    assert len(last.refused) > 10


def test_silence_is_told_and_is_no_choice(puppet):
    puppet.run(0.8)
    puppet.silent = True
    puppet.run(2)
    assert puppet.of(Pointed)[-1].refused == "stale: nothing heard of wrist"
    assert puppet.of(Pointed)[-1].xy is None
    assert puppet.of(Selected) == []
    puppet.silent = False
    puppet.run(3, until=Selected)
    assert puppet.of(Selected)[0].robot == "elm"


def test_a_sure_choice_of_a_robot_teaches_the_place(puppet):
    puppet.robots["elm"] = (0.615, 0.25)  # 15 mm beside where the arm points
    puppet.point_at((0.60, 0.25))
    puppet.run(3, until=Selected)
    [chosen] = puppet.of(Selected)
    assert chosen.probability > SURE
    [refined] = puppet.of(Calibrated)
    assert refined.t == chosen.t
    before = puppet.of(Pointed)[-1].xy
    puppet.run(0.5)
    after = puppet.of(Pointed)[-1].xy
    assert abs(after[0] - 0.615) < abs(before[0] - 0.615) - 0.002


def test_a_choice_that_is_not_sure_teaches_nothing():
    puppet = Puppet(selection=SelectionSettings(gate=0.55, hold=0.5)).set_up()
    puppet.pose(FORWARD)
    puppet.run(5)
    puppet.outputs.clear()
    puppet.robots["ash"] = (0.48, 0.25)
    puppet.point_at((0.55, 0.25))  # 5 cm from elm, 7 cm from ash
    puppet.run(3, until=Selected)
    [chosen] = puppet.of(Selected)
    assert 0.55 <= chosen.probability < SURE
    assert puppet.of(Calibrated) == []


def test_shown_the_cursor_a_choice_teaches_nothing(puppet):
    puppet.press("feedback", "on")
    puppet.run(3, until=Selected)
    assert puppet.of(Selected)
    assert puppet.of(Calibrated) == []
    lights = [light for light in puppet.of(Light) if light.robot == "elm"]
    assert any(light.colour == (0, 255, 0) for light in lights)  # the cursor was on it


def test_every_tick_says_where(puppet):
    puppet.run(2)
    times = [pointed.t for pointed in puppet.of(Pointed)]
    assert np.diff(times) == pytest.approx(0.05)
    assert len(times) == 40


# --- the cursor ----------------------------------------------------------------------------------------------

SPOT = Spot(np.array([0.3, 0.3]), np.array([[9e-4, 2e-4], [2e-4, 16e-4]]), "")


def steered(seconds, *robots):
    return steered_by_cursor(SPOT, seconds, {str(k): RobotState(0.0, str(k), xy, 0.0) for k, xy in enumerate(robots)})


def test_a_cursor_just_seen_changes_nothing():
    for seconds in (-1.0, 0.0):
        assert_allclose(steered(seconds, (0.3, 0.3)).covariance, SPOT.covariance)
    assert_allclose(steered(100.0).covariance, SPOT.covariance)  # no robot, no cursor


def test_a_cursor_long_seen_adds_what_the_lights_tell():
    # 10 cm from the nearest robot the lights tell 2 cm + 0.35 of 10 cm per axis.
    told = (CURSOR + CURSOR_SHARE * 0.10) ** -2
    wanted = np.linalg.inv(np.linalg.inv(SPOT.covariance) + told * np.eye(2))
    found = steered(100.0, (0.4, 0.3), (0.3, 0.9))
    assert_allclose(found.covariance, wanted)
    assert_allclose(found.xy, SPOT.xy)
    half = steered(CORRECTING * np.log(2), (0.4, 0.3))
    assert_allclose(half.covariance, np.linalg.inv(np.linalg.inv(SPOT.covariance) + told / 2 * np.eye(2)))
