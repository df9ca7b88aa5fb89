import math

import numpy as np
import pytest

from armspan.devices.toio.mat import Chassis, Mat
from armspan.devices.toio.reckoning import Pulse, Reckoning, rolled
from armspan.devices.toio.wire import encode

ORIGIN = (0.0, 0.0, 0.0)
SPEED = 50 * 4.3 * math.pi * 0.0125 / 60


def seen(*pulses):
    """A cube that was seen at 1.0 s at rest, and told pulses at their times since."""
    reckoning = Reckoning()
    reckoning.carried(ORIGIN, 1.0)
    for at, *pulse in pulses:
        reckoning.note(at, Pulse(*pulse))
    return reckoning


def test_a_pulse_adds_its_whole_length_to_where_a_cube_comes_to_rest():
    _, rest = seen((1.0, 50, 50, 0.2)).forecast(ORIGIN, 1.5)
    assert rest == pytest.approx((0.2 * SPEED, 0, 0), abs=1e-4)


def test_what_is_told_later_cuts_it_short():
    here, rest = seen((1.0, 50, 50, 0.2)).forecast(ORIGIN, 1.07)
    assert rest[0] == pytest.approx(0.07 * SPEED, abs=1e-4)
    assert here[0] == pytest.approx(SPEED * (0.07 - 0.1 * (1 - math.exp(-0.7))), abs=2e-4)
    _, rest = seen((1.0, 50, 50, 0.2), (1.1, 0, 0, 0.0)).forecast(ORIGIN, 1.5)
    assert rest[0] == pytest.approx(0.1 * SPEED, abs=1e-4)


def test_a_cube_is_carried_on_from_where_it_was_seen():
    reckoning, pose = seen((1.0, 50, 50, 0.2)), ORIGIN
    for k in range(1, 60):
        pose = reckoning.carried(pose, 1.0 + 0.02 * k)
    assert pose == pytest.approx((0.2 * SPEED, 0, 0), abs=2e-4)


def test_a_turn_on_the_spot():
    _, rest = seen((1.0, 50, -50, 0.1)).forecast(ORIGIN, 1.4)
    assert rest == pytest.approx((0, 0, 2 * SPEED * 0.1 / 0.0266), abs=2e-3)


def test_wheels_that_roll_differently_make_an_arc():
    radius, angle = 0.1, 0.02
    x, y, heading = rolled(ORIGIN, (radius + 0.0133) * angle, (radius - 0.0133) * angle)
    assert heading == pytest.approx(angle)
    assert (x, y) == pytest.approx((radius * math.sin(angle), radius * (1 - math.cos(angle))), abs=1e-5)


def test_long_ago_does_not_matter():
    reckoning = seen((1.0, 50, 50, 0.2))
    assert reckoning.carried(ORIGIN, 1000.0) == pytest.approx(ORIGIN)


def test_it_says_where_an_emulated_cube_comes_to_rest():
    mat = Mat([(0.28, 0.28)], [0.4], np.random.default_rng(0), Chassis(gain=(1.0, 1.0), mismatch=0.0))
    reckoning = Reckoning()
    mat.advance(1.0)
    reckoning.carried((0.28, 0.28, 0.4), 1.03)
    for t, left, right, seconds in ((1.0, 60, 40, 0.2), (1.1, -30, 30, 0.1), (1.2, 20, 35, 0.2)):
        mat.advance(t)
        mat.cubes[0].write(t, *encode("motorTimed", left=left, right=right, duration_ms=round(1000 * seconds)))
        reckoning.note(t, Pulse(left, right, seconds))
    _, rest = reckoning.forecast((0.28, 0.28, 0.4), 1.6)
    mat.advance(3.0)
    assert rest[:2] == pytest.approx(tuple(mat.pose[:2, 0]), abs=5e-4)
    assert rest[2] == pytest.approx(mat.pose[2, 0], abs=0.05)
