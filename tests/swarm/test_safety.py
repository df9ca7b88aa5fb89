import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.errors import ConfigError
from armspan.records import Drive, GoTo, Light, RobotState, Sheet, Stop
from armspan.swarm.limits import Limits
from armspan.swarm.safety import SafetyFilter

SHEET, LIMITS = Sheet(1.0, 0.8), Limits()
GAP = 2 * LIMITS.body_radius_m + LIMITS.gap_m


def filtered(command, *states):
    return SafetyFilter(LIMITS, SHEET).admit(command, {state.robot: state for state in states})


def robot(name="a", xy=(0.5, 0.4), t=0.0, held=False):
    return RobotState(t, name, xy, 0.0, held=held)


def go(xy, speed=0.1, until=0.3, t=0.0):
    return GoTo(t, "a", xy, speed, until)


def test_a_far_goal_becomes_one_lead_ahead():
    out = filtered(go((0.9, 0.4)), robot())
    assert out.xy == pytest.approx((0.5 + LIMITS.lead_m, 0.4))


def test_caps_on_speed_and_lease():
    out = filtered(go((0.52, 0.4), speed=9.0, until=60.0), robot())
    assert out.speed == LIMITS.speed_m_s
    assert out.until == pytest.approx(LIMITS.lease_s)


def test_a_velocity_leaves_as_a_goal():
    out = filtered(Drive(0.0, "a", (0.1, 0.0), 0.0, 0.3), robot())
    assert isinstance(out, GoTo)
    assert out.xy == pytest.approx((0.53, 0.4))


def test_one_robot_alone_keeps_to_the_sheet():
    out = filtered(go((1.5, 0.4)), robot(xy=(0.95, 0.4)))
    assert out.xy == pytest.approx((1.0 - LIMITS.body_radius_m, 0.4))


@pytest.mark.parametrize("command", [go((np.nan, 0.4)), Drive(0.0, "a", (np.inf, 0.0), 0.0, 0.3)])
def test_what_is_not_finite_stops(command):
    out = filtered(command, robot())
    assert isinstance(out, Stop)
    assert out.robot == "a"


def test_a_held_a_silent_and_an_unknown_robot_get_no_motion():
    assert isinstance(filtered(go((0.6, 0.4)), robot(held=True)), Stop)
    assert isinstance(filtered(go((0.6, 0.4), t=2.0, until=2.3), robot()), Stop)
    assert filtered(go((0.6, 0.4))) is None


def test_an_expired_lease_is_dropped():
    assert filtered(go((0.6, 0.4), until=0.0), robot()) is None


def test_stop_is_latched_until_resume():
    safety = SafetyFilter(LIMITS, SHEET)
    states = {"a": robot()}
    assert safety.admit(Stop(0.0), states) == Stop(0.0)
    assert safety.admit(go((0.52, 0.4)), states) is None
    assert safety.admit(Light(0.0, "a", (255, 0, 0)), states) is not None
    safety.resume()
    assert safety.admit(go((0.52, 0.4)), states) is not None


places = st.tuples(st.floats(0.05, 0.95), st.floats(0.05, 0.75))


@settings(max_examples=300, derandomize=True)
@given(places, st.tuples(st.floats(-1, 2), st.floats(-1, 2)), st.lists(places, max_size=6), st.floats(0, 10))
def test_whatever_is_asked_what_leaves_keeps_every_limit(here, goal, others, speed):
    states = [robot(xy=here), *(robot(f"o{k}", xy) for k, xy in enumerate(others))]
    out = filtered(go(goal, speed=speed, until=50.0), *states)
    assert isinstance(out, GoTo)
    x, y = out.xy
    margin = LIMITS.body_radius_m
    assert out.speed <= LIMITS.speed_m_s
    assert out.until <= LIMITS.lease_s
    assert margin - 1e-9 <= x <= SHEET.width_m - margin + 1e-9 or not margin <= here[0] <= SHEET.width_m - margin
    assert np.hypot(x - here[0], y - here[1]) <= LIMITS.lead_m + 1e-9
    for other in others:
        before, after = np.hypot(*np.subtract(here, other)), np.hypot(x - other[0], y - other[1])
        assert after >= min(GAP, before) - 1e-9


@pytest.mark.parametrize("wrong", [{"speed_m_s": 1.0}, {"lease_s": 0.0}, {"lead_m": -1.0}, {"gap_m": float("nan")}])
def test_limits_out_of_range_are_refused(wrong):
    with pytest.raises(ConfigError, match="expected more than 0"):
        Limits(**wrong)
