import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armspan.gesture.channels import Channels, prefix_of, same_columns, sensor_of

BAND = tuple(f"right_{name}" for name in ("qx", "qy", "qz", "qw", "ax", "ay", "az", "gx", "gy", "gz"))


def test_a_band_with_attitude_is_seen_in_its_own_wrist() -> None:
    turn = Rotation.from_euler("ZYX", [40, -30, 20], degrees=True)
    acc, rate = np.array([1.0, 2.0, 3.0]), np.array([-1.0, 0.5, 0.2])
    row = np.concatenate([turn.as_quat(), turn.apply(acc), turn.apply(rate)])[None]
    seen = Channels(BAND)(row)[0]
    np.testing.assert_allclose(seen[:3], turn.inv().apply([0, 0, 1]), atol=1e-12)
    np.testing.assert_allclose(seen[3:6], acc, atol=1e-12)
    np.testing.assert_allclose(seen[6:9], rate, atol=1e-12)


@pytest.mark.parametrize("heading", [30.0, -120.0])
def test_turning_about_the_vertical_changes_nothing(heading: float) -> None:
    rng = np.random.default_rng(3)
    turns, spin = Rotation.random(20, random_state=1), Rotation.from_euler("z", heading, degrees=True)
    acc, rate = rng.standard_normal((2, 20, 3))
    before = np.concatenate([turns.as_quat(), acc, rate], axis=1)
    after = np.concatenate([(spin * turns).as_quat(), spin.apply(acc), spin.apply(rate)], axis=1)
    np.testing.assert_allclose(Channels(BAND)(after), Channels(BAND)(before), atol=1e-12)


def test_other_columns_stay_as_they_are_and_bands_are_told_apart() -> None:
    columns = ("left_ax", "wrist_ay", "left_ay", "left_az", "wrist_b")
    channels = Channels(columns)
    assert [band.prefix for band in channels.bands] == ["left", "wrist"]
    values = np.arange(10.0).reshape(2, 5)
    np.testing.assert_array_equal(channels(values), values[:, [0, 2, 3, 1, 4]])
    left, ay, b = channels.groups[0], channels.groups[3], channels.groups[4]
    assert channels.groups == (left, left, left, ay, b)
    assert len({left, ay, b}) == 3


def test_sensors_of_a_band_have_a_group_each() -> None:
    groups = Channels(BAND).groups
    assert len(groups) == 9
    assert [len(set(groups[k : k + 3])) for k in (0, 3, 6)] == [1, 1, 1]
    assert len(set(groups)) == 3


def test_names_are_taken_apart() -> None:
    assert prefix_of("right_qx") == "right"
    assert prefix_of("c12") == "c12"
    assert sensor_of("right_gz") == "right_g"
    assert sensor_of("dim_7") == "dim_7"
    assert same_columns(("a", "b"), ("b", "c")) == ["a"]
