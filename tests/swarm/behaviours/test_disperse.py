import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.swarm.behaviours.disperse import disperse, spread
from ideal_robots import least, run, stage, standing, xy

# The longest least distance of n points in the unit square, as known (n up to 9 and 16 proved)
PACKINGS = {
    2: 1.41421, 3: 1.03528, 4: 1.0, 5: 0.70711, 6: 0.60093, 7: 0.53590, 8: 0.51764, 9: 0.5, 10: 0.42128,
    11: 0.39821, 12: 0.38873, 13: 0.36610, 14: 0.34892, 15: 0.34108, 16: 0.33333, 17: 0.30615, 18: 0.30046,
    19: 0.28954, 20: 0.28661,
}  # fmt: skip


def test_four_robots_go_to_the_corners():
    states = standing([(0.45, 0.45), (0.57, 0.45), (0.57, 0.57), (0.45, 0.57)])
    behaviour = disperse(stage(), states)
    end = xy(run(behaviour, states)[-1])
    assert behaviour.done
    assert end == pytest.approx(np.array([[0.045, 0.045], [0.955, 0.045], [0.955, 0.955], [0.045, 0.955]]), abs=0.008)


@pytest.mark.parametrize("n", [2, 3, 5, 7, 12, 20])
def test_gathered_robots_end_much_farther_apart(n):
    start = 0.3 + 0.125 * np.array([(i % 5, i // 5) for i in range(n)])
    states = standing(start)
    end = xy(run(disperse(stage(), states), states)[-1])
    # the way to the slots ends within 8 mm of each
    assert least(end) >= 0.93 * PACKINGS[n] * 0.91 - 0.016 > 1.5 * least(start)


@pytest.mark.parametrize("n", sorted(PACKINGS))
def test_near_the_best_packings_of_the_square(n):
    share = least(spread(n, 0.1, np.ones(2))) / PACKINGS[n]
    assert share <= 1 + 1e-4
    assert share >= (0.9999 if n in (2, 4, 5, 6, 9, 12, 16, 18) else 0.93)


def test_on_a_long_sheet_they_stand_in_a_row():
    sites = spread(5, 0.1, np.array([2.0, 0.05]))
    assert least(sites) == pytest.approx(np.hypot(0.5, 0.05), rel=1e-3)  # in zigzag


def test_who_stands_as_far_apart_already_stays():
    third = [(0.045, 0.045), (0.955, 0.2888), (0.2888, 0.955)]  # the best triangle: sides of 0.942 m, no lattice
    (*wishes,) = disperse(stage(), standing(third)).step(0.0, standing(third), None)
    assert np.array([wish.xy for wish in wishes]) == pytest.approx(np.array(third))


def test_a_lone_robot_stays():
    (wish,) = disperse(stage(), standing([(0.3, 0.4)])).step(0.0, standing([(0.3, 0.4)]), (0.9, 0.9))
    assert wish.xy == (0.3, 0.4)


def test_more_robots_than_fit_are_refused():
    with pytest.raises(ConfigError, match="at most 6 fit"):
        disperse(stage(0.3, 0.3), standing([(0.15, 0.15)] * 7))
