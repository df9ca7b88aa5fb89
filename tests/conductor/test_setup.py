import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.conductor import BandSettings
from armspan.records import Calibrated, GoTo, Pointed, Press, Say
from armspan.swarm.limits import Limits
from puppet import HANGING, PLACE, RAISED, STOPS, WORN, Puppet

CUES = ["stretch", "hang", *["point:ash"] * 4, "ready"]


def test_an_exact_arm_is_placed_exactly():
    puppet = Puppet().set_up()
    [found] = puppet.of(Calibrated)
    assert puppet.said() == CUES
    assert_allclose(found.xyz, PLACE[0], atol=1e-6)
    assert found.yaw == pytest.approx(PLACE[1], abs=1e-6)
    assert (found.source, found.pairs) == ("wrist", 4)
    assert found.rms < 1e-6
    covariance = np.reshape(found.covariance, (4, 4))
    assert_allclose(covariance, covariance.T, atol=1e-12)
    assert np.linalg.eigvalsh(covariance).min() > 0


def test_the_robot_went_to_each_stop_and_comes_home():
    puppet = Puppet()
    puppet.press("setup")
    home, visited = puppet.robots["ash"], []
    for _ in range(600):
        puppet.step()
        if any(np.hypot(*np.subtract(puppet.robots["ash"], stop)) < 0.006 for stop in STOPS):
            visited.append(puppet.robots["ash"])
    nearest = [int(np.argmin([np.hypot(*np.subtract(xy, stop)) for stop in STOPS])) for xy in visited]
    assert list(dict.fromkeys(nearest)) == [0, 1, 2, 3]
    assert_allclose(puppet.robots["ash"], home, atol=0.006)
    assert all(command.robot == "ash" for command in puppet.of(GoTo))


def test_two_bands_find_the_same_place():
    bands = (BandSettings("wrist"), BandSettings("elbow", "upperarm"))
    puppet = Puppet(bands=bands).set_up()
    assert_allclose(puppet.of(Calibrated)[0].xyz, PLACE[0], atol=1e-6)


def test_a_known_mounting_needs_no_hanging_arm():
    puppet = Puppet(bands=(BandSettings("wrist", wrist_from_sensor=tuple(WORN)),)).set_up()
    assert puppet.said() == [cue for cue in CUES if cue != "hang"]
    assert_allclose(puppet.of(Calibrated)[0].xyz, PLACE[0], atol=1e-6)


def test_a_table_that_was_measured_pulls_the_height():
    puppet = Puppet(table_height_m=0.80).set_up()
    assert 0.751 < puppet.of(Calibrated)[0].xyz[2] < 0.80


def test_a_person_who_never_holds_still_is_asked_again():
    puppet = Puppet()
    puppet.restless = True
    puppet.press("setup")
    puppet.run(30)
    first, *again = puppet.of(Say)
    assert [record.cue for record in again] == ["stretch", "stretch"]
    assert {record.text for record in again} == {
        "Stretch your arm straight forward and hold still: the bands feel it move"
    }
    assert [record.t - first.t for record in again] == pytest.approx([12.0, 24.0], abs=0.11)


def test_an_arm_that_was_not_level_starts_over_and_is_told_why():
    puppet = Puppet()
    puppet.obeys = False
    puppet.pose(RAISED)  # by 29 degrees
    puppet.press("setup")
    puppet.run(4)
    puppet.pose(HANGING)
    puppet.run(4)
    said = next(record for record in puppet.of(Say) if "Once more" in record.text)
    assert said.cue == "stretch"
    assert "Once more, please: the arm was not level: it pointed 29 degrees up" in said.text


def test_a_silent_band_is_told_by_its_name():
    puppet = Puppet()
    puppet.silent = True
    puppet.press("setup")
    puppet.run(13)
    assert puppet.of(Say)[-1].text == "Nothing is heard of wrist: is the band on and near?"


def test_a_robot_that_does_not_get_there_is_told():
    puppet = Puppet(limits=Limits(lead_m=1e-6))
    puppet.press("setup")
    puppet.run(25)
    assert "ash does not reach its stop: is it on the sheet, and the way free?" in puppet.said()
    assert puppet.of(Calibrated) == []


def test_a_held_robot_gives_no_pair():
    puppet = Puppet()
    puppet.press("setup")
    while puppet.said().count("point:ash") < 1:
        puppet.step()
    puppet.run(4)
    puppet.held.add("ash")
    before = puppet.said().count("point:ash")
    puppet.run(8)
    assert puppet.said().count("point:ash") == before


def test_an_arm_in_motion_gives_no_pair():
    puppet = Puppet()
    puppet.press("setup")
    while puppet.said().count("point:ash") < 1:
        puppet.step()
    puppet.obeys = False
    for k in range(200):
        puppet.point_at((0.15 + 0.05 * (k % 2), 0.12))
        puppet.step()
    assert puppet.said().count("point:ash") == 1


def test_without_three_stops_there_is_no_set_up():
    puppet = Puppet(stops=STOPS[:2])
    [said] = puppet.press("setup")
    assert said.cue == "trouble"
    assert "three stops at least" in said.text
    assert puppet.run(5) == []


def test_a_stop_ends_the_set_up_and_setup_begins_it_anew():
    puppet = Puppet()
    puppet.press("setup")
    puppet.run(8)
    puppet.press("stop")
    assert puppet.run(20) == []
    puppet.press("resume")
    puppet.set_up()
    assert puppet.said()[-7:] == CUES
    assert_allclose(puppet.of(Calibrated)[0].xyz, PLACE[0], atol=1e-6)


def test_a_second_set_up_replaces_the_first():
    puppet = Puppet().set_up()
    puppet.press("setup")
    assert not [record for record in puppet.run(1) if isinstance(record, Pointed)]
    puppet.set_up()
    assert len(puppet.of(Calibrated)) == 2


@pytest.mark.parametrize(("bands", "model"), [(1, "head-finger"), (2, "two-band")])
def test_the_model_follows_the_bands_unless_it_is_told(bands, model):
    worn = (BandSettings("wrist"), BandSettings("elbow", "upperarm"))[:bands]
    for told, wanted in ((None, model), ("forearm", "forearm")):
        puppet = Puppet(bands=worn, model=told)
        puppet.tell(Press(0.0, "setup"))
        assert puppet.conductor._setup.model == wanted
