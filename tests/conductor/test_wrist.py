import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armspan.conductor.arm import Band
from armspan.conductor.settings import BandSettings
from armspan.conductor.wrist import wrist_row
from armspan.orientation import Mount
from armspan.records import ImuSample


def a_band(mount: Mount | None, quat: np.ndarray, acc: tuple[float, ...], gyr: tuple[float, ...]) -> tuple:
    band, sample = Band.from_settings(BandSettings("b")), ImuSample(1.0, "b", acc, gyr, None, tuple(quat.tolist()))
    band.mount = mount
    band.feel(sample)
    return band, sample


@pytest.mark.parametrize("seed", range(5))
def test_a_row_is_what_the_matrices_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wrist_from_sensor = Rotation.random(random_state=seed).as_matrix()
    earth_from_sensor = Rotation.random(random_state=seed + 100)
    heading = float(rng.uniform(-3, 3))
    acc, gyr = rng.standard_normal((2, 3)) * 5
    mount = Mount(wrist_from_sensor, heading)
    row = wrist_row(*a_band(mount, earth_from_sensor.as_quat(scalar_first=True), tuple(acc), tuple(gyr)))
    user_from_sensor = Rotation.from_euler("z", -heading).as_matrix() @ earth_from_sensor.as_matrix()
    np.testing.assert_allclose(
        Rotation.from_quat(row[:4]).as_matrix(), user_from_sensor @ wrist_from_sensor.T, atol=1e-12
    )
    np.testing.assert_allclose(row[4:7], user_from_sensor @ acc - [0, 0, 9.80665], atol=1e-12)
    np.testing.assert_allclose(row[7:], user_from_sensor @ gyr, atol=1e-12)
    assert row[3] >= 0


def test_a_resting_band_has_no_linear_acceleration() -> None:
    mount = Mount(np.eye(3), 0.0)
    row = wrist_row(*a_band(mount, np.array([1.0, 0, 0, 0]), (0.0, 0.0, 9.80665), (0.0, 0.0, 0.0)))
    assert row == (0, 0, 0, 1, 0, 0, 0, 0, 0, 0)


def test_before_the_set_up_there_is_no_row() -> None:
    assert wrist_row(*a_band(None, np.array([1.0, 0, 0, 0]), (0.0, 0.0, 9.8), (0.0, 0.0, 0.0))) is None
