"""The scale of a picture from the height of the person in it."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from armspan.body.anthropometry import prior
from armspan.body.scale import HeightScale, Scale, View
from armspan.body.skeleton import Skeleton
from armspan.body.told import Told
from armspan.errors import DataError
from filmed_person import FOCAL, SIZE, Person, film

Pixels = dict[str, tuple[float, float, float]]
MAN = prior(Told(height_m=1.75, sex="man"))
FAR = {"distance": 50.0}  # nearly no perspective: what is left is the scale's own doing


def skeleton(pixels: Pixels, *without: str, size: tuple[int, int] | None = None) -> Skeleton:
    return Skeleton({name: point for name, point in pixels.items() if name not in without}, size, "test")


def placed(scale: Scale, pixels: Pixels, name: str) -> tuple[float, float]:
    right, up = scale.place(np.array([pixels[name][:2]]))[0]
    return float(right), float(up)


@pytest.mark.parametrize(
    ("without", "top", "foot"),
    [
        ((), "crown", "heels"),
        (("crown",), "eyes", "heels"),
        (("crown", "lheel", "rheel"), "eyes", "ankles"),
        (("lheel", "rheel"), "crown", "ankles"),
        (("crown", "rheel", "reye"), "eyes", "heels"),
    ],
)
def test_lengths_come_out_from_whatever_ends_of_the_body_are_known(
    without: tuple[str, ...], top: str, foot: str
) -> None:
    pixels = film(Person().t_pose(), **FAR)
    scale = HeightScale.of(skeleton(pixels, *without), MAN)
    assert scale.notes[0].startswith(f"scale: {top} ")
    assert f" and {foot} " in scale.notes[0]
    assert scale.from_eyes == (top == "eyes")
    assert_allclose(placed(scale, pixels, "rsh")[1], 0.820 * 1.75 - 0.025, atol=0.004)
    assert_allclose(placed(scale, pixels, "leye")[1], 1.636, atol=0.004)
    across = placed(scale, pixels, "lwr")[0] - placed(scale, pixels, "rwr")[0]
    assert_allclose(across, 0.36 + 2 * (0.300 + 0.262), rtol=0.004)


def test_heights_stand_on_the_floor_under_the_shoes() -> None:
    tall_shoes = Person(sole=0.04)
    pixels = film(tall_shoes.t_pose(), **FAR)
    told = prior(Told(height_m=1.75, sex="man", sole_m=0.04))
    for without in ((), ("crown",), ("crown", "lheel", "rheel")):
        scale = HeightScale.of(skeleton(pixels, *without), told)
        assert_allclose(placed(scale, pixels, "reye")[1], 1.676, atol=0.004)
        assert_allclose(placed(scale, pixels, "lan")[1], 0.138, atol=0.004)


@settings(derandomize=True, max_examples=60, deadline=None)
@given(st.floats(-180.0, 180.0), st.sampled_from([("front", "t_pose"), ("right", "pointing")]))
def test_a_tilted_picture_measures_like_a_level_one(roll: float, pose: tuple[str, str]) -> None:
    seen_from, taken = pose
    view: View = "front" if seen_from == "front" else "side"
    points = getattr(Person(), taken)()
    level, tilted = film(points, seen_from, **FAR), film(points, seen_from, roll=roll, **FAR)
    before = HeightScale.of(skeleton(level), MAN, view)
    after = HeightScale.of(skeleton(tilted), MAN, view)
    # from the side a tilt of up to about 5 degrees is taken for the person's own lean: 0.09 of a length
    near = 0.003 if view == "front" else 0.15
    for name in ("rsh", "reye", "rwr"):
        assert_allclose(placed(after, tilted, name), placed(before, level, name), atol=near)
    if abs(abs(roll) - 1.0) > 0.01:
        assert ("tilted by" in after.notes[0]) == (after.up[1] > -np.cos(np.radians(1.0)))


@settings(derandomize=True, max_examples=60, deadline=None)
@given(st.floats(8.0, 180.0), st.sampled_from([-1.0, 1.0]), st.sampled_from(["left", "right"]))
def test_a_side_picture_tilted_plainly_is_set_upright(roll: float, sense: float, seen_from: str) -> None:
    points = Person().pointing(seen_from)
    level, tilted = film(points, seen_from, **FAR), film(points, seen_from, roll=sense * roll, **FAR)
    before = HeightScale.of(skeleton(level), MAN, "side")
    after = HeightScale.of(skeleton(tilted), MAN, "side")
    for name in ("rsh", "reye", "rwr"):
        assert_allclose(placed(after, tilted, name), placed(before, level, name), atol=0.012)


@settings(derandomize=True, max_examples=60, deadline=None)
@given(st.floats(0.05, 20.0), st.floats(-5000.0, 5000.0), st.floats(-5000.0, 5000.0))
def test_neither_zoom_nor_where_in_the_picture_matters(zoom: float, x: float, y: float) -> None:
    pixels = film(Person().t_pose())
    moved = {name: (zoom * p[0] + x, zoom * p[1] + y, p[2]) for name, p in pixels.items()}
    one, other = HeightScale.of(skeleton(pixels), MAN), HeightScale.of(skeleton(moved), MAN)
    for name in pixels:
        assert_allclose(placed(other, moved, name), placed(one, pixels, name), atol=1e-6)


def test_a_person_standing_on_a_pixel_of_known_size() -> None:
    """Worked out by hand: crown 1000 px above the heels, 1.715 m apart, so 1.715 mm a pixel."""
    points = {"crown": (500.0, 100.0, 1.0), "lheel": (500.0, 1100.0, 1.0), "lsh": (450.0, 300.0, 1.0)}
    scale = HeightScale.of(Skeleton(points | {"rsh": (550.0, 300.0, 1.0)}, None, "test"), MAN)
    assert_allclose(scale.pixel, 0.001715, rtol=1e-4)
    assert_allclose(
        scale.place(np.array([[700.0, 600.0], [500.0, 1100.0]])), [[0.343, 0.8925], [0.0, 0.035]], rtol=1e-4
    )
    assert scale.height_sd == 0.015
    assert_allclose(scale.sd_share, np.sqrt(0.015**2 + 0.006**2 + 0.005**2 + 0.015**2) / 1.715, rtol=1e-4)


def test_a_height_that_was_not_measured_is_doubted_more() -> None:
    pixels = film(Person().t_pose())
    unsure = prior(Told(height_m=1.75, sex="man", self_reported=True))
    assert HeightScale.of(skeleton(pixels), unsure).sd_share > 1.5 * HeightScale.of(skeleton(pixels), MAN).sd_share


def test_a_user_who_sits_is_scaled_standing() -> None:
    pixels = film(Person().t_pose(), **FAR)
    sitting = prior(Told(height_m=1.75, sex="man", seat_height_m=0.45))
    scale = HeightScale.of(skeleton(pixels, "crown"), sitting)
    assert_allclose(placed(scale, pixels, "reye")[1], 1.636, atol=0.004)


@pytest.mark.parametrize(
    ("distance", "words"), [(5.0, " 5.0 m away$"), (2.5, "only 2.5 m away: take the picture again")]
)
def test_a_known_focal_length_tells_how_far_off_the_camera_stood(distance: float, words: str) -> None:
    pixels = film(Person().t_pose(), distance=distance)
    told = HeightScale.of(skeleton(pixels), MAN, focal_px=FOCAL).notes[0]
    assert re.search(words, told)


@pytest.mark.parametrize("distance", [3.2, 4.0])
def test_a_nearer_plane_shrinks_toward_where_the_camera_looks(distance: float) -> None:
    """A rod 0.3 m before the person is as long as one beside them, once it is said to be nearer."""
    person = Person().t_pose()
    rod = {f"{side}tip": np.array([0.3, left * 0.4, 1.6]) for side, left in (("l", 1.0), ("r", -1.0))}
    filmed = film(person | rod, distance=distance, height=1.3)
    rods = np.array([filmed[name][:2] for name in ("rtip", "ltip")])
    known = Skeleton({name: p for name, p in filmed.items() if name not in rod}, (1920, 1440), "test")
    pixels = {name: p for name, p in known.points.items() if name[1:] not in ("toe",)}
    scale = HeightScale.of(Skeleton(pixels, (1920, 1440), "test"), MAN, focal_px=FOCAL)
    ends = scale.nearer(0.3).place(rods)
    assert_allclose(ends[1, 0] - ends[0, 0], 0.8, rtol=0.015)
    assert_allclose(ends[:, 1], 1.6, atol=0.02)
    unknown = HeightScale.of(known, MAN)
    assert unknown.nearer(0.3) is unknown


def crouching() -> Pixels:
    person = Person()
    points = person.t_pose()
    for side in "lr":
        points[side + "kn"] = points[side + "kn"] + np.array([0.0, 0.25, 0.0])
    return film(points)


@pytest.mark.parametrize(
    ("pixels", "size", "words"),
    [
        (
            skeleton(film(Person().t_pose()), "lan", "ran", "lheel", "rheel").points,
            None,
            "The feet are not seen: show the whole body",
        ),
        (film(Person().t_pose(), distance=2.0), SIZE, "The feet are not seen: show the whole body"),
        (skeleton(film(Person().t_pose()), "crown", "leye", "reye").points, None, "The eyes are not seen"),
        (crouching(), None, r"A knee is bent by \d+ degrees, .*: stand upright, or use the printed marker"),
    ],
)
def test_a_person_who_cannot_give_the_scale(pixels: Pixels, size: tuple[int, int] | None, words: str) -> None:
    with pytest.raises(DataError, match=words):
        HeightScale.of(Skeleton(pixels, size, "test"), MAN)


def assert_one_sentence(error: DataError) -> None:
    assert str(error)
    assert "\n" not in str(error)


ANYWHERE = st.tuples(st.floats(-100.0, 2000.0), st.floats(-100.0, 2000.0), st.floats(0.0, 1.0))


@settings(derandomize=True, max_examples=300, deadline=None)
@given(
    st.dictionaries(
        st.sampled_from(["lheel", "ran", "leye", "crown", "lsh", "rsh", "nose", "rear", "rhip", "rkn"]), ANYWHERE
    ),
    st.sampled_from(["front", "side"]),
)
def test_points_anywhere_give_a_finite_scale_or_one_sentence(points: Pixels, view: View) -> None:
    try:
        scale = HeightScale.of(Skeleton(points, SIZE, "test"), MAN, view)
    except DataError as error:
        assert_one_sentence(error)
        return
    assert np.isfinite(scale.place(np.array([[0.0, 0.0]]))).all()
    assert scale.pixel > 0
    assert_allclose([scale.up @ scale.up, scale.right @ scale.right, scale.up @ scale.right], [1, 1, 0], atol=1e-9)
