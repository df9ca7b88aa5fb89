import math
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.errors import DataError, DeviceNotFound
from armspan.records import Drive, GoTo, Light, Sheet, Stop
from armspan.simulation.discs import IdealDiscs

SHEET = Sheet(2.0, 1.0)


def names(n):
    return [f"disc{i}" for i in range(n)]


def discs(*xy, sheet=SHEET, **more):
    return IdealDiscs(names(len(xy)), xy, sheet, **more)


def goto(t, x, y, speed=0.15, robot="disc0", heading=None):
    return GoTo(t, robot, (x, y), speed, t + 0.3, heading)


def drive(t, vx, vy=0.0, turn=0.0, robot="disc0"):
    return Drive(t, robot, (vx, vy), turn, t + 0.3)


def place(plant, i=0):
    return plant.truth()[0][i].tolist()


# --- motion -----------------------------------------------------------------------------------------------


def test_a_disc_drives_straight_at_the_told_speed_and_stops_at_the_goal():
    plant = discs((0.2, 0.2))
    plant.command(0.0, goto(0.0, 0.5, 0.6, speed=0.1))  # 0.5 m away: 5 s
    plant.advance(2.0)
    assert place(plant) == pytest.approx([0.32, 0.36], abs=1e-12)
    assert plant.truth()[2][0] == pytest.approx([0.06, 0.08], abs=1e-12)
    plant.advance(4.999)
    assert place(plant) == pytest.approx([0.49994, 0.59992], abs=1e-9)
    plant.advance(60.0)
    assert place(plant) == pytest.approx([0.5, 0.6], abs=1e-12)
    assert plant.truth()[2].tolist() == [[0.0, 0.0]]


def test_a_drive_knows_no_lease_and_turns_until_a_stop():
    plant = discs((0.2, 0.2), (0.2, 0.8))
    plant.command(0.0, drive(0.0, 0.05, 0.02, turn=1.5))
    plant.advance(10.0)
    assert place(plant) == pytest.approx([0.7, 0.4])
    assert plant.truth()[1].tolist() == pytest.approx([15.0 % (2 * math.pi), 0.0])
    plant.command(10.0, Stop(10.0))
    plant.advance(20.0)
    assert place(plant) == pytest.approx([0.7, 0.4])
    assert plant.truth()[1][0] == pytest.approx(15.0 % (2 * math.pi))
    assert place(plant, 1) == [0.2, 0.8]


def test_a_stop_for_one_leaves_the_other_driving():
    plant = discs((0.2, 0.2), (0.2, 0.8))
    for robot in names(2):
        plant.command(0.0, drive(0.0, 0.1, robot=robot))
    plant.command(1.0, Stop(1.0, "disc1"))
    plant.advance(2.0)
    np.testing.assert_allclose(plant.truth()[0], [[0.4, 0.2], [0.3, 0.8]], atol=1e-12)


def test_a_command_acts_late_and_a_state_is_told_late():
    plant = discs((0.2, 0.2), latency=0.1)
    plant.command(0.0, goto(0.0, 1.2, 0.2, speed=0.1))
    told = plant.advance(1.0)
    assert place(plant)[0] == pytest.approx(0.2 + 0.1 * 0.9, abs=1e-12)
    for arrival, state in told:
        assert arrival == pytest.approx(state.t + 0.1, abs=1e-12)
        assert state.xy[0] == pytest.approx(0.2 + 0.1 * max(0.0, state.t - 0.1), abs=1e-12)
    assert told[-1][0] == pytest.approx(1.0)


def test_states_come_every_20_ms_and_the_times_are_exact():
    told = discs((0.2, 0.2), (0.4, 0.4)).advance(1.0)
    assert [state.t for _, state in told if state.robot == "disc1"] == pytest.approx(np.arange(51) * 0.02)
    assert len(discs((0.2, 0.2), period=0.1).advance(1.0)) == 11
    assert len(discs((0.2, 0.2), period=0.025).advance(1.0)) == 41


def test_the_speed_is_capped_and_never_negative():
    plant = discs((0.2, 0.2), (0.2, 0.5), (0.2, 0.8), speed=0.15)
    plant.command(0.0, goto(0.0, 1.9, 0.2, speed=0.5))
    plant.command(0.0, drive(0.0, -0.3, 0.4, robot="disc1"))
    plant.command(0.0, goto(0.0, 1.9, 0.8, speed=-1.0, robot="disc2"))
    plant.advance(1.0)
    np.testing.assert_allclose(plant.truth()[2], [[0.15, 0.0], [-0.09, 0.12], [0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(plant.truth()[0], [[0.35, 0.2], [0.11, 0.62], [0.2, 0.8]], atol=1e-12)


def test_a_told_heading_is_taken_at_once_and_kept_on_the_way():
    plant = discs((0.2, 0.2))
    plant.command(0.0, goto(0.0, 0.5, 0.2, heading=-1.0))
    plant.advance(0.1)
    plant.command(0.1, goto(0.1, 0.5, 0.2))
    plant.advance(0.2)
    assert plant.truth()[1][0] == pytest.approx(2 * math.pi - 1.0)


def test_a_light_moves_nobody():
    plant = discs((0.2, 0.2))
    plant.command(0.0, drive(0.0, 0.1))
    plant.command(0.5, Light(0.5, "disc0", (255, 0, 0)))
    plant.advance(1.0)
    assert place(plant)[0] == pytest.approx(0.3)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(st.floats(0, 2.9), st.integers(0, 2), st.floats(0.1, 1.9), st.floats(0.1, 0.9), st.booleans()),
        max_size=12,
    ),
    st.floats(0.003, 0.7),
)
def test_the_steps_of_advance_do_not_matter(acts, step):
    ends = []
    for stride in (3.0, step):
        plant, told, left = discs((0.3, 0.3), (0.6, 0.6), (1.5, 0.5), latency=0.05), [], sorted(acts)
        for end in [*np.arange(stride, 3.0, stride), 3.0]:
            while left and left[0][0] <= end:
                t, i, x, y, goes = left.pop(0)
                speed = 0.05 + 0.1 * x
                plant.command(
                    t, goto(t, x, y, speed, f"disc{i}") if goes else drive(t, x - 1, y - 0.5, robot=f"disc{i}")
                )
            told += plant.advance(float(end))
        ends.append((*plant.truth(), np.array([state.xy for _, state in told])))
    # the longest step sends all beforehand, the other one just before it acts
    for one, other in zip(*ends, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-7)


# --- lifting, the sheet's edge ----------------------------------------------------------------------------


def test_a_lifted_disc_tells_held_once_and_resumes_its_goal():
    plant = discs((0.2, 0.2))
    plant.command(0.0, goto(0.0, 1.2, 0.2, speed=0.1))
    plant.lift(1.005, "disc0")
    told = [state for _, state in plant.advance(2.0)]
    assert [state.held for state in told] == [False] * 51 + [True]
    assert told[-1].xy == told[-2].xy == pytest.approx((0.3, 0.2))
    plant.command(2.0, goto(2.0, 1.0, 0.9, speed=0.1))
    assert plant.advance(2.5) == []
    plant.put_down(3.0, "disc0", (1.0, 0.3), 2.0)
    told = [state for _, state in plant.advance(4.0)]
    assert told[0].xy == pytest.approx((1.0, 0.3))
    assert told[0].heading == pytest.approx(2.0)
    assert not any(state.held for state in told)
    assert place(plant) == pytest.approx([1.0, 0.4])


def test_off_the_sheet_a_disc_is_blind_but_drives_on():
    plant = discs((1.9, 0.5))
    plant.command(0.0, drive(0.0, 0.1))
    told = [state for _, state in plant.advance(3.0)]
    assert told[-1].held
    assert told[-1].xy[0] == pytest.approx(2.0, abs=0.0021)
    assert told[-1].t == pytest.approx(1.02, abs=0.021)
    assert place(plant)[0] == pytest.approx(2.2)


# --- overlaps ---------------------------------------------------------------------------------------------


def test_discs_do_not_push_each_other_and_each_overlap_counts_once():
    plant = discs((0.2, 0.5), (0.8, 0.5), (0.5, 0.58))
    plant.command(0.0, goto(0.0, 0.8, 0.5, robot="disc0"))
    plant.command(0.0, goto(0.0, 0.2, 0.5, robot="disc1"))
    plant.advance(10.0)
    np.testing.assert_allclose(plant.truth()[0], [[0.8, 0.5], [0.2, 0.5], [0.5, 0.58]], atol=1e-12)
    assert plant.contacts == 1  # the third is 80 mm off the way, and they are 75 mm wide
    plant.command(10.0, goto(10.0, 0.2, 0.5, robot="disc0"))
    plant.advance(20.0)
    assert plant.contacts == 2


def test_the_entry_is_where_the_centres_are_two_radii_apart():
    plant = discs((0.2, 0.5), (0.6, 0.5), radius=0.05)
    plant.command(0.0, drive(0.0, 0.1))
    plant.advance(2.98)
    assert plant.contacts == 0
    plant.advance(3.03)  # 0.3 m at 0.1 m/s, looked for every 10 ms
    assert plant.contacts == 1


def test_two_on_one_spot_overlap_at_once_and_lifted_ones_do_not():
    assert contacts_at_once(discs((0.2, 0.5), (0.25, 0.5))) == 1
    plant = discs((0.2, 0.5), (0.25, 0.5), (1.0, 0.5))
    plant.lift(0.0, "disc0")
    plant.advance(1.0)
    assert plant.contacts == 0
    plant.put_down(1.0, "disc0", (1.0, 0.52), 0.0)
    plant.advance(2.0)
    assert plant.contacts == 1


def contacts_at_once(plant):
    plant.advance(0.0)
    return plant.contacts


def test_the_count_is_that_of_looking_at_all_pairs():
    rng = np.random.default_rng(3)
    plant = IdealDiscs(names(30), rng.uniform(0.05, 0.95, (30, 2)), Sheet(1.0, 1.0))
    inside, found = set(), 0
    for step in range(1500):
        t = step * 0.01
        if step % 7 == 0:
            i, speed = int(rng.integers(30)), float(rng.uniform(0.02, 0.6))
            plant.command(t, goto(t, *rng.uniform(0.0, 1.0, 2).tolist(), speed, f"disc{i}"))
        plant.advance(t)
        xy = plant.truth()[0]
        gaps = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1)) + 9.0 * np.tri(30)
        now = {tuple(pair) for pair in np.argwhere(gaps < 0.075).tolist()}
        found, inside = found + len(now - inside), now
    assert plant.contacts == found > 100


# --- bad input, scale -------------------------------------------------------------------------------------


def test_who_does_not_exist_is_told_who_does():
    with pytest.raises(DeviceNotFound, match="there are: disc0"):
        discs((0.2, 0.2)).command(0.0, goto(0.0, 0.5, 0.5, robot="disk0"))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"xy": ((0.1, 0.1, 0.1),) * 2}, r"\(2, 2\)"),
        ({"xy": ((0.1, 0.1), (0.1, math.nan))}, "finite"),
        ({"names": ["a", "a"]}, "not all different"),
        ({"latency": -0.1}, "latency is -0.1"),
        ({"speed": math.inf}, "speed is inf"),
        ({"period": 0.0}, "period is 0"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    scene = {"names": names(2), "xy": ((0.1, 0.1), (0.3, 0.1)), "sheet": SHEET} | settings
    with pytest.raises(DataError, match=words):
        IdealDiscs(**scene)


def test_a_command_that_is_not_finite_is_refused():
    with pytest.raises(DataError, match="not finite"):
        discs((0.2, 0.2)).command(0.0, goto(0.0, math.nan, 0.2))


def test_a_thousand_discs_are_cheap():
    places = np.stack(np.meshgrid(np.arange(40), np.arange(25)), axis=-1).reshape(-1, 2) * 0.2 + 0.1
    plant, goals = IdealDiscs(names(1000), places, Sheet(8.0, 5.0)), np.random.default_rng(1)
    began = time.process_time()
    for step in range(10):
        for i, (x, y) in enumerate(goals.uniform(0.0, 5.0, (1000, 2)).tolist()):
            plant.command(step * 0.05, goto(step * 0.05, x, y, robot=f"disc{i}"))
        plant.advance((step + 1) * 0.05)
    assert time.process_time() - began < 0.5  # faster than real time; it takes about 0.12 s
