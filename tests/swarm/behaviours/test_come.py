import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.swarm.behaviours.come import come
from ideal_robots import least, run, stage, standing, xy

THREE = [(0.2, 0.3), (0.5, 0.2), (0.7, 0.4)]


@pytest.mark.parametrize(
    ("user", "edge"),
    [
        ((0.5, 1.4), [(0.3524, 0.955), (0.5, 0.955), (0.6476, 0.955)]),  # below the print
        ((0.4, -0.6), [(0.2524, 0.045), (0.4, 0.045), (0.5476, 0.045)]),  # above it
        ((-0.5, 0.6), [(0.045, 0.4524), (0.045, 0.6), (0.045, 0.7476)]),  # to the left
        ((1.6, 0.98), [(0.955, 0.6598), (0.955, 0.8074), (0.955, 0.955)]),  # to the right, near a corner
        ((1.2, 1.7), [(0.6598, 0.955), (0.8074, 0.955), (0.955, 0.955)]),  # beyond a corner, rather below
        ((0.5, 0.9), [(0.3524, 0.955), (0.5, 0.955), (0.6476, 0.955)]),  # leaning over the sheet
    ],
)
def test_they_line_up_at_the_edge_before_the_user(user, edge):
    behaviour = come(stage(user=user), states := standing(THREE))
    end = xy(run(behaviour, states)[-1])
    assert behaviour.done
    # 1.2 times 0.123 m apart: 0.1476 m
    order = np.argsort(end.sum(axis=1))
    assert end[order] == pytest.approx(np.array(edge), abs=0.008)


def test_ways_do_not_cross():
    end = xy(run(come(stage(user=(0.5, 1.4)), standing(THREE)), standing(THREE))[-1])
    assert end[:, 0].tolist() == sorted(end[:, 0])  # as they stood from left to right


def test_more_than_a_row_holds_stand_behind():
    states = standing([(0.1 + 0.2 * (i % 5), 0.1 + 0.2 * (i // 5)) for i in range(10)])
    end = xy(run(come(stage(user=(0.5, 1.4)), states), states)[-1])
    # seven in the first row: 0.91 m hold six times 0.1476 m, 0.8856 m
    assert np.sort(end[:, 1]) == pytest.approx([0.8074] * 3 + [0.955] * 7, abs=0.008)
    assert least(end) >= 0.1476 - 0.016


def test_pointing_changes_nothing():
    first, second = (
        run(come(stage(user=(0.5, 1.4)), standing(THREE)), standing(THREE), pointed=p) for p in (None, (0.1, 0.1))
    )
    assert first == second


def test_before_the_set_up_it_is_refused():
    with pytest.raises(ConfigError, match="set up first"):
        come(stage(), standing(THREE))
