"""Slots, and what every behaviour made of them promises; here are also the ideal robots that its neighbours use."""

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.errors import ConfigError
from armspan.records import RobotState, Sheet, Zone
from armspan.swarm.behaviours import slots
from armspan.swarm.behaviours.come import Come
from armspan.swarm.behaviours.disperse import Disperse
from armspan.swarm.behaviours.follow import Follow
from armspan.swarm.behaviours.formation import FormationAt
from armspan.swarm.behaviours.gather import Gather
from armspan.swarm.behaviours.leader import Leader
from armspan.swarm.behaviours.patrol import Patrol
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.behaviours.rotate import Rotate
from armspan.swarm.behaviours.split import Merge, Split
from armspan.swarm.limits import Limits

DT = 0.05


def square(name, x, y, half=0.05):
    return Zone(name, ((x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)))


def stage(width=1.0, height=1.0, limits=None, zones=(), user=None):
    return Stage(Sheet(width, height), limits or Limits(), np.random.default_rng(0), tuple(zones), user)


def standing(places, t=0.0):
    """Robots a, b, c ... at places, by name."""
    return {chr(97 + i): RobotState(t, chr(97 + i), tuple(map(float, xy)), 0.0) for i, xy in enumerate(places)}


def moved(states, wishes, speeds=None):
    """Ideal robots one tick later: each straight toward its wish at its speed, through others if need be."""
    new = dict(states)
    for wish in wishes:
        state = states[wish.robot]
        way = np.subtract(wish.xy, state.xy)
        reach = min(wish.speed, (speeds or {}).get(wish.robot, np.inf)) * DT
        share = min(1.0, reach / max(math.hypot(*way), 1e-12))
        new[wish.robot] = RobotState(wish.t, wish.robot, tuple((np.array(state.xy) + share * way).tolist()), 0.0)
    return new


def run(behaviour, states, seconds=20.0, pointed=None, speeds=None):
    """The states at each tick until the behaviour is done or the time is over; ``pointed`` may depend on time."""
    trace = [states]
    for tick in range(round(seconds / DT)):
        spot = pointed(tick * DT) if callable(pointed) else pointed
        wishes = behaviour.step(tick * DT, trace[-1], spot)
        if behaviour.done:
            break
        trace.append(moved(trace[-1], wishes, speeds))
    return trace


def xy(states):
    return np.array([states[name].xy for name in sorted(states)])


def least(points):
    return min((math.dist(a, b) for a, b in combinations(points, 2)), default=math.inf)


# --- shapes ---------------------------------------------------------------------------------------------


def test_a_ring_of_four_has_its_neighbours_a_pitch_apart():
    four = slots.ring(4, 0.123)
    assert np.hypot(*four.T) == pytest.approx([0.123 / math.sqrt(2)] * 4)
    assert least(four) == pytest.approx(0.123)
    assert least(slots.ring(7, 0.123)) == pytest.approx(0.123)
    assert slots.ring(1, 0.123).tolist() == [[0.0, 0.0]]


def test_a_filled_disc_of_seven_is_a_hexagon_round_its_middle():
    radii = np.sort(np.hypot(*slots.filled_disc(7, 0.1).T))
    assert radii == pytest.approx([0.0] + [0.1] * 6, abs=1e-12)


def test_a_filled_disc_of_nineteen_has_two_full_rings():
    radii = np.sort(np.hypot(*slots.filled_disc(19, 1.0).T))
    assert radii == pytest.approx([0.0] + [1.0] * 6 + [math.sqrt(3)] * 6 + [2.0] * 6, abs=1e-9)


@pytest.mark.parametrize("n", [1, 5, 9, 20, 57, 200])
def test_slots_lie_apart_inside_the_sheet_wherever_they_are_wanted(n):
    here = stage(2.0, 1.5)
    for centre in ([0.0, 0.0], [1.0, 0.75], [5.0, 0.7]):
        places = slots.gathered(n, here, np.array(centre))
        assert places.shape == (n, 2)
        assert least(places) >= 0.12
        assert (places >= 0.045).all()
        assert (places <= [1.955, 1.455]).all()


def test_up_to_eight_leave_the_spot_itself_free():
    for n in (7, 8):
        places = slots.gathered(n, stage(), np.array([0.5, 0.5]))
        assert np.hypot(*(places - 0.5).T) == pytest.approx([0.0615 / math.sin(math.pi / n)] * n)


def test_where_no_ring_fits_robots_take_a_lattice():
    # 0.21 m are left in each direction: a ring of six would be 0.246 m wide
    places = slots.gathered(6, stage(0.3, 0.3), np.array([0.1, 0.1]))
    assert least(places) >= 0.12
    assert (places >= 0.045).all()
    assert (places <= 0.255).all()


def test_more_robots_than_fit_are_told_how_many_do():
    # of seven points in a square of side 1 two are 0.5359 or less apart: 0.1125 m on 0.21 m
    with pytest.raises(ConfigError, match=r"7 robots, 123 mm .* at most 6 fit: try fewer robots, a larger sheet"):
        slots.check_room(7, stage(0.3, 0.3))
    slots.check_room(6, stage(0.3, 0.3))


def test_a_narrow_sheet_holds_a_row():
    # 1 m less two margins is 0.91 m: seven pitches of 0.123 m, so eight robots
    narrow = stage(1.0, 0.09)
    assert slots.gathered(8, narrow, np.array([0.5, 0.5]))[:, 1] == pytest.approx([0.045] * 8)
    with pytest.raises(ConfigError, match="at most 8 fit"):
        slots.check_room(9, narrow)


@given(gap=st.floats(0.1, 0.4), wide=st.floats(0.0, 1.0), deep=st.floats(0.0, 1.0))
@settings(derandomize=True, deadline=None, max_examples=40)
def test_lattices_keep_the_gap_and_the_box(gap, wide, deep):
    for lattice in slots.lattices(gap, np.array([wide, deep])):
        assert least(lattice) >= gap - 1e-6
        assert (lattice >= -1e-9).all()
        assert (lattice <= np.array([wide, deep]) + 1e-9).all()


# --- who goes where -------------------------------------------------------------------------------------


def test_the_assignment_takes_the_least_squares():
    # lengths: 0.3007 + 0.1 is less than 0.2010 + 0.2; squares: 0.0904 + 0.01 is more than 0.0404 + 0.04
    here, wanted = np.array([[0.0, 0.02], [0.1, 0.0]]), np.array([[0.3, 0.0], [0.2, 0.0]])
    assert slots.matched(here, wanted).tolist() == [[0.2, 0.0], [0.3, 0.0]]


def test_places_apart_are_left_alone_and_others_set_apart():
    here = stage()
    apart = np.array([[0.3, 0.5], [0.43, 0.5], [0.56, 0.5]])
    assert slots.spaced(apart, here).tolist() == apart.tolist()
    found = slots.spaced(np.array([[0.45, 0.5], [0.55, 0.5]]), here)  # 0.1 apart: 11.5 mm each, to 0.123
    assert found == pytest.approx(np.array([[0.4385, 0.5], [0.5615, 0.5]]))


def test_a_fixed_place_is_kept_and_the_other_makes_way():
    found = slots.spaced(np.array([[0.45, 0.5], [0.55, 0.5]]), stage(), fixed=1)
    assert found == pytest.approx(np.array([[0.427, 0.5], [0.55, 0.5]]))


def test_robots_on_one_spot_or_pressed_into_a_corner_are_set_apart():
    for wanted in (np.full((12, 2), 0.5), np.full((12, 2), 2.0), np.full((12, 2), -1.0)):
        found = slots.spaced(wanted, stage())
        assert least(found) >= 0.12
        assert (found >= 0.045).all()
        assert (found <= 0.955).all()


def test_who_stands_on_a_fixed_place_in_a_corner_makes_way():
    found = slots.spaced(np.array([[0.0, 0.0]] * 3), stage(), fixed=0)
    assert found[0].tolist() == [0.045, 0.045]
    assert np.hypot(*(found[1:] - found[0]).T).max() < 0.25


def test_a_fixed_place_that_pins_others_into_a_corner_gives_way_a_little():
    wanted = np.array([[0.790, 0.844], [0.248, 0.613], [0.955, 0.970], [0.828, 0.970]])
    found = slots.spaced(wanted, stage(), fixed=0)
    assert found[1].tolist() == wanted[1].tolist()  # far from the crowd
    assert np.hypot(*(found - wanted).T).max() < 0.06


def test_a_row_that_is_too_long_for_the_edge_buckles():
    row = np.stack([np.linspace(0.045, 0.955, 10), np.full(10, 0.955)], axis=1)  # eight fit
    found = slots.spaced(row, stage())
    assert least(found) >= 0.12
    assert np.hypot(*(found - row).T).max() < 0.13


def test_rows_stand_behind_each_other():
    # 0.91 m hold eight in a row
    found = slots.rows(10, stage(), np.array([0.5, 0.955]), 1, -1)
    assert found[:8, 0] == pytest.approx(0.5 + 0.123 * np.arange(-3.5, 4))
    assert found[:8, 1] == pytest.approx([0.955] * 8)
    assert found[8:] == pytest.approx(np.array([[0.4385, 0.832], [0.5615, 0.832]]))


def test_rows_that_do_not_fit_become_a_lattice():
    found = slots.rows(6, stage(0.3, 0.3), np.array([0.15, 0.255]), 1, -1)  # two rows of two would fit
    assert len(found) == 6
    assert least(found) >= 0.12


# --- slots that are gone to ------------------------------------------------------------------------------


def test_slots_are_planned_anew_only_when_robots_come_or_go():
    asked = []
    going = slots.Slots(stage(), lambda here: asked.append(len(here)) or here + 0.1)
    three = standing([(0.2, 0.2), (0.4, 0.2), (0.6, 0.2)])
    for present in (three, three, {"b": three["b"]}, {"b": three["b"]}, three, {}):
        assert [wish.robot for wish in going.step(1.0, present)] == sorted(present)
    assert asked == [3, 1, 3]


def test_slots_are_done_within_eight_millimetres_and_not_without_robots():
    going = slots.Slots(stage(), lambda here: np.full((1, 2), 0.5))
    for x, done in ((0.509, False), (0.507, True)):
        (wish,) = going.step(2.0, standing([(x, 0.5)]))
        assert (wish.t, wish.until, wish.speed, wish.xy) == (2.0, 2.3, 0.15, (0.5, 0.5))
        assert going.done is done
    going.step(3.0, {})
    assert not going.done


def test_a_pause_counts_little():
    pace = slots.Pace()
    assert [pace.elapsed(t) for t in (5.0, 5.05, 9.0, 8.0)] == pytest.approx([0.0, 0.05, 0.1, 0.0])


# --- what every behaviour promises ----------------------------------------------------------------------

BEHAVIOURS = {
    "gather": Gather,
    "disperse": Disperse,
    "follow": Follow,
    "formation": FormationAt,
    "left": Rotate,
    "right": lambda *given: Rotate(*given, turn=-1),
    "split": Split,
    "merge": Merge,
    "patrol": Patrol,
    "leader": Leader,
    "come": Come,
}

_share = st.floats(-0.2, 1.2)
_anywhere = st.tuples(_share, _share)


@st.composite
def scenes(draw):
    """A sheet on which twelve robots have room to turn, robots anywhere, and what happens at 30 ticks."""
    limits = Limits(
        speed_m_s=draw(st.floats(0.05, 0.3)),
        body_radius_m=draw(st.floats(0.02, 0.06)),
        gap_m=draw(st.floats(0.001, 0.02)),
    )
    room = 4.2 * (limits.spacing_m + 0.003) + 2 * limits.body_radius_m
    size = np.array([room * draw(st.floats(1.0, 3.0)), room * draw(st.floats(1.0, 3.0))])
    points = draw(st.lists(_anywhere, min_size=1, max_size=12))
    zones = [
        square(f"z{i}", *(size * at), 0.04) for i, at in enumerate(draw(st.lists(_anywhere, min_size=1, max_size=4)))
    ]
    user = tuple((size * draw(_anywhere)).tolist())
    spots = [
        None if at is None else tuple((size * at).tolist()) for at in draw(st.lists(st.none() | _anywhere, max_size=4))
    ]
    away = draw(st.lists(st.tuples(st.integers(0, 11), st.integers(0, 29), st.integers(1, 10)), max_size=3))
    return stage(*size.tolist(), limits, zones, user), standing(size * np.array(points)), [*spots, None], away


@pytest.mark.parametrize("name", sorted(BEHAVIOURS))
@given(scene=scenes())
@settings(derandomize=True, deadline=None, max_examples=25)
def test_wishes_are_leased_inside_the_sheet_and_apart(name, scene):
    here, states, spots, away = scene
    behaviour = BEHAVIOURS[name](here, states)
    low, high = here.bounds
    for tick in range(30):
        gone = {chr(97 + who) for who, start, ticks in away if start <= tick < start + ticks}
        present = {robot: state for robot, state in states.items() if robot not in gone}
        wishes = behaviour.step(tick * DT, present, spots[tick * len(spots) // 30])
        assert {wish.robot for wish in wishes} <= set(present)
        assert len({wish.robot for wish in wishes}) == len(wishes)
        wanted = np.array([wish.xy for wish in wishes]).reshape(-1, 2)
        assert np.isfinite(wanted).all()
        assert (wanted >= low).all()
        assert (wanted <= high).all()
        assert least(wanted) >= 2 * here.limits.body_radius_m + here.limits.gap_m
        assert all(wish.t == tick * DT and wish.until == wish.t + here.limits.lease_s for wish in wishes)
        assert all(0 < wish.speed <= here.limits.speed_m_s for wish in wishes)
        states = moved(states, wishes)


@pytest.mark.parametrize("name", sorted(BEHAVIOURS))
def test_without_robots_nothing_is_wished_and_nothing_breaks(name):
    behaviour = BEHAVIOURS[name](stage(zones=[square("pond", 0.5, 0.5)], user=(0.5, 1.5)), {})
    assert behaviour.step(0.0, {}, (0.5, 0.5)) == []
    assert behaviour.step(0.05, {}, None) == []


@pytest.mark.parametrize("name", sorted(BEHAVIOURS))
def test_the_same_robots_lead_to_the_same_wishes(name):
    here = stage(zones=[square("pond", 0.3, 0.3), square("hill", 0.7, 0.6)], user=(0.5, 1.5))
    states = standing(np.random.default_rng(3).uniform(0.1, 0.9, (7, 2)))
    first, second = (BEHAVIOURS[name](here, order) for order in (states, dict(reversed(states.items()))))
    for tick in range(20):
        assert first.step(tick * DT, states, (0.6, 0.4)) == second.step(tick * DT, states, (0.6, 0.4))


@pytest.mark.parametrize("name", sorted(BEHAVIOURS))
def test_two_hundred_robots_find_room(name):
    here = stage(
        3.0, 3.0, zones=[square("pond", 0.5, 0.5), square("hill", 2.5, 0.9), square("lake", 1.0, 2.4)], user=(1.5, 4.0)
    )
    low, high = here.bounds
    behaviour = BEHAVIOURS[name](here, states := standing(np.random.default_rng(5).uniform(low, high, (200, 2))))
    for tick in range(3):
        wanted = np.array([wish.xy for wish in behaviour.step(tick * DT, states, (1.0, 1.0))])
        assert len(wanted) == 200
        assert least(wanted) >= 0.1
