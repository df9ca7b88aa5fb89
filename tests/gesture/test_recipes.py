"""Recipes, by numbers worked out by hand."""

import numpy as np
import pytest

from armspan.errors import ModelError
from armspan.gesture.recipes import Report, Standard


def test_standard_shares_a_scale_within_a_sensor_and_keeps_levels() -> None:
    takes = np.zeros((2, 3, 2))
    takes[:, 0] = [[1, 3], [5, 7]]  # mean 4, variance 5
    takes[:, 1] = [[10, 10], [16, 16]]  # mean 13, variance 9
    takes[:, 2] = [[-2, 2], [-2, 2]]  # mean 0, variance 4; a sensor of its own
    out = Standard(groups=(0, 0, 7)).fit(takes).transform(takes)
    np.testing.assert_allclose(out[:, 0], (takes[:, 0] - 4) / np.sqrt(7))
    np.testing.assert_allclose(out[:, 1], (takes[:, 1] - 13) / np.sqrt(7))
    np.testing.assert_allclose(out[:, 2], takes[:, 2] / 2)
    assert out[1, 1].mean() - out[0, 1].mean() == pytest.approx(6 / np.sqrt(7))


def test_standard_uses_training_numbers_for_new_takes() -> None:
    rng = np.random.default_rng(0)
    recipe = Standard().fit(rng.normal(3, 2, (200, 1, 50)))
    assert recipe.transform(np.full((1, 1, 2), 5.0)) == pytest.approx(1.0, abs=0.05)


def test_standard_leaves_a_still_sensor_at_zero() -> None:
    takes = np.full((3, 2, 5), 9.81)
    assert np.all(np.abs(Standard(groups=(0, 0)).fit(takes).transform(takes)) < 1e-9)


def test_report_stretches_each_take_then_differs() -> None:
    takes = np.array([[[0.0, 5, 10], [7, 7, 7]], [[4.0, 2, 3], [-1, 0, -3]]])
    out = Report(groups=(0, 0)).fit(takes).transform(takes)
    np.testing.assert_allclose(out, [[[1, 1], [0, 0]], [[-2, 1], [2 / 3, -2]]])


@pytest.mark.parametrize("recipe", [Standard(groups=(0, 0, 1)), Standard(), Report(groups=(0, 0, 1)), Report()])
def test_state_round_trip(recipe: Standard | Report) -> None:
    takes = np.random.default_rng(1).normal(5, 3, (4, 3, 10))
    recipe.fit(takes)
    state = recipe.state()
    assert all(isinstance(value, np.ndarray | list | int) for value in state.values())
    copy = type(recipe).from_state(state)
    np.testing.assert_array_equal(copy.transform(takes), recipe.transform(takes))
    assert copy.groups == recipe.groups


@pytest.mark.parametrize("kind", [Standard, Report])
def test_refuses_other_channels(kind: type[Standard] | type[Report]) -> None:
    takes = np.zeros((2, 3, 5))
    with pytest.raises(ModelError, match="3 channels, but the recipe's groups name 2"):
        kind(groups=(0, 0)).fit(takes)
    with pytest.raises(ModelError, match="2 channels, but the recipe was fitted on 3"):
        kind().fit(takes).transform(takes[:, :2])
    with pytest.raises(ModelError, match="expected"):
        kind().fit(takes[0])
