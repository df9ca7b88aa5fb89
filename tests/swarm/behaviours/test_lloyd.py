import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from armspan.errors import ConfigError
from armspan.records import RobotState, Sheet
from armspan.swarm.behaviours.lloyd import Lloyd, centroids, lattice
from armspan.swarm.behaviours.protocol import Stage
from armspan.swarm.limits import Limits

DT = 0.05
ELL = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.4), (0.4, 0.4), (0.4, 1.0), (0.0, 1.0)]


def stage(seed=0, size=(1.0, 1.0)):
    return Stage(Sheet(*size), Limits(), np.random.default_rng(seed))


def states_of(t, places):
    return {name: RobotState(t, name, (float(xy[0]), float(xy[1])), 0.0) for name, xy in places.items()}


def run(behaviour, places, seconds=40.0, t=0.0, on=None):
    """Ideal discs drive straight to their wishes until all is done; the time it took."""
    low, high = (on or stage()).bounds
    end = t + seconds
    while t < end and not behaviour.done:
        for wish in behaviour.step(t, states_of(t, places), None):
            assert ((low - 1e-9 <= np.array(wish.xy)) & (np.array(wish.xy) <= high + 1e-9)).all()
            way = np.array(wish.xy) - places[wish.robot]
            places[wish.robot] = places[wish.robot] + way * min(1.0, 0.15 * DT / max(math.hypot(*way), 1e-12))
        t += DT
    return t


def cost(places, area=None):
    """The locational cost H: the mean squared distance to the nearest robot, over a raster."""
    line = np.arange(0.0025, 1.0, 0.005)
    points = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    if area is not None:
        points = points[shapely.contains_xy(shapely.Polygon(area), points[:, 0], points[:, 1])]
    return float((KDTree(np.array(list(places.values()))).query(points)[0] ** 2).mean())


def in_a_row(count):
    return {f"r{i}": np.array([0.5, (i + 0.5) / count]) for i in range(count)}


def anywhere(count, seed, size=1.0):
    rng = np.random.default_rng(seed)
    return {f"r{i:03d}": rng.uniform(0.05, size - 0.05, 2) for i in range(count)}


@pytest.mark.parametrize(
    ("count", "best"), [(1, 1 / 6), (2, 0.10416), (4, 1 / 24), (5, 0.0353), (6, 0.03), (9, 1 / 54)]
)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_cost_is_that_of_the_exact_optimum(count, best, seed):
    """Also from a row, in which plain Lloyd never leaves the line."""
    places = in_a_row(count) if seed == 0 else anywhere(count, seed)
    behaviour = Lloyd(stage(seed), states_of(0.0, places))
    run(behaviour, places)
    assert behaviour.done
    assert cost(places) == pytest.approx(best, rel=0.02)


def test_the_centroids_of_two_cells_by_hand():
    """An L of two legs, cut by the line x = 0.4 between two sites: a rectangle each."""
    area = shapely.Polygon(ELL)
    sites = np.array([[0.2, 0.2], [0.6, 0.2]])
    assert centroids(area, sites) == pytest.approx(np.array([[0.2, 0.5], [0.7, 0.2]]))


def test_sites_in_a_row_and_outside_of_the_area_have_centroids():
    area = shapely.box(0, 0, 1, 1)
    middles = centroids(area, np.array([[0.25, 0.5], [0.75, 0.5]]))
    assert middles == pytest.approx(np.array([[0.25, 0.5], [0.75, 0.5]]))
    assert centroids(area, np.array([[0.5, 0.5], [9.0, 0.5]])) == pytest.approx(np.array([[0.5, 0.5], [1.0, 0.5]]))


def test_each_robot_goes_to_a_site_of_its_own_and_holds_it():
    places = in_a_row(4)
    behaviour = Lloyd(stage(), states_of(0.0, places))
    t = run(behaviour, places)
    expected = {(0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75)}
    assert {tuple(np.round(xy * 4) / 4) for xy in places.values()} == expected
    pushed = {name: xy + 0.03 for name, xy in places.items()}
    for wish in behaviour.step(t, states_of(t, pushed), None):
        assert math.dist(wish.xy, places[wish.robot]) < 0.009
    assert not behaviour.done


def test_the_others_take_over_when_one_leaves_and_make_room_when_it_returns():
    places = anywhere(5, 3)
    behaviour = Lloyd(stage(), states_of(0.0, places))
    t = run(behaviour, places)
    gone = {"r000": places.pop("r000")}
    for _ in range(10):  # half a second: nothing changes
        wishes = behaviour.step(t, states_of(t, places), None)
        assert all(math.dist(wish.xy, places[wish.robot]) < 0.009 for wish in wishes)
        t += DT
    for _ in range(15):
        behaviour.step(t, states_of(t, places), None)
        t += DT
    assert not behaviour.done
    t = run(behaviour, places, t=t)
    assert cost(places) == pytest.approx(1 / 24, rel=0.02)
    places |= gone
    behaviour.step(t, states_of(t, places), None)
    run(behaviour, places, t=t)
    assert cost(places) == pytest.approx(0.0353, rel=0.02)


def test_an_area_that_is_not_convex():
    """Three in an L: no worse than one in the middle of each of its three equal squares of 0.4 m and more."""
    places = in_a_row(3)
    behaviour = Lloyd(stage(), states_of(0.0, places), ELL)
    run(behaviour, places)
    assert behaviour.done
    by_hand = {"a": np.array([0.2, 0.2]), "b": np.array([0.7, 0.2]), "c": np.array([0.2, 0.7])}
    assert cost(places, ELL) < cost(by_hand, ELL)


@pytest.mark.parametrize(
    "area", [[(0.0, 0.2), (0.02, 0.2), (0.02, 0.8), (0.0, 0.8)], [(0.0, 0.0), (0.04, 0.0), (0.0, 0.04)]]
)
def test_an_area_in_the_margin_is_served_from_beside_it(area):
    places = anywhere(1, 2)
    behaviour = Lloyd(stage(), states_of(0.0, places), area)
    run(behaviour, places)
    assert behaviour.done
    assert places["r000"][0] == pytest.approx(0.045, abs=0.009)


def test_a_crowd_keeps_its_spacing():
    places = anywhere(60, 1)
    behaviour = Lloyd(stage(), states_of(0.0, places))
    run(behaviour, places, 60.0)
    assert behaviour.done
    stops = np.array(list(places.values()))
    away = KDTree(stops).query(stops, k=2)[0][:, 1]
    assert away.min() > stage().spacing - 2 * 0.008


def test_robots_in_one_place_part():
    places = {f"r{i}": np.array([0.5, 0.5]) for i in range(30)}
    behaviour = Lloyd(stage(), states_of(0.0, places))
    run(behaviour, places)
    assert behaviour.done
    assert len({tuple(np.round(xy, 2)) for xy in places.values()}) == 30


def test_a_lattice_has_as_many_places_as_fit_by_hand():
    """0.35 m squared at 0.1 m: 4 x 4 in squares; in a hexagon 5 rows of 4 and 3 or 4, since 4 x 0.0866 is 0.346."""
    places = lattice(shapely.box(0, 0, 0.35, 0.35), 0.1)
    assert len(places) == 20
    assert KDTree(places).query(places, k=2)[0][:, 1].min() == pytest.approx(0.1)


def test_what_cannot_be_done_is_refused():
    with pytest.raises(ConfigError, match=r"5 robots do not fit .* expected at most 4: take a larger area"):
        Lloyd(stage(), states_of(0.0, anywhere(5, 0)), [(0.2, 0.2), (0.35, 0.2), (0.35, 0.35), (0.2, 0.35)])
    with pytest.raises(ConfigError, match="crosses itself"):
        Lloyd(stage(), {}, [(0.1, 0.1), (0.9, 0.9), (0.9, 0.1), (0.1, 0.9)])
    four = Lloyd(stage(), states_of(0.0, anywhere(4, 0)), [(0.2, 0.2), (0.35, 0.2), (0.35, 0.35), (0.2, 0.35)])
    places = anywhere(4, 0)
    run(four, places)
    assert four.done


def test_without_robots_there_is_nothing_to_do_yet():
    behaviour = Lloyd(stage(), {})
    assert behaviour.step(0.0, {}, None) == []
    assert not behaviour.done


@settings(max_examples=12, derandomize=True, deadline=None)
@given(st.integers(1, 14), st.integers(0, 10_000), st.booleans())
def test_it_ends_no_worse_than_it_began_and_is_the_same_twice(count, seed, ell):
    area = ELL if ell else None
    ends = []
    for _ in range(2):
        places = anywhere(count, seed)
        behaviour = Lloyd(stage(seed), states_of(0.0, places), area)
        run(behaviour, places)
        assert behaviour.done
        ends.append([tuple(xy) for xy in places.values()])
    assert cost(places, area) <= cost(anywhere(count, seed), area) * 1.01
    assert ends[0] == ends[1]
