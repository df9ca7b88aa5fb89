import struct

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.image import imread

from armspan.errors import DataError
from armspan.records import Sheet, Zone
from armspan.study.swarm import SwarmAccount
from armspan.study.swarm_picture import _COLOURS, draw_swarm
from armspan.swarm.limits import Limits

SHEET = Sheet(1.0, 1.0)
DOTS = 110
BLUE, RED = _COLOURS[:2]


def swept(*ways, sheet=SHEET, names=None, steps=60, **more):
    """An account of robots that each drive a straight way."""
    found = SwarmAccount(names or [f"r{i}" for i in range(len(ways))], sheet, Limits(), **more)
    starts, ends = (np.array([way[k] for way in ways]) for k in (0, 1))
    for k in range(steps):
        found.take(0.1 * k, starts + k / (steps - 1) * (ends - starts))
    return found


def picture(path, account, zones=(), title="a run"):
    draw_swarm(path, account, zones, title)
    pixels = imread(path)[:, :, :3]
    for rim in (pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:]):
        assert (rim == 1.0).all()  # nothing is cut off
    return pixels


def near(pixels, colour, apart=0.02):
    return (np.abs(pixels - np.array(to_rgb(colour))) < apart).all(axis=2)


def through(colour, under="#fbfaf5", share=0.75):
    """A disc's colour over what is under it."""
    return tuple(share * np.array(to_rgb(colour)) + (1 - share) * np.array(to_rgb(under)))


def sheet_box(pixels):
    """The sheet's rows and columns: the largest frame of ink's and paper's or shade's colours, left of the curves."""
    left = pixels[:, : int(pixels.shape[1] * 0.62)]
    rows, columns = np.nonzero(near(left, "#fbfaf5", 0.004))
    return rows.min(), rows.max(), columns.min(), columns.max()


def middle(mask):
    return np.argwhere(mask).mean(axis=0)


def test_robots_stand_where_they_ended_with_y_down_and_their_true_size(tmp_path):
    found = swept(((0.2, 0.2), (0.201, 0.2)), ((0.8, 0.7), (0.8, 0.701)), names=["", " "], body=0.05, cover_radius=0.01)
    pixels = picture(tmp_path / "a.png", found)
    top, bottom, left, right = sheet_box(pixels)
    for colour, (x, y) in ((BLUE, (0.2, 0.2)), (RED, (0.8, 0.7))):
        disc = near(pixels, through(colour), 0.03)
        disc[:, int(pixels.shape[1] * 0.62) :] = False
        row, column = middle(disc)
        assert (column - left) / (right - left) == pytest.approx(x, abs=0.01)
        assert (row - top) / (bottom - top) == pytest.approx(y, abs=0.01)
        across = np.argwhere(disc).max(axis=0) - np.argwhere(disc).min(axis=0)
        assert across / (right - left) == pytest.approx([0.1, 0.1], abs=0.01)


def test_the_shade_is_as_large_as_what_was_covered(tmp_path):
    found = swept(((-0.2, 0.25), (1.2, 0.25)), names=["off"], body=0.005, cover_radius=0.25)  # the upper half
    pixels = picture(tmp_path / "a.png", found)
    left = pixels[:, : int(pixels.shape[1] * 0.62)]
    paper = near(left, "#fbfaf5", 0.004)
    rows, columns = np.nonzero(paper)
    inside = left[2 * rows.min() - rows.max() : rows.max(), columns.min() : columns.max()]
    greys = (np.ptp(inside, axis=2) < 0.12) & (inside.max(axis=2) < 0.93) & (inside.min(axis=2) > 0.5)
    assert greys.mean() == pytest.approx(0.5, abs=0.03)
    west, east = inside[: len(inside) // 3, :60], inside[: len(inside) // 3, -60:]
    assert west.mean() < east.mean() - 0.1  # the darker the earlier


SEVEN = [((0.1, 0.1 + 0.13 * i), (0.9, 0.1 + 0.13 * i)) for i in range(7)]


@pytest.fixture(scope="module")
def seven(tmp_path_factory):
    """A picture of seven robots: its path and its pixels."""
    path = tmp_path_factory.mktemp("seven") / "a.png"
    return path, picture(path, swept(*SEVEN))


def test_every_robot_has_its_colour_and_the_curves_are_drawn(seven):
    _, pixels = seven
    assert all(near(pixels, colour).sum() > 300 for colour in _COLOURS)
    assert pixels.shape[1] == round(10.6 * DOTS)
    curves = pixels[:, int(pixels.shape[1] * 0.65) :]
    assert near(curves, "#222222").sum() > 500
    assert near(curves, BLUE).sum() > 20  # t50's mark


@pytest.mark.parametrize(("width", "height"), [(3.0, 0.3), (0.4, 1.6)])
def test_sheets_of_other_shapes_and_one_robot(tmp_path, width, height):
    sheet = Sheet(width, height)
    found = swept(((0.1, 0.1), (width - 0.1, height - 0.1)), sheet=sheet)
    picture(tmp_path / "a.png", found, title="one robot")
    rows = struct.unpack(">II", (tmp_path / "a.png").read_bytes()[16:24])[1]
    assert 4 * DOTS < rows <= 10 * DOTS


def test_many_robots(tmp_path):
    dice = np.random.default_rng(1)
    found = swept(*dice.uniform(0.1, 0.9, (60, 2, 2)), steps=20)
    picture(tmp_path / "a.png", found)
    assert (tmp_path / "a.png").stat().st_size < 500_000


def test_a_run_of_a_moment_a_lifted_robot_and_names_as_they_are_written(tmp_path):
    found = SwarmAccount(["$a$ $\\b$", "b"], SHEET, Limits())
    found.take(0.0, [(0.3, 0.3), (np.nan, np.nan)])
    zone = Zone("$1 or $x_2^", ((0.1, 0.1), (0.3, 0.1), (0.3, 0.2)))
    picture(tmp_path / "a.png", found, [zone], "$x$ \\y_")


def test_equal_runs_give_equal_pictures(seven, tmp_path):
    picture(tmp_path / "b.png", swept(*SEVEN))
    assert seven[0].read_bytes() == (tmp_path / "b.png").read_bytes()


def test_nothing_to_draw_is_told(tmp_path):
    with pytest.raises(DataError, match="nothing to draw"):
        draw_swarm(tmp_path / "a.png", SwarmAccount(["a"], SHEET, Limits()))
