import struct

import numpy as np
import pytest
from matplotlib.image import imread

from armspan.records import Body, RobotState, Sheet, Zone
from armspan.study.account import account
from armspan.study.picture import _ellipse, draw
from armspan.study.trials import CHI2_90
from armspan.swarm.limits import Limits
from small_rooms import played


def drawn(path, records, settings, zones=None):
    zones = settings.zones if zones is None else zones
    found = account(records, settings.body, settings.sheet, zones, settings.limits, settings.light_height_m)
    draw(path, records, found, settings.sheet, zones)
    return found


def size(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert data[12:16] == b"IHDR"
    return struct.unpack(">II", data[16:24])


def panels(path, count):
    """The pixels of each panel; nothing is cut off at the picture's rims."""
    width, height = size(path)
    assert width == count * 704  # 6.4 inches of 110 dots
    assert 500 < height < 800
    pixels = imread(path)[:, :, :3]
    for rim in (pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:]):
        assert (rim == 1.0).all()
    return np.array_split(pixels, count, axis=1)


def greens(panel):
    r, g, b = np.moveaxis(panel, 2, 0)
    return int(((g - r > 0.15) & (g - b > 0.08)).sum())


def test_a_session_gives_a_panel_without_and_one_with_the_cursor(tmp_path):
    path = tmp_path / "session.png"
    found = drawn(path, played().log.records, played().house.settings)
    assert [trial.right for trial in found.trials] == [True, True]
    assert 20_000 < path.stat().st_size < 300_000
    assert all(greens(panel) > 10 for panel in panels(path, 2))  # a right choice in each


def test_a_session_without_trials_gives_one_panel(tmp_path):
    path = tmp_path / "none.png"
    drawn(path, played().log.records[:200], played().house.settings)
    [panel] = panels(path, 1)
    assert greens(panel) == 0
    assert panel.std() > 0.05


@pytest.mark.parametrize(("width", "height"), [(0.5, 0.5), (2.0, 0.3), (0.4, 1.2)])
def test_a_room_where_nothing_happened_and_sheets_of_other_shapes(tmp_path, width, height):
    path, sheet = tmp_path / "empty.png", Sheet(width, height)
    draw(path, [], account([], Body(1.6, (0.1, 0.1, 0.2), 0.7), sheet, [], Limits(), 0.045), sheet, [])
    pixels = imread(path)[:, :, :3]
    assert (pixels[:2] == 1.0).all()
    assert (pixels[:, -2:] == 1.0).all()
    assert 200 < size(path)[1] <= 1100


def test_equal_sessions_give_equal_pictures(tmp_path):
    for name in ("a.png", "b.png"):
        drawn(tmp_path / name, played().log.records, played().house.settings)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_names_are_drawn_as_they_are_written(tmp_path):
    zone = Zone("$1 or $x_2^", ((0.1, 0.1), (0.3, 0.1), (0.3, 0.2)))
    records = [RobotState(0.0, "$a$ $\\b$", (0.2, 0.2), 0.0)]
    drawn(tmp_path / "names.png", records, played().house.settings, [zone])
    panels(tmp_path / "names.png", 1)


def test_the_ellipse_holds_90_percent():
    # Long axis along (3, 4)/5 with 2 cm, short one with 1 cm.
    axis, across = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    covariance = 4e-4 * np.outer(axis, axis) + 1e-4 * np.outer(across, across)
    ellipse = _ellipse((0.1, 0.2), tuple(map(tuple, covariance)), "k")
    assert ellipse.center == pytest.approx((100, 200))
    assert ellipse.width == pytest.approx(2 * 20 * np.sqrt(CHI2_90))
    assert ellipse.height == pytest.approx(2 * 10 * np.sqrt(CHI2_90))
    assert ellipse.angle % 180 == pytest.approx(np.degrees(np.arctan2(0.8, 0.6)))
    assert abs(CHI2_90 + 2 * np.log(0.1)) < 1e-3
