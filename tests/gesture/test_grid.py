import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.gesture.grid import bridge, cells, on_grid, stretched


def test_a_cell_holds_the_mean_of_the_line_through_the_samples() -> None:
    times = np.arange(0, 4, 0.01)
    first, last = cells(32.0, 0.0, 3.99)
    values = on_grid(times, np.stack([times, np.full_like(times, 2.0)], axis=1), 32.0, first, last)
    middles = np.arange(first, last) / 32 - 1 / 64
    np.testing.assert_allclose(values[:, 0], middles, atol=1e-9)
    np.testing.assert_allclose(values[:, 1], 2.0)
    assert first == 1
    assert last == 128  # 3.99 s hold 127 whole cells


def test_averaging_keeps_what_is_faster_than_the_grid_from_aliasing() -> None:
    times = np.arange(0, 4, 0.001)
    hum = np.sin(2 * np.pi * 32.0 * times)[:, None]  # exactly the grid's rate: picked samples would show a constant
    first, last = cells(32.0, 0.0, times[-1])
    assert np.abs(on_grid(times, hum, 32.0, first, last)).max() < 1e-3


def test_a_gap_makes_the_cells_it_touches_nan_and_no_other() -> None:
    times = np.arange(0, 4, 0.01)
    kept = (times < 1.005) | (times > 1.955)
    values = on_grid(times[kept], times[kept, None], 10.0, 1, 40)
    assert np.flatnonzero(np.isnan(values[:, 0])).tolist() == list(range(10, 20))  # cells that end at 1.1 .. 2.0 s
    bridged = on_grid(times[kept], times[kept, None], 10.0, 1, 40, longest=1.0)
    np.testing.assert_allclose(bridged[:, 0], np.arange(1, 40) / 10 - 0.05, atol=1e-9)


def test_outside_the_samples_there_is_nothing() -> None:
    times = np.arange(0.25, 1.0, 0.01)
    values = on_grid(times, times[:, None], 10.0, 1, 12)
    assert np.isnan(values[:3]).all()
    assert np.isnan(values[-2:]).all()
    assert np.isfinite(values[3:9]).all()


@given(st.integers(1, 30), st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_cells_do_not_depend_on_how_the_samples_are_cut(at: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.005, 0.02, 400))
    values = rng.standard_normal((400, 2)).cumsum(axis=0)
    first, last = cells(16.0, times[0], times[-1])
    whole = on_grid(times, values, 16.0, first, last)
    middle = min(first + at, last - 1)
    after = max(0, int(np.searchsorted(times, (middle - 1) / 16.0, side="right")) - 1)
    parts = [on_grid(times, values, 16.0, first, middle), on_grid(times[after:], values[after:], 16.0, middle, last)]
    np.testing.assert_allclose(np.concatenate(parts), whole, atol=1e-9)


def test_short_gaps_are_bridged_column_by_column_and_long_ones_stay() -> None:
    times = np.arange(100) / 50
    values = np.stack([times, times], axis=1)
    values[10:20, 0] = np.nan
    values[50:90, 1] = np.nan
    filled = bridge(times, values)
    np.testing.assert_allclose(filled[:, 0], times)
    assert np.isnan(filled[50:90, 1]).all()


def test_stretching_leaves_what_already_fits_as_it_is() -> None:
    times = np.arange(64) / 20
    values = np.random.default_rng(0).standard_normal((64, 3))
    np.testing.assert_allclose(stretched(times, values, 64), values, atol=1e-12)
    assert stretched(times, values, 16).shape == (16, 3)
    line = np.linspace(0, 1, 1000)[:, None]
    np.testing.assert_allclose(stretched(np.linspace(5, 9, 1000), line, 10)[:, 0], np.arange(10) / 10 + 0.05, atol=1e-9)
    assert stretched(times, values, 200).shape == (200, 3)


def test_no_cell_fits_into_too_short_a_time() -> None:
    assert cells(32.0, 1.0, 1.01)[1] - cells(32.0, 1.0, 1.01)[0] == 0
    assert on_grid(np.array([1.0]), np.ones((1, 2)), 32.0, 3, 5).shape == (2, 2)
    assert cells(10.0, 0.1, 0.3) == (2, 4) != pytest.approx(0)
