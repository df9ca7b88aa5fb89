import numpy as np
import pytest

from armspan.frames import sheet_from_user
from armspan.pointing.place import Place
from armspan.records import Calibrated

TRUE_XYZ, TRUE_YAW = (0.45, 0.85, 0.75), 1.6
EYE = np.array([0.0, 0.0, 1.6])


def calibration(yaw: float = TRUE_YAW, xyz=TRUE_XYZ) -> Calibrated:
    covariance = np.diag([0.01**2, 0.01**2, 0.01**2, np.radians(1.0) ** 2])
    return Calibrated(0.0, "wrist", xyz, yaw, tuple(covariance.ravel()), 0.01, np.radians(1.0), 4)


def ray_to(point, yaw: float = TRUE_YAW):
    user_from_sheet = sheet_from_user(TRUE_XYZ, yaw).inverse()
    way = user_from_sheet.points(point) - EYE
    return EYE, way / np.linalg.norm(way)


POINTS = [(0.2, 0.1, -0.045), (0.7, 0.2, -0.045), (0.3, 0.5, -0.045), (0.6, 0.4, -0.045)]


def test_perfect_rays_leave_a_perfect_place_where_it_is():
    place = Place.from_calibration(calibration())
    for k, point in enumerate(POINTS):
        place.advance(10.0 * k)
        assert place.confirm(*ray_to(point), np.array(point))
    assert place.state[:4] == pytest.approx([*TRUE_XYZ, TRUE_YAW], abs=1e-9)


def test_selections_follow_a_drifting_heading():
    """A drift of 2 deg/min for three minutes, one confirmed selection every ten seconds."""
    followed, left_alone = Place.from_calibration(calibration()), Place.from_calibration(calibration())
    rate = np.radians(2.0) / 60
    for k in range(1, 19):
        t, point = 10.0 * k, POINTS[k % 4]
        for place in (followed, left_alone):
            place.advance(t)
        followed.confirm(*ray_to(point, TRUE_YAW + rate * t), np.array(point))
    truth = TRUE_YAW + rate * 180
    assert abs(np.degrees(followed.state[3] - truth)) < 0.5  # a robot is only as sure as one degree of noise
    assert abs(np.degrees(left_alone.state[3] - truth)) == pytest.approx(6.0, abs=0.01)
    assert np.degrees(followed.state[4]) * 60 == pytest.approx(2.0, abs=0.4)


def test_a_selection_that_cannot_be_meant_teaches_nothing():
    place = Place.from_calibration(calibration())
    before = place.state.copy()
    assert not place.confirm(*ray_to(POINTS[0]), np.array(POINTS[1]))
    assert place.state == pytest.approx(before)


def test_uncertainty_grows_with_time_and_shrinks_with_selections():
    place = Place.from_calibration(calibration())
    place.advance(60.0)
    grown = np.sqrt(place.covariance[3, 3])
    assert np.degrees(grown) == pytest.approx(np.hypot(1.0, 2.0), abs=1e-6)
    place.confirm(*ray_to(POINTS[0]), np.array(POINTS[0]))
    assert place.covariance[3, 3] < grown**2
    assert np.linalg.eigvalsh(place.covariance).min() > -1e-15


def test_the_slope_of_the_miss_is_its_derivative():
    place = Place.from_calibration(calibration(yaw=1.5, xyz=(0.4, 0.9, 0.7)))
    ray, point = ray_to(POINTS[2]), np.array(POINTS[2])
    _, slope = place._miss(*ray, point)
    for k in range(4):
        step = 1e-6
        ahead, behind = (Place.from_calibration(calibration(yaw=1.5, xyz=(0.4, 0.9, 0.7))) for _ in range(2))
        ahead.state[k] += step
        behind.state[k] -= step
        numeric = (ahead._miss(*ray, point)[0] - behind._miss(*ray, point)[0]) / (2 * step)
        assert slope[:, k] == pytest.approx(numeric, abs=0.03 * max(1.0, abs(numeric).max()))
