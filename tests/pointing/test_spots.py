from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.frames import Transform, sheet_from_user
from armspan.pointing.pairs import Area
from armspan.pointing.spots import spot

EYE = np.array([0.0, 0.0, 1.5])
SHARP = np.diag([1e-12, 1e-12, 1e-12, 1e-12])


@dataclass(frozen=True)
class Known:
    """A place told by its numbers: the sheet's origin below the eye, its x ahead, 0.75 m above the floor."""

    xyz: np.ndarray
    yaw: float
    covariance: np.ndarray
    sigma: float

    def transform(self) -> Transform:
        return sheet_from_user(self.xyz, self.yaw)


def known(covariance=SHARP, sigma_deg=1e-4, yaw=0.0):
    return Known(np.array([0.0, 0.0, 0.75]), yaw, np.asarray(covariance), np.radians(sigma_deg))


def down(degrees, azimuth_deg=0.0):
    a, e = np.radians(azimuth_deg), np.radians(-degrees)
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def test_a_ray_45_degrees_down_lands_as_far_ahead_as_the_eye_is_high():
    found = spot(known(), EYE, down(45.0), 0.0)
    assert_allclose(found.xy, [0.75, 0.0], atol=1e-9)
    assert_allclose(spot(known(), EYE, down(45.0), -0.05).xy, [0.70, 0.0], atol=1e-9)  # above the sheet: z is down
    assert_allclose(spot(known(), EYE, down(45.0, 90.0), 0.0).xy, [0.0, -0.75], atol=1e-9)  # the user's left is up
    assert found.refused is None


def test_pointing_noise_is_longer_along_the_ray_than_across():
    """Small angles at 30 degrees down: h / sin(e) across and h / sin(e)^2 along."""
    sigma = np.radians(0.2)
    covariance = spot(known(sigma_deg=0.2), EYE, down(30.0), 0.0).covariance
    assert_allclose(np.sqrt(np.diagonal(covariance)), [sigma * 0.75 / 0.25, sigma * 0.75 / 0.5], rtol=0.01)
    assert abs(covariance[0, 1]) < 1e-9


def test_the_calibrations_doubt_moves_the_spot_as_it_moves_the_sheet():
    shift = spot(known(np.diag([4e-6, 1e-6, 1e-12, 1e-12])), EYE, down(40.0), 0.0).covariance
    assert_allclose(shift, np.diag([4e-6, 1e-6]), rtol=0.02, atol=1e-9)
    height = spot(known(np.diag([1e-12, 1e-12, 1e-6, 1e-12])), EYE, down(45.0), 0.0).covariance
    assert_allclose(height, [[1e-6, 0], [0, 0]], rtol=0.02, atol=1e-9)
    turn = spot(known(np.diag([1e-12, 1e-12, 1e-12, 1e-6])), EYE, down(45.0), 0.0).covariance
    assert_allclose(turn, [[0, 0], [0, 0.75**2 * 1e-6]], rtol=0.02, atol=1e-9)


@pytest.mark.parametrize("degrees", [60.0, 25.0, 12.0])
def test_the_covariance_is_the_second_moment_of_random_rays(degrees):
    rng = np.random.default_rng(0)
    cov = np.diag([0.02, 0.02, 0.01, 0.02]) ** 2
    place, centre = known(cov, sigma_deg=1.0, yaw=0.4), down(degrees, 20.0)
    spots = []
    for x, y, z, yaw in rng.multivariate_normal([0, 0, 0.75, 0.4], cov, 4000):
        ray = centre + np.radians(1.0) * rng.normal(size=3)
        transform = sheet_from_user((x, y, z), yaw)
        o, d = transform.points(EYE), transform.directions(ray / np.linalg.norm(ray))
        spots.append((o - o[2] / d[2] * d)[:2])
    found = spot(place, EYE, centre, 0.0)
    off = np.array(spots) - found.xy
    assert_allclose(found.covariance, off.T @ off / len(off), rtol=0.15, atol=0.1 * np.trace(found.covariance))


def test_no_answer_behind_or_near_the_horizon():
    assert "points 20.0 degrees away from the plane" in spot(known(), EYE, down(-20.0), 0.0).refused
    near = spot(known(), EYE, down(3.0), 0.0)
    assert near.xy is None
    assert near.covariance is None
    assert "3.0 degrees from the horizon of the plane, and 5 are needed" in near.refused
    assert spot(known(), EYE, np.array([1.0, 0.0, 0.0]), 0.0).xy is None
    assert spot(known(), EYE, down(6.0), 0.0).xy is not None


def test_an_answer_straight_down_has_a_round_ellipse():
    found = spot(known(sigma_deg=0.5), EYE, np.array([0.0, 0.0, -1.0]), 0.0)
    assert_allclose(found.xy, [0, 0], atol=1e-12)
    assert_allclose(found.covariance, np.eye(2) * (0.75 * np.radians(0.5)) ** 2, rtol=0.01, atol=1e-9)


def test_the_area_draws_an_unsure_spot_more_than_a_sure_one():
    area = Area(np.array([0.8, 0.0, 0.0]), np.diag([0.04, 0.04]))
    ray, plain = down(20.0), 0.75 / np.tan(np.radians(20.0))
    sure = spot(known(sigma_deg=0.1), EYE, ray, 0.0, area=area)
    unsure = spot(known(sigma_deg=4.0), EYE, ray, 0.0, area=area)
    assert_allclose(sure.xy, [plain, 0.0], atol=0.01)
    assert 0.8 < unsure.xy[0] < plain - 0.3
    assert np.trace(unsure.covariance) < np.trace(spot(known(sigma_deg=4.0), EYE, ray, 0.0).covariance)


def test_with_an_area_the_spot_is_the_mean_of_ray_times_prior():
    """Against a Monte Carlo that weighs random rays by the t density at their spots."""
    rng = np.random.default_rng(1)
    area = Area(np.array([1.2, 0.1, 0.0]), np.diag([0.09, 0.04]))
    centre, sigma = down(25.0, 5.0), np.radians(2.5)
    rays = centre + sigma * rng.normal(size=(40000, 3))
    spots = (0.75 / -rays[:, 2:] * rays[:, :2]) * [1.0, -1.0]
    off = spots - area.centre[:2]
    weights = (1 + (off**2 / np.diagonal(area.scatter)).sum(axis=1) / 4) ** -3.0
    found = spot(known(sigma_deg=2.5), EYE, centre, 0.0, area=area)
    assert_allclose(found.xy, np.average(spots, axis=0, weights=weights), atol=0.02)


def test_the_area_of_another_plane_tells_nothing():
    area = Area(np.array([0.8, 0.0, 0.5]), np.diag([0.01, 0.01]))
    ray = down(20.0)
    assert_allclose(spot(known(), EYE, ray, 0.0, area=area).xy, spot(known(), EYE, ray, 0.0).xy)


@pytest.mark.parametrize("z_up", [False, True])
def test_the_covariance_of_the_place_reaches_the_spot_with_its_correlations(z_up):
    """Against places drawn from the covariance itself: x, y, z and yaw all correlated, in both kinds of frame."""
    rng = np.random.default_rng(0)
    shape = rng.normal(size=(4, 4)) * [0.004, 0.004, 0.004, 0.008]
    place, ray = np.array([0.45, 0.8, -0.75 if z_up else 0.75, 1.5]), down(50.0, 10.0)

    @dataclass
    class Drawn:
        xyz: np.ndarray
        yaw: float
        covariance: np.ndarray
        sigma: float = 1e-7

        def transform(self) -> Transform:
            return sheet_from_user(self.xyz, self.yaw, z_up=z_up)

    def at(values):
        return spot(Drawn(values[:3], float(values[3]), shape.T @ shape), EYE, ray, 0.0)

    drawn = np.array([at(place + shape.T @ rng.normal(size=4)).xy for _ in range(4000)])
    expected = np.cov(drawn.T)
    assert_allclose(at(place).covariance, expected, rtol=0.12, atol=0.06 * np.trace(expected))
