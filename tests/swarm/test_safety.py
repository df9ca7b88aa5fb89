import numpy as np
import pytest
import shapely
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from armspan.errors import ConfigError
from armspan.records import Drive, GoTo, Light, RobotState, Sheet, Stop
from armspan.swarm.answers import SLUGGISH_LEAD
from armspan.swarm.limits import Limits
from armspan.swarm.safety import LOST, SafetyFilter

SHEET, LIMITS = Sheet(1.0, 0.8), Limits()
GAP = 2 * LIMITS.body_radius_m + LIMITS.gap_m


def filtered(command, *states, t=None):
    """The one command that leaves a fresh filter for this one, or None."""
    out = SafetyFilter(LIMITS, SHEET).admit(command.t if t is None else t, [command], {s.robot: s for s in states})
    assert len(out) <= 1
    return out[0] if out else None


def robot(name="a", xy=(0.5, 0.4), t=0.0, held=False, battery=None):
    return RobotState(t, name, xy, 0.0, held, battery)


def go(xy, speed=0.1, until=0.3, t=0.0, robot="a"):
    return GoTo(t, robot, xy, speed, until)


def test_a_far_goal_becomes_one_lead_ahead():
    out = filtered(go((0.9, 0.4), speed=0.05), robot())
    assert out.xy == pytest.approx((0.5 + 0.05 * LIMITS.lease_s + 0.01, 0.4))
    assert filtered(go((0.9, 0.4), speed=0.15), robot()).xy == pytest.approx((0.5 + SLUGGISH_LEAD, 0.4))


def test_caps_on_speed_and_lease():
    out = filtered(go((0.52, 0.4), speed=9.0, until=60.0), robot())
    assert out.speed <= LIMITS.speed_m_s
    assert out.until == pytest.approx(LIMITS.lease_s)


def test_speed_is_gathered_at_the_cap_on_acceleration():
    safety, speeds = SafetyFilter(Limits(accel_m_s2=0.5), SHEET), []
    for k in range(12):
        t = 0.05 * k
        (out,) = safety.admit(t, [go((0.9, 0.4), 0.15, t + 0.3, t)], {"a": robot(t=t)})
        speeds.append(out.speed)
    steps = np.diff([0.0, *speeds])
    assert steps[0] <= 0.5 * 0.1 + 1e-9  # after a rest: what a tenth of a second allows
    assert (steps[1:] <= 0.5 * 0.05 + 1e-9).all()
    assert speeds[-1] == pytest.approx(0.15)


def test_a_velocity_leaves_as_a_goal():
    out = filtered(Drive(0.0, "a", (0.05, 0.0), 0.0, 0.3), robot())
    assert isinstance(out, GoTo)
    assert out.speed == pytest.approx(0.05)
    assert out.xy == pytest.approx((0.5 + 0.05 * LIMITS.lease_s + 0.01, 0.4))
    assert filtered(Drive(0.0, "a", (0.0, 0.0), 0.0, 0.3), robot()).xy == (0.5, 0.4)


def test_one_robot_alone_keeps_to_the_sheet():
    out = filtered(go((1.5, 0.4)), robot(xy=(0.95, 0.4)))
    assert out.xy == pytest.approx((1.0 - LIMITS.body_radius_m, 0.4))


@pytest.mark.parametrize("command", [go((np.nan, 0.4)), Drive(0.0, "a", (np.inf, 0.0), 0.0, 0.3)])
def test_what_is_not_finite_stops(command):
    out = filtered(command, robot())
    assert isinstance(out, Stop)
    assert out.robot == "a"


@pytest.mark.parametrize(
    ("state", "why"),
    [
        (robot(held=True, t=2.0), "lifted or off the sheet"),
        (robot(), "nothing heard of a for 0.5 s"),
        (robot(xy=(1.02, 0.4), t=2.0), "off the sheet"),
        (robot(battery=0.03, t=2.0), "battery at 3 %"),
    ],
)
def test_an_unfit_robot_is_stopped_and_waits_for_a_new_command(state, why):
    safety = SafetyFilter(LIMITS, SHEET)
    assert safety.admit(2.0, [go((0.6, 0.4), t=2.0, until=2.3)], {"a": state}) == [Stop(2.0, "a", why)]
    assert safety.admit(2.05, [go((0.6, 0.4), t=2.05, until=2.3)], {"a": state}) == []  # told once
    fit = {"a": robot(t=2.1, battery=0.5)}
    assert safety.admit(2.1, [go((0.6, 0.4), t=2.1, until=2.4)], fit) == []
    safety.release(["a"])
    assert [type(c) for c in safety.admit(2.15, [go((0.6, 0.4), t=2.15, until=2.4)], fit)] == [GoTo]


def test_watching_stops_the_unfit_without_any_command():
    safety = SafetyFilter(LIMITS, SHEET)
    assert safety.watch(0.0, {"a": robot()}) == []
    assert safety.watch(0.1, {"a": robot(t=0.1, held=True)}) == [Stop(0.1, "a", "lifted or off the sheet")]
    assert safety.watch(0.2, {"a": robot(t=0.2)}) == []
    assert safety.waiting == {"a": "lifted or off the sheet"}


def test_an_unknown_robot_gets_no_motion_and_others_none_without_a_lease():
    assert filtered(go((0.6, 0.4))) is None
    assert filtered(go((0.6, 0.4), until=0.0), robot()) is None


def test_a_lease_that_ends_is_a_stop():
    safety = SafetyFilter(LIMITS, SHEET)
    safety.admit(0.0, [go((0.6, 0.4))], {"a": robot()})
    assert safety.watch(0.25, {"a": robot(t=0.25)}) == []
    assert safety.watch(0.3, {"a": robot(t=0.3)}) == [Stop(0.3, "a", "its lease ended")]
    assert safety.watch(0.35, {"a": robot(t=0.35)}) == []


def test_stop_is_latched_until_resume():
    safety = SafetyFilter(LIMITS, SHEET)
    states = {"a": robot()}
    assert safety.admit(0.0, [Stop(0.0)], states) == [Stop(0.0)]
    assert safety.admit(0.0, [go((0.52, 0.4))], states) == []
    assert safety.admit(0.0, [Light(0.0, "a", (255, 0, 0))], states) == [Light(0.0, "a", (255, 0, 0))]
    safety.resume()
    assert len(safety.admit(0.0, [go((0.52, 0.4))], states)) == 1


def test_a_stop_takes_the_motions_before_it_with_it():
    safety = SafetyFilter(LIMITS, SHEET)
    states = {"a": robot(), "b": robot("b", (0.2, 0.2))}
    out = safety.admit(0.0, [go((0.6, 0.4)), go((0.3, 0.2), robot="b"), Stop(0.0, "a", "x")], states)
    assert [(type(c), c.robot) for c in out] == [(Stop, "a"), (GoTo, "b")]


def test_the_goal_of_a_robot_that_is_not_heard_of_is_still_kept_clear():
    """A Stop may not have reached it: it may be on its way to the last goal."""
    safety = SafetyFilter(LIMITS, SHEET)
    states = {"lost": robot("lost", (0.5, 0.4)), "a": robot("a", (0.66, 0.4))}
    (left,) = safety.admit(0.0, [go((0.6, 0.4), robot="lost")], states)
    assert left.xy[0] > 0.515
    t = 2.0
    states["a"] = robot("a", (0.66, 0.4), t=t)
    assert safety.watch(t, states)[0].robot == "lost"
    for k in range(30):
        t = 2.0 + 0.05 * k
        states["a"] = robot("a", states["a"].xy, t=t)
        (out,) = safety.admit(t, [go((0.4, 0.4), t=t, until=t + 0.3)], states)
        states["a"] = robot("a", out.xy, t=t)
        assert np.hypot(*np.subtract(out.xy, left.xy)) >= GAP - 1e-6


def unlinked(safety, states):
    """Its link is told to be down before it has been silent for long."""
    safety.hold(0.1, "lost", "its link is down")


def lapsed(safety, states):
    """Its lease ends before it has been silent for long."""
    safety.watch(0.3, states)


def stopped(safety, states):
    """All are stopped, and may go again."""
    safety.admit(0.1, [Stop(0.1)], states)
    safety.resume()


@pytest.mark.parametrize("befall", [unlinked, lapsed, stopped])
def test_a_stop_that_was_perhaps_not_heard_forgets_no_goal(befall):
    safety = SafetyFilter(LIMITS, SHEET)
    states = {"lost": robot("lost", (0.5, 0.4)), "a": robot("a", (0.75, 0.4))}
    (left,) = safety.admit(0.0, [go((0.6, 0.4), robot="lost")], states)
    befall(safety, states)
    for k in range(40):
        t = 1.0 + 0.05 * k
        states["a"] = robot("a", states["a"].xy, t=t)
        safety.watch(t, states)
        (out,) = safety.admit(t, [go((0.4, 0.4), t=t, until=t + 0.3)], states)
        states["a"] = robot("a", out.xy, t=t)
        assert np.hypot(*np.subtract(out.xy, left.xy)) >= GAP - 1e-6


@pytest.mark.parametrize("xy", [np.array([np.nan, 0.4]), [np.nan, 0.4], (np.float32("nan"), 0.4)])
def test_what_is_not_finite_in_any_other_guise_stops_too(xy):
    assert isinstance(filtered(go(xy), robot()), Stop)


def test_a_robot_whose_clock_is_ahead_is_not_driven():
    assert "clock is ahead" in filtered(go((0.6, 0.4)), robot(t=9.0)).why


# --- whatever is asked ---------------------------------------------------------------------------------------

places = st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 0.8))
wild = st.tuples(st.floats(-1, 2), st.floats(-1, 2))


def hull(points):
    return shapely.MultiPoint(points).convex_hull


class Overseer:
    """Keeps, apart from the filter, every goal that a robot may still drive to, and checks what leaves."""

    def __init__(self, places):
        self.at = dict(places)
        self.goals = {name: [] for name in self.at}

    def way(self, name, t):
        return hull([self.at[name], *(xy for xy, end in self.goals[name] if end > t)])

    def distances(self, t):
        names = sorted(self.at)
        ways = {name: self.way(name, t) for name in names}
        return {(a, b): ways[a].distance(ways[b]) for a in names for b in names if a < b}

    def take(self, t, out):
        before = self.distances(t)
        for command in out:
            self._check(command, t)
            goals = self.goals[command.robot]
            keep = t + (LIMITS.latency_s + LOST)
            self.goals[command.robot] = [(xy, min(end, keep)) for xy, end in goals] + [(command.xy, np.inf)]
        after = self.distances(t)
        for pair, distance in before.items():
            assert after[pair] >= min(GAP, distance) - 1e-6

    def _check(self, command, t):
        (x, y), (hx, hy), margin = command.xy, self.at[command.robot], LIMITS.body_radius_m
        assert isinstance(command, GoTo)
        assert 0 <= command.speed <= LIMITS.speed_m_s + 1e-9
        assert t < command.until <= t + LIMITS.lease_s + 1e-9
        assert np.hypot(x - hx, y - hy) <= LIMITS.lead_m + 1e-9
        for value, here, size in ((x, hx, SHEET.width_m), (y, hy, SHEET.height_m)):
            assert min(margin, here) - 1e-9 <= value <= max(size - margin, here) + 1e-9

    def move(self, t, rng):
        """Every robot turns up somewhere on its way, as the worst of links and firmwares would have it."""
        for name, (x, y) in self.at.items():
            live = [(x, y), *(xy for xy, end in self.goals[name] if end > t)]
            share = rng.dirichlet(np.full(len(live), 0.5))
            self.at[name] = tuple((share @ np.array(live)).tolist())


@settings(max_examples=30, derandomize=True, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(st.lists(places, min_size=2, max_size=7), st.lists(wild, min_size=7, max_size=7), st.integers(0, 1000))
def test_whatever_is_asked_what_leaves_keeps_every_limit_and_every_gap(starts, goals, seed):
    rng = np.random.default_rng(seed)
    names = [f"r{k}" for k in range(len(starts))]
    safety = SafetyFilter(LIMITS, SHEET, np.random.default_rng(seed))
    overseer = Overseer(zip(names, starts, strict=True))
    for k in range(25):
        t = 0.05 * k
        states = {name: robot(name, overseer.at[name], t) for name in names}
        asked = []
        for name, goal in zip(names, goals, strict=False):
            if rng.random() < 0.8:
                speed = float(rng.choice([0.0, 0.05, 0.15, 9.0]))
                drive = Drive(t, name, (goal[0] - 0.5, goal[1] - 0.4), 0.0, t + 9.0)
                asked.append(GoTo(t, name, goal, speed, t + 9.0) if rng.random() < 0.7 else drive)
        overseer.take(t, safety.admit(t, asked, states))
        overseer.move(t, rng)


@pytest.mark.parametrize("wrong", [{"speed_m_s": 1.0}, {"lease_s": 0.0}, {"lead_m": -1.0}, {"gap_m": float("nan")}])
def test_limits_out_of_range_are_refused(wrong):
    with pytest.raises(ConfigError, match="expected more than 0"):
        Limits(**wrong)
