import math
import time

import numpy as np
import pytest
import shapely

from armspan.errors import DataError
from armspan.records import Sheet
from armspan.study.coverage import Coverage, closeness, cluster_size, locational_cost, outline

R = 0.0375
SQUARE = Sheet(1.0, 1.0)
ELL = ((0.0, 0.0), (1.0, 0.0), (1.0, 0.4), (0.4, 0.4), (0.4, 1.0), (0.0, 1.0))


def swept(*ways, area=SQUARE, radius=R, cell=0.005):
    """One disc for each way, a place a second."""
    coverage = Coverage(area, radius, cell)
    for t, places in enumerate(zip(*ways, strict=True)):
        coverage.take(float(t), places)
    return coverage


def brute(segments, radius, coverage):
    """Which cells are within a radius of a segment, by looking at every cell and shapely's distance."""
    rows, columns = coverage.inside.shape
    points = shapely.points(*coverage._spots(np.arange(rows)[:, None], np.arange(columns)))
    near = [shapely.distance(points, shapely.LineString(segment)) <= radius for segment in segments]
    return np.any(near, axis=0)


# --- what is swept ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("end", [(0.8, 0.2), (0.8, 0.9), (0.21, 0.2)])
def test_a_straight_path_covers_a_capsule(end):
    coverage = swept([(0.2, 0.2), end], cell=0.002)
    length = math.hypot(end[0] - 0.2, end[1] - 0.2)
    assert coverage.share() == pytest.approx(2 * R * length + math.pi * R**2, rel=0.005)


@pytest.mark.parametrize("width", [0.0300, 0.0375, 0.0401])
def test_a_strip_along_an_axis_is_not_rounded_to_whole_cells(width):
    for start, end in (((0.2, 0.5), (0.8, 0.5)), ((0.3, 0.1), (0.3, 0.7))):
        coverage = swept([start, end], radius=width)
        assert coverage.share() == pytest.approx(2 * width * 0.6 + math.pi * width**2, rel=0.005)


def test_a_sliver_between_two_lanes_counts_for_what_it_is():
    # 2 mm are left bare, in cells of 5 mm.
    lanes = [(0.0, 0.3 - R), (1.0, 0.3 - R)], [(0.0, 0.302 + R), (1.0, 0.302 + R)]
    box = ((0.1, 0.25), (0.9, 0.25), (0.9, 0.35), (0.1, 0.35))
    assert 1 - swept(*lanes, area=box).share() == pytest.approx(0.02, rel=0.05)


def test_the_spots_lie_in_their_cells_and_evenly():
    coverage = Coverage(Sheet(1.0, 0.5), R, 0.01)
    x, y = coverage._spots(np.arange(50)[:, None], np.arange(100))
    np.testing.assert_array_equal(np.floor(100 * x), np.arange(100) + np.zeros((50, 1)))
    np.testing.assert_array_equal(np.floor(100 * y), np.arange(50)[:, None] + np.zeros(100))
    np.testing.assert_allclose(np.histogram((100 * y) % 1.0, 5, (0.0, 1.0))[0], 1000, atol=50)


def test_a_path_in_small_steps_covers_what_one_step_covers():
    steps = np.linspace((0.2, 0.2), (0.8, 0.9), 300)
    np.testing.assert_array_equal(np.isfinite(swept(steps).first), np.isfinite(swept([(0.2, 0.2), (0.8, 0.9)]).first))


@pytest.mark.parametrize("seed", range(5))
def test_the_cells_are_those_within_the_radius_of_the_path(seed):
    dice = np.random.default_rng(seed)
    ways = dice.uniform(-0.1, 1.1, (3, 4, 2))  # off the sheet, too
    ways[2] = ways[2, 0] + 1e-4 * dice.standard_normal((4, 2))
    coverage = swept(*ways, area=Sheet(0.97, 0.71), radius=0.06, cell=0.007)
    segments = [(way[k], way[k + 1]) for way in ways for k in range(3)]
    np.testing.assert_array_equal(np.isfinite(coverage.first), brute(segments, 0.06, coverage))


def test_only_the_area_counts():
    triangle = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    coverage = swept([(0.0, 0.05), (1.0, 0.05)], area=triangle, radius=0.05)
    # What lies below y = 0.1: 0.1 - 0.1²/2 of the triangle's 0.5 m²; the disc's round ends lie beyond it.
    assert coverage.share() == pytest.approx(0.095 / 0.5, rel=0.01)


def test_a_hole_does_not_count():
    ring = shapely.Polygon([(0, 0), (1, 0), (1, 1), (0, 1)], [[(0.25, 0.25), (0.75, 0.25), (0.75, 0.75), (0.25, 0.75)]])
    coverage = swept([(-1.0, 0.5), (2.0, 0.5)], area=ring, radius=0.1)  # two pieces of 0.25 m by 0.2 m
    assert coverage.share() == pytest.approx(0.1 / 0.75, rel=0.01)


def test_a_lifted_disc_covers_nothing_until_it_is_back():
    gone = (math.nan, math.nan)
    coverage = swept([(0.2, 0.2), gone, (0.8, 0.2)], cell=0.002)
    assert coverage.share() == pytest.approx(2 * math.pi * R**2, rel=0.01)


def test_a_disc_at_rest_covers_itself_once():
    coverage = swept([(0.5, 0.5)] * 20)
    assert coverage.share() == pytest.approx(math.pi * R**2, rel=0.01)
    assert coverage.overlap == 0.0


def test_the_way_back_is_overlap():
    # Every cell is left and entered again, but for those that the disc stood on as it turned.
    path = [*np.linspace((0.2, 0.5), (0.8, 0.5), 61), *np.linspace((0.79, 0.5), (0.2, 0.5), 60)]
    assert swept(path).overlap == pytest.approx(2 * R * 0.6, rel=0.03)


def test_a_second_disc_that_comes_later_is_overlap():
    first = [*np.linspace((0.2, 0.5), (0.8, 0.5), 50), *[(0.8, 0.5)] * 50]
    second = [*[(0.5, 0.2)] * 50, *np.linspace((0.5, 0.2), (0.5, 0.8), 50)]
    assert swept(first, second).overlap == pytest.approx((2 * R) ** 2, rel=0.05)  # where their ways cross


# --- over time --------------------------------------------------------------------------------------------


def test_times_grow_with_the_swept_length():
    # A strip 1 m long and 20 mm wide, and a front of 100 mm that starts at its rim: the share is v t.
    strip = ((0.0, 0.0), (1.0, 0.0), (1.0, 0.02), (0.0, 0.02))
    coverage = Coverage(strip, 0.1)
    for t in np.arange(5.0, 16.0, 0.05):  # a run may begin at any time
        coverage.take(t, [(-0.1 + 0.1 * (t - 5.0), 0.01)])
    expected = {"t50": 5.0, "t90": 9.0, "t95": 9.5, "t99": 9.9}
    assert coverage.times() == pytest.approx(expected, abs=0.06)
    assert coverage.shares()[[0, 60, 120]] == pytest.approx([0.0, 0.3, 0.6], abs=0.006)
    assert coverage.taken[-1] == pytest.approx(10.95)


def test_between_two_takes_the_share_is_linear():
    coverage = Coverage(SQUARE, 2.0, 0.02)
    coverage.take(0.0, [(-5.0, 0.5)])
    coverage.take(8.0, [(-4.0, 0.5)])
    coverage.take(18.0, [(0.5, 0.5)])
    assert coverage.times((0.5, 0.9)) == pytest.approx({"t50": 13.0, "t90": 17.0})


def test_a_share_that_is_never_reached_has_no_time():
    strip = Sheet(1.0, 0.07)
    coverage = swept(np.linspace((R, 0.035), (0.5, 0.035), 100), area=strip)
    times = coverage.times()
    assert times["t50"] is not None
    assert times["t50"] > 90
    assert (times["t90"], times["t95"], times["t99"]) == (None, None, None)


def test_what_is_covered_at_the_start_takes_no_time():
    assert swept([(0.5, 0.5)], radius=1.0).times() == {"t50": 0.0, "t90": 0.0, "t95": 0.0, "t99": 0.0}


def test_each_cell_knows_when_it_was_covered_first():
    coverage = swept(np.linspace((0.1, 0.5), (0.9, 0.5), 81))  # 10 mm a second
    row = coverage.first[100]
    middles = (np.arange(200) + 0.5) * 0.005
    ahead = (middles > 0.2) & (middles < 0.9)
    np.testing.assert_allclose(row[ahead], 100 * (middles[ahead] - R - 0.1), atol=1.1)
    assert np.isinf(coverage.first[50]).all()


# --- what can be swept ------------------------------------------------------------------------------------


def test_the_corners_are_out_of_a_discs_reach():
    coverage = Coverage(SQUARE, R, 0.002)
    assert coverage.coverable(R) == pytest.approx(1 - (4 - math.pi) * R**2, abs=2e-5)
    side = 1 - 2 * 0.045
    assert coverage.coverable(0.045) == pytest.approx(side**2 + 4 * side * R + math.pi * R**2, abs=1e-3)


def test_a_zone_is_reached_from_the_sheet_round_it():
    zone = ((0.4, 0.4), (0.6, 0.4), (0.6, 0.6), (0.4, 0.6))
    coverage = Coverage(zone, R)
    assert coverage.coverable(0.045, SQUARE) == 1.0
    assert coverage.coverable(R) == pytest.approx(1 - (4 - math.pi) * R**2 / 0.04, abs=3e-3)
    assert coverage.coverable(0.2) == 0.0  # no room at all


def test_times_can_be_those_of_what_can_be_reached():
    path = [(0.045, 0.045), (0.955, 0.045), (0.955, 0.955), (0.045, 0.955), (0.045, 0.045)]
    coverage = swept(path, radius=0.04)
    rim = coverage.reachable(0.045)
    assert coverage.share(rim) > coverage.share()
    # What is within the reach of the path, of what is within 40 mm of the square inside the margin.
    side = 0.91
    inner = side - 2 * 0.04
    reach = side**2 + 4 * side * 0.04 + math.pi * 0.04**2
    assert coverage.share(rim) == pytest.approx((reach - inner**2) / reach, rel=0.01)


# --- bad input, scale -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("area", "words"),
    [
        (((0, 0), (1, 1), (1, 0), (0, 1)), "Self-intersection"),
        (((0, 0), (1, 1)), "at least 3"),
        (((0, 0), (1, 0), (math.nan, 1)), "finite"),
        (((0, 0), (1, 0), (2, 0)), "simple outline"),
    ],
)
def test_an_area_that_is_none_is_refused(area, words):
    with pytest.raises(DataError, match=words):
        outline(area)


def test_time_must_rise_and_robots_stay_as_many():
    coverage = swept([(0.2, 0.2)])
    with pytest.raises(DataError, match=r"1 places at 0\.0 s"):
        coverage.take(0.0, [(0.3, 0.2)])
    with pytest.raises(DataError, match="2 places"):
        coverage.take(1.0, [(0.3, 0.2), (0.4, 0.2)])


@pytest.mark.parametrize(("radius", "cell"), [(R, 0.0), (R, 0.05), (math.inf, 0.005), (-1.0, 0.005)])
def test_cells_must_be_smaller_than_the_disc(radius, cell):
    with pytest.raises(DataError, match="expected 0 < cell <= radius"):
        Coverage(SQUARE, radius, cell)


def test_a_thousand_discs_are_marked_cheaply():
    dice = np.random.default_rng(1)
    coverage, xy = Coverage(Sheet(6.0, 6.0), R), dice.uniform(0.0, 6.0, (1000, 2))
    began = time.process_time()
    for k in range(10):
        coverage.take(0.05 * k, xy + 0.0075 * k)
    assert time.process_time() - began < 0.5  # faster than real time; it takes about 0.08 s


# --- deployment -------------------------------------------------------------------------------------------


def lattice(k, size=1.0):
    middles = (np.arange(k) + 0.5) / k * size
    return np.stack(np.meshgrid(middles, middles), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize(("k", "cost"), [(1, 1 / 6), (2, 1 / 24), (3, 1 / 54), (10, 1 / 600)])
def test_the_lattice_in_the_unit_square_has_the_known_cost(k, cost):
    assert locational_cost(lattice(k), SQUARE) == pytest.approx(cost, rel=1e-6)
    small = Sheet(0.6, 0.6)
    assert locational_cost(lattice(k, 0.6), small, normalised=True) == pytest.approx(cost, rel=1e-6)
    assert locational_cost(lattice(k, 0.6), small) == pytest.approx(cost * 0.6**4, rel=1e-6)


@pytest.mark.parametrize(
    ("xy", "cost"),
    [
        (((0.0, 0.0),), 2 / 3),  # the integral of x² + y²
        (((0.25, 0.5), (0.75, 0.5)), 0.5 * (0.5**2 + 1) / 12 * 2),
        (((0.25, 0.5), (0.75, 0.5), (0.75, 0.5)), 0.5 * (0.5**2 + 1) / 12 * 2),  # two on one spot are as one
        (((0.5, 0.5), (5.0, 0.5)), 1 / 6),  # one off the sheet is of no use
        (((-1.0, 0.5),), 1 / 12 + 1 / 12 + 1.5**2),  # parallel axes
    ],
)
def test_costs_worked_out_by_hand(xy, cost):
    assert locational_cost(xy, SQUARE) == pytest.approx(cost, rel=1e-6)


def test_a_hole_costs_nothing():
    ring = shapely.Polygon([(0, 0), (1, 0), (1, 1), (0, 1)], [[(0.25, 0.25), (0.75, 0.25), (0.75, 0.75), (0.25, 0.75)]])
    assert locational_cost([(0.5, 0.5)], ring) == pytest.approx(1 / 6 - 0.25 * 0.5 / 12)


@pytest.mark.parametrize("seed", range(6))
def test_the_cost_is_the_mean_over_many_spots(seed):
    dice = np.random.default_rng(seed)
    xy = dice.uniform(-0.2, 1.2, (dice.integers(2, 9), 2))
    middles = (np.arange(300) + 0.5) / 300
    spots = np.stack(np.meshgrid(middles, middles), axis=-1).reshape(-1, 2)
    spots = spots[(spots[:, 0] < 0.4) | (spots[:, 1] < 0.4)]  # 0.4 is a rim of the cells
    nearest = ((spots[:, None] - xy) ** 2).sum(axis=2).min(axis=1)
    assert locational_cost(xy, ELL) == pytest.approx(nearest.sum() / 300**2, rel=1e-3)


def test_a_cost_needs_a_place():
    with pytest.raises(DataError, match="at least one"):
        locational_cost([], SQUARE)
    with pytest.raises(DataError, match="finite"):
        locational_cost([(math.nan, 0.0)], SQUARE)


def test_cs_is_the_size_of_an_average_robots_cluster():
    chain, pair, alone = [(0.0, 0.0), (0.15, 0.0), (0.3, 0.0)], [(1.0, 0.0), (1.0, 0.1)], [(2.0, 2.0)]
    assert cluster_size(chain + pair) == pytest.approx((9 + 4) / 5)
    assert cluster_size(chain + pair + alone) == pytest.approx((9 + 4 + 1) / 6)
    assert cluster_size(alone) == 1.0
    assert cluster_size([(0.0, 0.0), (0.2, 0.0)]) == 1.0  # nearer than 0.2 m, not as near
    assert cluster_size([(0.0, 0.0), (0.2, 0.0)], link=0.21) == 2.0


def test_z_is_the_sum_of_all_distances():
    assert closeness([(0.0, 0.0), (0.3, 0.0), (0.0, 0.4)]) == pytest.approx(-(0.3 + 0.4 + 0.5))
    assert closeness([(0.0, 0.0)]) == 0.0
