import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.devices.toio.pilot import HOLD_S, Pilot
from armspan.devices.toio.quantities import speed_of
from armspan.devices.toio.reckoning import REST

ORIGIN = (0.0, 0.0, 0.0)
PER_VALUE = 4.3 * math.pi * 0.0125 / 60


def plan(goal, heading=None, speed=0.15, here=ORIGIN, rest=ORIGIN, pilot=None):
    return (pilot or Pilot()).plan(here, rest, goal, heading, speed)


def length(pulse):
    return (speed_of(pulse.left) + speed_of(pulse.right)) / 2 * pulse.seconds


def turn(pulse):
    return (speed_of(pulse.left) - speed_of(pulse.right)) / 0.0266 * pulse.seconds


def test_a_goal_ahead_is_driven_to_straight():
    pulse = plan((0.04, 0.0))
    assert pulse.left == pulse.right == round(0.15 / PER_VALUE)
    assert 0.022 < length(pulse) <= 0.026


def test_the_last_pulse_ends_at_the_goal():
    for far in (0.004, 0.008, 0.015):
        pulse = plan((far, 0.0))
        assert length(pulse) == pytest.approx(far, abs=0.0012)
        assert speed_of(pulse.left) <= 8.0 * far + 2 * PER_VALUE or pulse.left == 8


def test_a_goal_behind_is_driven_to_backward():
    pulse = plan((-0.04, 0.0))
    assert pulse.left == pulse.right < 0


@pytest.mark.parametrize("degrees", [60, -60, 120, -120])
def test_a_goal_aside_is_turned_to_first_on_the_spot(degrees):
    angle = math.radians(degrees)
    pulse = plan((0.04 * math.cos(angle), 0.04 * math.sin(angle)))
    assert pulse.left == -pulse.right != 0
    wanted = angle if abs(degrees) < 90 else angle - math.copysign(math.pi, angle)  # one end or the other
    assert turn(pulse) == pytest.approx(wanted, abs=0.12)
    assert (pulse.left > 0) == (wanted > 0)  # clockwise: the left wheel forward


def test_there_is_there_until_it_is_clearly_elsewhere():
    pilot = Pilot()
    assert plan((0.002, 0.0), pilot=pilot) == REST
    assert pilot.arrived
    assert plan((0.0035, 0.0), pilot=pilot) == REST
    assert plan((0.005, 0.0), pilot=pilot) != REST


def test_a_heading_is_turned_to_at_the_goal():
    pulse = plan((0.001, 0.0), heading=math.radians(-30))
    assert turn(pulse) == pytest.approx(math.radians(-30), abs=0.06)
    assert plan((0.001, 0.0), heading=math.radians(2)) == REST
    assert plan((0.001, 0.0), heading=2 * math.pi) == REST


def test_a_cube_that_still_turns_waits():
    ahead = (0.04 * math.cos(1.5), 0.04 * math.sin(1.5))
    assert plan(ahead, here=(0.0, 0.0, 0.5), rest=(0.0, 0.0, 1.5)) == REST
    assert length(plan(ahead, here=(0.0, 0.0, 1.3), rest=(0.0, 0.0, 1.5))) > 0.02


@settings(derandomize=True, max_examples=300)
@given(
    st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(0, 7)),
    st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(0, 7)),
    st.tuples(*[st.floats(-1, 1)] * 2),
    st.none() | st.floats(-9, 9),
    st.floats(0, 1),
)
def test_every_pulse_ends_soon_and_near(here, rest, goal, wanted, speed):
    pulse = plan(goal, wanted, speed, here, rest)
    assert 0.0 <= pulse.seconds <= HOLD_S
    assert abs(pulse.left) <= 115
    assert abs(pulse.right) <= 115
    assert abs(length(pulse)) <= 0.0265
    assert abs(length(pulse)) <= max(min(speed, 0.2), 8 * PER_VALUE) * pulse.seconds + 1.1 * PER_VALUE * pulse.seconds
