import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from armspan.errors import FrameError
from armspan.frames import (
    Transform,
    identity,
    plane_hit,
    polygon_middle,
    rotation_from_quaternion,
    sheet_from_user,
    yaw_rotation,
)

EXACT = settings(derandomize=True, database=None, deadline=None, max_examples=100)
METRES = st.floats(-10.0, 10.0)
POINTS = st.tuples(METRES, METRES, METRES).map(np.array)
ROTATIONS = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: math.hypot(*q) > 0.1).map(Rotation.from_quat)


def transforms(target, source):
    return st.builds(lambda r, p: Transform(target, source, r.as_matrix(), p), ROTATIONS, POINTS)


def matrix(transform):
    """The same motion as a 4 by 4 matrix."""
    rows = np.column_stack([transform.rotation, transform.translation])
    return np.vstack([rows, [0.0, 0.0, 0.0, 1.0]])


def assert_same(left, right):
    assert (left.target, left.source) == (right.target, right.source)
    np.testing.assert_allclose(matrix(left), matrix(right), atol=1e-12)


# --- products and inverses -------------------------------------------------------------------------------


@EXACT
@given(transforms("sheet", "user"), transforms("user", "earth"), POINTS)
def test_a_product_is_that_of_the_matrices(sheet_from_user_, user_from_earth, point_earth):
    product = sheet_from_user_ @ user_from_earth
    assert (product.target, product.source) == ("sheet", "earth")
    np.testing.assert_allclose(matrix(product), matrix(sheet_from_user_) @ matrix(user_from_earth), atol=1e-12)
    expected = (matrix(product) @ [*point_earth, 1.0])[:3]
    np.testing.assert_allclose(product.points(point_earth), expected, atol=1e-12)


@EXACT
@given(transforms("sheet", "user"))
def test_the_inverse_is_that_of_the_matrix_and_undoes_the_motion(transform):
    back = transform.inverse()
    np.testing.assert_allclose(matrix(back), np.linalg.inv(matrix(transform)), atol=1e-12)
    assert_same(back @ transform, identity("user", "user"))
    assert_same(transform @ back, identity("sheet", "sheet"))
    assert_same(back.inverse(), transform)


@EXACT
@given(transforms("sheet", "user"), transforms("user", "earth"), transforms("earth", "sensor"))
def test_products_associate_and_inverses_turn_them_round(a, b, c):
    assert_same((a @ b) @ c, a @ (b @ c))
    assert_same((a @ b).inverse(), b.inverse() @ a.inverse())


@EXACT
@given(transforms("sheet", "user"), POINTS, POINTS)
def test_directions_are_differences_of_points(transform, first, second):
    moved = transform.points(second) - transform.points(first)
    np.testing.assert_allclose(transform.directions(second - first), moved, atol=1e-12)


def test_points_of_any_leading_shape_move_as_one_by_one():
    transform = sheet_from_user((0.1, 0.2, 0.3), 0.7)
    points = np.arange(24.0).reshape(2, 4, 3)
    moved = transform.points(points)
    assert moved.shape == (2, 4, 3)
    np.testing.assert_allclose(moved[1, 2], transform.points(points[1, 2]), atol=1e-14)
    assert transform.directions(points.tolist()).shape == (2, 4, 3)


# --- what is refused, in which words ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("left", "right", "told"),
    [
        (
            ("sheet", "user"),
            ("earth", "user"),
            "sheet_from_user @ earth_from_user does not cancel: 'user' is not 'earth'."
            " earth_from_user is likely inverted: use its .inverse().",
        ),
        (
            ("user", "sheet"),
            ("user", "earth"),
            "user_from_sheet @ user_from_earth does not cancel: 'sheet' is not 'user'."
            " user_from_sheet is likely inverted: use its .inverse().",
        ),
        (
            ("user", "earth"),
            ("sheet", "user"),
            "user_from_earth @ sheet_from_user does not cancel: 'earth' is not 'sheet'."
            " The two are likely in the wrong order.",
        ),
        (
            ("sheet", "user"),
            ("earth", "sensor"),
            "sheet_from_user @ earth_from_sensor does not cancel: 'user' is not 'earth'."
            " A transform user_from_earth is missing between them.",
        ),
    ],
)
def test_inner_names_that_differ_are_told_with_the_way_out(left, right, told):
    with pytest.raises(FrameError) as error:
        identity(*left) @ identity(*right)
    assert str(error.value) == told


@pytest.mark.parametrize(
    ("left", "right", "mended"),
    [
        (("sheet", "user"), ("earth", "user"), lambda a, b: a @ b.inverse()),
        (("user", "sheet"), ("user", "earth"), lambda a, b: a.inverse() @ b),
        (("user", "earth"), ("sheet", "user"), lambda a, b: b @ a),
    ],
)
def test_the_way_out_works(left, right, mended):
    product = mended(identity(*left), identity(*right))
    assert (product.target, product.source) == ("sheet", "earth")


@pytest.mark.parametrize("bad", [1.0, [1.0, 2.0], [1.0, 2.0, 3.0, 4.0], np.zeros((3, 2)), []])
def test_vectors_that_are_not_three_numbers_are_refused(bad):
    transform = identity("sheet", "user")
    for move in (transform.points, transform.directions):
        with pytest.raises(FrameError, match=r"sheet_from_user moves vectors of 3 numbers.*not an array of shape"):
            move(bad)


# --- the user's place ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("yaw", "z_up", "point_sheet"),
    [
        # p = (1, 2, 3): Rz(90 deg) p = (-2, 1, 3); the flip makes it (-2, -1, -3); + (10, 20, 30)
        (math.pi / 2, False, (8.0, 19.0, 27.0)),
        (math.pi / 2, True, (8.0, 21.0, 33.0)),
        (0.0, False, (11.0, 18.0, 27.0)),
        (0.0, True, (11.0, 22.0, 33.0)),
        (math.pi, False, (9.0, 22.0, 27.0)),
        # Rz(-90 deg) p = (2, -1, 3)
        (-math.pi / 2, False, (12.0, 21.0, 27.0)),
    ],
)
def test_the_place_of_the_user_by_hand(yaw, z_up, point_sheet):
    transform = sheet_from_user((10.0, 20.0, 30.0), yaw, z_up=z_up)
    assert (transform.target, transform.source) == ("sheet", "user")
    np.testing.assert_allclose(transform.points((1.0, 2.0, 3.0)), point_sheet, atol=1e-12)


def test_a_user_at_the_near_edge_who_looks_along_the_sheet_points_where_it_is_printed():
    # The sheet is 0.7 m wide; y is printed downwards, so its bottom edge is y = 0.4. The user stands 0.5 m
    # before that edge, in the middle, and looks across the sheet: in the sheet's axes that is along -y.
    transform = sheet_from_user((0.35, 0.9, 0.75), math.pi / 2)
    np.testing.assert_allclose(transform.directions((1.0, 0.0, 0.0)), (0.0, -1.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(transform.directions((0.0, 0.0, 1.0)), (0.0, 0.0, -1.0), atol=1e-12)
    np.testing.assert_allclose(transform.points((0.7, 0.1, 0.75)), (0.25, 0.2, 0.0), atol=1e-12)


@EXACT
@given(st.floats(-10.0, 10.0), st.booleans())
def test_the_place_of_the_user_is_a_proper_rotation(yaw, z_up):
    rotation = sheet_from_user((0.0, 0.0, 0.0), yaw, z_up=z_up).rotation
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    np.testing.assert_allclose(yaw_rotation(yaw), Rotation.from_euler("z", yaw).as_matrix(), atol=1e-12)


# --- quaternions -----------------------------------------------------------------------------------------


def test_a_quarter_turn_about_z_takes_x_to_y():
    half = math.sqrt(0.5)
    np.testing.assert_allclose(
        rotation_from_quaternion((half, 0.0, 0.0, half)) @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15
    )


@EXACT
@given(st.lists(ROTATIONS, min_size=1, max_size=6))
def test_quaternions_turn_as_scipy_turns(rotations):
    expected = np.stack([rotation.as_matrix() for rotation in rotations])
    wxyz = np.stack([rotation.as_quat()[[3, 0, 1, 2]] for rotation in rotations])
    np.testing.assert_allclose(rotation_from_quaternion(wxyz), expected, atol=1e-12)
    np.testing.assert_allclose(rotation_from_quaternion(tuple(-wxyz[0])), expected[0], atol=1e-12)
    assert rotation_from_quaternion(wxyz[None, :, None]).shape == (1, len(rotations), 1, 3, 3)


# --- planes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("direction", "z", "hit"),
    [
        ((1.0, 0.0, -1.0), 0.0, (1.6, 0.0, 0.0)),
        ((2.0, 0.0, -2.0), 0.0, (1.6, 0.0, 0.0)),
        ((1.0, 0.5, -1.0), 0.8, (0.8, 0.4, 0.8)),
        ((0.0, 1.0, 2.0), 2.6, (0.0, 0.5, 2.6)),
        ((1.0, 0.0, 0.0), 0.0, None),  # parallel
        ((1.0, 0.0, 0.0), 1.6, None),  # in the plane
        ((1.0, 0.0, 1.0), 0.0, None),  # behind
        ((0.0, 0.0, 0.0), 0.0, None),  # no direction
        ((1.0, 0.0, -1e-320), 0.0, None),  # as good as parallel: the reach is not a number any more
    ],
)
def test_where_a_ray_from_the_eye_meets_a_plane_by_hand(direction, z, hit):
    found = plane_hit((0.0, 0.0, 1.6), direction, z)
    np.testing.assert_allclose(found, [math.nan] * 3 if hit is None else hit, atol=1e-12)


def test_many_rays_and_planes_at_once():
    origins = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]])
    hits = plane_hit(origins, (1.0, 0.0, -1.0), [[0.0], [0.5], [3.0]])
    assert hits.shape == (3, 2, 3)
    np.testing.assert_allclose(hits[:2, :, 0], [[1.0, 2.0], [0.5, 1.5]], atol=1e-12)
    assert np.isnan(hits[2]).all()


@EXACT
@given(POINTS, POINTS, METRES)
def test_a_hit_lies_in_the_plane_ahead_on_the_ray(origin, direction, z):
    hit = plane_hit(origin, direction, z)
    ahead = np.sign(z - origin[2]) * np.sign(direction[2]) > 0
    if not ahead:
        assert np.isnan(hit).all()
    elif abs(direction[2]) > 1e-3:
        assert hit[2] == pytest.approx(z, abs=1e-9)
        np.testing.assert_allclose(np.cross(hit - origin, direction), 0.0, atol=1e-6)
        assert (hit - origin) @ direction > 0 or abs(z - origin[2]) < 1e-9


def test_the_middle_of_a_polygon_is_that_of_its_area():
    """An L of two squares: middles (0.5, 0.5), (1.5, 0.5) and (0.5, 1.5), whichever way round it is listed."""
    shape = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    assert polygon_middle(shape) == pytest.approx((2.5 / 3, 2.5 / 3))
    assert polygon_middle(shape[::-1]) == pytest.approx((2.5 / 3, 2.5 / 3))
