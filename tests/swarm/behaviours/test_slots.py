"""Slots, and what every behaviour made of them promises."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.errors import ConfigError
from armspan.swarm.behaviours import slots
from armspan.swarm.behaviours.come import come
from armspan.swarm.behaviours.disperse import disperse
from armspan.swarm.behaviours.follow import Follow
from armspan.swarm.behaviours.formation import FormationAt
from armspan.swarm.behaviours.gather import Gather
from armspan.swarm.behaviours.leader import Leader
from armspan.swarm.behaviours.patrol import Patrol
from armspan.swarm.behaviours.rotate import Rotate
from armspan.swarm.behaviours.split import Merge, split
from armspan.swarm.limits import Limits
from ideal_robots import DT, least, moved, square, stage, standing

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
        assert np.hypot(*(places - 0.5).T) == pytest.approx([0.0738 / math.sin(math.pi / n)] * n)


@pytest.mark.parametrize(
    ("n", "side", "gap"), [(4, 0.3, 0.1476), (4, 0.29, 0.123), (19, 0.69, 0.1476), (19, 0.67, 0.123)]
)
def test_slots_lie_a_fifth_wider_where_there_is_room(n, side, gap):
    # a ring of four is 1.414 gaps wide, 0.2087 m, and its disc 1.5, 0.2214 m: 0.21 and 0.20 m are there;
    # a disc of nineteen is four gaps wide, 0.5904 m: 0.60 and 0.58 m are there
    places = slots.gathered(n, stage(side, side), np.array([0.1, 0.1]))
    assert least(places) == pytest.approx(gap)
    assert np.ptp(places, axis=0).max() == pytest.approx(gap * (math.sqrt(2) if n == 4 else 4))


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
@settings(derandomize=True, deadline=None, max_examples=25)
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
    # 0.91 m hold seven in a row, 0.1476 m apart
    found = slots.rows(9, stage(), np.array([0.5, 0.955]), 1, -1)
    assert found[:7, 0] == pytest.approx(0.5 + 0.1476 * np.arange(-3, 4))
    assert found[:7, 1] == pytest.approx([0.955] * 7)
    assert found[7:] == pytest.approx(np.array([[0.4262, 0.8074], [0.5738, 0.8074]]))


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


INNER, OUTER = (0.5, 0.5), (0.65, 0.5)


def in_turn(swap):
    """Slots that are given out by name: the inner one to "a"."""
    return slots.Slots(stage(), lambda here: np.array([INNER, OUTER]), swap)


def test_robots_take_each_others_slots_every_half_second_where_that_is_shorter():
    # squares in all, "a" out and "b" in: 0.25² + 0 as given out, 0.1² + 0.15² the other way round
    crossed, given_out = standing([(0.75, 0.5), OUTER]), standing([(0.45, 0.5), (0.75, 0.5)])
    going, told = in_turn(swap=True), []
    for tick in range(23):
        (first, second) = going.step(tick * DT, given_out if 2 <= tick < 21 else crossed)
        assert {first.xy, second.xy} == {INNER, OUTER}
        told.append(first.xy == OUTER)
    # asked for at the second step, half a second after it, 0.55 s, and again 1.05 s after the start
    assert told == [False] + [True] * 10 + [False] * 10 + [True] * 2


def test_one_in_the_way_of_an_empty_slot_moves_in_and_leaves_its_own():
    """Discs that halt before each other: "b" rests in its outer slot, between "a" and the empty inner one."""
    for swap in (False, True):
        going, states = in_turn(swap), standing([(0.8, 0.5), OUTER])
        for tick in range(60):
            states = moved(states, going.step(tick * DT, states), apart=0.12)
        assert going.done is swap
        # "a" halts 0.12 m before "b", or else has the outer slot
        assert states["a"].xy == pytest.approx(OUTER if swap else (0.77, 0.5), abs=0.008)
        assert states["b"].xy == pytest.approx(INNER if swap else OUTER)


@pytest.mark.parametrize("make", [Gather, disperse, split, Merge, come])
def test_who_is_blocked_changes_slots(make):
    """All stand in their slots but two, and each of these is in the other's."""
    here = stage(user=(0.5, 1.4))
    places = np.random.default_rng(8).uniform(0.2, 0.8, (6, 2))
    wanted = make(here, standing(places)).step(0.0, standing(places), None)
    crossed = np.array([wish.xy for wish in wanted])[[1, 0, 2, 3, 4, 5]]
    behaviour = make(here, standing(places))
    behaviour.step(0.0, standing(places), None)
    behaviour.step(DT, standing(crossed), None)
    assert behaviour.done


@pytest.mark.parametrize("make", [Follow, FormationAt])
def test_in_a_formation_nobody_changes_slots(make):
    places = np.array([(0.2, 0.2), (0.4, 0.2), (0.3, 0.4)])
    behaviour = make(stage(), standing(places))
    first, later = (
        behaviour.step(t, standing(at), (0.6, 0.6)) for t, at in ((0.0, places), (2.0, places[[1, 2, 0]] + 0.3))
    )
    moves = np.subtract([wish.xy for wish in later], [wish.xy for wish in first])
    assert np.hypot(*moves.T).max() <= 0.015 + 1e-9  # the centre glides by 0.1 s at most


# --- what every behaviour promises ----------------------------------------------------------------------

BEHAVIOURS = {
    "gather": Gather,
    "disperse": disperse,
    "follow": Follow,
    "formation": FormationAt,
    "left": Rotate,
    "right": lambda *given: Rotate(*given, turn=-1),
    "split": split,
    "merge": Merge,
    "patrol": Patrol,
    "leader": Leader,
    "come": come,
}

_share = st.floats(-0.2, 1.2)
_anywhere = st.tuples(_share, _share)


@st.composite
def scenes(draw):
    """A sheet on which twelve robots have room to turn, robots anywhere, and what happens at 20 ticks."""
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
    away = draw(st.lists(st.tuples(st.integers(0, 11), st.integers(0, 19), st.integers(1, 10)), max_size=3))
    return stage(*size.tolist(), limits, zones, user), standing(size * np.array(points)), [*spots, None], away


@pytest.mark.parametrize("name", sorted(BEHAVIOURS))
@given(scene=scenes())
@settings(derandomize=True, deadline=None, max_examples=25)
def test_wishes_are_leased_inside_the_sheet_and_apart(name, scene):
    here, states, spots, away = scene
    behaviour = BEHAVIOURS[name](here, states)
    low, high = here.bounds
    for tick in range(20):
        gone = {chr(97 + who) for who, start, ticks in away if start <= tick < start + ticks}
        present = {robot: state for robot, state in states.items() if robot not in gone}
        wishes = behaviour.step(tick * DT, present, spots[tick * len(spots) // 20])
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
