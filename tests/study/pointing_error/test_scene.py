import numpy as np
from numpy.testing import assert_allclose

from armspan.study.pointing_error.scene import (
    about,
    attitudes,
    floor_workplace,
    front_sector,
    ideal_circle,
    published_circle,
    table_workplace,
)


def circle_of(points):
    """Centre (2,) and radius of the circle through points, by linear least squares (Kasa)."""
    x, y = points[:, 0], points[:, 1]
    a, b, c = np.linalg.lstsq(np.column_stack([x, y, np.ones_like(x)]), x**2 + y**2, rcond=None)[0]
    return np.array([a, b]) / 2, float(np.sqrt(c + (a**2 + b**2) / 4))


def test_the_published_circle_is_that_of_the_figures():
    points = published_circle().points()
    centre, radius = circle_of(points)
    assert_allclose(centre, [0.0, -0.540], atol=1e-12)
    assert abs(radius - 1.0875) < 1e-12
    assert_allclose(points[:, 2], 0.0, atol=1e-12)
    azimuths = np.arctan2(points[:, 1] + 0.540, points[:, 0])
    assert len(points) == 30
    assert_allclose(np.diff(np.unwrap(azimuths)), 2 * np.pi / 29, atol=1e-9)
    assert_allclose(points[0], points[-1], atol=1e-12)  # -180 and 180 degrees are one place


def test_the_published_circle_needs_a_plausible_shoulder():
    forward, left, up = published_circle().body.shoulder_to_eye_m
    assert forward == 0.0
    assert abs(left - 0.2594) < 1e-4
    assert abs(up - 0.2561) < 1e-4


def test_the_ideal_circle_by_hand():
    """The ray falls 0.25 + 0.70 sin 45° on its way to the fingertip, and 1.65 m to the floor."""
    stretch = 1.65 / (0.25 + 0.70 * np.sqrt(0.5))
    centre, radius = circle_of(ideal_circle().points())
    assert abs(radius - stretch * 0.70 * np.sqrt(0.5)) < 1e-12
    assert_allclose(centre, [0.0, 0.03 - 0.20 * stretch], atol=1e-12)


def test_attitudes_are_rotations_with_x_along_the_arm():
    rotations = attitudes(np.array([0.0, 0.7, -2.0]), np.array([0.0, -0.5, 0.3]))
    assert_allclose(rotations @ rotations.swapaxes(1, 2), np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-12)
    assert_allclose(np.linalg.det(rotations), 1.0)
    assert_allclose(rotations[0], np.eye(3), atol=1e-15)
    assert_allclose(rotations[1, :, 0], [np.cos(0.5) * np.cos(0.7), np.cos(0.5) * np.sin(0.7), -np.sin(0.5)])
    assert_allclose(rotations[:, 2, 1], 0.0)  # y stays level


def test_a_turn_about_an_axis():
    assert_allclose(about(np.array([0.0, 0.0, 1.0]), np.pi / 2) @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15)
    many = about(np.eye(3), np.pi / 2)
    assert_allclose(many[0] @ [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], atol=1e-15)
    assert_allclose(many[1] @ [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], atol=1e-15)


def test_the_front_sector_has_thirty_rays_of_the_arm():
    scene = front_sector()
    along = scene.user_from_forearm[:, :, 0]
    assert along.shape == (30, 3)
    azimuths = np.degrees(np.arctan2(along[:, 1], along[:, 0]))
    downs = -np.degrees(np.arcsin(along[:, 2]))
    assert_allclose([azimuths.min(), azimuths.max(), downs.min(), downs.max()], [-60, 60, 35, 65])


def test_workplaces_are_squares_in_front_of_the_eye():
    work = table_workplace()
    assert_allclose(work.corners().mean(axis=0), [1.0, 0.0, 0.75], atol=1e-12)
    assert_allclose(np.abs(work.corners() - [1.0, 0.0, 0.75])[:, :2], 0.2)
    assert len(np.unique(work.corners(), axis=0)) == 4
    assert work.grid(5).shape == (25, 3)
    assert_allclose(work.grid().mean(axis=0), [1.0, 0.0, 0.75], atol=1e-12)
    assert_allclose(work.grid().min(axis=0), [0.8, -0.2, 0.75])
    assert work.origin() == (0.8, 0.2)
    assert_allclose(floor_workplace().grid().max(axis=0), [2.0, 0.5, 0.0])
