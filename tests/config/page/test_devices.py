import pytest

from armspan.config.demo_room import page_room
from armspan.config.doors import Doors
from armspan.config.house import open_house
from armspan.config.page.devices import advice_of, devices_of, invitation_of, share, told_by
from armspan.devices.metawear.counters import StreamCounters
from armspan.devices.metawear.driver import MetaWearBand
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.phone.driver import PhoneBands
from armspan.devices.phone.entry import PhoneEntry
from armspan.records import ImuSample, Link, RobotState
from armspan.web.shown import Shown

G = (0.0, 0.0, 9.81)


def heard(shown, band, until=1.0):
    """A band is heard 100 times a second from 0 s."""
    for k in range(round(100 * until)):
        shown(ImuSample(k / 100, band, G, (0.0, 0.0, 0.0)))


def metawear(**changes):
    band = MetaWearBand(MetaWearEntry("right wrist", "C0:FF:EE:00:00:01"), now=lambda: 0.0)
    for name, value in changes.items():
        setattr(band.report(), name, value)
    return band


def test_no_room_has_no_devices():
    assert devices_of(None, Shown()) == []


def test_bands_that_are_heard_have_a_rate_and_others_a_note():
    house, shown = open_house(page_room(1)), Shown()
    heard(shown, "right wrist")
    right, left, *robots = devices_of(house, shown)
    assert (right.up, right.where, right.note) == (True, "right wrist", "simulated")
    assert right.rate_hz == pytest.approx(100.0)
    assert (right.battery, right.lost) == (None, None)  # a virtual band has neither
    assert (left.up, left.rate_hz, left.note) == (False, None, "nothing heard: is it on, charged and near?")
    assert {(robot.up, robot.note) for robot in robots} == {(False, "nothing heard: is it on and on the sheet?")}


def test_a_lifted_robot_and_one_out_of_reach_are_told():
    house, shown = open_house(page_room(1)), Shown()
    for name, held in (("amber", True), ("birch", False), ("cobalt", False)):
        shown(RobotState(1.0, name, (0.1, 0.1), 0.0, held, 0.5))
    shown(Link(1.0, "cobalt", up=False))
    told = {device.name: device for device in devices_of(house, shown)}
    assert (told["amber"].note, told["amber"].battery) == ("lifted: put it on the sheet", 0.5)
    assert (told["birch"].up, told["cobalt"].up) == (True, False)


def test_a_metawear_tells_battery_loss_and_why_it_is_away():
    streams = {"acc": StreamCounters(samples=90, lost=10), "gyro": StreamCounters(samples=100)}
    band = metawear(battery=0.8, trouble="it does not answer: charge it", streams=streams)
    house, shown = open_house(page_room(1)), Shown()
    house.doors = Doors([band])
    right = devices_of(house, shown)[0]
    assert (right.battery, right.lost, right.note) == (0.8, 0.05, "it does not answer: charge it")
    heard(shown, "right wrist")
    assert devices_of(house, shown)[0].note == "simulated"  # its trouble is over


def test_before_any_sample_no_loss_is_known():
    assert told_by(Doors([metawear()]))["right wrist"].lost is None
    assert (share(0, 0), share(1, 3)) == (None, 0.25)


def test_a_phone_tells_its_loss_and_no_battery():
    phones = PhoneBands([PhoneEntry("phone", app="sensor-logger")])
    [decoder] = phones._decoders.values()
    decoder.band.counters.samples, decoder.band.counters.lost = 300, 100
    told = told_by(Doors([phones]))["phone"]
    assert (told.battery, told.lost) == (None, 0.25)


def test_phones_are_invited_with_a_code_that_needs_no_terminal(tmp_path):
    phones = PhoneBands([PhoneEntry("phone", app="browser", token="hKNilobh92kf")], folder=tmp_path)
    told = invitation_of(Doors([phones, metawear()]))
    assert told.startswith("phone: open this page on the phone")
    assert "\u2588" in told
    assert "\x1b" not in told
    assert invitation_of(Doors([metawear()])) == ""


def test_what_is_wrong_with_phones_is_told_and_a_band_has_its_note():
    phones = PhoneBands([PhoneEntry("phone", app="sensor-logger")])
    phones.strangers["somebody"] = 1
    assert ["somebody" in sentence for sentence in advice_of(Doors([phones, metawear(trouble="away")]))] == [True]
