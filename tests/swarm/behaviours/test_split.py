import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.swarm.behaviours.split import Merge, split
from ideal_robots import least, run, stage, standing, xy

CLOSE = [(0.50, 0.40), (0.75, 0.40), (0.60, 0.30), (0.65, 0.50)]


@pytest.mark.parametrize("upright", [False, True])
def test_two_groups_go_apart_along_the_longer_side(upright):
    turn = -1 if upright else 1
    states = standing(np.array(CLOSE)[:, ::turn])
    behaviour = split(stage(*(1.2, 0.8)[::turn]), states)
    end = xy(run(behaviour, states)[-1])[:, ::turn]
    assert behaviour.done
    # a half runs from 0.045 m to a pitch before the middle, 0.477 m: its middle is at 0.261 m
    assert end[[0, 2]].mean(axis=0) == pytest.approx([0.261, 0.4], abs=0.008)  # the two farther to the left
    assert end[[1, 3]].mean(axis=0) == pytest.approx([0.939, 0.4], abs=0.008)
    assert least(end) == pytest.approx(0.1476, abs=0.016)


def test_of_five_three_go_to_the_left():
    states = standing([*CLOSE, (0.62, 0.6)])
    end = xy(run(split(stage(1.2, 0.8), states), states)[-1])
    assert np.flatnonzero(end[:, 0] < 0.6).tolist() == [0, 2, 4]


def test_where_it_is_full_groups_stand_a_pitch_apart():
    # 0.52 by 0.16 m for centres: a half is 0.137 m long at two pitches, room for four, and 0.1985 m at one, for five
    states = standing([(0.08 + 0.05 * i, 0.1) for i in range(10)])
    end = xy(run(split(stage(0.61, 0.25), states), states)[-1])
    gap = end[5:, 0].min() - end[:5, 0].max()
    assert gap == pytest.approx(0.123, abs=0.016)
    assert least(end) >= 0.12 - 0.016


def test_groups_that_do_not_fit_are_refused():
    with pytest.raises(ConfigError, match="at most"):
        split(stage(0.61, 0.25), standing([(0.1, 0.1)] * 14))
    with pytest.raises(ConfigError, match="no room for two groups"):
        split(stage(0.2, 0.1), standing([(0.1, 0.05)] * 2))


def test_merge_brings_all_together_at_their_centroid_wherever_one_points():
    states = standing([(0.2, 0.3), (0.2, 0.5), (1.0, 0.3), (1.0, 0.5)])
    behaviour = Merge(stage(1.2, 0.8), states)
    end = xy(run(behaviour, states, pointed=(0.1, 0.1))[-1])
    assert behaviour.done
    assert np.hypot(*(end - [0.6, 0.4]).T) == pytest.approx([0.1476 / 2**0.5] * 4, abs=0.008)
