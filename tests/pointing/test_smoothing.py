import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armspan.pointing.smoothing import SmoothRotation, rotation_vector, turn_by


def test_rotation_vectors_agree_with_scipy():
    rng = np.random.default_rng(1)
    for vector in rng.normal(0, 1, (50, 3)):
        matrix = Rotation.from_rotvec(vector).as_matrix()
        assert turn_by(vector) == pytest.approx(matrix, abs=1e-12)
        assert rotation_vector(matrix) == pytest.approx(Rotation.from_matrix(matrix).as_rotvec(), abs=1e-9)
    assert rotation_vector(np.eye(3)) == pytest.approx([0, 0, 0])


def test_jitter_at_rest_falls_below_a_half():
    rng = np.random.default_rng(2)
    smooth = SmoothRotation()
    angles = [
        np.degrees(rotation_vector(smooth(k / 20, Rotation.from_rotvec(np.radians(rng.normal(0, 0.4, 3))).as_matrix())))
        for k in range(400)
    ]
    # A first-order filter of 1 Hz at 20 Hz leaves sqrt(a / (2 - a)) = 0.37 of white noise, a = 0.24; beta adds.
    assert np.std(angles[40:], axis=0).max() < 0.4 * 0.45


def test_a_fast_turn_is_followed_with_little_lag_across_any_angle():
    smooth = SmoothRotation()
    rate = np.radians(120)
    for k in range(80):  # nearly ten full turns: nothing wraps
        t = k / 20
        seen = smooth(t, Rotation.from_rotvec([0, 0, rate * t]).as_matrix())
    lag = rotation_vector(seen.T @ Rotation.from_rotvec([0, 0, rate * t]).as_matrix())[2] / rate
    assert 0 < lag < 0.06


def test_a_gap_starts_anew():
    smooth = SmoothRotation()
    smooth(0.0, np.eye(3))
    there = Rotation.from_rotvec([0, 0, 1.0]).as_matrix()
    assert smooth(2.0, there) == pytest.approx(there)
