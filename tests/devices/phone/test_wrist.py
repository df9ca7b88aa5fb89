"""Strapped to a virtual person's wrist, a phone points: what its apps add to the attitude's error."""

from dataclasses import replace

import numpy as np
import pytest

from armspan.devices.phone.band import Band
from armspan.devices.phone.browser import Browser
from armspan.devices.phone.emulator import EmulatedPhone
from armspan.devices.phone.entry import STRAPPED
from armspan.devices.phone.sensor_logger import SensorLogger
from armspan.devices.phone.sensor_server import FORCE, GAME, RATE, SensorServer
from armspan.devices.phone.voices import LoggerVoice, PageVoice, ServerVoice
from armspan.frames import rotation_from_quaternion
from armspan.orientation import Attitude
from armspan.records import ImuSample
from armspan.simulation.bands import BandTraits, VirtualBand, draw_band
from armspan.simulation.inertial import motion
from armspan.simulation.person import VirtualPerson, draw_person

WAY = 0.010
STEP = 0.005
WORN = (STRAPPED[0], 0.0, 0.0, -STRAPPED[3])
FLAWLESS = BandTraits(rate_hz=60.0, segment_from_sensor=WORN)
DRAWN = replace(draw_band(np.random.default_rng(5)), rate_hz=60.0, loss=0.0, segment_from_sensor=WORN)


class Direct:
    """A band without an app between."""

    def __init__(self, traits, seed=1):
        self.rng = np.random.default_rng(seed)
        self.person = VirtualPerson(draw_person(self.rng), (0.4, 0.9), np.pi / 2, self.rng)
        self.band = VirtualBand("wrist", "forearm", traits, self.rng)
        self._targets, self._next = self.rng.uniform(0.0, 0.6, (50, 2)), 1.0

    def samples(self, t):
        """The band's samples, of a person who points somewhere else every two seconds."""
        if t >= self._next:
            self.person.point(t, (*self._targets[int(self._next) // 2], 0.8))
            self._next += 2.0
        return [sample for _, sample in self.band.advance(t, self.person)]

    def events(self, t):
        return self.samples(t)


class ThroughApp(Direct):
    def __init__(self, traits, voice, decoder, ordered=True):
        super().__init__(traits)
        self.phone = EmulatedPhone(voice, self.samples, ordered=ordered)
        self.decoder = decoder(Band("wrist"))

    def events(self, t):
        return [event for data in self.phone.advance(t) for event in self.decoder.feed(data, t + WAY)]


def error_deg(world, way, seconds=12.0):
    """Errors (n,) [deg] of the attitude, but for a constant heading, which the set-up finds."""
    attitude, turns, told = Attitude(60.0), [], []
    for k in range(int(seconds / STEP)):
        for event in world.events(k * STEP):
            if isinstance(event, ImuSample):
                attitude.update(event)
                told.append((event.t - way, attitude.quaternion))
        if told and k % 50 == 49:  # the person remembers a second
            times, quaternions = zip(*told, strict=True)
            true = motion(world.person, "forearm", np.array(times), rotation_from_quaternion(WORN), np.zeros(3))
            found = rotation_from_quaternion(np.array(quaternions)) @ true.room_from_sensor.transpose(0, 2, 1)
            turns.append(found[np.array(times) > 3.0])
            told.clear()
    turns = np.concatenate(turns)
    heading = np.arctan2((turns[:, 1, 0] - turns[:, 0, 1]).mean(), (turns[:, 0, 0] + turns[:, 1, 1]).mean())
    c, s = np.cos(heading), np.sin(heading)
    turns = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ turns
    cosine = (np.trace(turns, axis1=1, axis2=2) - 1.0) / 2.0
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def rms(errors):
    return float(np.sqrt((errors**2).mean()))


APPS = {
    "angles": lambda traits: ThroughApp(traits, PageVoice(), Browser),
    "quaternion": lambda traits: ThroughApp(traits, PageVoice(attitude="quaternion"), Browser),
    "iphone": lambda traits: ThroughApp(traits, PageVoice(apple=True), Browser),
    "sensor-logger": lambda traits: ThroughApp(traits, LoggerVoice("ios", 0.1), SensorLogger, ordered=False),
    "sensor-server": lambda traits: ThroughApp(traits, ServerVoice((FORCE, RATE, GAME)), SensorServer),
}


@pytest.mark.parametrize("app", APPS)
def test_an_app_adds_little_to_a_flawless_attitude(app):
    # Browsers round to 0.1 degrees, whose error about three axes has 0.05 degrees rms; a clock that is 5 ms off costs
    # half a degree at 100 degrees a second.
    errors = error_deg(APPS[app](FLAWLESS), WAY)
    assert len(errors) > 500
    assert rms(errors) < 0.15
    assert np.percentile(errors, 95) < 0.4


def test_a_worn_bands_own_error_is_what_remains():
    direct = rms(error_deg(Direct(DRAWN), 0.0))
    page = rms(error_deg(APPS["angles"](DRAWN), WAY))
    assert 0.2 < direct < 2.0
    assert abs(page - direct) < 0.1
