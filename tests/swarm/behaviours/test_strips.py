import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.errors import ConfigError
from armspan.records import Sheet
from armspan.swarm.behaviours.strips import COVER, area_on, closest, missed, plan, way_lengths

SHEET = Sheet(1.0, 1.0)
BOUNDS = (np.full(2, 0.0375), np.full(2, 0.9625))
ELL = [(0.1, 0.1), (0.9, 0.1), (0.9, 0.4), (0.4, 0.4), (0.4, 0.9), (0.1, 0.9)]
U_SHAPE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.7, 1.0), (0.7, 0.3), (0.3, 0.3), (0.3, 1.0), (0.0, 1.0)]


def raster(area, step=0.005):
    """Middles of cells (n, 2) of a raster over the sheet that lie in the area."""
    line = np.arange(step / 2, 1.0, step)
    points = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    return points[shapely.contains_xy(area, points[:, 0], points[:, 1])]


def swept(points, lanes, cover=COVER):
    """Which points (n,) come under a disc that drives through the lanes (k, 2, 2): distances to segments, by hand."""
    corners, under = lanes.reshape(-1, 2), np.zeros(len(points), dtype=bool)
    for a, b in pairwise(corners):
        box = (points >= np.minimum(a, b) - cover / 2) & (points <= np.maximum(a, b) + cover / 2)
        near = np.flatnonzero(box[:, 0] & box[:, 1] & ~under)
        share = np.clip((points[near] - a) @ (b - a) / max((b - a) @ (b - a), 1e-12), 0, 1)
        away = a + share[:, None] * (b - a) - points[near]
        under[near] = np.hypot(away[:, 0], away[:, 1]) <= cover / 2
    return under


@st.composite
def stars(draw):
    """Polygons that need not be convex: corners in the order of their angles about the middle."""
    count = draw(st.integers(4, 9))
    parts = np.array(draw(st.lists(st.floats(0.2, 1.0), min_size=count, max_size=count)))
    angles = 2 * math.pi * np.cumsum(parts) / parts.sum()
    radii = draw(st.lists(st.floats(0.1, 0.6), min_size=count, max_size=count))
    return [(0.5 + r * math.cos(a), 0.5 + r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]


@settings(max_examples=15, derandomize=True, deadline=None)
@given(stars(), st.integers(1, 7))
def test_parts_are_equal_and_disjoint_and_their_lanes_sweep_them(polygon, count):
    area = area_on(SHEET, polygon)
    points = raster(area, 0.008)
    reachable = np.linalg.norm(points - np.clip(points, *BOUNDS), axis=1) <= COVER / 2
    for layout in plan(area, BOUNDS, count, COVER, 0.12):
        sizes = np.array([part.area for part in layout.parts])
        assert sizes == pytest.approx(np.full(count, area.area / count), rel=0.01)
        assert shapely.union_all(layout.parts).symmetric_difference(area).area < 1e-6
        under = np.any([swept(points, lanes) for lanes in layout.lanes], axis=0)
        assert under[reachable].mean() > 0.975
        for lanes in layout.lanes:
            assert (lanes >= BOUNDS[0] - 1e-9).all()
            assert (lanes <= BOUNDS[1] + 1e-9).all()


@pytest.mark.parametrize("polygon", [None, ELL, U_SHAPE])
@pytest.mark.parametrize("count", [1, 3, 5])
def test_what_is_left_out_is_what_a_raster_says(polygon, count):
    area = area_on(SHEET, polygon)
    points = raster(area)
    reachable = np.linalg.norm(points - np.clip(points, *BOUNDS), axis=1) <= COVER / 2
    layout = plan(area, BOUNDS, count, COVER, 0.12)[0]
    under = np.any([swept(points, lanes) for lanes in layout.lanes], axis=0)
    assert missed(layout, area, BOUNDS, COVER) == pytest.approx(1 - under[reachable].mean(), abs=0.002)
    assert under[reachable].mean() > 0.988


def test_one_robot_on_the_square_by_hand():
    """1 m of lanes 75 mm wide is 13.3: 14 lanes of 0.925 m and 13 turns, begun in any corner.

    The outermost lanes would lie at 1 / 28 m; a robot's centre stays 0.0375 m from the edge.
    """
    layouts = plan(area_on(SHEET, None), BOUNDS, 1, COVER, 0.12)
    for layout in layouts:
        assert len(layout.lanes[0]) == 14
        assert layout.lengths == pytest.approx([14 * 0.925 + 0.925], abs=1e-6)
    starts = {tuple(np.round(layout.lanes[0][0, 0]).astype(int)) for layout in layouts}
    assert starts == {(0, 0), (0, 1), (1, 0), (1, 1)}


@pytest.mark.parametrize(("count", "most"), [(2, 1.05), (4, 1.05), (6, 1.05), (9, 1.15), (12, 1.15), (20, 1.15)])
def test_the_slowest_needs_hardly_longer_than_the_bound(count, most):
    """No plan sweeps faster than A / (n d) of way each; robots in step keep their distance all along."""
    layout = plan(area_on(SHEET, None), BOUNDS, count, COVER, 0.12)[0]
    assert layout.lengths.max() < most / (count * COVER)
    assert closest(layout.lanes) > 0.12


def test_lanes_lie_no_farther_apart_than_the_disc_is_wide():
    (lanes,) = plan(area_on(SHEET, None), BOUNDS, 1, 0.1, 0.12)[0].lanes
    across = 1 if abs(lanes[0, 0, 1] - lanes[0, 1, 1]) < 1e-9 else 0
    gaps = np.abs(np.diff(lanes[:, 0, across]))
    assert gaps == pytest.approx(np.full(9, 0.1))


def test_the_closest_approach_by_hand():
    """Two on parallel lanes 0.3 m apart in step; begun 0.4 m late the distance is the hypotenuse, then 0.3 at rest."""
    one = np.array([[[0.0, 0.0], [1.0, 0.0]]])
    other = one + np.array([0.0, 0.3])
    assert closest([one, other]) == pytest.approx(0.3)
    crossing = np.array([[[0.5, -0.5], [0.5, 0.5]]])
    assert closest([one, crossing]) == pytest.approx(0.0, abs=1e-6)
    assert closest([one, crossing], np.array([0.0, 0.4])) == pytest.approx(0.4 / math.sqrt(2), abs=0.01)
    assert way_lengths(np.concatenate([one, other[:, ::-1]])) == pytest.approx([0.0, 1.0, 1.3, 2.3])


@pytest.mark.parametrize(
    ("polygon", "words"),
    [
        ([(0.1, 0.1), (0.9, 0.9), (0.9, 0.1), (0.1, 0.9)], "crosses itself"),
        ([(0.1, 0.1), (0.5, 0.5), (0.9, 0.9)], "0 cm² on the sheet"),
        ([(1.1, 0.1), (1.5, 0.1), (1.5, 0.9)], "0 cm² on the sheet"),
        ([(100.0, 100.0), (900.0, 100.0), (900.0, 900.0)], "metres"),
        ([(0.1, 0.1), (0.9, 0.1)], "three or more corners"),
        ([(0.1, 0.1), (0.9, math.nan), (0.5, 0.5)], "finite"),
        ([(0.1, 0.1, 0.0), (0.9, 0.1, 0.0), (0.5, 0.5, 0.0)], "two finite numbers"),
    ],
)
def test_an_area_that_is_none_is_refused(polygon, words):
    with pytest.raises(ConfigError, match=words):
        area_on(SHEET, polygon)


def test_an_area_that_lies_partly_on_the_sheet_is_swept_there():
    assert area_on(SHEET, [(-1.0, 0.5), (2.0, 0.5), (2.0, 0.8), (-1.0, 0.8)]).bounds == pytest.approx((0, 0.5, 1, 0.8))


def test_an_area_in_the_margin_is_swept_from_the_bounds():
    layout = plan(area_on(SHEET, [(0.0, 0.2), (0.02, 0.2), (0.02, 0.8), (0.0, 0.8)]), BOUNDS, 2, COVER, 0.12)[0]
    for lanes in layout.lanes:
        assert lanes[..., 0] == pytest.approx(np.full(lanes.shape[:2], 0.0375))
