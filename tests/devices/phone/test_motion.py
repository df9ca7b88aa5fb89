"""What does not depend on the app: readings, sign of the force, clock, weaving of sensors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from armspan.devices.phone.band import Band
from armspan.devices.phone.readings import (
    GRAVITY,
    attitude_between,
    quaternion,
    quaternion_from_angles,
    turned,
    up,
    vector,
)
from armspan.devices.phone.timeline import Timeline
from armspan.devices.phone.upright import Upright
from armspan.devices.phone.weave import WARM_NS, Weave
from armspan.errors import DeviceError
from armspan.records import ImuSample, Link

ANGLES = st.floats(-180, 180)


def close(a, b, most=1e-9):
    """Whether two quaternions are the same turn."""
    return 1.0 - abs(float(np.dot(a, b))) < most


def random_attitude(rng):
    return tuple(Rotation.random(random_state=rng).as_quat(scalar_first=True).tolist())


# --- readings ----------------------------------------------------------------------------------------------


@given(ANGLES, ANGLES, ANGLES)
def test_a_browsers_angles_turn_about_z_then_x_then_y(alpha, beta, gamma):
    expected = Rotation.from_euler("ZXY", [alpha, beta, gamma], degrees=True).as_quat(scalar_first=True)
    assert close(quaternion_from_angles(alpha, beta, gamma), expected)


@pytest.mark.parametrize(
    ("angles", "force"),
    [  # the examples of W3C's Device Orientation and Motion, section 'Device motion model' and 'orientation model'
        ((0, 0, 0), (0, 0, 1)),  # on a table
        ((90, 90, 0), (0, 1, 0)),  # upright in portrait
        ((0, 0, 90), (-1, 0, 0)),  # on its right edge's opposite: rolled to the right
        ((0, -90, 0), (0, -1, 0)),  # upside down
    ],
)
def test_up_is_where_a_phone_feels_it(angles, force):
    assert up(quaternion_from_angles(*angles)) == pytest.approx(force, abs=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_an_attitude_is_turned_by_its_rate(seed):
    rng = np.random.default_rng(seed)
    attitude, rate, seconds = random_attitude(rng), rng.normal(size=3) * 3.0, float(rng.uniform(-0.5, 0.5))
    expected = Rotation.from_quat(attitude, scalar_first=True) * Rotation.from_rotvec(rate * seconds)
    assert close(turned(attitude, tuple(rate), seconds), expected.as_quat(scalar_first=True))
    assert turned(attitude, (0.0, 0.0, 0.0), seconds) == attitude


def test_the_way_between_attitudes_is_the_short_one():
    a, b = quaternion_from_angles(0, 0, 0), quaternion_from_angles(10, 0, 0)
    expected = quaternion_from_angles(5, 0, 0)
    assert close(attitude_between(a, b, 0.5), expected)
    assert close(attitude_between(a, tuple(-x for x in b), 0.5), expected)


@pytest.mark.parametrize(
    "values", [(1, 2), (1, 2, 3, 4), (math.nan, 0, 0), (0, math.inf, 0), (0, 0, 1e9), (0, 0, -101)]
)
def test_what_no_sensor_says(values):
    with pytest.raises(DeviceError, match="expected three numbers up to 100"):
        vector(values, "the force", 100.0)


@pytest.mark.parametrize(
    "wxyz", [(0, 0, 0, 0), (2, 0, 0, 0), (math.nan, 0, 0, 1), (math.inf, 0, 0, 0), (0.8, 0.1, 0, 0)]
)
def test_what_is_no_attitude(wxyz):
    with pytest.raises(DeviceError, match="expected length 1"):
        quaternion(*wxyz)


def test_an_attitude_is_made_exactly_one_long():
    assert math.hypot(*quaternion(0.7, 0.7, 0.1, 0.0)) == pytest.approx(1.0, abs=1e-15)


# --- the sign of the force -----------------------------------------------------------------------------------


@pytest.mark.parametrize("assumed", [1.0, -1.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_either_sign_is_found_in_any_attitude(sign, assumed):
    rng = np.random.default_rng(5)
    for _ in range(20):
        upright, attitude = Upright(), random_attitude(rng)
        upright.assume(assumed)
        felt = sign * GRAVITY * np.array(up(attitude)) + rng.normal(size=3) * 0.3
        upright.feel(tuple(felt), attitude)
        force = np.array(upright.force(tuple(felt)))
        assert force @ up(attitude) == pytest.approx(GRAVITY, abs=1.5)
        assert upright.agreement > 0.95


def test_shaking_does_not_turn_the_sign_over():
    rng = np.random.default_rng(6)
    upright, attitude = Upright(), quaternion_from_angles(30, 40, 10)
    for k in range(600):
        motion = rng.normal(size=3) * (25.0 if k > 60 else 0.2)  # [m/s²]
        upright.feel(tuple(np.array(up(attitude)) * GRAVITY + motion), attitude)
        assert upright.sign == 1.0


def test_a_word_is_taken_until_gravity_has_spoken():
    upright = Upright()
    upright.assume(-1.0)
    assert upright.sign == -1.0
    upright.feel((0.0, 0.0, 9.8), (1.0, 0.0, 0.0, 0.0))
    upright.assume(-1.0)
    assert upright.sign == 1.0


def test_an_attitude_that_gravity_speaks_against_is_not_believed():
    band, t = Band("wrist"), 0.0
    wrong = quaternion_from_angles(0, 90, 0)  # upright, while the force says that it lies on its back
    events = []
    for k in range(200):
        t = k / 60
        events += band.feel(t, (0.0, 0.0, GRAVITY), (0.0, 0.0, 0.0), wrong)
    samples = [event for event in events if isinstance(event, ImuSample)]
    assert samples[-1].quat is None
    links = [event for event in events if isinstance(event, Link)]
    assert [link.fresh for link in links] == [False, True]  # the heading that was known is void
    assert 0.5 < links[1].t < 2.0


# --- the clock -----------------------------------------------------------------------------------------------

UTC = 1_790_000_000_000_000_000


def mapped(timeline, true, rng, *, batch, delay, rate=0.0, offset=UTC, start=0.0):
    """Session times of samples taken at ``true`` [s], sent in batches that arrive late."""
    told = []
    for k in range(0, len(true), batch):
        part = true[k : k + batch]
        taken = [offset + round(t * (1 + rate) * 1e9) for t in part]
        told += timeline.seconds(taken, start + part[-1] + delay + float(rng.exponential(0.02)))
    return np.array(told)


@pytest.mark.parametrize("batch", [1, 6, 60])
@pytest.mark.parametrize("rate", [0.0, 50e-6, -50e-6])
def test_utc_becomes_session_time_whatever_the_batches(batch, rate):
    true = np.arange(0, 120, 1 / 60)
    told = mapped(Timeline(), true, np.random.default_rng(1), batch=batch, delay=0.015, rate=rate)
    error = told - true - 0.015  # a constant way cannot be known
    later = error[600:]
    assert abs(np.median(later)) < 0.005
    assert np.abs(later).max() < 0.012
    assert (np.diff(told) > 0).all()


@pytest.mark.parametrize("jump", [-3600.0, -3.0, 3.0, 3600.0])
def test_a_clock_that_is_set_is_followed(jump):
    rng, timeline = np.random.default_rng(2), Timeline()
    first, second = np.arange(0, 10, 0.02), np.arange(10, 20, 0.02)
    a = mapped(timeline, first, rng, batch=10, delay=0.015)
    b = mapped(timeline, second, rng, batch=10, delay=0.015, offset=UTC + round(jump * 1e9))
    assert timeline.steps == 1
    assert np.abs(b - second - 0.015)[250:].max() < 0.03
    assert a[-1] - 0.25 < b[0] < a[-1] + 0.3


def test_a_first_batch_that_was_held_up_is_made_good():
    timeline, period = Timeline(), 1 / 50
    taken = [UTC + round(k * period * 1e9) for k in range(100)]
    timeline.seconds(taken[:50], 4.0)  # three seconds on its way
    told = timeline.seconds(taken[50:], 2.0 - period + 3.0 - 2.98)  # its follower came at once
    assert timeline.steps == 1
    assert told[-1] == pytest.approx(2.0 - period + 0.02, abs=1e-6)


# --- the weave -----------------------------------------------------------------------------------------------


def test_sensors_are_read_between_their_times():
    weave = Weave("gyro")
    for k in range(200):
        weave.put("gyro", k * 10_000_000, (float(k),) * 3)
        weave.put("acc", k * 10_000_000 + 3_000_000, (k * 10.0 + 3.0, 0.0, 0.0))
    told = weave.take()
    assert told[0][0] > WARM_NS
    assert [k for k, _ in told] == sorted(k for k, _ in told)
    assert told[-1][0] == 199 * 10_000_000
    for taken, values in told:
        assert values["acc"][0] == pytest.approx(taken / 1e6)
    assert weave.take() == []


def test_nothing_is_told_before_every_sensor_has_spoken():
    weave = Weave("gyro")
    for k in range(60):
        weave.put("gyro", k * 10_000_000, (0.0,) * 3)
        weave.put("acc", k * 10_000_000, (0.0,) * 3)
    weave.take()
    weave.put("gyro", 600_000_000, (1.0,) * 3)
    assert weave.take() == []
    weave.put("acc", 610_000_000, (1.0,) * 3)
    assert [taken for taken, _ in weave.take()] == [600_000_000]


def test_a_sensor_that_ended_is_not_waited_for():
    weave = Weave("gyro")
    for k in range(300):
        weave.put("gyro", k * 10_000_000, (0.0,) * 3)
        if k < 100:
            weave.put("mag", k * 10_000_000, (0.0,) * 3)
    told = weave.take()
    assert told[-1][0] > 1_900_000_000
    assert "mag" not in told[-1][1]
    assert "mag" in told[0][1]


def test_readings_may_come_in_any_order_and_twice():
    rng = np.random.default_rng(3)
    orders = [np.arange(100), rng.permutation(100)]
    found = []
    for order in orders:
        weave = Weave("gyro")
        weave.put("gyro", 0, (0.0,) * 3)
        weave.put("acc", 0, (0.0,) * 3)
        for k in [*order, *order[:20]]:
            weave.put("gyro", int(k) * 10_000_000, (float(k),) * 3)
            weave.put("acc", int(k) * 10_000_000, (float(k),) * 3)
        found.append(weave.take())
    assert found[0] == found[1]
    assert len(found[0]) == 100 - 31


def test_a_weave_stays_small():
    weave = Weave("gyro")
    for k in range(30_000):
        weave.put("gyro", k * 10_000_000, (0.0,) * 3)
        weave.put("never", 0, (0.0,) * 3)
        if k % 1000 == 0:
            weave.take()
    assert sum(len(readings) for readings in weave._readings.values()) < 5000
