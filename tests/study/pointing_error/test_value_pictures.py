import json

import numpy as np
import pytest
from matplotlib.image import imread

from armspan.study.pointing_error.bands import BandRow
from armspan.study.pointing_error.feedback import QUOTED, SECONDS, FeedbackRow
from armspan.study.pointing_error.monte_carlo import FLOOR, TABLE, Budget, MonteCarlo
from armspan.study.pointing_error.moving import CHOICES, RealRow, SimulatedRow
from armspan.study.pointing_error.sources import NAMES
from armspan.study.pointing_error.stops import COUNTS, REAL_COUNTS, StopsRow
from armspan.study.pointing_error.trials import Misses
from armspan.study.pointing_error.value import Values, study
from armspan.study.pointing_error.value_pictures import budget, draw_values, feedback, monte_carlo, moving, stops


def made_up(real=True):
    rng = np.random.default_rng(0)
    errors = np.sort(rng.rayleigh(0.05, 4000))
    parts = tuple(Budget(name, 1 / len(NAMES), (0.01, 0.02 + 0.001 * k), (0.04, 0.09)) for k, name in enumerate(NAMES))
    carlo = tuple(MonteCarlo(layout, 500, 4, errors, parts) for layout in (TABLE, FLOOR))
    rows = [
        StopsRow(f"{layout.name}, {words}", True, count, gestures, 0.06 + 0.001 * count, 0.1)
        for layout in (TABLE, FLOOR)
        for words, gestures in (("no drift", 1), ("no drift", 5), ("drift", 1))
        for count in COUNTS
    ]
    rows += [
        StopsRow(f"people, {name}", simulated, count, gestures, 0.2, 0.4)
        for simulated in ((True, False) if real else (True,))
        for name in ("one band", "two bands")
        for gestures in (1, 5)
        for count in REAL_COUNTS
    ]
    miss = Misses(errors, errors)
    middle = np.linspace(0.08, 0.03, 2 * len(SECONDS)).reshape(2, -1)
    followed = [RealRow(name, seconds, 5, 1, 0.2, 0.03) for seconds in (5.0, 10.0, 20.0) for name, _ in CHOICES]
    return Values(
        monte_carlo=carlo,
        stops=tuple(rows),
        bands=(BandRow("virtual arm, here", True, miss, miss), BandRow("real arm, there", False, miss, miss)),
        feedback=(FeedbackRow("straight arm, table", 30, SECONDS, middle, middle),),
        quoted=QUOTED,
        moving=tuple(SimulatedRow(who, k, 5.0, 0.06, 0.1) for who in ("one", "two") for k in ("4 stops", "moving")),
        followed=tuple(followed) if real else (),
        by_speed=((0.1, 0.02),) if real else (),
    )


@pytest.mark.parametrize("real", [True, False])
def test_every_picture_is_drawn_and_nothing_is_cut_off(tmp_path, real):
    paths = draw_values(tmp_path, made_up(real))
    assert [path.name for path in paths] == [
        "monte-carlo.png",
        "budget.png",
        "stops.png",
        "bands.png",
        "feedback.png",
        "moving.png",
    ]
    for path in paths:
        pixels = imread(path)[:, :, :3]
        assert pixels.std() > 0.05
        for rim in (pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:]):
            assert (rim == 1.0).all(), path


def test_the_percentiles_are_written_where_they_are():
    figure = monte_carlo(made_up().monte_carlo)
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    middle, high, highest = 1000 * np.percentile(made_up().monte_carlo[0].errors, (50, 90, 99))
    assert labels == [f"median: {middle:.0f} mm", f"90 %: {high:.0f} mm", f"99 %: {highest:.0f} mm"]


def test_the_budget_has_a_bar_for_each_source():
    axes = budget(made_up().monte_carlo).axes[0]
    assert sorted(label.get_text() for label in axes.get_yticklabels()) == sorted(NAMES)
    assert sorted(bar.get_width() for bar in axes.patches) == pytest.approx([20.0 + k for k in range(len(NAMES))])


def test_simulated_and_real_stops_stand_in_one_picture():
    _, right = stops(made_up().stops).axes
    assert {line.get_marker() for line in right.lines} == {"o", "*"}
    assert all(line.get_ydata() == pytest.approx([200.0] * 3) for line in right.lines)


def test_quoted_feedback_stands_beside_the_simulated():
    _, right = feedback(made_up().feedback, QUOTED).axes
    labels = [label.get_text() for label in right.get_yticklabels()]
    assert len(labels) == 1 + len(QUOTED)
    assert sum("REAL" in label for label in labels) == 1


def test_without_sessions_only_the_simulation_is_drawn():
    assert len(moving(made_up().moving, ()).axes) == 1
    assert len(moving(made_up().moving, made_up().followed).axes) == 3


def test_the_whole_study_in_small_is_plain_json():
    told = []
    found = study(count=100, people=1, progress=lambda what, done, total: told.append((what, done, total)))
    document = json.loads(json.dumps(found.document(), allow_nan=False))
    assert {"sources", "monte_carlo", "stops", "bands", "feedback", "moving", "miss_by_speed"} == set(document)
    assert document["monte_carlo"][0]["layout"] == "table at 1 m"
    assert {what for what, _, _ in told} >= {"table at 1 m", "floor at 1.5 m", "stops", "feedback", "moving"}
    assert all(0 <= done <= total for _, done, total in told)
