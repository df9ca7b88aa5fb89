import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.testing import assert_allclose

from armspan.gesture.takes import Take
from armspan.study.take_picture import draw_take, forearm_directions
from recorded_takes import SPAN, two_band_take


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """Draws a take; the figure as it was when it was written."""
    figures = []
    save = Figure.savefig

    def kept(figure, *args, **more):
        figures.append(figure)
        return save(figure, *args, **more)

    monkeypatch.setattr(Figure, "savefig", kept)

    def draw(take):
        path = tmp_path / "take.png"
        draw_take(path, take, "a $title")
        assert path.read_bytes().startswith(b"\x89PNG")
        return figures[-1]

    return draw


def panels(figure):
    return {axes.get_title(): axes for axes in figure.axes if axes.get_visible()}


def test_each_band_has_its_column_of_three_panels(drawn):
    found = panels(drawn(two_band_take()))
    assert list(found) == [
        f"{band}: {what}"
        for what in ("where the forearm points", "acceleration without gravity [m/s²]", "rate [rad/s]")
        for band in ("right", "left")
    ]
    for axes in found.values():
        assert [line.get_label() for line in axes.lines[:3]] == ["x front", "y left", "z up"]


def test_the_forearm_is_drawn_where_it_points(drawn):
    found = panels(drawn(two_band_take()))
    for band, top in (("right", (0, 0, 1)), ("left", (1, 0, 0))):
        lines = [line.get_ydata() for line in found[f"{band}: where the forearm points"].lines[:3]]
        assert_allclose([line[0] for line in lines], [0, 0, -1], atol=1e-9)
        assert_allclose([line[200] for line in lines], top, atol=1e-9)


def test_the_gesture_is_shaded_where_it_is_known(drawn):
    for axes in panels(drawn(two_band_take())).values():
        [shade] = axes.patches
        assert (shade.get_x(), shade.get_x() + shade.get_width()) == SPAN
    unknown = two_band_take()
    bare = Take(unknown.label, unknown.person, 1, unknown.columns, unknown.times, unknown.values)
    assert [len(axes.patches) for axes in panels(drawn(bare)).values()] == [0] * 6


def test_gaps_stay_open(drawn):
    take = two_band_take()
    take.values[100:140] = np.nan
    for axes in panels(drawn(take)).values():
        assert np.isnan(axes.lines[0].get_ydata()[100:140]).all()
        assert np.isfinite(axes.lines[0].get_ydata()[140:]).all()


def test_other_peoples_columns_are_drawn_by_sensor(drawn):
    times = np.arange(20) / 50
    columns = ("wrist_ax", "wrist_ay", "wrist_az", "elbow_angle")
    found = panels(drawn(Take("wave", "bob", 1, columns, times, np.ones((20, 4)))))
    assert list(found) == ["wrist: a", "elbow: angle"]
    assert [line.get_label() for line in found["wrist: a"].lines[:3]] == list(columns[:3])


def test_directions_by_hand():
    half = np.sqrt(0.5)
    wxyz = np.array([[1, 0, 0, 0], [half, 0, half, 0], [half, 0, 0, half], [-half, 0, 0, -half]])
    assert_allclose(forearm_directions(2 * wxyz), [[1, 0, 0], [0, 0, -1], [0, 1, 0], [0, 1, 0]], atol=1e-12)
